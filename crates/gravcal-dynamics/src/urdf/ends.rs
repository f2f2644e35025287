//! Where a chain most likely begins and ends, where nobody says.

use urdf_rs::JointType;

use super::error::UrdfError;
use super::read;
use super::tree::Tree;

/// Base and tips of a chain, by the names of links of a URDF.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UrdfEnds {
    /// The link on which all else hangs.
    pub base: String,
    /// The last links, one for each branch.
    pub tips: Vec<String>,
}

impl UrdfEnds {
    /// The ends of a chain whose joints are `recorded`, guessed: the base is the root of the tree, and a tip each
    /// link that one of them carries and beyond which none of them moves. Names that the URDF does not know are of
    /// something else, such as a gripper.
    ///
    /// Where it knows none of them, only how many there are, `count`, matters: the tip is the one link that so many joints move, one
    /// after another. `None` where there is none, or more than one.
    ///
    /// # Errors
    /// The text is no URDF, or no tree.
    pub fn guess(text: &str, recorded: &[&str], count: usize) -> Result<Option<UrdfEnds>, UrdfError> {
        let robot = read(text)?;
        let tree = Tree::new(&robot)?;
        let place = |name: &&str| robot.joints.iter().position(|joint| joint.name == *name);
        let named: Vec<usize> = recorded.iter().filter_map(place).collect();
        let tips = if named.is_empty() { at_depth(&tree, count) } else { last_of(&tree, &named) };
        Ok(ending_at(&tree, &tips))
    }

    /// The ends of a chain to these links: its base is guessed. `None` where the URDF has no link of one of these names.
    ///
    /// # Errors
    /// The text is no URDF, or no tree.
    pub fn guess_base(text: &str, tips: &[String]) -> Result<Option<UrdfEnds>, UrdfError> {
        let robot = read(text)?;
        let tree = Tree::new(&robot)?;
        let place = |tip: &String| robot.links.iter().position(|link| link.name == *tip);
        let tips: Option<Vec<usize>> = tips.iter().map(place).collect();
        Ok(tips.and_then(|tips| ending_at(&tree, &tips)))
    }
}

fn ending_at(tree: &Tree<'_>, tips: &[usize]) -> Option<UrdfEnds> {
    let root = tree.links_to_root(*tips.first()?).last()?;
    let tips = tips.iter().map(|link| tree.link_name(*link)).collect();
    Some(UrdfEnds { base: tree.link_name(root), tips })
}

/// Links that one of the joints carries and beyond which none of them moves.
fn last_of(tree: &Tree<'_>, joints: &[usize]) -> Vec<usize> {
    let carried: Vec<usize> = joints.iter().map(|joint| tree.child(*joint)).collect();
    let bears_another = |link: usize| {
        carried.iter().any(|other| *other != link && tree.links_to_root(*other).any(|above| above == link))
    };
    carried.iter().copied().filter(|link| !bears_another(*link)).collect()
}

/// The one link that so many joints move, each carrying the next.
fn at_depth(tree: &Tree<'_>, depth: usize) -> Vec<usize> {
    let depth_of = |link: usize| tree.links_to_root(link).filter(|link| is_moved(tree, *link)).count();
    let links = 0..tree.robot.links.len();
    let found: Vec<usize> = links.filter(|link| is_moved(tree, *link) && depth_of(*link) == depth).collect();
    if found.len() == 1 { found } else { Vec::new() }
}

/// Whether the joint that carries a link moves it.
fn is_moved(tree: &Tree<'_>, link: usize) -> bool {
    tree.parent_joint(link).is_some_and(|joint| tree.robot.joints[joint].joint_type != JointType::Fixed)
}

#[cfg(test)]
mod tests {
    use super::super::tests::ARM;
    use super::*;

    fn guessed(recorded: &[&str]) -> Option<(String, Vec<String>)> {
        UrdfEnds::guess(ARM, recorded, recorded.len()).unwrap().map(|ends| (ends.base, ends.tips))
    }

    fn ends(tip: &str) -> Option<(String, Vec<String>)> {
        Some(("base".to_owned(), vec![tip.to_owned()]))
    }

    #[test]
    fn names_of_joints_tell_the_tip() {
        assert_eq!(guessed(&["lift", "pan"]), ends("arm"));
        assert_eq!(guessed(&["pan", "lift", "grip"]), ends("finger"));
        assert_eq!(guessed(&["another_finger", "pan", "lift"]), ends("arm"));
        let standing =
            ARM.replacen("<joint name=\"pan\" type=\"continuous\">", "<joint name=\"pan\" type=\"fixed\">", 1);
        let base = UrdfEnds::guess(&standing, &["lift"], 1).unwrap().map(|ends| ends.base);
        assert_eq!(base.as_deref(), Some("base"), "what is fixed to the root is no base of its own");
    }

    #[test]
    fn tips_tell_the_base() {
        let base = |tip: &str| UrdfEnds::guess_base(ARM, &[tip.to_owned()]).unwrap().map(|ends| (ends.base, ends.tips));
        assert_eq!((base("arm"), base("nowhere")), (ends("arm"), None));
    }

    #[test]
    fn without_names_the_number_of_joints_tells_it() {
        assert_eq!(guessed(&["1", "2"]), ends("arm"));
        assert_eq!(guessed(&["1", "2", "3", "4"]), None);
        assert_eq!(guessed(&[]), None);
        let forked = ARM.replace("<parent link=\"hand\"/>", "<parent link=\"column\"/>");
        assert_eq!(UrdfEnds::guess(&forked, &["1", "2"], 2).unwrap(), None);
    }
}
