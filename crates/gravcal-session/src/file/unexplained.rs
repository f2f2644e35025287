//! `unexplained_std`, beside `std`: errors of readings that their noise does not explain.
//!
//! Means of standstills and of sweeps state the noise that was measured in them, which is far less than what friction leaves at rest: there
//! such errors are estimated where nothing is said. Who states a std by hand means all errors by it.

use std::fmt;

use gravcal_robot_model::session::{Session, UnexplainedError};
use serde::de::{Deserialize, Deserializer, Error, Visitor};

use super::context::Context;
use super::reading_columns::ReadingColumnsTable;
use crate::document::{Document, Field, FileError};

/// As it is written: `"estimated"`, `"none"`, or a standard deviation in the unit of the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Written(UnexplainedError);

impl<'de> Deserialize<'de> for Written {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(WrittenVisitor)
    }
}

struct WrittenVisitor;

impl Visitor<'_> for WrittenVisitor {
    type Value = Written;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("\"estimated\", \"none\" or a standard deviation in the unit of the readings")
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<Written, E> {
        match word {
            "estimated" => Ok(Written(UnexplainedError::Estimated)),
            "none" => Ok(Written(UnexplainedError::Absent)),
            other => Err(E::custom(format!(
                "`{other}` says nothing of unexplained errors: expected \"estimated\", \"none\" or a standard deviation"
            ))),
        }
    }

    fn visit_i64<E: Error>(self, std: i64) -> Result<Written, E> {
        self.visit_f64(std as f64)
    }

    fn visit_f64<E: Error>(self, std: f64) -> Result<Written, E> {
        match std {
            0.0 => Ok(Written(UnexplainedError::Absent)),
            _ if std > 0.0 && std.is_finite() => Ok(Written(UnexplainedError::Stated { std })),
            _ => Err(E::custom(format!(
                "{std} is no standard deviation: expected a positive number, \"estimated\" or \"none\""
            ))),
        }
    }
}

/// What is said of a channel, and where.
#[derive(Clone, Debug)]
pub(crate) struct Said {
    error: UnexplainedError,
    field: Field,
}

/// What a table of readings says of its columns, one for each; nothing where nothing is said.
pub(super) fn said(
    context: &Context<'_>,
    field: &Field,
    names: &[&str],
    table: &ReadingColumnsTable,
) -> Result<Vec<Option<Said>>, FileError> {
    let field = field.key("unexplained_std");
    let Some(written) = &table.unexplained_std else { return Ok(vec![None; names.len()]) };
    let each = context.document.for_each(&field, written, names)?;
    Ok(each.into_iter().map(|Written(error)| Some(Said { error, field: field.clone() })).collect())
}

/// The session with what is said of each channel; where nothing is, errors of means that were found in recordings are estimated.
///
/// # Errors
/// Where something is said that cannot be told from the rest.
pub(super) fn resolve(
    document: &Document,
    said: &[Option<Said>],
    recorded: bool,
    session: Session,
) -> Result<Session, FileError> {
    let unstated = session.noise_estimated();
    for (channel, Said { error, field }) in said.iter().enumerate().filter_map(|(c, said)| Some((c, said.as_ref()?))) {
        if *error != UnexplainedError::Absent && unstated[channel] {
            let name = session.channel_name(channel);
            let message = format!(
                "readings of {name} state no std, so that all their errors are estimated from the residuals: state the std of \
                 their noise, or leave this out"
            );
            return Err(document.error(field, message));
        }
    }
    let default = if recorded { UnexplainedError::Estimated } else { UnexplainedError::Absent };
    let unexplained = said.iter().map(|said| said.as_ref().map_or(default, |said| said.error)).collect();
    Ok(Session { unexplained, ..session })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{changed, read};
    use super::*;

    const STATED: &str = "std = 0.8 }";

    fn said(written: &str) -> Result<Session, String> {
        read(&[("session.toml", STATED, &format!("std = 0.8, unexplained_std = {written} }}"))])
    }

    #[test]
    fn it_is_said_for_all_joints_or_for_each() {
        use UnexplainedError::{Absent, Estimated, Stated};
        let errors = |written: &str| said(written).unwrap().unexplained_errors();
        assert_eq!(errors("\"estimated\""), [Estimated; 2]);
        assert_eq!(errors("\"none\""), [Absent; 2]);
        assert_eq!(errors("0.5"), [Stated { std: 0.5 }; 2]);
        assert_eq!(errors("[\"estimated\", 2]"), [Estimated, Stated { std: 2.0 }]);
        assert_eq!(
            changed(STATED, STATED).unexplained_errors(),
            [Absent; 2],
            "who states a std means all errors by it"
        );
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let message = said("-1").unwrap_err();
        assert!(message.contains("-1 is no standard deviation") && message.starts_with("session.toml:10"), "{message}");
        let message = said("\"yes\"").unwrap_err();
        assert!(message.contains("`yes` says nothing of unexplained errors: expected \"estimated\""), "{message}");
        let message = said("[0.1]").unwrap_err();
        assert!(message.contains("unexplained_std: expected 2 entries, one for each joint"), "{message}");
        let message = read(&[("session.toml", STATED, "unexplained_std = \"estimated\" }")]).unwrap_err();
        assert!(message.contains("readings.torque.unexplained_std: readings of shoulder state no std"), "{message}");
    }
}
