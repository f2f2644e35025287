//! What readings come to: the solution, what of it is determined, and what a reader must know of it, for reports and batches alike.

use gravcal_estimation::EvaluateError;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{MistakenUnit, Session};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::mistakes::hypotheses::{Mistake, find_mistake};
use crate::joint::model_error::large_errors::WARNING;
use crate::joint::reporting::answer::{Answer, Conclusion};
use crate::joint::reporting::findings::Findings;
use crate::joint::reporting::report::{mirrored_gains, report_termination};
use crate::joint::solved::Solved;
use crate::joint::solving::solve_from::solve_from;
use crate::joint::variables::State;
use crate::judgement::{TestsWanted, explained, far_off, in_words};
use crate::result::{NoiseSource, ParameterResult, UncertaintyResult, Verdict};

/// Readings explained this many times worse than their stated noise contradict the model: no number can be relied on.
const CONTRADICTION: f64 = 3.0;
/// And where that is less probable than this: a single degree of freedom exceeds its noise three times in one session of four hundred.
const BEYOND_CHANCE: f64 = 1e-6;
/// From here on intervals cannot be relied on though the values may.
const DOUBT: f64 = 1.5;
/// Probability below which an earlier calibration is contradicted.
const CONTRADICTED_PRIOR: f64 = 1e-4;
/// Standard deviations by which readings pass a constraint that they contradict.
const PASSED: f64 = 5.0;
/// A position gain so many times larger or smaller than its nominal value is of another unit: 180/π is 57.3.
const OTHER_UNIT: f64 = 3.0;

/// Solves and judges the joint problem of these readings. `wanted`: which tests on residuals.
///
/// # Errors
/// Where there is no answer at all; not converging is a verdict.
pub(in crate::joint) fn conclude(
    session: &Session,
    readings: &MeasurementSet,
    known: Option<&State>,
    wanted: TestsWanted,
    environment: &SolveEnvironment<'_>,
) -> Result<Conclusion, EstimateError> {
    let mut answer = Answer::of(session, readings, known, wanted, environment)?;
    let mut findings = answer.looked_over(session, environment)?;
    if environment.stopped() {
        findings.doubt();
        findings.reason_first([
            "Stopped before all was looked over: other starting values and likely mistakes may not have been tried, \
                                so that the numbers may be those of a local minimum. Calibrate again, and let it end."
                .to_owned(),
        ]);
    }
    let verdict = findings.verdict(answer.is_complete(session));
    if verdict == Verdict::Failed {
        answer.withdraw();
    }
    let (failure, [reasons, remarks]) = findings.reported();
    let termination = failure.unwrap_or_else(|| report_termination(&answer.solved));
    Ok(Conclusion { answer, verdict, termination, reasons, remarks })
}

impl Answer {
    /// What a reader must know of it before any number.
    fn looked_over(&self, session: &Session, environment: &SolveEnvironment<'_>) -> Result<Findings, EstimateError> {
        let mut findings = Findings::none(self.solved.estimate.termination.converged());
        let reliable = self.misfit.is_none_or(|misfit| misfit < DOUBT);
        if !reliable || !far_off(session, &self.parameters).is_empty() {
            findings.doubt();
        }
        self.remark_on_noise(session, &mut findings)?;
        self.remark_on_blocks(&mut findings);
        self.solved.contradicted_priors(session).into_iter().for_each(|reason| findings.doubt_for(reason));
        self.remark_on_residuals(session, &mut findings);
        self.solved.biases_that_hold_friction(session).into_iter().for_each(|remark| findings.remark(remark));
        self.solved.gains_that_hold_bending(session).into_iter().for_each(|remark| findings.remark(remark));
        self.remark_on_contradictions(session, &mut findings)?;
        self.remark_on_unexplained(session, &mut findings);
        let noisy = self.remark_on_noise_found(session, &mut findings)?;
        self.remark_on_gravity_upwards(session, &mut findings);
        self.remark_on_earlier(session, &mut findings, environment)?;
        let excused = self.unexplained.iter().flatten().any(|size| size.std > WARNING * size.gravity_std);
        let doubtful = session.noise_estimated().contains(&true) || excused || findings.failed();
        if let Some(mistake) = find_mistake(session, &self.solved, doubtful, environment)? {
            self.forget_mirrored(session, &mut findings);
            findings.fail_first(mistake);
        } else if self.contradiction(session)?.is_some() || noisy || excused {
            findings.reason_first(session.stuck_positions_remark());
        }
        Ok(findings)
    }

