//! A TOML file with what is wrong in it.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use gravcal_recording::{in_command, nearest_name};
use serde::de::{DeserializeOwned, DeserializeSeed};
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::environment;
use super::field::{self, Field};
use super::file_error::FileError;
use super::text::read_text;

/// How names of recordings end.
const RECORDINGS: [&str; 5] = ["csv", "tsv", "mcap", "db3", "parquet"];

/// What is said of XML: a robot whose file is not named as a URDF is taken for a `robot.toml`.
const IS_XML: &str = "this is XML, where a TOML file is expected; the name of a URDF must end in .urdf, and xacro must be expanded first \
                      (`xacro robot.xacro > robot.urdf`)";

/// A TOML file: syntactically right, every number finite.
#[derive(Clone, Debug)]
pub struct Document {
    path: PathBuf,
    text: String,
}

impl Document {
    /// Reads a file.
    ///
    /// # Errors
    /// The file is a recording by its name, cannot be read, is XML or else not TOML, or holds a number that is infinite or NaN.
    pub fn read(path: &Path) -> Result<Document, FileError> {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        if RECORDINGS.iter().any(|recording| extension.eq_ignore_ascii_case(recording)) {
            let inspect =
                format!("`gravcal inspect {} --session session.toml` writes a session for it", in_command(path));
            return Err(FileError::new(path, format!("this is a recording, where a TOML file is expected; {inspect}")));
        }
        Document::of(path, read_text(path)?)
    }

    /// The document of that text; `path` is where it stands, or would.
    ///
    /// # Errors
    /// As for [`Document::read`], but for reading.
    pub fn of(path: &Path, text: String) -> Result<Document, FileError> {
        if text.trim_start_matches('\u{feff}').trim_start().starts_with('<') {
            return Err(FileError::new(path, IS_XML));
        }
        let document = Document { path: path.to_owned(), text };
        document.check_finite()?;
        Ok(document)
    }

    /// Where it stands.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What it says, as it is written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// What the document says, as a `T`.
    ///
    /// # Errors
    /// An unknown or missing key, a value of the wrong type: what serde sees.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, FileError> {
        toml::from_str(&self.text).map_err(|error| self.toml_error(&error))
    }

    /// What the table `key` at the top says, as `seed` wants it, but for its entry `left_out`. Anything but a table is as
    /// good as an empty one.
    ///
    /// # Errors
    /// What `seed` refuses.
    pub fn parse_table<T>(
        &self,
        key: &str,
        left_out: &str,
        seed: impl for<'de> DeserializeSeed<'de, Value = T>,
    ) -> Result<T, FileError> {
        let parse = || {
            let found = DeTable::parse(&self.text)?.into_inner().remove(key);
            let span = found.as_ref().map_or(0..0, Spanned::span);
            let mut table = match found.map(Spanned::into_inner) {
                Some(DeValue::Table(table)) => table,
                _ => DeTable::new(),
            };
            table.remove(left_out);
            seed.deserialize(ValueDeserializer::from(Spanned::new(span, DeValue::Table(table))))
        };
        parse().map_err(|mut error: toml::de::Error| {
            error.set_input(Some(&self.text));
            self.toml_error(&error)
        })
    }

    /// An error in a field. Its line is that of the field or, where the field is missing, of what should hold it.
    pub fn error(&self, field: &Field, message: impl Display) -> FileError {
        let error = FileError::new(&self.path, message).in_field(field);
        match self.line_of(field) {
            Some(line) => error.at_line(line),
            None => error,
        }
    }

    /// The path that is written in a field: `${NAME}` and `${NAME:-default}` replaced by the environment's values, and
    /// taken relative to the folder of this document.
    ///
    /// # Errors
    /// The path is empty, a variable is not set and has no default, or a `${` is not closed.
    pub fn resolve_path(&self, field: &Field, written: &str) -> Result<PathBuf, FileError> {
        let expanded = environment::expand(written, environment::variable).map_err(|error| self.error(field, error))?;
        if expanded.text.is_empty() {
            return Err(self.error(field, "the path is empty: name a file, relative to the folder of this one"));
        }
        Ok(self.path.parent().unwrap_or(Path::new("")).join(expanded.text))
    }

    /// Says which field named another file, and which variables of the environment had a part in it: a note for errors
    /// in that file.
    pub fn named_by(&self, field: &Field, written: &str) -> String {
        let line = self.line_of(field).map(|line| format!(":{line}")).unwrap_or_default();
        let mut note = format!("named by {field} in {}{line}", self.path.display());
        if let Ok(expanded) = environment::expand(written, environment::variable) {
            expanded.explanations.iter().for_each(|explanation| note.push_str(&format!("\n  {explanation}")));
        }
        note
    }

    fn tree(&self) -> Result<DeValue<'_>, toml::de::Error> {
        DeTable::parse(&self.text).map(|table| DeValue::Table(table.into_inner()))
    }

    fn line_of(&self, field: &Field) -> Option<usize> {
        let tree = self.tree().ok()?;
        Some(self.line_at(field::offset(&tree, field)))
    }

    fn line_at(&self, offset: usize) -> usize {
        1 + self.text.bytes().take(offset).filter(|byte| *byte == b'\n').count()
    }

    /// TOML knows `inf` and `nan`; no quantity of ours does.
    fn check_finite(&self) -> Result<(), FileError> {
        let tree = self.tree().map_err(|error| self.toml_error(&error))?;
        let mut broken = None;
        field::visit(&tree, &mut |field, value, _| {
            let number = value.as_float().filter(|float| !float.as_str().parse().is_ok_and(f64::is_finite));
            if let (Some(number), None) = (number, &broken) {
                broken = Some(self.error(field, format!("expected a finite number, found {number}")));
            }
        });
        broken.map_or(Ok(()), Err)
    }

    /// What the toml crate says, with the place in our words and its picture of the line.
    fn toml_error(&self, error: &toml::de::Error) -> FileError {
        let mut reported = FileError::new(&self.path, toml_message(error));
        if let Some(span) = error.span() {
            reported = reported.at_line(self.line_at(span.start));
            let field = self.tree().ok().and_then(|tree| field::at_offset(&tree, span.start));
            reported = field.iter().fold(reported, FileError::in_field);
        }
        reported
    }
}

