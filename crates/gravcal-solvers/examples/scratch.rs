use gravcal_estimation::published::nist;
use gravcal_estimation::SolveContext;
use gravcal_solvers::SolverName;
fn main() {
    let name = std::env::args().nth(1).unwrap();
    let which: usize = std::env::args().nth(2).unwrap().parse().unwrap();
    let sets = nist::read(std::path::Path::new("/work/shared/data/nist_strd")).unwrap();
    let c = sets.iter().find(|c| c.problem.name == name).unwrap();
    for solver in SolverName::ALL {
        let (p, i) = c.problem.pose(&c.problem.starts[which]).unwrap();
        let mut n = 0;
        let mut obs = |r: &gravcal_estimation::IterationRecord| { n += 1; if n < 25 && solver == SolverName::LevenbergMarquardt { println!("{r:?}") } };
        let mut ctx = SolveContext { observer: Some(&mut obs), ..Default::default() };
        match solver.build().solve(&p, &i, &mut ctx) {
            Ok(e) => println!("{solver}: {} after {}: cost {:e} {:?} {:?}", e.termination, e.iterations.len(), e.cost, e.values.as_slice(), c.digits(&p, &e.values).map(|d| d.parameters)),
            Err(e) => println!("{solver}: {e}"),
        }
    }
}
