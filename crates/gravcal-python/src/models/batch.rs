//! All poses of a session at once.

use std::collections::HashMap;
use std::sync::{PoisonError, RwLock};

use gravcal::calibration::Session;
use gravcal::calibration::sensors::Moment;

use super::term::{Evaluated, Function, row};

/// What a term is at every pose of the session, for the parameters that it was asked with last.
///
/// Nobody who holds the interpreter's lock may ask, as a batch asks Python while it is locked.
#[derive(Debug)]
pub struct Batch {
    joint: usize,
    known: RwLock<Known>,
}

#[derive(Debug, Default)]
struct Known {
    /// Rows of the poses, one after the other, and which of them has these bits.
    rows: Vec<f64>,
    width: usize,
    places: HashMap<Vec<u64>, usize>,
    /// The parameters; empty before the first evaluation.
    x: Vec<f64>,
    found: Evaluated,
}

impl Batch {
    pub fn new(joint: usize) -> Batch {
        Batch { joint, known: RwLock::default() }
    }

    /// Takes note of the session's poses.
    pub fn know(&self, session: &Session) {
        let mut known = self.known.write().unwrap_or_else(PoisonError::into_inner);
        *known = Known::default();
        for pose in &session.poses {
            let at = Moment::new(&[], &[], &pose.position, &pose.conditions);
            let row = row(self.joint, session.joints.len(), &at);
            let next = known.places.len();
            known.width = row.len();
            if *known.places.entry(bits(&row)).or_insert(next) == next {
                known.rows.extend(row);
            }
        }
    }

    /// The value in a pose and, where `slopes` is given, its derivatives by the parameters.
    pub fn value(&self, function: &Function, row: &[f64], x: &[f64], slopes: Option<&mut [f64]>) -> f64 {
        let key = bits(row);
        let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
        let Some(place) = known.places.get(&key).copied() else {
            drop(known);
            let found = function.evaluate(x, row, row.len(), slopes.is_some());
            return found.map_or(f64::NAN, |found| take(&found, 0, slopes));
        };
        if known.holds(x, slopes.is_some()) {
            return take(&known.found, place, slopes);
        }
        drop(known);
        let mut known = self.known.write().unwrap_or_else(PoisonError::into_inner);
        // Another thread may have been faster.
        if !known.holds(x, slopes.is_some()) {
            let Ok(found) = function.evaluate(x, &known.rows, known.width, slopes.is_some()) else { return f64::NAN };
            known.found = found;
            known.x = x.to_vec();
        }
        take(&known.found, place, slopes)
    }
}

impl Known {
    fn holds(&self, x: &[f64], slopes: bool) -> bool {
        let same = self.x.len() == x.len() && self.x.iter().zip(x).all(|(a, b)| a.to_bits() == b.to_bits());
        same && !self.found.values.is_empty() && (!slopes || !self.found.by_parameter.is_empty())
    }
}

fn take(found: &Evaluated, place: usize, slopes: Option<&mut [f64]>) -> f64 {
    if let Some(slopes) = slopes {
        let begin = place * slopes.len();
        slopes.iter_mut().zip(&found.by_parameter[begin..]).for_each(|(own, slope)| *own = *slope);
    }
    found.values[place]
}

/// Torque and coordinate, which such a term does not read, are whatever they are.
fn bits(row: &[f64]) -> Vec<u64> {
    row[2..].iter().map(|number| number.to_bits()).collect()
}