    /// Says where residuals are larger or smaller than the stated noise makes them.
    fn remark_on_noise(&self, session: &Session, findings: &mut Findings) -> Result<(), EvaluateError> {
        if let Some(misfit) = self.misfit {
            let consequence = match self.uncertainty {
                UncertaintyResult::Noise { widened_by: Some(_), .. } => {
                    "All standard deviations are widened by that factor, which is honest only if the errors are noise."
                }
                UncertaintyResult::LargerOfNoiseAndJackknife { widened_by: Some(_), .. } => {
                    "Standard deviations are widened by that factor, and are no smaller than those of the jackknife."
                }
                _ => "Standard deviations come from the residuals, and need no widening.",
            };
            findings.remark(format!(
                "The readings are explained {misfit:.1} times worse than their stated noise (p < 0.001). {consequence} \
                 Look at the residuals of each joint: wrong lengths or load masses, friction, motion or a few bad rows \
                 make such errors; or state the std that the sensors have."
            ));
        }
        if let Some(ratio) = self.too_well_explained(session)? {
            findings.remark(format!(
                "The readings scatter only {ratio:.2} times as much as their stated noise: its std is stated about {:.1} \
                 times too large, and so is every standard deviation here. State the std of what is recorded (a mean of \
                 n samples has 1/√n of the noise), or leave it away.",
                1.0 / ratio
            ));
        }
        Ok(())
    }

    /// Says what blocks of poses left out cannot tell.
    fn remark_on_blocks(&self, findings: &mut Findings) {
        let Some(jackknife) = self.uncertainty.jackknife() else { return };
        if !jackknife.told_by_one_block.is_empty() {
            findings.doubt_for(format!(
                "A part of {} is determined by a single block of poses, so that the jackknife cannot tell how well it is known: the standard \
                 deviation assumes that noise is the only error. Add poses like these, or state shorter blocks ([uncertainty] \
                 block_poses).",
                jackknife.told_by_one_block.join(", ")
            ));
        }
        if !jackknife.correlated_blocks.is_empty() {
            let channels = jackknife.correlated_blocks.iter();
            let named = channels.map(|blocks| format!("{} ({:.2})", blocks.channel, blocks.correlation));
            findings.doubt_for(format!(
                "Errors outlast the blocks of poses that tell the standard deviations: sums of residuals over neighbouring blocks are \
                 correlated in {}. Standard deviations are too small. Look at the residuals over time: a drifting zero makes such errors; \
                 let the sensors warm up, or estimate a drift ([[joint]] sensor_models).",
                named.collect::<Vec<_>>().join(", ")
            ));
        }
        if let Some(wanted) = jackknife.too_short_for {
            findings.remark(format!(
                "Residuals stay correlated over more poses than a block has: those of neighbouring poses by {:.2}, for which blocks \
                 should have {wanted} poses, and there are too few poses for that. Intervals may be too narrow. Look at the residuals \
                 over time: a drifting zero makes such errors, and a bias for each table or a drift ([[joint]] sensor_models) takes them up.",
                jackknife.correlation.unwrap_or(0.0)
            ));
        }
    }

    /// Says what shape residuals have, and that intervals cannot hold where that is too large.
    fn remark_on_residuals(&self, session: &Session, findings: &mut Findings) {
        let spoilt = self.residual_tests.iter().any(|test| test.named && test.spoils_intervals);
        in_words(session, &self.residual_tests).into_iter().for_each(|remark| findings.remark(remark));
        if spoilt {
            findings.doubt();
        }
    }

    /// How many times as large as stated residuals are, where standard deviations come from a noise that is stated too large.
    fn too_well_explained(&self, session: &Session) -> Result<Option<f64>, EvaluateError> {
        let by_noise = matches!(self.uncertainty, UncertaintyResult::Noise { source: NoiseSource::Stated, .. });
        let explained = explained(session, &self.solved, self.solved.least_chi_squared())?;
        Ok(explained.too_well().filter(|_| by_noise))
    }

