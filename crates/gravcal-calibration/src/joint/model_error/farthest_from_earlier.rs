//! What an earlier calibration knows and the readings contradict.
//!
//! With all that is known, `N(m, C)`, and the estimate `v` of readings and knowledge together, whose covariance is `Σ`, each number is off by
//!
//! ```text
//!     z = (v − m)/√(C − Σ)
//! ```
//!
//! because `C − Σ` is the variance of that difference, to first order. A base that was moved or a sensor that has changed is off by most.

use gravcal_estimation::statistics::{LinearFunction, stored_coordinates};
use gravcal_robot_model::number::significant;
use gravcal_robot_model::session::{EarlierCalibration, KnownCombination};

use super::contradicted_priors::{CONTRADICTED, NAMED, OF_PRIOR};
use crate::joint::building::earlier::component;
use crate::joint::solved::Solved;

impl Solved {
    /// The numbers that the readings contradict most, and how many more there are; `None` where none is off by itself.
    pub(in crate::joint) fn farthest_from(&self, earlier: &EarlierCalibration) -> Option<String> {
        let mut off: Vec<(String, f64)> = Vec::new();
        for (place, quantity) in earlier.quantities().iter().enumerate() {
            let Some(apart) = self.known_apart(quantity, earlier.variance(place)).filter(|apart| *apart > CONTRADICTED)
            else {
                continue;
            };
            let name = named(quantity);
            match off.iter_mut().find(|(known, _)| *known == name) {
                Some((_, most)) => *most = most.max(apart),
                None => off.push((name, apart)),
            }
        }
        off.sort_by(|a, b| b.1.total_cmp(&a.1));
        let worst = off.iter().take(NAMED);
        let worst: Vec<String> =
            worst.map(|(name, apart)| format!("{name} by {} standard deviations", significant(*apart, 2))).collect();
        let more = match off.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(", and {more} more"),
        };
        (!worst.is_empty()).then(|| format!("{}{more}", worst.join(", ")))
    }

    /// By how many standard deviations the estimate is from what was known, of this variance; nothing where the readings say too little.
    fn known_apart(&self, quantity: &KnownCombination, variance: f64) -> Option<f64> {
        let (problem, values) = (self.judged_problem(), &self.estimate.values);
        let (mut value, mut function) = (0.0, LinearFunction::new());
        for (name, coefficient) in &quantity.terms {
            let (block, place) = component(problem, name)?;
            value += coefficient * values.get(block)[place];
            let columns = stored_coordinates(problem, values, &[block]).swap_remove(place);
            function.extend(columns.into_iter().map(|(column, slope)| (column, coefficient * slope)));
        }
        if let Some(gain) = &quantity.times {
            let (block, place) = component(problem, gain)?;
            let gain = values.get(block)[place];
            function.iter_mut().for_each(|(_, slope)| *slope *= gain);
            let columns = stored_coordinates(problem, values, &[block]).swap_remove(place);
            function.extend(columns.into_iter().map(|(column, slope)| (column, value * slope)));
            value *= gain;
        }
        let own = self.analysis.covariance().std_of(&function).powi(2);
        (own > 0.0 && own < OF_PRIOR * variance).then(|| (value - quantity.value).abs() / (variance - own).sqrt())
    }
}

/// A quantity for people: components of gravity are gravity, whichever they are.
fn named(quantity: &KnownCombination) -> String {
    match quantity.terms.as_slice() {
        terms if terms.iter().all(|(name, _)| name.starts_with("gravity.")) => "gravity".to_owned(),
        [(name, _)] => name.clone(),
        terms => {
            let largest = terms.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            largest.map_or_else(String::new, |(name, _)| format!("{name} with others"))
        }
    }
}
