//! Torque sensors that also read the torques of other joints.
//!
//! ```text
//!     y = K τ + b        K_ij: reading of joint i a N·m at joint j
//! ```
//!
//! The diagonal of `K` are the torque gains; the off-diagonal entries of the named joints are parameters, all others are
//! zero: naming every joint makes a full matrix, naming neighbours a band. Identified where the torques of the two joints vary
//! independently. The last link's joints may trade off with the unknown moments, and the common scale of all gains scales the
//! entries as well.

use gravcal_recording::Conditions;

use super::declare::{Declared, Options, RefusedOption, Site, Words};
use super::terms::TorqueFunction;
use crate::parameter::Limit;

/// Beyond this share of the joint's own gain an entry's standard deviation makes it useless.
const USEFUL: f64 = 0.1;

/// `τ_j`.
#[derive(Debug)]
struct OtherTorque {
    other: usize,
}

impl TorqueFunction for OtherTorque {
    fn source(&self) -> Option<usize> {
        Some(self.other)
    }

    fn value(&self, torque: f64, _conditions: &Conditions) -> f64 {
        torque
    }

    fn slope(&self, _torque: f64) -> f64 {
        1.0
    }
}

pub(super) fn declare(site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption> {
    let others = match &options.from {
        None => (0..site.names.len()).filter(|joint| *joint != site.joint).collect(),
        Some(names) => names.iter().map(|name| other(site, name)).collect::<Result<Vec<usize>, RefusedOption>>()?,
    };
    let words = Words {
        convention: "reading = ... + torque_crosstalk_<joint> * torque of that joint",
        cure: "add poses in which the torques of these joints vary independently, with and without a load",
    };
    let term = |other: usize| {
        // A point would part the name of the parameter from that of its joint.
        let quantity = format!("torque_crosstalk_{}", site.names[other].replace('.', "_"));
        let unit = format!("{}/({})", site.torque_unit, site.effort(other));
        site.torque(quantity, unit, words, Limit::Absolute(USEFUL * site.torque_gain.abs()), OtherTorque { other })
    };
    Ok(others.into_iter().map(term).collect())
}

fn other(site: &Site<'_>, name: &str) -> Result<usize, RefusedOption> {
    let place = site.names.iter().position(|joint| *joint == name);
    place.filter(|joint| *joint != site.joint).ok_or_else(|| {
        let message = format!("`{name}` is not another joint; the joints are {}", site.names.join(", "));
        RefusedOption { key: "from", message }
    })
}

#[cfg(test)]
mod tests {
    use crate::sensors::testing::{assert_told_apart, shoulder, undetermined, with_model};
    use crate::sensors::{Options, SensorModelName};

    #[test]
    fn a_banded_matrix_is_told_from_a_diagonal_one() {
        let options = Options { from: Some(vec!["joint3".into()]), ..Options::default() };
        assert_told_apart(&with_model(shoulder(), 1, SensorModelName::TorqueCrosstalk, &options, &[0.2]));
    }

    #[test]
    fn a_full_matrix_is_told_from_a_diagonal_one() {
        let mut simulation = shoulder();
        for (joint, truth) in [[0.1, -0.15], [0.2, 0.1], [-0.1, 0.12]].into_iter().enumerate() {
            simulation = with_model(simulation, joint, SensorModelName::TorqueCrosstalk, &Options::default(), &truth);
        }
        assert_told_apart(&simulation);
    }

    /// Bare poses in which only the last joint moves do not fill a full matrix.
    #[test]
    fn a_matrix_that_the_data_cannot_fill_is_undetermined_by_name() {
        let simulation = with_model(shoulder(), 0, SensorModelName::TorqueCrosstalk, &Options::default(), &[0.1, 0.1]);
        let mut session = simulation.session(0);
        session.poses.retain(|pose| pose.load.is_none() && pose.table == 2);
        let open = undetermined(&session);
        for name in ["joint1.torque_crosstalk_joint2", "joint1.torque_crosstalk_joint3"] {
            assert!(open.contains(&name.to_owned()), "{open:?}");
        }
    }
}
