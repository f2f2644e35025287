//! Joints of a robot whose names stand in names of columns, such as `elbow_joint` in `/joint_states/position/elbow_joint`.

use std::collections::BTreeMap;

use super::names::{meaning_of_unit, plain, unit_at_end, with_meaning, without_unit, words};
use super::{ColumnFound, Inspection, Meaning};
use crate::rows::joint_state::ColumnName;

/// A shorter name says nothing by standing in another: `a` may be ampere.
const SHORTEST: usize = 2;

/// Place among `joints` of the one whose name the name of a column contains: in whole words, whatever stands between them, so that
/// `joint_1` is not in `joint_10`. Of two names of which one is a part of the other the longer counts. `None` where the column contains
/// none, or several.
pub fn named_joint(column: &str, joints: &[&str]) -> Option<usize> {
    let (head, _) = without_unit(column);
    let words = words(ColumnName::parse(&head).map_or(head.as_str(), |name| name.joint));
    let names: Vec<String> = joints.iter().map(|joint| plain(joint)).collect();
    let tells = |name: &str| name.chars().count() >= SHORTEST && name.contains(|sign: char| !sign.is_ascii_digit());
    let mut found: Vec<(usize, [usize; 2])> = Vec::new();
    for from in 0..words.len() {
        for to in from + 1..=words.len() {
            let text = words[from..to].concat();
            found.extend(
                (0..names.len()).filter(|joint| names[*joint] == text && tells(&text)).map(|j| (j, [from, to])),
            );
        }
    }
    let is_part = |[from, to]: [usize; 2]| {
        found.iter().any(|(_, [start, end])| *start <= from && to <= *end && end - start > to - from)
    };
    let mut whole = found.iter().filter(|(_, span)| !is_part(*span)).map(|(joint, _)| *joint);
    let first = whole.next()?;
    whole.all(|joint| joint == first).then_some(first)
}

/// The columns that are taken to be of one joint, and the one of the robot whose name theirs contain.
struct Claim {
    columns: Vec<usize>,
    joint: usize,
    /// Whether the name is the robot's, but for spelling.
    exact: bool,
}

impl Inspection {
    /// The same where the names of a robot's joints are known: columns whose names contain that of exactly one of them are this joint's.
    /// Where columns of two joints contain the same name (of a left arm and a right one), and none has just that, they stay as they are.
    #[must_use]
    pub fn with_joint_names(mut self, joints: &[&str]) -> Inspection {
        self.guess_by_units(joints);
        self.guess_bare_names(joints);
        let claims = self.claims(joints);
        let kinds = |claim: &Claim| -> Vec<(Meaning, bool)> {
            let guesses = claim.columns.iter().map(|column| &self.columns[*column].guess);
            guesses.filter_map(|guess| Some((guess.meaning?, guess.commanded))).collect()
        };
        let clash = |a: &Claim, b: &Claim| a.joint == b.joint && kinds(a).iter().any(|kind| kinds(b).contains(kind));
        let loses = |place: usize| {
            let others = claims.iter().enumerate().filter(|(other, _)| *other != place);
            let mut others = others.map(|(_, other)| other);
            !claims[place].exact && others.any(|other| clash(&claims[place], other))
        };
        let kept = (0..claims.len()).filter(|place| !loses(*place)).map(|place| &claims[place]);
        let named: Vec<(usize, usize, bool)> =
            kept.flat_map(|claim| claim.columns.iter().map(|column| (*column, claim.joint, claim.exact))).collect();
        for (column, joint, exact) in named {
            let guess = &mut self.columns[column].guess;
            guess.joint = Some(joints[joint].to_owned());
            guess.by_part = !exact;
        }
        self
    }

    /// What the unit at the end of a name tells of a column that names a joint, and of which no word tells what it is:
    /// `elbow_joint_deg`.
    fn guess_by_units(&mut self, joints: &[&str]) {
        for column in self.columns.iter_mut().filter(|column| column.guess.meaning.is_none()) {
            let meaning = unit_at_end(&column.name).and_then(meaning_of_unit);
            if let Some(meaning) = meaning.filter(|_| named_joint(&column.name, joints).is_some()) {
                column.guess = with_meaning(&column.name, meaning, [column.lowest, column.highest], column.whole);
            }
        }
    }

    /// Where no column is a position by its words or its unit, that is which alone of those that tell nothing names a joint:
    /// `robot1/elbow_joint`.
    fn guess_bare_names(&mut self, joints: &[&str]) {
        if self.columns.iter().any(|column| column.guess.meaning == Some(Meaning::Position)) {
            return;
        }
        let tells_nothing = |column: &&ColumnFound| column.guess.meaning.is_none() && !column.guess.commanded;
        let named = |column: &ColumnFound| {
            Some(column).filter(tells_nothing).and_then(|column| named_joint(&column.name, joints))
        };
        let named: Vec<Option<usize>> = self.columns.iter().map(named).collect();
        for (column, joint) in self.columns.iter_mut().zip(&named).filter(|(_, joint)| joint.is_some()) {
            if named.iter().filter(|other| *other == joint).count() == 1 {
                column.guess =
                    with_meaning(&column.name, Meaning::Position, [column.lowest, column.highest], column.whole);
            }
        }
    }

    fn claims(&self, joints: &[&str]) -> Vec<Claim> {
        let mut groups: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (place, column) in self.columns.iter().enumerate() {
            if let Some(joint) = &column.guess.joint {
                groups.entry(joint).or_default().push(place);
            }
        }
        let claim = |(name, columns): (&str, Vec<usize>)| {
            if let Some(joint) = joints.iter().position(|joint| plain(joint) == plain(name)) {
                return Some(Claim { columns, joint, exact: true });
            }
            let mut named = columns.iter().filter_map(|column| named_joint(&self.columns[*column].name, joints));
            let joint = named.next()?;
            named.all(|other| other == joint).then_some(Claim { columns, joint, exact: false })
        };
        groups.into_iter().filter_map(claim).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARM: [&str; 4] = ["elbow_joint", "joint_1", "joint_10", "joint"];

    #[test]
    fn a_joints_name_is_found_in_whole_words() {
        for (column, joint) in [
            ("/joint_states/position/elbow_joint", None),
            ("/js/position/elbow_joint", Some(0)),
            ("left_elbow_joint.position", Some(0)),
            ("/elbow_joint:joint_1.effort", Some(1)),
            ("robot1/joint_1", Some(1)),
            ("joint1 Winkel [°]", Some(1)),
            ("pos_joint_10_rad", Some(2)),
            ("joint_100", Some(3)),
            ("left_elbow", None),
            ("joint_1_joint_10", None),
        ] {
            assert_eq!(named_joint(column, &ARM), joint, "{column}");
        }
        assert_eq!(named_joint("/joint_states/position/elbow_joint", &ARM[..3]), Some(0));
        assert_eq!(named_joint("current_1_a", &["a", "1"]), None);
    }
}