    /// How many times worse than their stated noise the readings are explained, where that is far beyond any chance.
    fn contradiction(&self, session: &Session) -> Result<Option<f64>, EstimateError> {
        let Some(misfit) = self.misfit.filter(|misfit| *misfit > CONTRADICTION) else { return Ok(None) };
        let p_value = explained(session, &self.solved, self.solved.least_chi_squared())?.p_value;
        Ok(p_value.is_some_and(|p| p < BEYOND_CHANCE).then_some(misfit))
    }

    /// Finds what the readings contradict: then there is no answer to rely on.
    fn remark_on_contradictions(&self, session: &Session, findings: &mut Findings) -> Result<(), EstimateError> {
        let solved = &self.solved;
        let termination = solved.estimate.termination;
        if let Some(misfit) = self.contradiction(session)? {
            findings.fail(Mistake {
                what: format!("the model contradicts the readings: residuals {misfit:.0} times the stated noise"),
                advice: format!(
                    "What to look at: the sign of a torque sensor (torque_sign = \"reversed\"), units, swapped \
                         columns, the hemisphere of gravity, the loads' masses and distances, values given as fixed, \
                         poses that are not static, single bad rows. If the model is known to be this rough, leave std \
                         away: the noise is then estimated from the residuals.{}",
                    of_instruments(session)
                ),
            });
        }
        if !termination.converged() {
            return Ok(());
        }
        if self.solved.hemisphere_contradicted {
            findings.fail(Mistake {
                what: "gravity came out in the other hemisphere than the declared one".into(),
                advice:
                    "The readings decide against [gravity] hemisphere: correct it, or look for torque sensors that \
                         are all reversed."
                        .into(),
            });
        }
        let passed = self.solved.estimate.active.iter().zip(&self.solved.leans).filter(|(_, lean)| **lean > PASSED);
        let passed: Vec<String> =
            passed.map(|(active, lean)| format!("\"{}\" by {lean:.0} standard deviations", active.name)).collect();
        if !passed.is_empty() {
            findings.fail(Mistake {
                what: format!("the readings contradict {}", passed.join(", ")),
                advice: "A constraint that the readings would like to pass so far spoils what is estimated under it: \
                         widen it, or drop it and look at what comes out."
                    .into(),
            });
        }
        for mirrored in mirrored_gains(session, &self.solved, &self.parameters) {
            findings.fail(mirrored);
        }
        if let Some(mistake) = other_unit(session, &self.solved, &self.parameters) {
            findings.fail(mistake);
        }
        Ok(())
    }

    /// Torques of the other sign are those of gravity the other way up: where it comes out upwards and no hemisphere says so, one of both
    /// is the case.
    fn remark_on_gravity_upwards(&self, session: &Session, findings: &mut Findings) {
        let Some(gravity) = self.gravity.as_ref().filter(|_| session.gravity.hemisphere.is_none()) else { return };
        if gravity.vector_m_per_s2[2] <= 0.0 {
            return;
        }
        findings.doubt();
        findings.reason_first([
            "Gravity comes out upwards in base coordinates. Either the base hangs or leans over, or all torques are recorded with the \
             other sign: the readings are the same in both cases. Say which: [gravity] hemisphere = [0, 0, -1] for an upright base, \
             and torque_sign = \"reversed\" ([joints]; sign of a [[force_torque_sensor]]) if the signs are the other ones; hemisphere = \
             [0, 0, 1] for a base that hangs."
                .to_owned(),
        ]);
    }

    /// Holds an earlier calibration against the readings: χ² must not grow by more than chance where it is heeded.
    fn remark_on_earlier(
        &self,
        session: &Session,
        findings: &mut Findings,
        environment: &SolveEnvironment<'_>,
    ) -> Result<(), EstimateError> {
        let solved = &self.solved;
        if session.earlier.is_none() || !solved.estimate.termination.converged() {
            return Ok(());
        }
        environment.report("holding the earlier calibration against the readings");
        let alone = Session { earlier: None, ..session.clone() };
        let start = solved.state(&State::nominal(session));
        let without = solve_from(&alone, &solved.readings, start, environment)?;
        let freedom = |solved: &Solved| solved.judged_problem().rows().saturating_sub(solved.analysis.rank());
        let gained = freedom(solved).saturating_sub(freedom(&without)) as f64;
        let size = match session.noise_estimated().contains(&true) {
            true => without.least_chi_squared() / freedom(&without).max(1) as f64,
            false => 1.0,
        };
        let growth = (solved.least_chi_squared() - without.least_chi_squared()) / size;
        let Ok(distribution) = ChiSquared::new(gained) else { return Ok(()) };
        let p = distribution.sf(growth.max(0.0));
        if without.estimate.termination.converged() && p < CONTRADICTED_PRIOR {
            // Readings that are explained without it are not to blame.
            let fail = if without.misfit(session)?.is_none() { Findings::fail_first } else { Findings::fail };
            fail(findings, Mistake {
                what: format!("the readings contradict the earlier calibration: χ² grows by {growth:.0} for {gained:.0} numbers"),
                advice: "What [prior] knows is not what was read here: a base that was moved, links or loads that are not as \
                         they were (leave them out of prior.unchanged), or a sensor that has changed (compare the two \
                         calibrations, `gravcal compare`)."
                    .into(),
            });
        }
        Ok(())
    }

