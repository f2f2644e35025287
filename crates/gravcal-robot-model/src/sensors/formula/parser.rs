//! Formulas as users write them: `amplitude * sin(order * position + phase)`.
//!
//! ```text
//!     sum      product { (+ | -) product }
//!     product  signed { (* | /) signed }
//!     signed   - signed  |  power
//!     power    part [ ^ signed ]
//!     part     number  |  name  |  name [ joint ]  |  function ( sum )  |  ( sum )
//! ```

use std::f64::consts::PI;
use std::iter::Peekable;
use std::str::CharIndices;

use gravcal_recording::nearest_name;
use thiserror::Error;

use super::expression::{Expression, Function, Operation, Variable};
use crate::sensors::Site;

/// Parts that a formula may have: trees are walked by recursion.
const MOST_PARTS: usize = 500;

/// A formula that is not one.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("column {column}: {message}")]
pub(super) struct FormulaError {
    /// Counted from 1.
    column: usize,
    message: String,
}

/// What names mean.
pub(super) struct Vocabulary<'a> {
    pub parameters: &'a [&'a str],
    /// The joint that is meant where none is named, and all others.
    pub site: &'a Site<'a>,
}

const VARIABLES: [(&str, Variable); 7] = [
    ("torque", Variable::Torque),
    ("coordinate", Variable::Coordinate),
    ("position", Variable::Position),
    ("velocity", Variable::Velocity),
    ("direction", Variable::Direction),
    ("temperature", Variable::Temperature),
    ("time", Variable::Time),
];

const FUNCTIONS: [(&str, Function); 14] = [
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("asin", Function::Asin),
    ("acos", Function::Acos),
    ("atan", Function::Atan),
    ("sinh", Function::Sinh),
    ("cosh", Function::Cosh),
    ("tanh", Function::Tanh),
    ("exp", Function::Exp),
    ("ln", Function::Ln),
    ("sqrt", Function::Sqrt),
    ("abs", Function::Abs),
    ("sign", Function::Sign),
];

const CONSTANT: &str = "pi";
const FURTHER: &str = "further";

/// Whether a name has a meaning of its own, which no parameter may have.
pub(super) fn is_taken(name: &str) -> bool {
    let variable = VARIABLES.iter().any(|(known, _)| *known == name);
    variable || FUNCTIONS.iter().any(|(known, _)| *known == name) || [CONSTANT, FURTHER].contains(&name)
}

/// Reads a formula.
///
/// # Errors
/// Names the column and what was expected there.
pub(super) fn parse(text: &str, vocabulary: &Vocabulary<'_>) -> Result<Expression, FormulaError> {
    let mut reader = Reader { text, rest: text.char_indices().peekable(), vocabulary, parts: 0 };
    let expression = reader.sum()?;
    match reader.peek() {
        None => Ok(expression),
        Some(_) => Err(reader.expected("an operator (+ - * / ^) or the end")),
    }
}

/// A formula that is being read.
struct Reader<'a> {
    text: &'a str,
    rest: Peekable<CharIndices<'a>>,
    vocabulary: &'a Vocabulary<'a>,
    parts: usize,
}

impl<'a> Reader<'a> {
    fn sum(&mut self) -> Result<Expression, FormulaError> {
        let mut left = self.product()?;
        loop {
            let operation = match self.peek() {
                Some('+') => Operation::Sum,
                Some('-') => Operation::Difference,
                _ => return Ok(left),
            };
            self.rest.next();
            left = Expression::Both(operation, Box::new([left, self.product()?]));
        }
    }

    fn product(&mut self) -> Result<Expression, FormulaError> {
        let mut left = self.signed()?;
        loop {
            let operation = match self.peek() {
                Some('*') => Operation::Product,
                Some('/') => Operation::Quotient,
                _ => return Ok(left),
            };
            self.rest.next();
            left = Expression::Both(operation, Box::new([left, self.signed()?]));
        }
    }

    fn signed(&mut self) -> Result<Expression, FormulaError> {
        self.count()?;
        if self.take('-') {
            return Ok(Expression::Negative(Box::new(self.signed()?)));
        }
        let base = self.part()?;
        if self.take('^') {
            return Ok(Expression::Power(Box::new([base, self.signed()?])));
        }
        Ok(base)
    }

    fn part(&mut self) -> Result<Expression, FormulaError> {
        match self.peek() {
            Some('(') => self.in_brackets(),
            Some(first) if first.is_ascii_digit() || first == '.' => self.number(),
            Some(first) if first.is_alphabetic() || first == '_' => self.named(),
            _ => Err(self.expected("a number, a name, `-` or `(`")),
        }
    }

    fn in_brackets(&mut self) -> Result<Expression, FormulaError> {
        if !self.take('(') {
            return Err(self.expected("`(`"));
        }
        let inner = self.sum()?;
        if !self.take(')') {
            return Err(self.expected("an operator (+ - * / ^) or `)`"));
        }
        Ok(inner)
    }

