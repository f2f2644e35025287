//! A number for all links, or a table with one for each that is named.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Visitor};

/// Written as one number or as a table by name.
#[derive(Clone, Debug, PartialEq)]
pub enum OneOrNamed {
    /// One for all.
    One(f64),
    /// One for each that is named.
    Named(BTreeMap<String, f64>),
}

impl<'de> Deserialize<'de> for OneOrNamed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OneOrNamedVisitor)
    }
}

struct OneOrNamedVisitor;

impl<'de> Visitor<'de> for OneOrNamedVisitor {
    type Value = OneOrNamed;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("one number for all links or a table with one for each that is named")
    }

    fn visit_map<A: MapAccess<'de>>(self, values: A) -> Result<Self::Value, A::Error> {
        BTreeMap::deserialize(MapAccessDeserializer::new(values)).map(OneOrNamed::Named)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
        Ok(OneOrNamed::One(value as f64))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        Ok(OneOrNamed::One(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<OneOrNamed, String> {
        let mut table: BTreeMap<String, OneOrNamed> = toml::from_str(text).map_err(|error| error.to_string())?;
        Ok(table.remove("x").unwrap())
    }

    #[test]
    fn one_number_or_a_table() {
        assert_eq!(parse("x = 1"), Ok(OneOrNamed::One(1.0)));
        assert_eq!(parse("x = 0.5"), Ok(OneOrNamed::One(0.5)));
        let named = BTreeMap::from([("a".to_owned(), 1.0), ("b".to_owned(), 0.5)]);
        assert_eq!(parse("x = { b = 0.5, a = 1 }"), Ok(OneOrNamed::Named(named)));
    }

    #[test]
    fn what_is_neither_is_reported_with_its_place() {
        let message = parse("x = 'far'").unwrap_err();
        assert!(message.contains("string \"far\", expected one number for all links or a table"), "{message}");
        let message = parse("x = { a = 'far' }").unwrap_err();
        assert!(message.contains("string \"far\", expected f64"), "{message}");
    }
}
