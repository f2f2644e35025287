//! Models that a session writes as formulas, for those who write no Rust.
//!
//! ```toml
//! sensor_models = [{ kind = "formula", adds = "ripple * sin(order * position + phase)", unknowns = {
//!     ripple = { unit = "N·m", nominal = 0.2, limit = 0.05 },
//!     order = { unit = "1/rad", nominal = 6, limit = 0.1 },
//!     phase = { unit = "rad", limit = 0.2 },
//! } }]
//! ```
//!
//! `adds` is what comes to the torque reading, in its unit (`position-formula`: to the coordinate, rad or m). Known are `torque`,
//! `coordinate`, `position` (the reading), `velocity`, `direction`, `temperature` of the joint or, as `torque[elbow]`, of another, and
//! `time`, and `further[oil]`, a column that `readings.further = { oil = "p_oil" }` names; the constant `pi`; + - * / ^; and `sin` and its like. Its unknowns have the unit in which the formula counts them; `limit` is
//! the standard deviation beyond which a number would mislead. What is known of them goes under `parameters`, as for any model.

mod expression;
mod parser;

use gravcal_estimation::Number;

use self::expression::Expression;
use self::parser::{Vocabulary, is_taken, parse};
use super::automatic::{Differentiated, SensorFormula};
use super::model::{Declared, ParameterSpec, SensorModel, Side, Site};
use super::options::{Options, RefusedOption};
use super::term::{Moment, Reads};
use crate::parameter::Limit;

/// `formula` and `position-formula`.
#[derive(Debug)]
pub(super) struct Formula(pub Side);

/// The term of a formula.
#[derive(Debug)]
struct Written(Expression);

impl SensorFormula for Written {
    fn reads(&self) -> Reads {
        self.0.reads()
    }

    fn value<N: Number>(&self, at: &Moment<'_, N>, x: &[N]) -> N {
        self.0.value(at, x)
    }
}

impl SensorModel for Formula {
    fn name(&self) -> &str {
        match self.0 {
            Side::Torque => "formula",
            Side::Position => "position-formula",
        }
    }

    fn help(&self) -> &str {
        match self.0 {
            Side::Torque => "what the session writes as a formula is added to the torque reading",
            Side::Position => "what the session writes as a formula is added to the coordinate",
        }
    }

    fn side(&self) -> Side {
        self.0
    }

    fn options(&self) -> &[&str] {
        &["adds", "unknowns"]
    }

    fn is_repeatable(&self) -> bool {
        true
    }

    fn declare(&self, site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let text = options.text("adds")?.ok_or_else(|| {
            RefusedOption::new("adds", "what does it add? write a formula, such as adds = \"a * sin(position)\"")
        })?;
        let convention = match self.0 {
            Side::Torque => format!("reading = ... + {text}"),
            Side::Position => format!("coordinate = ... + {text}"),
        };
        let unknowns = options.tables("unknowns")?.unwrap_or_default();
        let parameter = |(name, said): &(&str, Options)| {
            let spec = unknown(name, said).map_err(|refused| refused.within(name).within("unknowns"))?;
            Ok(spec.in_equation(convention.clone()).cured_by(CURE))
        };
        let parameters = unknowns.iter().map(parameter).collect::<Result<Vec<_>, RefusedOption>>()?;
        let names: Vec<&str> = unknowns.iter().map(|(name, _)| *name).collect();
        let vocabulary = Vocabulary { parameters: &names, site };
        let expression = parse(text, &vocabulary).map_err(|error| RefusedOption::new("adds", error.to_string()))?;
        if let Some(place) = (0..names.len()).find(|place| !expression.has_parameter(*place)) {
            let message = "the formula does not have it: write it into adds, or delete it";
            return Err(RefusedOption::new(names[place], message).within("unknowns"));
        }
        Ok(vec![Declared::new(parameters, Differentiated::new(Written(expression)))])
    }
}

const CURE: &str = "add poses that change what the formula reads over a wider range";

fn unknown(name: &str, said: &Options) -> Result<ParameterSpec, RefusedOption> {
    const KEYS: [&str; 4] = ["unit", "nominal", "limit", "shared"];
    if is_taken(name) {
        return Err(RefusedOption {
            keys: Vec::new(),
            message: "the name has a meaning already: choose another".into(),
        });
    }
    if let Some(key) = said.keys().find(|key| !KEYS.contains(key)) {
        return Err(RefusedOption::new(key, format!("expected one of {}", KEYS.join(", "))));
    }
    let missing = |key: &str, message: &str| RefusedOption::new(key, message);
    let unit = said.text("unit")?.ok_or_else(|| missing("unit", "in which unit is it? add unit, or unit = \"1\""))?;
    let limit = said.number("limit")?.filter(|limit| *limit > 0.0).ok_or_else(|| {
        missing(
            "limit",
            "how uncertain may it be before its number misleads? add limit, a standard deviation above zero",
        )
    })?;
    let nominal = said.number("nominal")?.unwrap_or(0.0);
    let spec = ParameterSpec::new(name, unit, Limit::Absolute(limit)).starting_at(nominal);
    Ok(match said.text("shared")? {
        Some(owner) => spec.shared(owner),
        None => spec,
    })
}
