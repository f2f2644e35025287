//! A calibration in the forms that others take: parameters of a driver, code, a robot description, tables.
//!
//! | format | what it holds |
//! |---|---|
//! | `ros2` | parameters of a ROS 2 node (YAML): each joint's gain and bias, forward and inverse |
//! | `urdf` | the session's URDF with joints' origins moved by their position offsets, a root that hangs as gravity says, and identified inertias |
//! | `mujoco` | the arm as a MuJoCo model (MJCF) with identified inertias and gravity |
//! | `payload` | loads of unknown mass and the mount's gravity, as the drivers of some makers take them |
//! | `c`, `python` | functions from a reading to what it truly says |
//! | `csv` | every parameter with its interval, for programs |
//! | `markdown`, `latex` | every parameter with its standard deviation, rounded, for people |
//!
//! Each states its convention in the file. All numbers but those of the tables for people have all their digits.
//!
//! **What is not determined** has no value: `csv`, `markdown` and `latex` say so, the others refuse it by name, or take its nominal
//! value and mark it where that is asked for. **Sensors beyond gain and bias** stand in `csv`, `markdown` and `latex` with the equation of
//! each parameter; the others know gain and bias only, and refuse such a joint or instrument by name. Mass and moment of a tool and the
//! mounting of an accelerometer are in these three alone, which the others say, and no instrument is in a URDF.

mod c_header;
mod contents;
mod corrections;
mod csv;
mod error;
mod format;
mod instruments;
mod latex;
mod latex_text;
mod markdown;
mod mujoco;
mod numbers;
mod payload;
mod python;
mod ros2;
mod rows;
#[cfg(test)]
mod tests;
mod urdf;

pub use contents::{Export, Exported, RobotDescription, RobotModel};
use contents::{doubts, head};
use corrections::Corrections;
pub use error::ExportError;
pub use format::{ExportFormat, UnknownFormat};

impl Export<'_> {
    /// The calibration in a format.
    ///
    /// # Errors
    /// See [`ExportError`]; `markdown` and `latex` have none.
    pub fn to(&self, format: ExportFormat) -> Result<Exported, ExportError> {
        let corrections = || Corrections::new(self.estimate, self.nominal, format);
        let exported = match format {
            ExportFormat::Csv => csv::export(self),
            ExportFormat::Markdown => Ok(markdown::export(self)),
            ExportFormat::Latex => Ok(latex::export(self)),
            ExportFormat::Ros2 => ros2::export(self, &corrections()?),
            ExportFormat::C => Ok(c_header::export(self, &corrections()?)),
            ExportFormat::Python => Ok(python::export(self, &corrections()?)),
            ExportFormat::Urdf => urdf::export(self, &corrections()?),
            ExportFormat::Mujoco => self.mujoco(&corrections()?),
            ExportFormat::Payload => self.payload(),
        };
        exported.map(|Exported { text, remarks }| Exported { text, remarks: [doubts(self.estimate), remarks].concat() })
    }
}

impl Export<'_> {
    fn mujoco(&self, corrections: &Corrections) -> Result<Exported, ExportError> {
        let RobotModel { name, chain } = self.model.ok_or(ExportError::NoModel)?;
        let inertias = self.estimate.inertias.as_deref().ok_or(ExportError::NoInertias)?;
        let gravity =
            corrections.gravity.ok_or_else(|| ExportError::Undetermined { names: vec!["gravity".to_owned()] })?;
        if chain.joint_count() < chain.link_count() {
            return Err(ExportError::Mimics);
        }
        let offsets = corrections.joints.iter().map(|joint| (joint.name.clone(), joint.position.offset));
        let arm = mujoco::Arm { name, chain, inertias, offsets: &offsets.collect::<Vec<_>>(), gravity };
        let text = arm.text(&head(self, &mujoco::CONVENTION, &corrections.remarks));
        let text = text.map_err(|missing| ExportError::Missing { names: vec![format!("{}.inertia", missing.link)] })?;
        Ok(Exported { text, remarks: corrections.remarks.clone() })
    }

    fn payload(&self) -> Result<Exported, ExportError> {
        let (payloads, gravity) = (&self.estimate.payloads, self.estimate.gravity);
        if payloads.is_empty() && gravity.is_none() {
            return Err(ExportError::NoPayload);
        }
        let open = payloads.iter().filter(|load| load.mass_kg.is_none()).map(|load| load.load.clone());
        let loads: Vec<String> = open.collect();
        if !loads.is_empty() {
            return Err(ExportError::OpenPayloads { loads });
        }
        let remarks = match payloads.iter().any(|load| load.center_of_mass_m.is_some()) {
            true => payload::frame_remarks(&self.estimate.parameters),
            false if payloads.is_empty() => vec![payload::NONE.to_owned()],
            false => Vec::new(),
        };
        let text = payload::text(payloads, gravity, &head(self, &payload::CONVENTION, &remarks));
        Ok(Exported { text, remarks })
    }
}
