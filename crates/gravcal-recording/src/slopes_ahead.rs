//! Velocities of joints at one row of a recording after another: slopes of their positions, as [`Slope`] says, by a pass of its own that reads ahead by half
//! of a window. So a recording may be longer than memory.

use std::collections::VecDeque;
use std::fmt;

use crate::conditions::{ConditionColumn, Slope};
use crate::mapping::PoseMapping;
use crate::rows::{Row, Rows};
use crate::slope::slope_of_line;
use crate::turns::unwrapped;

/// By so much of itself a window is wider, as clocks are rounded.
const ROUNDING: f64 = 1e-9;

/// The pass.
pub struct SlopesAhead<'a> {
    rows: Box<dyn Rows>,
    mapping: &'a PoseMapping,
    clock: ConditionColumn,
    slope: Slope,
    row: Row,
    /// Time of the last row, s; infinite at the end.
    read_to: f64,
    /// By joint, times, s, and its coordinate but for the offset by the nominal gain, rad or m, in the window and ahead of it. Angles go on over full turns.
    kept: Vec<VecDeque<(f64, f64)>>,
}

impl<'a> SlopesAhead<'a> {
    /// `rows`: of the recording, from the first on. `mapping`: what its columns mean.
    pub fn new(rows: Box<dyn Rows>, mapping: &'a PoseMapping, slope: Slope) -> SlopesAhead<'a> {
        let kept = vec![VecDeque::new(); mapping.positions.len()];
        let clock = mapping.conditions.clock();
        SlopesAhead { rows, mapping, clock, slope, row: Row::default(), read_to: f64::NEG_INFINITY, kept }
    }

    /// Slope of each joint's coordinate at a time, s, no earlier than any before, rad/s or m/s by the nominal gain of its position reading. NaN of a joint that is read no more than once in the
    /// window.
    pub fn at(&mut self, time: f64) -> Vec<f64> {
        let half = 0.5 * self.slope.window * (1.0 + ROUNDING);
        while self.read_to <= time + half {
            self.read_row();
        }
        let of_joint = |own: &mut VecDeque<(f64, f64)>| {
            while own.front().is_some_and(|(earliest, _)| *earliest < time - half) {
                own.pop_front();
            }
            let (times, readings): (Vec<f64>, Vec<f64>) =
                own.iter().take_while(|(other, _)| *other <= time + half).copied().unzip();
            slope_of_line(&times, &readings)
        };
        self.kept.iter_mut().map(of_joint).collect()
    }

    /// What cannot be read ends this pass without a word: whoever asks for slopes reads the same rows, comes to the same place, and tells the error.
    fn read_row(&mut self) {
        if !self.rows.read(&mut self.row).unwrap_or(false) {
            self.read_to = f64::INFINITY;
            return;
        }
        let columns = self.rows.columns();
        let cell = |name: &str| {
            let place = columns.iter().position(|column| column == name);
            place.and_then(|place| self.row.cells.get(place)).copied().unwrap_or(f64::NAN)
        };
        let time = self.clock.unit.to_inside(cell(&self.clock.column));
        if time.is_nan() {
            return;
        }
        self.read_to = self.read_to.max(time);
        for (kept, position) in self.kept.iter_mut().zip(&self.mapping.positions) {
            let (reading, gain) = (cell(&position.column) * position.unit.to_si(), position.nominal_gain);
            if reading.is_nan() || kept.back().is_some_and(|(last, _)| *last >= time) {
                continue;
            }
            let last = kept.back().map(|(_, coordinate)| coordinate / gain);
            kept.push_back((time, gain * unwrapped(reading, last, position.unit)));
        }
    }
}

impl fmt::Debug for SlopesAhead<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SlopesAhead")
            .field("slope", &self.slope)
            .field("read_to", &self.read_to)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conditions::{ConditionColumns, ConditionUnit};
    use crate::csv_lines::CsvWriting;
    use crate::mapping::PositionColumn;
    use crate::rows::open_as;
    use crate::unit::PositionUnit;

    /// Times in ms; one joint in degrees that goes 2 rad/s and wraps at 20°, and one in rad, read in every other row, along a parabola.
    fn recording(rows: usize) -> tempfile::NamedTempFile {
        let row = |k: usize| {
            let t = 0.01 * k as f64;
            let second = if k.is_multiple_of(2) { format!("{}", t * t) } else { String::new() };
            let first = (2.0 * t).to_degrees();
            format!("{},{},{second}\n", 10 * k, if first > 20.0 { first - 360.0 } else { first })
        };
        let text: String = std::iter::once("t,a,b\n".to_owned()).chain((0..rows).map(row)).collect();
        let file = tempfile::Builder::new().suffix(".csv").tempfile().unwrap();
        std::fs::write(file.path(), text).unwrap();
        file
    }

    fn mapping() -> PoseMapping {
        let position = |column: &str, unit| PositionColumn::new(column, unit);
        PoseMapping {
            positions: vec![position("a", PositionUnit::Degree), position("b", PositionUnit::Radian)],
            torques: vec![None; 2],
            conditions: ConditionColumns {
                time: Some(ConditionColumn { column: "t".into(), unit: ConditionUnit::TIME[1] }),
                ..ConditionColumns::default()
            },
            ..PoseMapping::default()
        }
    }

    #[test]
    fn slopes_are_those_of_the_lines_through_what_is_near() {
        let (file, mapping) = (recording(50), mapping());
        let rows = open_as(file.path(), &CsvWriting::default()).unwrap();
        let mut slopes = SlopesAhead::new(rows, &mapping, Slope { window: 0.08 });
        for k in 0..50 {
            let t = 0.01 * k as f64;
            let [first, second] = slopes.at(t)[..] else { panic!("there are two joints") };
            assert!((first - 2.0).abs() < 1e-9, "{k}: {first}");
            // Within the recording the line through a parabola about a moment is its tangent there, or half a row beside it.
            if (5..44).contains(&k) {
                assert!((second - 2.0 * t).abs() < 1e-9, "{k}: {second}");
            }
            assert!(slopes.kept.iter().all(|own| own.len() <= 10), "what lies behind is not kept");
        }
    }

    #[test]
    fn a_joint_that_is_read_once_has_no_slope() {
        let (file, mapping) = (recording(2), mapping());
        let rows = open_as(file.path(), &CsvWriting::default()).unwrap();
        let slopes = SlopesAhead::new(rows, &mapping, Slope { window: 0.1 }).at(0.0);
        assert!((slopes[0] - 2.0).abs() < 1e-9 && slopes[1].is_nan(), "{slopes:?}");
    }
}
