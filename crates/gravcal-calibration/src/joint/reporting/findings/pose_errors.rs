//! Errors that differ from pose to pose by more than noise of one size.

use gravcal_robot_model::number::significant;

use crate::joint::model_error::pose_errors::PoseErrors;
use crate::joint::reporting::answer::Answer;
use crate::joint::reporting::findings::verdict::Findings;
use crate::result::UncertaintyResult;

impl Answer {
    /// Says what errs from pose to pose, where no test on residuals names what the model lacks, which looks the same.
    pub(in crate::joint::reporting) fn remark_on_pose_errors(&self, findings: &mut Findings) {
        let Some(errors) = self.pose_errors else { return };
        if self.residual_tests.iter().any(|test| test.spoils_intervals) {
            return;
        }
        let meant = match self.uncertainty {
            UncertaintyResult::LargerOfNoiseAndJackknife { .. } => {
                " Standard deviations are no smaller than those of the jackknife, which holds for such errors."
            }
            _ => "",
        };
        findings.remark(match errors {
            PoseErrors::Positions(std) => format!(
                "The torques of one pose err together, as if each joint were {} deg (root mean square) from where its sensor says, from pose to \
                 pose: so do backlash, a coarse encoder, and joints that do not hold.{meant} Hold each pose longer, or approach all from \
                 one side; where the sensors' errors are known, state them (std in [readings] position and torque).",
                significant(std.to_degrees(), 2)
            ),
            PoseErrors::Orientations(std) => format!(
                "The readings of one pose err together, as if the body were turned by {} deg (root mean square, about each axis) from where its orientation \
                 says, from pose to pose.{meant} Hold each pose longer, or tell orientations better.",
                significant(std.to_degrees(), 2)
            ),
            PoseErrors::Torques(share) => format!(
                "Torques scatter more where they are larger, as if by {} % of the torque beside their noise.{meant}",
                significant(100.0 * share, 2)
            ),
        });
    }
}
