//! Another sensor: potentiometers of Stanford and Scheinman arms, set to known angles in 1976 and 1977. The scale of each, by the part of
//! gravcal that knows no robot.
//!
//! ```text
//!     counts = gain · set point + zero
//! ```
//!
//! The table is read where it lies, `../shared/data/potentiometers` beside the project or the folder in `GRAVCAL_SHARED_DATA`.
//!
//! ```sh
//! cargo run --release -p gravcal --example potentiometers
//! ```

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use gravcal::estimation::statistics::{NoiseScale, Solution};
use gravcal::estimation::{
    Block, BlockId, EvaluateError, Factor, LocalValues, Noise, ProblemBuilder, RankAnalysis, Residual, RowsMut,
    SolveContext, Uncertainty,
};
use gravcal::solvers::SolverName;

/// Set points, and what the converter counted there.
type Points = Vec<[f64; 2]>;

/// A joint's potentiometer.
#[derive(Debug)]
struct Line {
    /// Gain and zero.
    blocks: [BlockId; 2],
    points: Points,
}

impl Residual for Line {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.points.len()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        mut jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        for (row, [set, counts]) in self.points.iter().enumerate() {
            residual[row] = x.scalar(0) * set + x.scalar(1) - counts;
            if let Some(rows) = jacobian.as_mut() {
                rows.row(row).copy_from_slice(&[*set, 1.0]);
            }
        }
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let Ok(table) = fs::read_to_string(folder().join("potentiometers/pot_calibration.csv")) else {
        println!("SKIPPED: there is no table of potentiometers in {}", folder().display());
        return Ok(());
    };
    for (joint, points) in joints(&table)? {
        match scale(&joint, points)? {
            Some([scale, std]) => println!("{joint:<40} {scale:.7} ± {std:.7} per count"),
            None => println!("{joint:<40} undetermined: too few set points"),
        }
    }
    Ok(())
}

fn folder() -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    std::env::var_os("GRAVCAL_SHARED_DATA").map_or_else(beside, PathBuf::from)
}

/// By arm, joint and unit.
fn joints(table: &str) -> Result<BTreeMap<String, Points>, Box<dyn Error>> {
    let mut joints: BTreeMap<String, Points> = BTreeMap::new();
    for line in table.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [arm, _source, joint, _date, set, unit, counts] = cells.as_slice() else {
            return Err(format!("expected seven cells, found `{line}`").into());
        };
        joints.entry(format!("{arm}, joint {joint}, {unit}")).or_default().push([set.parse()?, counts.parse()?]);
    }
    Ok(joints)
}

/// Set point per count with its standard deviation, by the scatter of the points about their line; nothing where there are none to scatter.
fn scale(name: &str, points: Points) -> Result<Option<[f64; 2]>, Box<dyn Error>> {
    if points.len() < 3 {
        return Ok(None);
    }
    let mut builder = ProblemBuilder::new();
    let gain = builder.add_block(Block::scalar(format!("{name}: gain"), "count"), &[1.0]);
    let zero = builder.add_block(Block::scalar(format!("{name}: zero"), "count"), &[0.0]);
    let noise = Noise::independent(&vec![1.0; points.len()])?;
    builder.add_factor(Factor::new(Line { blocks: [gain, zero], points }, noise));
    let (problem, start) = builder.build()?;
    let estimate = SolverName::LevenbergMarquardt.build().solve(&problem, &start, &mut SolveContext::default())?;
    let analysis = RankAnalysis::of(&problem, &estimate)?;
    let solution = Solution { problem: &problem, values: &estimate.values, analysis: &analysis };
    let uncertainty = Uncertainty::from_noise(&solution, NoiseScale::Relative)?;
    let value = estimate.values.scalar(gain);
    let std = uncertainty.covariance().std(problem.columns_of(gain).start);
    Ok(Some([1.0 / value, std / (value * value)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_runs() {
        main().unwrap();
    }

    /// The scale that was published with the table (MIT joint 2).
    #[test]
    fn a_published_scale_is_found() {
        let points = vec![[0.0, 3137.0], [-90.0, 2061.0], [-180.0, 1032.0]];
        let [scale, std] = scale("MIT joint 2", points).unwrap().unwrap();
        assert!((scale / 0.085_267_6 - 1.0).abs() < 0.005, "{scale} ± {std}");
    }
}