    fn number(&mut self) -> Result<Expression, FormulaError> {
        let start = self.offset();
        let mut before = ' ';
        while let Some((_, letter)) = self.rest.peek().copied() {
            let in_exponent = matches!(letter, '+' | '-') && matches!(before, 'e' | 'E');
            if !(letter.is_ascii_digit() || matches!(letter, '.' | 'e' | 'E') || in_exponent) {
                break;
            }
            before = letter;
            self.rest.next();
        }
        let written = &self.text[start..self.offset()];
        let number: Option<f64> = written.parse().ok().filter(|number: &f64| number.is_finite());
        number.map(Expression::Number).ok_or_else(|| self.error_at(start, format!("`{written}` is no number")))
    }

    fn named(&mut self) -> Result<Expression, FormulaError> {
        let start = self.offset();
        while self.rest.next_if(|(_, letter)| letter.is_alphanumeric() || *letter == '_').is_some() {}
        let name = &self.text[start..self.offset()];
        if let Some(place) = self.vocabulary.parameters.iter().position(|known| *known == name) {
            return Ok(Expression::Parameter(place));
        }
        if let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) {
            return Ok(Expression::Function(*function, Box::new(self.in_brackets()?)));
        }
        if let Some((_, variable)) = VARIABLES.iter().find(|(known, _)| *known == name) {
            return Ok(Expression::Variable(*variable, self.joint()?));
        }
        match name {
            CONSTANT => Ok(Expression::Number(PI)),
            FURTHER => {
                let Some((start, name)) = self.in_square_brackets()? else { return Err(self.expected("`[`")) };
                let place = self.vocabulary.site.further_column(name);
                Ok(Expression::Variable(Variable::Further, place.map_err(|message| self.error_at(start, message))?))
            }
            _ => Err(self.unknown(start, name)),
        }
    }

    /// The joint in square brackets, if there are any.
    fn joint(&mut self) -> Result<usize, FormulaError> {
        let site = self.vocabulary.site;
        let Some((start, name)) = self.in_square_brackets()? else { return Ok(site.joint()) };
        let message = || format!("there is no joint `{name}`; the joints are {}", site.joint_names().join(", "));
        site.joint_named(name).ok_or_else(|| self.error_at(start, message()))
    }

    /// A name in square brackets, if there are any, and where it begins.
    fn in_square_brackets(&mut self) -> Result<Option<(usize, &'a str)>, FormulaError> {
        if !self.take('[') {
            return Ok(None);
        }
        let (start, text) = (self.offset(), self.text);
        while self.rest.next_if(|(_, letter)| *letter != ']').is_some() {}
        let name = text[start..self.offset()].trim();
        match self.take(']') {
            true => Ok(Some((start, name))),
            false => Err(self.expected("`]`")),
        }
    }

    fn unknown(&self, start: usize, name: &str) -> FormulaError {
        let own = self.vocabulary.parameters.iter().copied();
        let variables = VARIABLES.iter().map(|(known, _)| *known);
        let functions = FUNCTIONS.iter().map(|(known, _)| *known);
        let known: Vec<&str> = own.chain(variables).chain(functions).chain([CONSTANT, FURTHER]).collect();
        let near = nearest_name(name, &known).map_or_else(String::new, |near| format!(" (did you mean `{near}`?)"));
        let message = format!(
            "`{name}` has no meaning{near}; expected one of its unknowns, a variable or a function: {}",
            known.join(", ")
        );
        self.error_at(start, message)
    }

    fn count(&mut self) -> Result<(), FormulaError> {
        self.parts += 1;
        match self.parts <= MOST_PARTS {
            true => Ok(()),
            false => {
                Err(self
                    .error_at(self.end(), format!("the formula has more than {MOST_PARTS} parts: write a shorter one")))
            }
        }
    }

    /// The next letter that is no space.
    fn peek(&mut self) -> Option<char> {
        while self.rest.next_if(|(_, letter)| letter.is_whitespace()).is_some() {}
        self.rest.peek().map(|(_, letter)| *letter)
    }

    fn take(&mut self, letter: char) -> bool {
        let is_next = self.peek() == Some(letter);
        if is_next {
            self.rest.next();
        }
        is_next
    }

    /// In bytes.
    fn offset(&mut self) -> usize {
        self.rest.peek().map_or(self.text.len(), |(offset, _)| *offset)
    }

    fn end(&self) -> usize {
        self.rest.clone().next().map_or(self.text.len(), |(offset, _)| offset)
    }

    fn expected(&mut self, expected: &str) -> FormulaError {
        let found = match self.peek() {
            Some(letter) => format!("`{letter}`"),
            None => "the end".to_owned(),
        };
        self.error_at(self.end(), format!("expected {expected}, found {found}"))
    }

    fn error_at(&self, offset: usize, message: String) -> FormulaError {
        FormulaError { column: self.text[..offset].chars().count() + 1, message }
    }
}

