//! Friction of gears that grows with what they carry, as slow sweeps and standstills show it.
//!
//! ```text
//!     h = h₀ + s |τ|                                   half the difference of both ways
//!     τ (1 + u) where the gear lifts, τ (1 − v) where it lowers:   s = (u + v)/2,   mean of both ways  τ (1 + (u − v)/2)
//! ```
//!
//! A gear that takes more to lift than it saves to lower turns the mean of both ways away from the torque without friction, in proportion to it: that is
//! exactly a torque gain, and no reading tells it from one. So the gain is known less well, by what `(u − v)/2` may be:
//!
//! ```text
//!     in sweeps, a gear of efficiency η:  u = 1/η − 1,  v = 1 − η       (u − v)/2 = s²/2, to second order
//!     at rest:  a part of u and of v is left, not the same part of both; u = 2 v is taken as one standard deviation:  (u − v)/2 = s/3
//! ```

use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;

use crate::joint::solved::Solved;

/// A slope of fewer standard deviations is none: friction wavers over the angle, too, and torque with it.
const SURE: f64 = 5.0;
/// Correlation of neighbouring bins from which hardly anything can be told.
const MOST_ALIKE: f64 = 0.95;
/// Shares of the gain's standard deviation from which it is worth a remark.
const REMARKABLE: f64 = 0.5;
/// `(u − v)/(u + v)` of a joint at rest that loses twice as much where it lifts as where it lowers. Chosen, not measured.
const UNEVEN_AT_REST: f64 = 1.0 / 3.0;

/// A joint whose friction grows with what it carries.
struct Lossy {
    joint: usize,
    /// Friction over torque.
    slope: f64,
    at_rest: bool,
}

impl Lossy {
    /// One standard deviation of the share of its gain by which its readings may be off.
    fn share(&self) -> f64 {
        if self.at_rest { UNEVEN_AT_REST * self.slope } else { 0.5 * self.slope * self.slope }
    }
}

impl Solved {
    /// By how much the torque gains of joints whose friction grows with what they carry may be off: one entry a column of each.
    pub(in crate::joint) fn moved_by_friction_of_load(&self, session: &Session) -> Vec<Vec<f64>> {
        let moved = |lossy: Lossy| {
            let gain = self.built.variables.sensors[lossy.joint][SensorParameter::TorqueGain as usize];
            let mut moved = vec![0.0; self.judged_problem().columns().len()];
            let by = lossy.share() * self.estimate.values.scalar(gain);
            self.judged_problem().columns_of(gain).for_each(|column| moved[column] = by);
            moved
        };
        self.lossy(session).into_iter().map(moved).collect()
    }

    /// Says whose gains are known less well for it. Their intervals include it already.
    pub(in crate::joint) fn gains_that_hold_friction_of_load(&self, session: &Session) -> Vec<String> {
        let matters = |lossy: &Lossy| {
            let gain = self.built.variables.sensors[lossy.joint][SensorParameter::TorqueGain as usize];
            let std = self.judged_problem().columns_of(gain).next().map_or(0.0, |column| self.covariance().std(column));
            lossy.share() * self.estimate.values.scalar(gain).abs() > REMARKABLE * std && std > 0.0
        };
        let (at_rest, swept): (Vec<Lossy>, Vec<Lossy>) =
            self.lossy(session).into_iter().filter(matters).partition(|lossy| lossy.at_rest);
        [of_sweeps(session, &swept), of_standstills(session, &at_rest)].into_iter().flatten().collect()
    }

    /// Joints whose friction grows with what they carry: surely in sweeps, as far as it seems to at rest.
    fn lossy(&self, session: &Session) -> Vec<Lossy> {
        let joints = 0..session.joints.len();
        let swept = joints
            .clone()
            .filter_map(|joint| Some(Lossy { joint, slope: self.slope_of_friction(session, joint)?, at_rest: false }));
        let at_rest =
            joints.filter_map(|joint| Some(Lossy { joint, slope: self.slope_at_rest(joint)?, at_rest: true }));
        swept.chain(at_rest).collect()
    }

    /// `s` of a joint, with another `h₀` in each of its sweeps; nothing where it may be chance.
    fn slope_of_friction(&self, session: &Session, joint: usize) -> Option<f64> {
        let value = |parameter: SensorParameter| {
            self.estimate.values.scalar(self.built.variables.sensors[joint][parameter as usize])
        };
        let bias = value(SensorParameter::TorqueBias);
        // Friction is read to the side to which the joint moves.
        let way = (value(SensorParameter::TorqueGain) * value(SensorParameter::PositionGain)).signum();
        let sweeps = session.fitted_recordings().filter_map(|searched| searched.sweeps.as_ref());
        let own = sweeps.flat_map(|sweeps| &sweeps.found).filter(|sweep| sweep.joint == joint);
        let (mut carried, mut halves, mut freedom) = (Vec::new(), Vec::new(), 0);
        for sweep in own {
            let bins = sweep.bins.iter().filter_map(|bin| {
                let (half, down) = (bin.half_difference(joint)?.value, bin.sides[1].torque[joint]?.value);
                Some(((down + half - bias).abs(), way * half))
            });
            let (load, half): (Vec<f64>, Vec<f64>) = bins.unzip();
            freedom += load.len().saturating_sub(1);
            carried.extend(about_mean(&load));
            halves.extend(about_mean(&half));
        }
        slope(&carried, &halves, freedom.checked_sub(1)?)
    }
}

