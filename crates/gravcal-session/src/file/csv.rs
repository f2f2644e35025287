//! `[readings.csv]`: how CSV files are written, where that is not to be found by itself.

use gravcal_recording::CsvWriting;
use serde::Deserialize;

use super::context::Context;
use crate::document::{Field, FileError};

/// `[readings.csv]`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct CsvTable {
    /// `","`, `";"`, `"\t"` or `"|"`.
    ///
    /// Default: found.
    /// Example: `delimiter = ";"`
    delimiter: Option<String>,
    /// Whether numbers have a decimal comma.
    ///
    /// Default: found.
    /// Example: `decimal_comma = true`
    decimal_comma: Option<bool>,
    /// Whether the first line has names.
    ///
    /// Default: found.
    /// Example: `header = false`
    header: Option<bool>,
    /// Names of the columns of a file without a header.
    ///
    /// Default: `column1`, `column2`, ….
    /// Example: `columns = ["t", "q1", "y1"]`
    columns: Option<Vec<String>>,
}

/// Signs that may stand between cells.
const DELIMITERS: [(&str, u8); 4] = [(",", b','), (";", b';'), ("\t", b'\t'), ("|", b'|')];

/// What it comes to.
pub(super) fn resolve(context: &Context<'_>, table: &CsvTable) -> Result<CsvWriting, FileError> {
    let field = Field::new("readings").key("csv");
    let wrong = |key: &str, message: String| context.document.error(&field.key(key), message);
    let delimiter = table.delimiter.as_deref().map(|written| {
        let known = DELIMITERS.iter().find(|(sign, _)| *sign == written).map(|(_, byte)| *byte);
        known.ok_or_else(|| {
            let message = format!("{written:?} does not stand between cells: expected \",\", \";\", \"\\t\" or \"|\"");
            wrong("delimiter", message)
        })
    });
    let delimiter = delimiter.transpose()?;
    if delimiter == Some(b',') && table.decimal_comma == Some(true) {
        let message = "commas stand between cells, so they cannot stand in numbers: delete one of the two".to_owned();
        return Err(wrong("decimal_comma", message));
    }
    if let Some(names) = &table.columns {
        check_columns(context, &field, table, names)?;
    }
    let CsvTable { decimal_comma, header, ref columns, .. } = *table;
    Ok(CsvWriting { delimiter, decimal_comma, header, columns: columns.clone() })
}

/// Names of columns are all different, and of files without a header.
fn check_columns(context: &Context<'_>, field: &Field, table: &CsvTable, names: &[String]) -> Result<(), FileError> {
    let place = field.key("columns");
    if table.header == Some(true) {
        let message = "columns are named of files without a header, and header = true says that all have one: delete one of the two";
        return Err(context.document.error(&place, message));
    }
    if let Some(empty) = names.iter().position(String::is_empty) {
        return Err(context.document.error(&place.at(empty), "the name is empty: name every column"));
    }
    context.document.check_names(names.iter().map(String::as_str), |i| place.at(i))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use crate::file::tests::assert_refused;
    use crate::read_session;
    use crate::testing::TWO_JOINTS;

    #[test]
    fn signs_that_cannot_be_are_refused() {
        let with = |csv: &str| format!("[readings]\ncsv = {csv}");
        assert_refused(
            "[readings]",
            &with("{ delimiter = 'x' }"),
            "9: readings.csv.delimiter: \"x\" does not stand between cells: expected",
        );
        assert_refused(
            "[readings]",
            &with("{ delimiter = ',', decimal_comma = true }"),
            "9: readings.csv.decimal_comma: commas stand between cells",
        );
        assert_refused(
            "[readings]",
            &with("{ header = true, columns = ['a'] }"),
            "9: readings.csv.columns: columns are named of files without a header",
        );
        assert_refused(
            "[readings]",
            &with("{ columns = ['a', 'b', 'a'] }"),
            "9: readings.csv.columns[2]: `a` is already readings.csv.columns[0]",
        );
    }

    /// Tables without a header, whose columns are named by their numbers, in some ways of writing.
    #[test]
    fn tables_may_be_written_otherwise() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("robot.toml"), TWO_JOINTS).unwrap();
        let read = |csv: &str, table: &str| {
            fs::write(folder.path().join("a.csv"), table).unwrap();
            let session = format!(
                "robot = \"robot.toml\"\n[gravity]\nmagnitude_m_per_s2 = 9.8\n[readings]\n{csv}\n\
                 position = {{ columns = [\"column1\", \"column2\"], unit = \"rad\" }}\n\
                 torque = {{ columns = [\"column3\", \"column4\"], unit = \"N·m\" }}\n[[poses]]\nfile = \"a.csv\"\n"
            );
            fs::write(folder.path().join("session.toml"), session).unwrap();
            read_session(&folder.path().join("session.toml")).map(|read| read.poses).map_err(|error| error.to_string())
        };
        let table = "0.5,0.25,1.5,2.5\n0.75,0.5,3.5,4.5\n";
        let plain = read("", table).unwrap();
        assert_eq!((plain.len(), plain[0].line, &plain[1].position[..]), (2, 1, &[0.75, 0.5][..]));
        let commas = table.replace(',', ";").replace('.', ",");
        assert_eq!(read("", &commas).unwrap(), plain);
        let bars = commas.replace(';', "|");
        assert!(read("", &bars).is_err());
        assert_eq!(read("csv = { delimiter = \"|\", decimal_comma = true, header = false }", &bars).unwrap(), plain);
        let named = "csv = { columns = [\"column1\", \"column2\", \"column3\", \"column4\"] }";
        assert_eq!(read(named, table).unwrap(), plain);
        let few = read("csv = { columns = [\"q1\", \"column1\"] }", table).unwrap_err();
        assert!(few.contains("its rows have 4 cells, and 2 columns are named"), "{few}");
        assert!(read("csv = { header = true }", table).unwrap_err().contains("there is no column `column1`"));
    }
}
