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

use super::model::{Declared, ParameterSpec, SensorModel, Site};
use super::options::{Options, RefusedOption};
use super::term::{Moment, Partials, Reads, SensorTerm};
use crate::parameter::Limit;

/// Beyond this share of the joint's own gain an entry's standard deviation makes it useless.
const USEFUL: f64 = 0.1;

/// `torque-crosstalk`.
#[derive(Debug)]
pub(super) struct Crosstalk;

/// `K_ij τ_j`.
#[derive(Debug)]
struct OtherTorque {
    other: usize,
}

impl SensorTerm for OtherTorque {
    fn reads(&self) -> Reads {
        Reads::positions().torque(self.other).affine_in_torques().linear_in_parameters()
    }

    fn value(&self, at: &Moment<'_>, x: &[f64], partials: Option<Partials<'_>>) -> f64 {
        let torque = at.torque(self.other);
        if let Some(Partials { by_parameter, by_torque, .. }) = partials {
            (by_parameter[0], by_torque[self.other]) = (torque, x[0]);
        }
        x[0] * torque
    }
}

impl SensorModel for Crosstalk {
    fn name(&self) -> &str {
        "torque-crosstalk"
    }

    fn help(&self) -> &str {
        "the torque reading depends on other joints' torques"
    }

    fn options(&self) -> &[&str] {
        &["from"]
    }

    fn declare(&self, site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let others = match options.texts("from")? {
            None => (0..site.names.len()).filter(|joint| *joint != site.joint).collect(),
            Some(names) => names.iter().map(|name| other(site, name)).collect::<Result<Vec<usize>, RefusedOption>>()?,
        };
        let term = |other: usize| {
            // A point would part the name of the parameter from that of its joint.
            let name = format!("torque_crosstalk_{}", site.names[other].replace('.', "_"));
            let unit = format!("{}/({})", site.torque_unit(), site.effort(other));
            let parameter = ParameterSpec::new(name, unit, Limit::Absolute(USEFUL * site.torque_gain().abs()))
                .in_equation("reading = ... + torque_crosstalk_<joint> * torque of that joint")
                .cured_by("add poses in which the torques of these joints vary independently, with and without a load");
            Declared::new([parameter], OtherTorque { other })
        };
        Ok(others.into_iter().map(term).collect())
    }
}

fn other(site: &Site<'_>, name: &str) -> Result<usize, RefusedOption> {
    site.joint_named(name).filter(|joint| *joint != site.joint).ok_or_else(|| {
        let joints = site.names.join(", ");
        RefusedOption::new("from", format!("`{name}` is not another joint; the joints are {joints}"))
    })
}
