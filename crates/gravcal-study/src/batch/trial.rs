//! One trial: every estimator with every solver on the same readings.

use std::panic::{AssertUnwindSafe, catch_unwind};

use gravcal_calibration::joint::{EstimateError, Signals};
use gravcal_calibration::result::Brief;
use gravcal_calibration::sequential::{Handed, Plan, report_steps_briefly, run_steps_handed};
use gravcal_calibration::{SolveEnvironment, calibrate_briefly};
use gravcal_estimation::statistics::Quantile;
use gravcal_robot_model::EstimatorName;

use super::row::{Cell, Outcome, Row};
use super::run::Helpers;
use crate::bounds::Bounds;
use crate::plan::{Compared, Instance, Study};
use crate::quantities::Measured;

/// How long a trial took, s.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Took {
    pub simulating: f64,
    pub calibrating: f64,
}

/// Which trial.
#[derive(Clone, Copy, Debug)]
pub(super) struct Which<'a> {
    pub study: &'a Study,
    pub point: usize,
    pub trial: u64,
    /// The bounds of the point, where they are the same for all its trials.
    pub bounds: Option<&'a Bounds>,
}

/// Runs it. A failure of whatever kind, a panic included, is a row with its reason.
pub(super) fn run(which: Which<'_>, helpers: &Helpers<'_>) -> (Vec<Row>, Took) {
    let began = (helpers.clock)();
    let failed = |reason: String| which.rows(helpers.solvers.len()).map(|row| row.failed(reason.clone())).collect();
    let point = &which.study.points[which.point];
    let instance = match guarded(|| point.instance(which.trial, &which.study.quantities)) {
        Ok(instance) => instance,
        Err(reason) => return (failed(reason), Took::default()),
    };
    let own;
    let bounds = match which.bounds {
        Some(bounds) => bounds,
        None => {
            own = guarded(|| bounds_of(which.study, &instance)).unwrap_or_default();
            &own
        }
    };
    let simulated = (helpers.clock)();
    let mut rows: Vec<Row> = which.rows(helpers.solvers.len()).collect();
    for (solver, (_, method)) in helpers.solvers.iter().enumerate() {
        let quiet = |_: &str| {};
        let environment = SolveEnvironment::new(method.as_ref(), &quiet);
        let together = |compared: &[Compared]| guarded(|| Ok(answers(compared, &instance, &environment)));
        let answers: Vec<Result<Brief, String>> = match together(&which.study.estimators) {
            Ok(answers) => answers.into_iter().map(|answer| answer.map_err(|error| error.to_string())).collect(),
            // One of them panicked: it takes no other with it.
            Err(_) => {
                let alone = |compared: &Compared| together(&[*compared])?.remove(0).map_err(|error| error.to_string());
                which.study.estimators.iter().map(alone).collect()
            }
        };
        for row in rows.iter_mut().filter(|row| row.solver == solver) {
            let answer = answers[row.estimator].as_ref().map_err(Clone::clone);
            row.fill(answer, &instance, bounds.of(which.study.estimators[row.estimator].signals()));
        }
    }
    let took = Took { simulating: simulated - began, calibrating: (helpers.clock)() - simulated };
    (rows, took)
}

/// The bounds of the readings that a study's estimators use.
pub(super) fn bounds_of(study: &Study, instance: &Instance) -> Result<Bounds, String> {
    let used = |signals: &Signals| study.estimators.iter().any(|estimator| estimator.signals() == *signals);
    let signals: Vec<Signals> = [Signals::PaperSteps, Signals::All].into_iter().filter(used).collect();
    let measured: Vec<Measured> = instance.measured.iter().map(|(_, measured)| *measured).collect();
    Bounds::new(&instance.session, &instance.truth, &signals, &measured).map_err(|error| error.to_string())
}

/// What each of them answers, in their order.
fn answers(
    compared: &[Compared],
    instance: &Instance,
    environment: &SolveEnvironment<'_>,
) -> Vec<Result<Brief, EstimateError>> {
    let (session, truth) = (&instance.session, &instance.truth);
    let own = |compared: &Compared| match compared {
        Compared::Estimator(name) => Some(*name),
        Compared::SequentialTrueStep1 | Compared::SequentialTrueSteps1And2 => None,
    };
    let estimators: Vec<EstimatorName> = compared.iter().filter_map(own).collect();
    let mut of_estimators = calibrate_briefly(session, &estimators, environment).into_iter();
    let handed = |handed: Handed<'_>| {
        let steps = run_steps_handed(session, &Plan::new(session), handed, environment);
        Some(Ok(report_steps_briefly(session, &steps)))
    };
    let step_1 = Some(truth);
    let each = compared.iter().filter_map(|compared| match compared {
        Compared::Estimator(_) => of_estimators.next(),
        Compared::SequentialTrueStep1 => handed(Handed { step_1, gravity: None }),
        Compared::SequentialTrueSteps1And2 => handed(Handed { step_1, gravity: Some(truth.gravity) }),
    });
    each.collect()
}

