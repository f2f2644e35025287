use gravcal_calibration::joint::predict_nominally;
use gravcal_calibration::{EstimatorName, Session, Workbench, calibrate};
use gravcal_estimation::*;
struct Lm;
impl Solver for Lm {
    fn name(&self) -> &'static str {
        "lm"
    }
    fn check(&self, _: &Problem) -> Result<(), Unsupported> {
        Ok(())
    }
    fn solve(
        &self,
        problem: &Problem,
        initial: &Values,
        context: &mut SolveContext<'_>,
    ) -> Result<Estimate, SolveError> {
        let mut values = initial.clone();
        let mut cost = problem.cost(&values)?;
        let mut lambda = 1e-3;
        let (mut way, mut iterations) = (vec![values.clone()], vec![]);
        iterations.push(IterationRecord { iteration: 0, cost, cosine: 1.0, step: 0.0, damping: 0.0 });
        for i in 1..60 {
            let mut lin = problem.linearize(&values)?;
            let scaling = lin.column_scales();
            let mut step = vec![0.0; scaling.len()];
            lin.damped_step(lambda, &scaling, &mut step);
            let next = problem.retract(&values, &step);
            let new = problem.cost(&next)?;
            if new.is_finite() && new <= cost {
                let done = cost - new < 1e-10 * cost;
                values = next;
                cost = new;
                lambda = (lambda * 0.1f64).max(1e-12);
                let record = IterationRecord { iteration: i, cost, cosine: 1e-3, step: 1e-3, damping: lambda };
                context.tell(&record);
                iterations.push(record);
                way.push(values.clone());
                if done {
                    break;
                }
            } else {
                lambda *= 10.0;
            }
        }
        Ok(Estimate {
            cost,
            values,
            termination: Termination::Cost { relative: 1e-10 },
            iterations,
            way,
            active: vec![],
            without_effect: vec![],
        })
    }
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let session = Session::read(std::path::Path::new(&a[1])).unwrap();
    let lm = Lm;
    let w = Workbench::new(&lm, &|_| {});
    let results = calibrate(&session, &EstimatorName::DEFAULT, &w);
    for r in &results {
        eprintln!("{} {:?} {}", r.name, r.verdict, r.termination);
    }
    let nominal = predict_nominally(&session, &w).unwrap();
    let t = std::time::Instant::now();
    let rec = gravcal_rerun::CalibrationRecording {
        id: "scratch",
        session: &session,
        results: &results,
        nominal: &nominal,
        table: "the table\n",
    };
    let bytes = rec.to_rrd().unwrap();
    eprintln!("{} bytes in {:?}", bytes.len(), t.elapsed());
    std::fs::write(&a[2], bytes).unwrap();
}
