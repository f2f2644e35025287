//! Variables of the environment in paths: `${NAME}` and `${NAME:-default}`, as in a shell.
//!
//! So a session can name data that lies elsewhere on another machine. As in a shell, the default also replaces a
//! variable that is set but empty.

/// A text with its variables replaced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Expanded {
    /// The text.
    pub text: String,
    /// For each variable, what became of it: told to the user when the path leads nowhere.
    pub explanations: Vec<String>,
}

/// Why a text cannot be expanded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum ExpandError {
    /// A variable without default is not set.
    #[error(
        "the environment variable {0} is not set: set it (export {0}=...) to what should stand there, or give a \
         default: ${{{0}:-default}}"
    )]
    Unset(String),
    /// `${` without `}`.
    #[error("`{0}` is not closed: expected ${{NAME}} or ${{NAME:-default}}")]
    Unclosed(String),
    /// Not the name of a variable.
    #[error(
        "`${{{0}}}` does not name a variable: expected ${{NAME}} or ${{NAME:-default}}, NAME of letters, digits and _"
    )]
    BadName(String),
}

/// The value of a variable of this program's environment, if it is set to UTF-8 text.
pub(super) fn variable(name: &str) -> Option<String> {
    std::env::var(name).ok()
}

/// Replaces every `${…}` in a text with what `lookup` knows.
pub(super) fn expand(written: &str, lookup: impl Fn(&str) -> Option<String>) -> Result<Expanded, ExpandError> {
    let mut expanded = Expanded { text: String::new(), explanations: Vec::new() };
    let mut rest = written;
    while let Some((before, inside)) = rest.split_once("${") {
        let (inside, after) = inside.split_once('}').ok_or_else(|| ExpandError::Unclosed(format!("${{{inside}")))?;
        expanded.text.push_str(before);
        expanded.push_variable(inside, &lookup)?;
        rest = after;
    }
    expanded.text.push_str(rest);
    Ok(expanded)
}

impl Expanded {
    fn push_variable(&mut self, inside: &str, lookup: impl Fn(&str) -> Option<String>) -> Result<(), ExpandError> {
        let (name, default) = match inside.split_once(":-") {
            Some((name, default)) => (name, Some(default)),
            None => (inside, None),
        };
        if !is_name(name) {
            return Err(ExpandError::BadName(inside.to_owned()));
        }
        let (value, explanation) = match (lookup(name).filter(|value| !value.is_empty()), default) {
            (Some(value), _) => {
                let explanation = format!("the environment variable {name} is set to `{value}`");
                (value, explanation)
            }
            (None, Some(default)) => (
                default.to_owned(),
                format!(
                    "the environment variable {name} is not set, so its default `{default}` is used; set it if the \
                     files lie elsewhere"
                ),
            ),
            (None, None) => return Err(ExpandError::Unset(name.to_owned())),
        };
        self.text.push_str(&value);
        self.explanations.push(explanation);
        Ok(())
    }
}

fn is_name(name: &str) -> bool {
    let letters = name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    letters && name.starts_with(|first: char| !first.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(written: &str) -> Result<String, ExpandError> {
        let lookup = |name: &str| match name {
            "DATA" => Some("/data".to_owned()),
            "EMPTY" => Some(String::new()),
            _ => None,
        };
        expand(written, lookup).map(|expanded| expanded.text)
    }

    #[test]
    fn variables_are_replaced() {
        assert_eq!(text("a/b.csv").unwrap(), "a/b.csv");
        assert_eq!(text("${DATA}/b.csv").unwrap(), "/data/b.csv");
        assert_eq!(text("${DATA:-../c}/${NONE:-d}.csv").unwrap(), "/data/d.csv");
        assert_eq!(text("${NONE:-}b$.csv").unwrap(), "b$.csv");
    }

    #[test]
    fn an_empty_variable_is_as_good_as_none() {
        assert_eq!(text("${EMPTY:-../c}/b.csv").unwrap(), "../c/b.csv");
        assert_eq!(text("${EMPTY}/b.csv"), Err(ExpandError::Unset("EMPTY".into())));
    }

    #[test]
    fn what_cannot_be_expanded_is_reported_with_the_remedy() {
        let message = |written: &str| text(written).unwrap_err().to_string();
        assert_eq!(
            message("${NONE}/b.csv"),
            "the environment variable NONE is not set: set it (export NONE=...) to what should stand there, or give a \
             default: ${NONE:-default}"
        );
        assert_eq!(message("x${DATA/b.csv"), "`${DATA/b.csv` is not closed: expected ${NAME} or ${NAME:-default}");
        for bad in ["", "2A", "A B", "A-x"] {
            assert!(message(&format!("${{{bad}}}")).contains("does not name a variable"), "{bad}");
        }
    }
}