/// Whatever happens inside ends as a reason.
fn guarded<T>(what: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(what)).unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let said = said.or_else(|| panic.downcast_ref::<String>().cloned());
        Err(format!("panicked: {}", said.unwrap_or_else(|| "nothing said".to_owned())))
    })
}

impl Which<'_> {
    /// Rows without an answer.
    fn rows(&self, solvers: usize) -> impl Iterator<Item = Row> {
        let (point, trial, estimators) = (self.point, self.trial, self.study.estimators.len());
        let cells = vec![Cell::EMPTY; self.study.quantities.len()];
        (0..estimators).flat_map(move |estimator| (0..solvers).map(move |solver| (estimator, solver))).map(
            move |(estimator, solver)| Row {
                point,
                trial,
                estimator,
                solver,
                outcome: Outcome::Failed,
                reason: None,
                iterations: 0,
                cells: cells.clone(),
            },
        )
    }
}

impl Row {
    fn failed(self, reason: String) -> Row {
        Row { reason: Some(reason), ..self }
    }

    fn fill(&mut self, answer: Result<&Brief, String>, instance: &Instance, bounds: &[Option<f64>]) {
        for ((place, _), bound) in instance.measured.iter().zip(bounds) {
            self.cells[*place].bound = bound.unwrap_or(f64::NAN);
        }
        let brief = match answer {
            Ok(brief) => brief,
            Err(reason) => return self.reason = Some(reason),
        };
        self.outcome = brief.verdict.into();
        self.iterations = brief.iterations as u64;
        if self.outcome == Outcome::Failed {
            return self.reason = Some(brief.termination.clone());
        }
        for (place, measured) in &instance.measured {
            let cell = &mut self.cells[*place];
            if let Some((error, std, inside)) = compare(*measured, brief, instance) {
                *cell = Cell { error, std, inside: Some(inside), ..*cell };
            }
        }
    }
}

/// Error, standard deviation, and whether the interval holds the truth, of a quantity that is determined.
fn compare(measured: Measured, brief: &Brief, instance: &Instance) -> Option<(f64, f64, bool)> {
    let truth = measured.of(&instance.truth);
    match measured {
        Measured::Gravity(axis) => {
            let gravity = brief.gravity.as_ref()?;
            let (error, std) = (gravity.vector_m_per_s2[axis] - truth, gravity.std_m_per_s2[axis]);
            let [low, high] = Quantile::normal().interval(error, std);
            Some((error, std, (low..=high).contains(&0.0)))
        }
        Measured::Sensor(..) => {
            let name = measured.name(&instance.session);
            let reported = brief
                .parameters
                .iter()
                .find(|reported| reported.name == name)
                .filter(|reported| reported.determined)?;
            let [low, high] = reported.ci95?;
            Some((reported.value? - truth, reported.std?, (low..=high).contains(&truth)))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::atomic::AtomicBool;

    use gravcal_estimation::{Estimate, Problem, SolveContext, SolveError, Solver, Unsupported, Values};

    use super::*;
    use crate::batch::{NamedSolver, Outcome};

    /// Stands for a residual or a method of a user that panics.
    struct Panicking;

    impl Solver for Panicking {
        fn name(&self) -> &'static str {
            "panicking"
        }

        fn check(&self, _: &Problem) -> Result<(), Unsupported> {
            Ok(())
        }

        fn solve(&self, _: &Problem, _: &Values, _: &mut SolveContext<'_>) -> Result<Estimate, SolveError> {
            panic!("index out of bounds")
        }
    }

    #[test]
    fn what_panics_is_a_row_with_its_reason_and_takes_no_other_with_it() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/joint-against-sequential/study.toml");
        let study = Study::read(&path).unwrap();
        let solvers: [NamedSolver; 2] = [
            ("panicking".to_owned(), Box::new(Panicking)),
            ("levenberg-marquardt".to_owned(), Box::new(gravcal_solvers::LevenbergMarquardt::default())),
        ];
        let stop = AtomicBool::new(false);
        let helpers = Helpers { solvers: &solvers, clock: &|| 0.0, progress: &|_, _| {}, stop: &stop };
        let (rows, _) = run(Which { study: &study, point: 0, trial: 0, bounds: None }, &helpers);
        assert_eq!(rows.len(), 2 * study.estimators.len());
        let joint = study.estimators.iter().position(|compared| compared.to_string() == "joint").unwrap();
        let of_joint: Vec<&Row> = rows.iter().filter(|row| row.estimator == joint).collect();
        assert_eq!(of_joint.iter().map(|row| row.outcome).collect::<Vec<_>>(), [Outcome::Failed, Outcome::Determined]);
        assert_eq!(of_joint[0].reason.as_deref(), Some("panicked: index out of bounds"));
    }
}