#[cfg(test)]
mod tests {
    use gravcal_dynamics::JointKind;
    use gravcal_recording::{Conditions, FurtherColumn};

    use super::*;
    use crate::sensors::testing::joint_priors;
    use crate::sensors::{Moment, Need, Reads};

    fn read(text: &str) -> Result<Expression, FormulaError> {
        let further = ["oil", "current"].map(|name| FurtherColumn {
            name: name.into(),
            column: name.into(),
            may_be_empty: false,
        });
        let prior = joint_priors();
        let site = Site::new(1, &["hip", "knee"], &[JointKind::Revolute; 2], &prior).with_further_columns(&further);
        parse(text, &Vocabulary { parameters: &["a", "b"], site: &site })
    }

    fn value(text: &str) -> f64 {
        let conditions = Conditions {
            time: Some(7.0),
            temperature: vec![20.0, 30.0],
            velocity: vec![0.5, -0.25],
            further: vec![0.25, 8.0],
            ..Conditions::default()
        };
        let at = Moment::new(&[10.0, 11.0], &[0.1, 0.2], &[1.0, 2.0], &conditions);
        read(text).unwrap().value(&at, &[3.0, 5.0])
    }

    #[test]
    fn formulas_mean_what_they_do_elsewhere() {
        let cases = [
            ("1 + 2 * 3 - 4 / 2", 5.0),
            ("8 - 3 - 2", 3.0),
            ("-2 ^ 2", -4.0),
            ("2 ^ -1", 0.5),
            ("2 ^ 3 ^ 2", 512.0),
            ("(1 + 2) * -a", -9.0),
            ("(-2) ^ 3 + 4 ^ 0.5 + a ^ b", -8.0 + 2.0 + 243.0),
            ("1.5e1 + .5 + 2E-1", 15.7),
            ("cos(pi) + abs(-a) + sign(velocity) + sign(0)", -1.0 + 3.0 - 1.0),
            ("torque + torque[hip] + coordinate + position[ hip ]", 11.0 + 10.0 + 0.2 + 1.0),
            ("time + temperature + temperature[hip] + direction", 7.0 + 30.0 + 20.0 - 1.0),
            ("sqrt(exp(ln(4)))", 2.0),
            ("further[current] / further[oil]", 32.0),
        ];
        for (text, expected) in cases {
            assert!((value(text) - expected).abs() < 1e-12, "{text}: {}", value(text));
        }
    }

    #[test]
    fn what_is_read_is_found() {
        let reads = |text: &str| read(text).unwrap().reads();
        let expected = Reads::positions().torque(1).torque(0).coordinate(1).condition(Need::Time);
        assert_eq!(reads("torque * torque[hip] + sin(coordinate) * time"), expected);
        assert_eq!(reads("a * position"), Reads::positions());
    }

    #[test]
    fn errors_name_the_column_and_what_was_expected() {
        let message = |text: &str| read(text).unwrap_err().to_string();
        let operand = "expected a number, a name, `-` or `(`, found";
        assert_eq!(message(""), format!("column 1: {operand} the end"));
        assert_eq!(message("a * * b"), format!("column 5: {operand} `*`"));
        assert_eq!(message("a b"), "column 3: expected an operator (+ - * / ^) or the end, found `b`");
        assert_eq!(message("sin a"), "column 5: expected `(`, found `a`");
        assert_eq!(message("(a + b"), "column 7: expected an operator (+ - * / ^) or `)`, found the end");
        assert_eq!(message("1.2.3"), "column 1: `1.2.3` is no number");
        assert_eq!(message("1e999"), "column 1: `1e999` is no number");
        assert_eq!(message("ä + a"), message("ö + a").replace('ö', "ä"));
        assert!(message("a + veloctiy").starts_with("column 5: `veloctiy` has no meaning (did you mean `velocity`?)"));
        assert_eq!(message("torque[foot]"), "column 8: there is no joint `foot`; the joints are hip, knee");
        assert!(
            message("further[gas]")
                .starts_with("column 9: there is no further column `gas`; the session names oil, current")
        );
        assert_eq!(message("further"), "column 8: expected `[`, found the end");
        assert_eq!(message("torque[hip"), "column 11: expected `]`, found the end");
    }

    #[test]
    fn a_formula_too_deep_or_long_to_walk_is_refused() {
        for text in ["(".repeat(100_000), "-".repeat(100_000), vec!["1"; 100_000].join("+"), "sin(".repeat(100_000)] {
            let error = read(&text).unwrap_err();
            assert!(error.message.contains("more than 500 parts"), "{error}");
        }
    }
}
