//! The zero of a sensor that drifts, or is another in another table.

use super::lacked::{Found, Lacked, Words};
use crate::judgement::residual_tests::columns::{ALL_JOINTS, Columns};
use crate::judgement::residual_tests::wording::{is_joint, shown, shown_amount};
use crate::result::{ResidualTest, ResidualTestKind};
use gravcal_robot_model::session::Session;

/// More tables are not compared.
const MOST_TABLES: usize = 40;

/// Shares of the time over which a zero may drift before it stays; fewer readings tell no such shape.
const SETTLED: [f64; 6] = [0.0625, 0.125, 0.1875, 0.25, 0.375, 0.5];
const FEWEST_SETTLING: usize = 30;

/// What is said of other sensors.
const OTHERS_DRIFT: &str =
    "The zeros of the other sensors may drift, too: their intervals include the drift that their own residuals allow.";

/// What adds to a reading, whatever it senses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorZero {
    Trend,
    /// In the unit of the reading, from the middle of the time to its ends.
    Curve,
    TrendInTables,
    /// In the unit of the reading: that drifts over a first part of the time and then stays, or sums of such.
    Settling,
    /// Of each table but the first.
    InTables,
}

impl SensorZero {
    /// Those that are looked for in a channel.
    pub fn of_channel(of: &Columns, channel: usize) -> Vec<SensorZero> {
        let mut terms = vec![SensorZero::Trend, SensorZero::Curve, SensorZero::TrendInTables, SensorZero::InTables];
        if of.read(channel) >= FEWEST_SETTLING {
            terms.push(SensorZero::Settling);
        }
        terms
    }
}

impl Lacked for SensorZero {
    fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        match self {
            SensorZero::Trend => vec![of.trend(channel, |_| 0)],
            SensorZero::Curve => vec![squared_time(of, channel, 0.5)],
            SensorZero::TrendInTables if of.tables(channel).len() < 2 => Vec::new(),
            SensorZero::TrendInTables => vec![of.trend(channel, |pose| of.table(pose))],
            SensorZero::Settling => SETTLED.map(|share| of.reading(channel, settling(of, channel, share))).into(),
            SensorZero::InTables => of.apart(&of.tables(channel), MOST_TABLES, |within| {
                vec![of.reading(channel, |pose| f64::from(within(pose)))]
            }),
        }
    }

    fn as_modelled(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        match self {
            SensorZero::Trend => vec![of.time_since(channel, |_| 0)],
            SensorZero::Curve => vec![squared_time(of, channel, 0.0)],
            SensorZero::TrendInTables => vec![of.time_since(channel, |pose| of.table(pose))],
            SensorZero::Settling | SensorZero::InTables => self.columns(of, channel),
        }
    }

    fn found(&self, of: &Columns, channel: usize, coefficients: &[f64]) -> Found {
        let unit = of.session.channel_unit(channel);
        let first = coefficients.first().copied().unwrap_or(0.0);
        match self {
            SensorZero::Trend => Found::new(ResidualTestKind::Trend, first, format!("{unit}/{}", of.unit_of_time())),
            SensorZero::Curve => Found::new(ResidualTestKind::TrendCurve, first, unit),
            SensorZero::TrendInTables => {
                Found::new(ResidualTestKind::TrendInTables, first, format!("{unit}/{}", of.unit_of_time()))
            }
            SensorZero::Settling => {
                let shapes = SETTLED.map(|share| settling(of, channel, share));
                let drifted =
                    |pose: usize| -> f64 { coefficients.iter().zip(&shapes).map(|(c, shape)| c * shape(pose)).sum() };
                let most = of.poses(channel).map(drifted).max_by(|a, b| a.abs().total_cmp(&b.abs()));
                Found::new(ResidualTestKind::Settling, most.unwrap_or(0.0), unit)
            }
            SensorZero::InTables => {
                let (file, size) = of.farthest(&of.tables(channel), coefficients);
                Found::new(ResidualTestKind::Tables { file }, size, unit)
            }
        }
    }
}

