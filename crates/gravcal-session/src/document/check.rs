//! Checks of single values that many fields need.

use super::field::Field;
use super::file_error::FileError;
use super::one_or_many::OneOrMany;
use super::one_or_named::OneOrNamed;
use super::toml_document::Document;

impl Document {
    /// A number above zero.
    ///
    /// `what` is a noun with its article ("a mass"), `unit` what it is counted in.
    ///
    /// # Errors
    /// Zero or below.
    pub fn positive(&self, field: &Field, value: f64, what: &str, unit: &str) -> Result<f64, FileError> {
        if value > 0.0 {
            return Ok(value);
        }
        Err(self.error(field, format!("{value} is not {what}: expected a positive number of {unit}")))
    }

    /// A positive number for each of `names`, from one for all or a table; `None` for a name that the table leaves out.
    ///
    /// `noun` is what the names are of ("link"), `what` and `unit` as for [`Document::positive`].
    ///
    /// # Errors
    /// A number that is not positive, a name that is not known.
    pub fn positive_by_name(
        &self,
        field: &Field,
        written: &OneOrNamed,
        (noun, names): (&str, &[&str]),
        (what, unit): (&str, &str),
    ) -> Result<Vec<Option<f64>>, FileError> {
        match written {
            OneOrNamed::One(all) => Ok(vec![Some(self.positive(field, *all, what, unit)?); names.len()]),
            OneOrNamed::Named(named) => {
                let mut values = vec![None; names.len()];
                for (name, value) in named {
                    let field = field.key(name);
                    let place = self.lookup(&field, noun, name, names)?;
                    values[place] = Some(self.positive(&field, *value, what, unit)?);
                }
                Ok(values)
            }
        }
    }

    /// One value for each of `names` ("joints"), from one for all or a list.
    ///
    /// # Errors
    /// The list is not as long as `names`.
    pub fn for_each<T: Clone>(
        &self,
        field: &Field,
        values: &OneOrMany<T>,
        names: &[&str],
    ) -> Result<Vec<T>, FileError> {
        match values {
            OneOrMany::One(value) => Ok(vec![value.clone(); names.len()]),
            OneOrMany::Many(values) => self.one_each(field, values, names).cloned(),
        }
    }

    /// A list that must have one entry for each of `names`, the joints.
    ///
    /// # Errors
    /// It has not.
    pub fn one_each<'a, T>(&self, field: &Field, list: &'a Vec<T>, names: &[&str]) -> Result<&'a Vec<T>, FileError> {
        if list.len() == names.len() {
            return Ok(list);
        }
        let (found, expected, joints) = (list.len(), names.len(), names.join(", "));
        Err(self.error(field, format!("expected {expected} entries, one for each joint ({joints}), found {found}")))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn checks_tell_what_was_expected() {
        let document = Document::of(Path::new("a.toml"), "\nx = 0\n".into()).unwrap();
        let x = Field::new("x");
        assert_eq!(document.positive(&x, 1.5, "a mass", "kg"), Ok(1.5));
        for (value, shown) in [(0.0, "0"), (-1.7, "-1.7")] {
            assert_eq!(
                document.positive(&x, value, "a mass", "kg").unwrap_err().to_string(),
                format!("a.toml:2: x: {shown} is not a mass: expected a positive number of kg")
            );
        }
        let names = ["a", "b"];
        assert_eq!(document.for_each(&x, &OneOrMany::One(3), &names), Ok(vec![3, 3]));
        assert_eq!(document.for_each(&x, &OneOrMany::Many(vec![3, 4]), &names), Ok(vec![3, 4]));
        assert_eq!(
            document.for_each(&x, &OneOrMany::Many(vec![3]), &names).unwrap_err().to_string(),
            "a.toml:2: x: expected 2 entries, one for each joint (a, b), found 1"
        );
    }
}
