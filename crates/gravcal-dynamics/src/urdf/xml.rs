//! Elements of a URDF's XML, read and written one by one.

use quick_xml::Writer;
use quick_xml::events::attributes::Attribute;
use quick_xml::events::{BytesStart, Event};

use super::error::UrdfError;

/// Writes an event.
pub(super) fn put(writer: &mut Writer<Vec<u8>>, event: Event<'_>) -> Result<(), UrdfError> {
    writer.write_event(event).map_err(|error| UrdfError::Parse(error.to_string()))
}

/// An element's name.
pub(super) fn name_of(start: &BytesStart<'_>) -> String {
    String::from_utf8_lossy(start.name().as_ref()).into_owned()
}

fn attributes<'s>(start: &'s BytesStart<'_>) -> Result<Vec<Attribute<'s>>, UrdfError> {
    start.attributes().collect::<Result<_, _>>().map_err(|error| UrdfError::Parse(error.to_string()))
}

/// The text of an attribute, where the element has it.
pub(super) fn attribute(start: &BytesStart<'_>, name: &str) -> Result<Option<String>, UrdfError> {
    let found = attributes(start)?.into_iter().find(|attribute| attribute.key.as_ref() == name.as_bytes());
    let value = found.map(|attribute| attribute.unescape_value().map(|value| value.into_owned()));
    value.transpose().map_err(|error| UrdfError::Parse(error.to_string()))
}

/// The number that an attribute holds, where the element has it.
pub(super) fn number(start: &BytesStart<'_>, name: &str) -> Result<Option<f64>, UrdfError> {
    let text = attribute(start, name)?;
    let parsed = text.map(|text| {
        let element = name_of(start);
        text.trim()
            .parse()
            .map_err(|_| UrdfError::Parse(format!("<{element}> has {name}=\"{text}\", which is no number")))
    });
    parsed.transpose()
}

/// The element with some attributes replaced, or added.
pub(super) fn with<'e>(start: &BytesStart<'_>, changed: &[(&str, String)]) -> Result<BytesStart<'e>, UrdfError> {
    let mut element = BytesStart::new(name_of(start));
    let is_changed = |key: &[u8]| changed.iter().any(|(name, _)| name.as_bytes() == key);
    for attribute in attributes(start)? {
        if !is_changed(attribute.key.as_ref()) {
            element.push_attribute(attribute);
        }
    }
    for (name, value) in changed {
        element.push_attribute((*name, value.as_str()));
    }
    Ok(element)
}
