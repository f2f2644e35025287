//! Fields of a TOML file, and where they stand in its text.

use std::fmt;
use std::ops::Range;

use toml::de::DeValue;

/// The way to a field from the top of its file: `load[1].mass_kg`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Field(Vec<Step>);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Step {
    Key(String),
    Index(usize),
}

impl Field {
    /// A field at the top of the file.
    pub fn new(key: &str) -> Field {
        Field::default().key(key)
    }

    /// A field of this table.
    pub fn key(&self, key: &str) -> Field {
        self.then(Step::Key(key.to_owned()))
    }

    /// An element of this list, counted from 0.
    pub fn at(&self, index: usize) -> Field {
        self.then(Step::Index(index))
    }

    fn then(&self, step: Step) -> Field {
        let mut steps = self.0.clone();
        steps.push(step);
        Field(steps)
    }
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (position, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if position == 0 => f.write_str(key)?,
                Step::Key(key) => write!(f, ".{key}")?,
                Step::Index(index) => write!(f, "[{index}]")?,
            }
        }
        Ok(())
    }
}

/// Where a field begins, in bytes; where it does not exist, the last of its parents that does (0: none).
pub(super) fn offset(tree: &DeValue<'_>, field: &Field) -> usize {
    let mut value = tree;
    let mut offset = 0;
    for step in &field.0 {
        let next = match step {
            Step::Key(key) => value.as_table().and_then(|table| table.get_key_value(key.as_str())),
            Step::Index(index) => match value.get(*index) {
                Some(element) => {
                    offset = element.span().start;
                    value = element.get_ref();
                    continue;
                }
                None => None,
            },
        };
        let Some((key, inner)) = next else { break };
        offset = key.span().start;
        value = inner.get_ref();
    }
    offset
}

/// The innermost field whose key or value stands at an offset.
pub(super) fn at_offset(tree: &DeValue<'_>, offset: usize) -> Option<Field> {
    let mut found = None;
    visit(tree, &mut |field, _, spans| {
        if spans.iter().any(|span| span.contains(&offset)) {
            found = Some(field.clone());
        }
    });
    found
}

/// Calls `see` for every field, outer ones first, with its value and the places of its key (if any) and value.
pub(super) fn visit<'i>(tree: &DeValue<'i>, see: &mut impl FnMut(&Field, &DeValue<'i>, &[Range<usize>])) {
    visit_inside(tree, &Field::default(), see);
}

fn visit_inside<'i>(value: &DeValue<'i>, field: &Field, see: &mut impl FnMut(&Field, &DeValue<'i>, &[Range<usize>])) {
    match value {
        DeValue::Table(table) => {
            for (key, inner) in table.iter() {
                let field = field.key(key.get_ref());
                see(&field, inner.get_ref(), &[key.span(), inner.span()]);
                visit_inside(inner.get_ref(), &field, see);
            }
        }
        DeValue::Array(elements) => {
            for (index, element) in elements.iter().enumerate() {
                let field = field.at(index);
                see(&field, element.get_ref(), &[element.span()]);
                visit_inside(element.get_ref(), &field, see);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use toml::de::DeTable;

    use super::*;

    const TEXT: &str = "a.b = 1\n[[c]]\nd = [1, 2]\n[[c]]\nd = []\n[e]\nf = { g = 'x' }\n";

    fn tree() -> DeValue<'static> {
        DeValue::Table(DeTable::parse(TEXT).unwrap().into_inner())
    }

    #[test]
    fn fields_are_shown_as_they_are_spoken_of() {
        assert_eq!(Field::new("load").at(1).key("position_m").at(2).to_string(), "load[1].position_m[2]");
    }

    #[test]
    fn every_field_is_found_where_it_stands_and_back() {
        visit(&tree(), &mut |field, _, spans| {
            assert_eq!(offset(&tree(), field), spans[0].start, "{field}");
        });
        let inner = [Field::new("a").key("b"), Field::new("c").at(0).key("d").at(1), Field::new("e").key("f").key("g")];
        for field in inner {
            assert_eq!(at_offset(&tree(), offset(&tree(), &field)), Some(field));
        }
    }

    #[test]
    fn a_missing_field_is_where_its_parent_is() {
        let second = Field::new("c").at(1);
        assert_eq!(offset(&tree(), &second.key("d").at(3).key("x")), offset(&tree(), &second.key("d")));
        assert_eq!(offset(&tree(), &second.key("x")), TEXT.rfind("[[c]]").unwrap());
        assert_eq!(offset(&tree(), &Field::new("x")), 0);
    }

    #[test]
    fn between_fields_there_is_none() {
        assert_eq!(at_offset(&tree(), TEXT.find('=').unwrap()), None);
    }
}