/// Time (or order) since the first reading in a share of its span, and one from there on.
fn settling(of: &Columns, channel: usize, share: f64) -> impl Fn(usize) -> f64 {
    let [first, last] = span(of, channel);
    move |pose| if last > first { ((of.when(pose) - first) / (share * (last - first))).min(1.0) } else { 0.0 }
}

/// The times (or places in the order) of the first reading and the last.
fn span(of: &Columns, channel: usize) -> [f64; 2] {
    let times = || of.poses(channel).map(|pose| of.when(pose));
    [times().fold(f64::INFINITY, f64::min), times().fold(f64::NEG_INFINITY, f64::max)]
}

/// Square of the time (or order) from a share of its span on, in halves of that.
fn squared_time(of: &Columns, channel: usize, share: f64) -> Vec<f64> {
    let [first, last] = span(of, channel);
    let (from, half) = (first + share * (last - first), 0.5 * (last - first));
    of.reading(channel, |pose| if half > 0.0 { ((of.when(pose) - from) / half).powi(2) } else { 0.0 })
}

pub fn of_trend(session: &Session, test: &ResidualTest) -> Words {
    let (channel, size) = (&test.channel, shown(test));
    let kind = if channel == ALL_JOINTS || is_joint(session, channel) { "torque-bias-in-time" } else { "bias-in-time" };
    let what = match channel == ALL_JOINTS {
        true => format!("The residuals of all joints together show that zeros drift, by up to {}.", shown_amount(test)),
        false => format!("The residual of {channel} drifts by {size}: its zero creeps."),
    };
    let cure = format!(
        "Let the sensor warm up before it is read; or estimate a steady drift: sensor_models = [{{ kind = \"{kind}\" }}], with the \
         poses in an order that has nothing to do with their angles."
    );
    Words::new(what, cure).beside(others_drift(channel))
}

pub fn of_curve(test: &ResidualTest) -> Words {
    let (channel, size) = (&test.channel, shown(test));
    let what = format!(
        "The residual of {channel} is not linear in time, by {size} from the middle to the ends: its zero drifts, and the drift settles or grows."
    );
    let cure = "A sensor that warms up does so. Let it warm up before it is read, or leave the first minutes out (from_s in [[poses]]); \
                torque-bias-in-time is a linear drift.";
    Words::new(what, cure).beside(others_drift(channel))
}

pub fn of_trend_in_tables(test: &ResidualTest) -> Words {
    let (channel, size) = (&test.channel, shown(test));
    let what = format!(
        "The residual of {channel} drifts by {size} within each table: its zero creeps, and is read anew between them."
    );
    let cure = "Let the sensor warm up before it is read, and visit some poses twice in each table: at its beginning and its end.";
    Words::new(what, cure).beside(others_drift(channel))
}

pub fn of_settling(test: &ResidualTest) -> Words {
    let channel = &test.channel;
    let what =
        format!("The residual of {channel} drifts by up to {}, and stays: its zero settles.", shown_amount(test));
    let cure = "Let the sensor warm up before it is read, or leave the first minutes out (from_s in [[poses]]).";
    Words::new(what, cure).beside(others_drift(channel))
}

pub fn of_tables(session: &Session, test: &ResidualTest, file: &str) -> Words {
    let channel = &test.channel;
    let zero = match is_joint(session, channel) {
        true => "or a shifted zero",
        false => "or a shifted zero (let each table have a bias of its own: biases = \"table\")",
    };
    Words::new(
        format!("The residual of {channel} is another in each table: in {file} by {}.", shown(test)),
        format!(
            "Possible causes: a load mounted elsewhere than stated, a moved cable, {zero}. Look at what changed between the tables."
        ),
    )
}

fn others_drift(channel: &str) -> Option<&'static str> {
    (channel != ALL_JOINTS).then_some(OTHERS_DRIFT)
}
