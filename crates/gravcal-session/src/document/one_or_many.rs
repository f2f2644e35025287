//! A value for all joints, or a list with one for each.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, IntoDeserializer, SeqAccess, Visitor};

/// Written as one value or as a list.
///
/// Read by hand and not by an untagged enum, whose errors neither say what was found nor where.
#[derive(Clone, Debug, PartialEq)]
pub enum OneOrMany<T> {
    /// One for all.
    One(T),
    /// One for each.
    Many(Vec<T>),
}

impl<T> OneOrMany<T> {
    /// What is written.
    pub fn as_slice(&self) -> &[T] {
        match self {
            OneOrMany::One(value) => std::slice::from_ref(value),
            OneOrMany::Many(values) => values,
        }
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for OneOrMany<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OneOrManyVisitor(PhantomData))
    }
}

struct OneOrManyVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for OneOrManyVisitor<T> {
    type Value = OneOrMany<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("one value for all joints or a list with one for each")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, values: A) -> Result<Self::Value, A::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(values)).map(OneOrMany::Many)
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Self::Value, E> {
        T::deserialize(value.into_deserializer()).map(OneOrMany::One)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
        T::deserialize(value.into_deserializer()).map(OneOrMany::One)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        T::deserialize(value.into_deserializer()).map(OneOrMany::One)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    fn parse<T: for<'de> Deserialize<'de>>(text: &str) -> Result<OneOrMany<T>, String> {
        let mut table: BTreeMap<String, OneOrMany<T>> = toml::from_str(text).map_err(|error| error.to_string())?;
        Ok(table.remove("x").unwrap())
    }

    #[test]
    fn one_value_or_a_list() {
        assert_eq!(parse("x = 'deg'"), Ok(OneOrMany::One("deg".to_owned())));
        assert_eq!(parse("x = ['deg', 'm']"), Ok(OneOrMany::Many(vec!["deg".to_owned(), "m".to_owned()])));
        assert_eq!(parse("x = 1"), Ok(OneOrMany::One(1.0)));
        assert_eq!(parse("x = [1, 0.5]"), Ok(OneOrMany::Many(vec![1.0, 0.5])));
    }

    #[test]
    fn what_is_neither_is_reported_with_its_place() {
        let message = parse::<f64>("x = true").unwrap_err();
        assert!(message.contains("invalid type: boolean `true`, expected one value for all joints or a list"));
        let message = parse::<f64>("x = 'a'").unwrap_err();
        assert!(message.contains("line 1, column 5") && message.contains("string \"a\", expected f64"), "{message}");
        let message = parse::<f64>("x = [1,\n'a']").unwrap_err();
        assert!(message.contains("line 2, column 1") && message.contains("string \"a\", expected f64"), "{message}");
    }
}
