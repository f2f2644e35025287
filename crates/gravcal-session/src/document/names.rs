//! Names in a document that stand for something elsewhere: looked up, and declared once.

use gravcal_recording::nearest_name;

use super::field::Field;
use super::file_error::FileError;
use super::toml_document::Document;

impl Document {
    /// The place of a name among `known`.
    ///
    /// `what` is the noun: "link".
    ///
    /// # Errors
    /// There is none of that name; the error lists those there are.
    pub fn lookup(&self, field: &Field, what: &str, name: &str, known: &[&str]) -> Result<usize, FileError> {
        known.iter().position(|candidate| *candidate == name).ok_or_else(|| {
            let suggestion =
                nearest_name(name, known).map(|near| format!(" (did you mean `{near}`?)")).unwrap_or_default();
            self.error(field, format!("there is no {what} `{name}`{suggestion}; {}", listed(what, known)))
        })
    }

    /// Sees to it that each name is there and declared only once; `field` gives the field of a name's place.
    ///
    /// # Errors
    /// A name is empty, or stands twice.
    pub fn check_names<'a>(
        &self,
        names: impl IntoIterator<Item = &'a str>,
        field: impl Fn(usize) -> Field,
    ) -> Result<(), FileError> {
        let mut seen: Vec<&str> = Vec::new();
        for (place, name) in names.into_iter().enumerate() {
            if name.is_empty() {
                return Err(self.error(&field(place), "the name is empty: give it one, results are told by it"));
            }
            if let Some(first) = seen.iter().position(|other| *other == name) {
                let first = field(first);
                return Err(self.error(&field(place), format!("`{name}` is already {first}: give each its own name")));
            }
            seen.push(name);
        }
        Ok(())
    }
}

fn listed(what: &str, known: &[&str]) -> String {
    if known.is_empty() {
        return format!("no {what} is declared");
    }
    let quoted: Vec<String> = known.iter().map(|name| format!("`{name}`")).collect();
    format!("known: {}", quoted.join(", "))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn document() -> Document {
        Document::of(Path::new("a.toml"), "\nx = 0\n".into()).unwrap()
    }

    #[test]
    fn unknown_names_are_reported_with_the_known_ones() {
        let x = Field::new("x");
        let lookup = |name: &str, known: &[&str]| document().lookup(&x, "link", name, known);
        assert_eq!(lookup("b", &["a", "b"]), Ok(1));
        let message = |name: &str, known: &[&str]| lookup(name, known).unwrap_err().to_string();
        assert_eq!(
            message("hnd", &["arm", "hand"]),
            "a.toml:2: x: there is no link `hnd` (did you mean `hand`?); known: `arm`, `hand`"
        );
        assert_eq!(message("tool", &["arm"]), "a.toml:2: x: there is no link `tool`; known: `arm`");
        assert_eq!(message("tool", &[]), "a.toml:2: x: there is no link `tool`; no link is declared");
    }

    #[test]
    fn names_are_declared_once() {
        let check = |names: &[&str]| document().check_names(names.iter().copied(), |i| Field::new("x").at(i));
        assert_eq!(check(&["a", "b"]), Ok(()));
        let message = |names: &[&str]| check(names).unwrap_err().to_string();
        assert_eq!(message(&["a", "b", "a"]), "a.toml:2: x[2]: `a` is already x[0]: give each its own name");
        assert!(message(&["a", ""]).starts_with("a.toml:2: x[1]: the name is empty"));
    }
}
