//! The part of a URDF that a chain is made of.
//!
//! URDFs carry much that says nothing of gravity (meshes, simulator tags, controllers) and over which a strict parser
//! may stumble, and some state twice what may stand once. Before parsing, everything but the elements below is
//! dropped, and of a repeated one the first is kept, as ROS's own parser (urdfdom) does:
//!
//! ```text
//!     robot
//!     ├── link*  ── inertial ── origin, mass, inertia
//!     └── joint* ── origin, parent, child, axis, limit, mimic
//! ```

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, Writer};

use super::error::UrdfError;

/// An element being copied, and the names of its children so far.
struct Open {
    name: String,
    children: Vec<String>,
}

/// Copies the elements that a chain is made of.
///
/// # Errors
///
/// Text that is not well-formed XML with a `robot` at its root; xacro macros among the elements that are read.
pub(super) fn essentials(text: &str) -> Result<String, UrdfError> {
    let mut reader = Reader::from_str(text);
    let mut kept = Writer::new(Vec::new());
    let mut open = vec![Open { name: String::new(), children: Vec::new() }];
    loop {
        let event = reader.read_event().map_err(|error| located(text, &reader, &error))?;
        match &event {
            Event::Start(start) => match enter(&mut open, start)? {
                Some(element) => open.push(element),
                None => {
                    reader.read_to_end(start.name()).map_err(|error| located(text, &reader, &error))?;
                    continue;
                }
            },
            Event::Empty(start) => {
                if enter(&mut open, start)?.is_none() {
                    continue;
                }
            }
            Event::End(_) => {
                open.pop();
            }
            Event::Eof => break,
            // Text, comments and declarations: URDF says everything in attributes.
            _ => continue,
        }
        kept.write_event(event).map_err(|error| UrdfError::Parse(error.to_string()))?;
    }
    finished(&open)?;
    Ok(String::from_utf8_lossy(&kept.into_inner()).into_owned())
}

/// The element, if it is to be copied into the innermost open one.
fn enter(open: &mut [Open], start: &BytesStart) -> Result<Option<Open>, UrdfError> {
    let name = String::from_utf8_lossy(start.name().as_ref()).into_owned();
    if name.starts_with("xacro:") {
        return Err(UrdfError::Xacro);
    }
    let Some(parent) = open.last_mut() else {
        return Ok(None);
    };
    if parent.name.is_empty() && name != "robot" {
        return Err(UrdfError::Parse(format!("the root element is <{name}>, not <robot>")));
    }
    let (wanted, often) = children_of(&parent.name);
    let again = parent.children.contains(&name);
    if !wanted.contains(&name.as_str()) || (again && !often) {
        return Ok(None);
    }
    if !again {
        parent.children.push(name.clone());
    }
    Ok(Some(Open { name, children: Vec::new() }))
}

/// The children that matter, and whether they may stand more than once.
fn children_of(element: &str) -> (&'static [&'static str], bool) {
    match element {
        "" => (&["robot"], false),
        "robot" => (&["link", "joint"], true),
        "link" => (&["inertial"], false),
        "inertial" => (&["origin", "mass", "inertia"], false),
        "joint" => (&["origin", "parent", "child", "axis", "limit", "mimic"], false),
        _ => (&[], false),
    }
}

fn finished(open: &[Open]) -> Result<(), UrdfError> {
    match open {
        [document] if document.children.is_empty() => Err(UrdfError::Parse("there is no <robot> element".to_owned())),
        [_, .., innermost] => Err(UrdfError::Parse(format!("<{}> is not closed", innermost.name))),
        _ => Ok(()),
    }
}

pub(super) fn located(text: &str, reader: &Reader<&[u8]>, error: &quick_xml::Error) -> UrdfError {
    let position = usize::try_from(reader.error_position()).unwrap_or(usize::MAX).min(text.len());
    let line = 1 + text.as_bytes()[..position].iter().filter(|byte| **byte == b'\n').count();
    UrdfError::Parse(format!("line {line}: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        essentials(text).unwrap_err().to_string()
    }

    #[test]
    fn keeps_what_a_chain_is_made_of() {
        let text = r#"<?xml version="1.0"?><!-- c --><robot name="r" version="1.2">
            <link name="a"><visual><origin/></visual><inertial><mass value="1"/><note/></inertial></link>
            <gazebo><joint/></gazebo><joint name="j" type="fixed"><parent link="a"/><dynamics/></joint></robot>"#;
        let expected = r#"<robot name="r" version="1.2"><link name="a"><inertial><mass value="1"/></inertial></link><joint name="j" type="fixed"><parent link="a"/></joint></robot>"#;
        assert_eq!(essentials(text).unwrap(), expected);
    }

    #[test]
    fn of_a_repeated_element_the_first_counts() {
        let text = r#"<robot><joint><origin xyz="1 0 0"/><origin xyz="2 0 0"/></joint><joint><origin xyz="3 0 0"/></joint></robot>"#;
        assert_eq!(essentials(text).unwrap(), text.replace(r#"<origin xyz="2 0 0"/>"#, ""));
    }

    #[test]
    fn macros_are_refused_but_not_in_comments() {
        let text = r#"<robot><!-- <xacro:arm/> --><xacro:arm/></robot>"#;
        assert_eq!(essentials(text), Err(UrdfError::Xacro));
        assert!(essentials(&text.replace("<xacro:arm/></", "</")).is_ok());
    }

    #[test]
    fn says_where_the_text_is_broken() {
        assert!(refused("<robot>\n<link>\n</joint></robot>").contains("line 3: "));
        assert!(refused("<robot>\n<gazebo>\n</robot>").contains("line "));
        assert!(refused("<robot><link>").contains("<link> is not closed"));
        assert!(refused("<html/>").contains("the root element is <html>, not <robot>"));
        assert!(refused("joints: [pan]").contains("there is no <robot> element"));
    }

    #[test]
    fn depth_is_no_danger() {
        let deep = "<a>".repeat(100_000) + &"</a>".repeat(100_000);
        assert_eq!(essentials(&format!("<robot>{deep}</robot>")).unwrap(), "<robot></robot>");
    }
}