fn of_sweeps(session: &Session, lossy: &[Lossy]) -> Option<String> {
    let most = largest_slope(lossy)?;
    Some(format!(
        "Friction of {} grows with what they carry, by up to {:.1} % of it. A gear that loses so much takes more to lift than it saves to \
         lower, and the mean of both ways is beyond the torque at rest: the intervals of these torque gains allow for up to {:.2} %.",
        names(session, lossy),
        100.0 * most,
        50.0 * most * most
    ))
}

fn of_standstills(session: &Session, lossy: &[Lossy]) -> Option<String> {
    let most = largest_slope(lossy)?;
    Some(format!(
        "Friction that is left at rest in {} grows with what they carry, by up to {:.2} % of it. No reading tells a torque gain from a gear that \
         loses more where it lifts than where it lowers: the intervals of these torque gains allow for it with a standard deviation of up to {:.2} %, as of a gear that loses twice as much where it lifts. Let \
         these joints swing about each pose, less and less, before they stand, so that less friction is left.",
        names(session, lossy),
        100.0 * most,
        100.0 * UNEVEN_AT_REST * most
    ))
}

fn largest_slope(lossy: &[Lossy]) -> Option<f64> {
    lossy.iter().map(|lossy| lossy.slope).reduce(f64::max)
}

fn names(session: &Session, lossy: &[Lossy]) -> String {
    let names: Vec<&str> = lossy.iter().map(|l| session.robot.chain.joints()[l.joint].name.as_str()).collect();
    names.join(", ")
}

/// The slope of the second numbers over the first, of which both means are zero; nothing where it may be chance. Friction wavers over many bins:
/// neighbours that are alike count as so many fewer.
fn slope(over: &[f64], of: &[f64], freedom: usize) -> Option<f64> {
    let spread: f64 = over.iter().map(|x| x * x).sum();
    let slope = over.iter().zip(of).map(|(x, y)| x * y).sum::<f64>() / spread;
    let left: Vec<f64> = over.iter().zip(of).map(|(x, y)| y - slope * x).collect();
    let squares: f64 = left.iter().map(|left| left * left).sum();
    let alike = (left.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / squares).clamp(0.0, MOST_ALIKE);
    let std = (squares / freedom.max(1) as f64 / spread * (1.0 + alike) / (1.0 - alike)).sqrt();
    (freedom > 0 && slope > SURE * std).then_some(slope)
}

fn about_mean(numbers: &[f64]) -> Vec<f64> {
    let mean = numbers.iter().sum::<f64>() / numbers.len().max(1) as f64;
    numbers.iter().map(|number| number - mean).collect()
}

#[cfg(test)]
mod tests {
    use gravcal_recording::{Reading, StaticPose, Sweep, Sweeps, SweptBin};
    use gravcal_robot_model::session::Searched;

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// The shoulder, with a sweep of its second joint whose gear has this efficiency, beside friction of 3 counts that wavers.
    fn swept(efficiency: f64) -> (Session, Solved) {
        let mut session = sarcos_shoulder().session(0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        let bias =
            solved.estimate.values.scalar(solved.built.variables.sensors[1][SensorParameter::TorqueBias as usize]);
        let bin = |index: usize| {
            let carried: f64 = 10.0 * (index as f64).to_radians().cos();
            let wavering = 3.0 + 0.05 * (0.2 * index as f64).sin();
            let side = |torque: f64| StaticPose {
                torque: vec![None, Some(Reading { value: bias + torque, std: None }), None],
                ..StaticPose::default()
            };
            SweptBin { sides: [side(carried / efficiency + wavering), side(carried * efficiency - wavering)] }
        };
        let sweep = Sweep { joint: 1, bins: (0..80).map(bin).collect(), ..Sweep::default() };
        let sweeps = Some(Sweeps { found: vec![sweep], ..Sweeps::default() });
        session.searched = vec![Searched { sweeps, ..Searched::default() }];
        (session, solved)
    }

    /// `s = (1/η − η)/2`, and the mean of both ways is `(1/η + η)/2` times the torque at rest.
    #[test]
    fn a_gain_may_be_off_by_what_the_gear_loses() {
        let efficiency = 0.93;
        let (session, solved) = swept(efficiency);
        let moved = solved.moved_by_friction_of_load(&session);
        let gain = solved.built.variables.sensors[1][SensorParameter::TorqueGain as usize];
        let column = solved.judged_problem().columns_of(gain).next().unwrap();
        let expected = (0.5 * (1.0 / efficiency + efficiency) - 1.0) * solved.estimate.values.scalar(gain);
        assert!(
            moved.len() == 1 && (moved[0][column] / expected - 1.0).abs() < 0.05,
            "{} {expected}",
            moved[0][column]
        );
        assert!(moved[0].iter().enumerate().all(|(other, by)| other == column || *by == 0.0));
        assert!(solved.gains_that_hold_friction_of_load(&session)[0].starts_with("Friction of joint2 grows"));
    }

    #[test]
    fn friction_that_only_wavers_moves_no_gain() {
        let (session, solved) = swept(1.0);
        assert!(solved.moved_by_friction_of_load(&session).is_empty());
        assert!(solved.gains_that_hold_friction_of_load(&session).is_empty());
    }
}