    /// Takes back what signs of gains accuse sensors of, as they come from a fit of a model that is wrong for another reason.
    fn forget_mirrored(&self, session: &Session, findings: &mut Findings) {
        let mirrored = mirrored_gains(session, &self.solved, &self.parameters);
        findings.forget(&mirrored.into_iter().map(|mistake| mistake.advice).collect::<Vec<_>>());
    }
}

/// What to look at besides where there are wrist sensors.
pub(in crate::joint) fn of_instruments(session: &Session) -> &'static str {
    match session.instruments.is_empty() {
        true => "",
        false => {
            " Of a wrist sensor: its sign (sign = \"reversed\"), its mounting, the frame of its readings (frame), and whether it was zeroed \
             before each table (biases = \"table\")."
        }
    }
}

/// Position readings that are in another unit than declared, as their gain tells.
fn other_unit(session: &Session, solved: &Solved, parameters: &[ParameterResult]) -> Option<Mistake> {
    let joints = session.robot.chain.joints().iter().enumerate();
    let mut found = joints.filter_map(|(joint, described)| {
        let name = SensorParameter::PositionGain.name(&described.name);
        let determined = parameters.iter().any(|p| p.name == name && p.determined && p.held.is_none());
        let value = solved
            .estimate
            .values
            .scalar(solved.built.variables.sensors[joint][SensorParameter::PositionGain as usize]);
        let ratio = value / session.joints[joint].of(SensorParameter::PositionGain).nominal;
        let other = determined && (ratio.abs() > OTHER_UNIT || ratio.abs() < 1.0 / OTHER_UNIT);
        other.then_some((name, ratio))
    });
    let (name, ratio) = found.next()?;
    let looks = match MistakenUnit::of_gain(ratio) {
        Some(mistaken) => format!("they {}: {}", mistaken.reported(), mistaken.cure()),
        None => "state the gain ([[joint]] position_gain = { nominal = …, unit = … })".to_owned(),
    };
    Some(Mistake {
        what: format!("{name} is {ratio:.3} times its nominal value"),
        advice: format!(
            "No position sensor is so far off its nominal gain: its readings are in another unit than declared; {looks}."
        ),
    })
}

#[cfg(test)]
mod tests {
    use gravcal_solvers::LevenbergMarquardt;

    use super::*;
    use crate::joint::{Signals, select};
    use crate::testing::sarcos_shoulder;

    #[test]
    fn beside_another_cause_no_sensor_is_accused_by_the_sign_of_its_gain() {
        let mut simulation = sarcos_shoulder();
        simulation.truth.sensors[2][0] *= -1.0;
        let session = simulation.session(0);
        let solver = LevenbergMarquardt::default();
        let environment = SolveEnvironment::new(&solver, &|_: &str| {});
        let answer =
            Answer::of(&session, &select(&session, Signals::All), None, TestsWanted::All, &environment).unwrap();
        let accused = |remarks: &[String]| remarks.iter().any(|r| r.contains("of the other sign than"));
        let mut findings = Findings::none(true);
        answer.remark_on_contradictions(&session, &mut findings).unwrap();
        answer.forget_mirrored(&session, &mut findings);
        let remarks = findings.reported().1.concat();
        assert!(!accused(&remarks), "{remarks:?}");
        let mut findings = Findings::none(true);
        answer.remark_on_contradictions(&session, &mut findings).unwrap();
        let remarks = findings.reported().1.concat();
        assert!(accused(&remarks), "{remarks:?}");
    }
}
