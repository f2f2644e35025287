//! `--columns`: names of the columns of a CSV file without a header.

use std::path::Path;

use clap::Args;
use gravcal_recording::{CsvWriting, open_as};

use crate::failure::Failure;

/// The names.
#[derive(Debug, Args)]
pub struct ColumnNames {
    /// Names of the columns of a CSV file without a header, such as t_s,q1_deg,q2_deg,tau1_Nm,tau2_Nm
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    columns: Option<Vec<String>>,
}

impl ColumnNames {
    /// How a file is written whose columns have these names, if there are any, and all else is as it is said to be.
    pub fn of(&self, file: &Path, said: &CsvWriting) -> Result<CsvWriting, Failure> {
        let Some(names) = &self.columns else { return Ok(said.clone()) };
        let names: Vec<String> = names.iter().map(|name| name.trim().to_owned()).collect();
        if let Some(place) =
            (0..names.len()).find(|place| names[*place].is_empty() || names[..*place].contains(&names[*place]))
        {
            let what = if names[place].is_empty() { "has no name" } else { "has the name of another one" };
            return Err(Failure::said(format!("--columns: column {} {what}", place + 1)).hint("name each column once"));
        }
        let csv = CsvWriting { columns: Some(names.clone()), ..said.clone() };
        let rows = open_as(file, &csv).map_err(|error| Failure::bad_input(&error))?;
        if rows.columns() != names {
            let (subject, own) = (file.display(), rows.columns().join(", "));
            let message = format!(
                "{subject}: --columns is for CSV files without a header, and this file names its columns itself: {own}"
            );
            return Err(Failure::said(message).hint("leave --columns away"));
        }
        Ok(csv)
    }
}