/// The message before the picture; the heading, which repeats line and column, is left out.
fn toml_message(error: &toml::de::Error) -> String {
    let message = with_suggestion(plain(error.message()));
    let shown = error.to_string();
    let picture = shown.trim_end().strip_suffix(error.message()).unwrap_or_default();
    let picture = picture.split_once('\n').map_or("", |(_heading, picture)| picture.trim_end());
    match picture {
        "" => message,
        picture => format!("{message}\n{picture}"),
    }
}

/// An unknown field that is near a known one is told with it.
fn with_suggestion(message: String) -> String {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let unknown = quoted.next().filter(|_| message.starts_with("unknown field"));
    let known: Vec<&str> = quoted.collect();
    match unknown.and_then(|unknown| nearest_name(unknown, &known)) {
        Some(near) => format!("{message} (did you mean `{near}`?)"),
        None => message,
    }
}

/// Where serde speaks of Rust's types, what a user writes.
fn plain(message: &str) -> String {
    const WORDS: [(&str, &str); 6] = [
        ("invalid type: map, expected a sequence", "one table where a list is expected: double its brackets, [[...]]"),
        ("expected a sequence", "expected a list"),
        ("expected f64", "expected a number"),
        ("expected u8", "expected a whole number"),
        ("expected u64", "expected a whole number"),
        ("expected usize", "expected a whole number"),
    ];
    WORDS.iter().fold(message.to_owned(), |message, (rust, words)| message.replace(rust, words))
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    const TEXT: &str = "\
scale = 2
[[load]]
name = 'a'

[[load]]
name = 'b'
place = [
    1,
    2.5,
]
";

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Loads {
        #[expect(dead_code)]
        scale: f64,
        load: Vec<Load>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Load {
        name: String,
        #[expect(dead_code)]
        place: Option<[f64; 2]>,
    }

    fn document(text: &str) -> Result<Document, FileError> {
        Document::of(Path::new("folder/a.toml"), text.to_owned())
    }

    fn parse_error(text: &str) -> String {
        document(text).and_then(|document| document.parse::<Loads>()).unwrap_err().to_string()
    }

    #[test]
    fn a_field_is_found_or_else_what_should_hold_it() {
        let document = document(TEXT).unwrap();
        let load = Field::new("load");
        let reported = |field: &Field| document.error(field, "is wrong").to_string();
        assert_eq!(reported(&load.at(1).key("name")), "folder/a.toml:6: load[1].name: is wrong");
        assert_eq!(reported(&load.at(1).key("place").at(1)), "folder/a.toml:9: load[1].place[1]: is wrong");
        assert_eq!(reported(&load.at(0).key("mass")), "folder/a.toml:2: load[0].mass: is wrong");
        assert_eq!(reported(&load.at(7)), "folder/a.toml:2: load[7]: is wrong");
        assert_eq!(reported(&Field::new("gravity")), "folder/a.toml:1: gravity: is wrong");
    }

    #[test]
    fn what_serde_refuses_is_reported_with_field_and_picture() {
        let misspelt = TEXT.replace("name = 'b'", "nam = 'b'");
        assert_eq!(
            parse_error(&misspelt),
            "folder/a.toml:6: load[1].nam: unknown field `nam`, expected `name` or `place` (did you mean `name`?)\n  |\n6 | nam = 'b'\n  | ^^^"
        );
        let text = TEXT.replace("    1,", "    'one',");
        assert!(
            parse_error(&text)
                .starts_with("folder/a.toml:8: load[1].place[0]: invalid type: string \"one\", expected a number\n")
        );
        assert!(
            parse_error("scale = 1\n[load]\n").starts_with(
                "folder/a.toml:2: load: one table where a list is expected: double its brackets, [[...]]\n"
            )
        );
        let missing = TEXT.replace("name = 'b'\n", "");
        assert!(parse_error(&missing).starts_with("folder/a.toml:5: load[1]: missing field `name`"));
    }

    #[test]
    fn what_is_no_toml_is_reported_with_its_line() {
        let twice = parse_error("scale = 1\nscale = 2\n");
        assert!(twice.starts_with("folder/a.toml:2: duplicate key\n"), "{twice}");
        let open = parse_error("scale = \"1\n");
        assert!(open.starts_with("folder/a.toml:1: invalid basic string"), "{open}");
    }

    #[test]
    fn numbers_are_finite() {
        for number in ["nan", "-inf", "+inf", "inf"] {
            let text = TEXT.replace("2.5", number);
            assert_eq!(
                parse_error(&text),
                format!("folder/a.toml:9: load[1].place[1]: expected a finite number, found {number}")
            );
        }
        assert!(parse_error("scale = 1e999").starts_with("folder/a.toml:1: scale: expected a finite number"));
    }

    #[test]
    fn whole_numbers_are_numbers() {
        let loads: Loads = document(TEXT).unwrap().parse().unwrap();
        assert_eq!(loads.load[1].name, "b");
    }

    #[test]
    fn paths_are_relative_to_the_document() {
        let document = document(TEXT).unwrap();
        let field = Field::new("scale");
        let resolved = |written: &str| document.resolve_path(&field, written).map_err(|error| error.to_string());
        assert_eq!(resolved("../b.csv"), Ok(PathBuf::from("folder/../b.csv")));
        assert_eq!(resolved("/b.csv"), Ok(PathBuf::from("/b.csv")));
        assert_eq!(resolved("${GRAVCAL_NO_SUCH_VARIABLE:-data}/b.csv"), Ok(PathBuf::from("folder/data/b.csv")));
        assert!(resolved("").unwrap_err().starts_with("folder/a.toml:1: scale: the path is empty"));
        assert!(resolved("${GRAVCAL_NO_SUCH_VARIABLE}/b.csv").unwrap_err().contains("GRAVCAL_NO_SUCH_VARIABLE"));
    }

    #[test]
    fn a_note_tells_who_named_a_file() {
        let document = document(TEXT).unwrap();
        let field = Field::new("load").at(1).key("name");
        assert_eq!(document.named_by(&field, "b.csv"), "named by load[1].name in folder/a.toml:6");
        assert_eq!(
            document.named_by(&field, "${GRAVCAL_NO_SUCH_VARIABLE:-data}/b.csv"),
            "named by load[1].name in folder/a.toml:6\n  the environment variable GRAVCAL_NO_SUCH_VARIABLE is not set, \
             so its default `data` is used; set it if the files lie elsewhere"
        );
    }
}
