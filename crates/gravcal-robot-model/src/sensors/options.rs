//! What an entry of `sensor_models` says besides the name of its model.

use toml::{Table, Value};

/// The options of one entry, by their keys in the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options(Table);

/// An option that a model cannot do with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusedOption {
    /// The way to it in the entry, from its key; `kind` where the model does not suit the joint.
    pub keys: Vec<String>,
    /// What is wrong, what was expected, what to do.
    pub message: String,
}

impl RefusedOption {
    /// The option of this key.
    pub fn new(key: &str, message: impl Into<String>) -> RefusedOption {
        RefusedOption { keys: vec![key.to_owned()], message: message.into() }
    }

    /// The same inside the table of this key.
    #[must_use]
    pub fn within(mut self, key: &str) -> RefusedOption {
        self.keys.insert(0, key.to_owned());
        self
    }
}

impl Options {
    /// Those of a table.
    pub fn of(table: Table) -> Options {
        Options(table)
    }

    /// The same with one more.
    #[must_use]
    pub fn with(mut self, key: &str, value: impl Into<Value>) -> Options {
        self.0.insert(key.to_owned(), value.into());
        self
    }

    /// Keys that are given.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// A number.
    ///
    /// # Errors
    /// It is something else.
    pub fn number(&self, key: &str) -> Result<Option<f64>, RefusedOption> {
        self.read(key, "a number", |value| value.as_float().or(value.as_integer().map(|whole| whole as f64)))
    }

    /// A whole number.
    ///
    /// # Errors
    /// It is something else.
    pub fn whole_number(&self, key: &str) -> Result<Option<i64>, RefusedOption> {
        self.read(key, "a whole number", Value::as_integer)
    }

    /// A text.
    ///
    /// # Errors
    /// It is something else.
    pub fn text(&self, key: &str) -> Result<Option<&str>, RefusedOption> {
        self.read(key, "a text", Value::as_str)
    }

    /// A list of numbers.
    ///
    /// # Errors
    /// It is something else.
    pub fn numbers(&self, key: &str) -> Result<Option<Vec<f64>>, RefusedOption> {
        let number = |value: &Value| value.as_float().or(value.as_integer().map(|whole| whole as f64));
        self.read(key, "a list of numbers", |value| value.as_array()?.iter().map(number).collect())
    }

    /// A list of whole numbers.
    ///
    /// # Errors
    /// It is something else.
    pub fn whole_numbers(&self, key: &str) -> Result<Option<Vec<i64>>, RefusedOption> {
        self.read(key, "a list of whole numbers", |value| value.as_array()?.iter().map(Value::as_integer).collect())
    }

    /// A list of texts.
    ///
    /// # Errors
    /// It is something else.
    pub fn texts(&self, key: &str) -> Result<Option<Vec<String>>, RefusedOption> {
        let text = |value: &Value| value.as_str().map(str::to_owned);
        self.read(key, "a list of texts", |value| value.as_array()?.iter().map(text).collect())
    }

    /// Tables by name.
    pub(super) fn tables(&self, key: &str) -> Result<Option<Vec<(&str, Options)>>, RefusedOption> {
        let Some(tables) = self.read(key, "a table of tables", Value::as_table)? else { return Ok(None) };
        let table = |(name, value): (&'_ String, &'_ Value)| {
            let table = value.as_table().ok_or_else(|| unfitting(name, "a table", value).within(key))?;
            Ok(Options(table.clone()))
        };
        let all = tables.iter().map(|(name, value)| Ok((name.as_str(), table((name, value))?)));
        all.collect::<Result<Vec<_>, _>>().map(Some)
    }

    fn read<'v, T>(
        &'v self,
        key: &str,
        expected: &str,
        read: impl FnOnce(&'v Value) -> Option<T>,
    ) -> Result<Option<T>, RefusedOption> {
        let Some(value) = self.0.get(key) else { return Ok(None) };
        read(value).map(Some).ok_or_else(|| unfitting(key, expected, value))
    }
}

fn unfitting(key: &str, expected: &str, value: &Value) -> RefusedOption {
    RefusedOption::new(key, format!("expected {expected}, found {} ({value})", in_words(value)))
}

fn in_words(value: &Value) -> &'static str {
    match value {
        Value::String(_) => "a text",
        Value::Integer(_) | Value::Float(_) => "a number",
        Value::Boolean(_) => "true or false",
        Value::Datetime(_) => "a date",
        Value::Array(_) => "a list",
        Value::Table(_) => "a table",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_of_another_kind_is_refused_with_what_was_expected() {
        let options = Options::default().with("degree", 2.5).with("reference", 3).with("orders", vec![1, 2]);
        assert_eq!(options.number("reference"), Ok(Some(3.0)));
        assert_eq!(options.whole_numbers("orders"), Ok(Some(vec![1, 2])));
        assert_eq!((options.text("absent"), options.keys().count()), (Ok(None), 3));
        let refused = options.whole_number("degree").unwrap_err();
        assert_eq!(refused, RefusedOption::new("degree", "expected a whole number, found a number (2.5)"));
        assert_eq!(refused.within("inner").keys, ["inner", "degree"]);
    }
}
