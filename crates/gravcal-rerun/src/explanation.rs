//! What the readings are said to be: by an estimator, or by nominal sensors.

use gravcal_calibration::result::{EstimatorResult, ReadingResidual};

/// Who says so, and all readings beside it.
#[derive(Clone, Copy)]
pub struct Explanation<'a> {
    /// Name of the estimator, or `nominal`.
    pub name: &'a str,
    rows: &'a [ReadingResidual],
    residual: fn(&ReadingResidual) -> f64,
}

/// One reading beside what is said of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explained {
    /// Index of the pose.
    pub pose: usize,
    /// What is said less what was read, in the unit of the reading.
    pub residual: f64,
    /// Standard deviation that the fit assumed, in that unit.
    pub std: f64,
}

impl<'a> Explanation<'a> {
    /// Of an estimator; of none that could not fit anything.
    pub fn of(result: &'a EstimatorResult) -> Option<Explanation<'a>> {
        Explanation::new(&result.name, result, |row| row.residual)
    }

    /// What its sensors would say if they were nominal.
    pub fn nominal(result: &'a EstimatorResult) -> Option<Explanation<'a>> {
        Explanation::new("nominal", result, |row| row.nominal_residual)
    }

    fn new(
        name: &'a str,
        result: &'a EstimatorResult,
        residual: fn(&ReadingResidual) -> f64,
    ) -> Option<Explanation<'a>> {
        let rows = result.fit.as_ref().map(|fit| fit.residuals.as_slice())?;
        rows.iter().any(|row| residual(row).is_finite()).then_some(Explanation { name, rows, residual })
    }

    /// Readings of one channel, by poses. Nominal sensors may be out of the model's reach: those have no number.
    pub fn of_channel(&self, channel: usize) -> impl Iterator<Item = Explained> + use<'a> {
        explained(self.rows, channel, self.residual)
    }

    /// The same of the poses from the first to the last.
    pub fn between(&self, [first, last]: [usize; 2], channel: usize) -> impl Iterator<Item = Explained> + use<'a> {
        let from = self.rows.partition_point(|row| row.id.pose < first);
        let until = self.rows.partition_point(|row| row.id.pose <= last);
        explained(&self.rows[from..until], channel, self.residual)
    }

    /// Whether anything is said of a channel.
    pub fn tells(&self, channel: usize) -> bool {
        self.of_channel(channel).next().is_some()
    }
}

fn explained(
    rows: &[ReadingResidual],
    channel: usize,
    residual: fn(&ReadingResidual) -> f64,
) -> impl Iterator<Item = Explained> {
    let own = rows.iter().filter(move |row| row.id.channel == channel);
    own.map(move |row| Explained { pose: row.id.pose, residual: residual(row), std: row.std })
        .filter(|one| one.residual.is_finite())
}
