//! What automatic derivatives cost beside analytic ones: one table.
//!
//! `cargo run --release -p gravcal-benches --bin automatic`

use std::hint::black_box;
use std::time::Instant;

use gravcal_estimation::{
    Automatic, Block, BlockId, EvaluateError, Formula, LocalNumbers, LocalValues, Number, ProblemBuilder, Residual,
    RowsMut,
};

const ROWS: usize = 250;
const REPETITIONS: usize = 20_000;

/// Rows over one block of numbers, with their derivatives by hand.
trait Twin: std::fmt::Debug + Send + Sync + 'static {
    fn value<N: Number>(b: &[N], t: f64) -> N;
    fn slope(b: &[f64], t: f64, row: &mut [f64]);
}

/// Polynomial with 8 coefficients: nothing but additions and multiplications.
#[derive(Clone, Copy, Debug)]
struct Polynomial;

impl Twin for Polynomial {
    fn value<N: Number>(b: &[N], t: f64) -> N {
        b.iter().rev().fold(N::from(0.0), |sum, c| sum * t + *c)
    }

    fn slope(_: &[f64], t: f64, row: &mut [f64]) {
        row.iter_mut().fold(1.0, |power, entry| {
            *entry = power;
            power * t
        });
    }
}

/// A decay and two peaks, as NIST's Gauss1: three exponentials, which the derivatives share.
#[derive(Clone, Copy, Debug)]
struct Peaks;

impl Twin for Peaks {
    fn value<N: Number>(b: &[N], t: f64) -> N {
        let peak = |b: &[N]| b[0] * (-((-b[1] + t) / b[2]).powi(2)).exp();
        b[0] * (-b[1] * t).exp() + peak(&b[2..5]) + peak(&b[5..8])
    }

    fn slope(b: &[f64], t: f64, row: &mut [f64]) {
        let decay = (-b[1] * t).exp();
        (row[0], row[1]) = (decay, -t * b[0] * decay);
        for k in [2, 5] {
            let distance = (t - b[k + 1]) / b[k + 2];
            let shape = (-distance * distance).exp();
            let slope = 2.0 * b[k] * shape * distance / b[k + 2];
            (row[k], row[k + 1], row[k + 2]) = (shape, slope, slope * distance);
        }
    }
}

/// The derivatives by hand.
#[derive(Debug)]
struct Analytic<T>(BlockId, T);

impl<T: Twin> Residual for Analytic<T> {
    fn blocks(&self) -> &[BlockId] {
        std::slice::from_ref(&self.0)
    }

    fn len(&self) -> usize {
        ROWS
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        residual.iter_mut().enumerate().for_each(|(i, r)| *r = T::value(x.block(0), i as f64));
        if let Some(mut rows) = jacobian {
            (0..ROWS).for_each(|i| T::slope(x.block(0), i as f64, rows.row(i)));
        }
        Ok(())
    }
}

impl<T: Twin> Formula for Analytic<T> {
    fn blocks(&self) -> &[BlockId] {
        std::slice::from_ref(&self.0)
    }

    fn len(&self) -> usize {
        ROWS
    }

    fn evaluate<N: Number>(&self, x: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
        residual.iter_mut().enumerate().for_each(|(i, r)| *r = T::value(x.block(0), i as f64));
        Ok(())
    }
}

/// Nanoseconds a row.
fn time(residual: &dyn Residual, x: &[f64], with_jacobian: bool) -> f64 {
    let (mut r, mut j) = (vec![0.0; ROWS], vec![0.0; ROWS * x.len()]);
    let offsets = [0, x.len()];
    let start = Instant::now();
    for _ in 0..REPETITIONS {
        let jacobian = with_jacobian.then(|| RowsMut::new(&mut j, x.len()));
        let _ = black_box(residual.evaluate(LocalValues::new(black_box(x), &offsets), &mut r, jacobian));
    }
    start.elapsed().as_secs_f64() * 1e9 / (REPETITIONS * ROWS) as f64
}

fn report<T: Twin + Copy>(name: &str, twin: T, x: &[f64], block: BlockId) {
    let (analytic, automatic) = (Analytic(block, twin), Automatic(Analytic(block, twin)));
    let (value, by_hand, by_dual) = (time(&analytic, x, false), time(&analytic, x, true), time(&automatic, x, true));
    println!("| {name} | {value:.1} | {by_hand:.1} | {by_dual:.1} | {:.1} |", by_dual / by_hand);
}

fn main() {
    let mut builder = ProblemBuilder::new();
    let block = builder.add_block(Block::vector("b", "", &["1", "2", "3", "4", "5", "6", "7", "8"]), &[0.0; 8]);
    println!("nanoseconds a row of 8 columns, one thread\n");
    println!("| | r | r and J by hand | r and J automatic | automatic/by hand |\n|---|---|---|---|---|");
    report("polynomial", Polynomial, &[1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-18, 1e-21], block);
    report("a decay and two peaks", Peaks, &[97.0, 0.009, 100.0, 65.0, 20.0, 70.0, 178.0, 16.5], block);
}
