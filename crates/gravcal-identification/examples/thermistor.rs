//! A thermometer, calibrated in twelve baths: a thermistor and a series resistor divide a supply voltage.
//!
//! ```text
//!     reading = V · R / (R + R_s),   R = R_0 exp(B (1/T − 1/298.15 K))
//! ```
//!
//! Nobody states the noise, and R_0 and R_s divide alike whatever their size: only their ratio shows. The first answer says so, and tells
//! B and V all the same. A second one has the series resistor measured.
//!
//! ```sh
//! cargo run --release -p gravcal-identification --example thermistor
//! ```

use std::error::Error;

use gravcal_estimation::{
    Automatic, Block, BlockId, Estimate, EvaluateError, Factor, Formula, LocalNumbers, Noise, Number, Problem,
    ProblemBuilder, Reference, SolveError, Values,
};
use gravcal_identification::{
    Combination, End, Fit, Known, Likeliest, Parameter, Place, Profiled, ReadingResidual, SolveEnvironment, fit, judge,
    limits_of_use, noise_by_squares, row_residuals, share_that_matters,
};
use gravcal_solvers::SolverName;

/// Bath, °C, and reading, V: B = 3950 K, V = 4.987 V, R_0 = 10.3 kΩ, R_s = 9.95 kΩ, noise of 0.5 mV.
const BATHS: [(f64, f64); 12] = [
    (0.0, 3.8739),
    (8.0, 3.4789),
    (16.0, 3.0414),
    (24.0, 2.5923),
    (32.0, 2.1602),
    (40.0, 1.7673),
    (48.0, 1.4277),
    (56.0, 1.1423),
    (64.0, 0.9113),
    (72.0, 0.7258),
    (80.0, 0.5792),
    (88.0, 0.4641),
];
/// By the data sheets, and the standard deviation beyond which a number would be of no use.
const PARAMETERS: [(&str, &str, f64, f64); 4] =
    [("B", "K", 3500.0, 40.0), ("V", "V", 5.0, 0.05), ("R_0", "kΩ", 10.0, 0.5), ("R_s", "kΩ", 10.0, 0.5)];
/// Other materials, K.
const OTHER_B: [f64; 3] = [2500.0, 4500.0, 6000.0];
/// Two ends whose `B` differ by a smaller share are one.
const SAME_B: f64 = 1e-3;
/// Rounds in which the noise is found.
const ROUNDS: usize = 4;

/// A reading in a bath.
#[derive(Debug)]
struct Divider {
    blocks: [BlockId; 4],
    celsius: f64,
    volts: f64,
}

impl Formula for Divider {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        1
    }

    fn evaluate<N: Number>(&self, p: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
        let inverse = 1.0 / (self.celsius + 273.15) - 1.0 / 298.15;
        let resistance = (p.scalar(0) * inverse).exp() * p.scalar(2);
        residual[0] = p.scalar(1) * resistance / (resistance + p.scalar(3)) - self.volts;
        Ok(())
    }
}

/// A resistance that was measured, kΩ.
#[derive(Debug)]
struct Measured {
    block: [BlockId; 1],
    value: f64,
}

impl Formula for Measured {
    fn blocks(&self) -> &[BlockId] {
        &self.block
    }

    fn len(&self) -> usize {
        1
    }

    fn evaluate<N: Number>(&self, p: LocalNumbers<'_, N>, residual: &mut [N]) -> Result<(), EvaluateError> {
        residual[0] = p.scalar(0) - self.value;
        Ok(())
    }
}

/// The thermometer as a problem, from its data sheets; readings with this noise, V.
struct Thermometer {
    /// Value and standard deviation of the series resistor, kΩ, if somebody measured it.
    series: Option<(f64, f64)>,
}

impl Thermometer {
    fn problem(&self, noise: f64) -> Result<(Problem, Values, [BlockId; 4]), Box<dyn Error>> {
        let mut builder = ProblemBuilder::new();
        let blocks =
            PARAMETERS.map(|(name, unit, nominal, _)| builder.add_block(Block::scalar(name, unit), &[nominal]));
        for (celsius, volts) in BATHS {
            let reading = Automatic(Divider { blocks, celsius, volts });
            builder.add_factor(Factor::new(reading, Noise::independent(&[noise])?));
        }
        if let Some((value, std)) = self.series {
            let measured = Automatic(Measured { block: [blocks[3]], value });
            builder.add_factor(Factor::new(measured, Noise::independent(&[std])?));
        }
        let (problem, nominal) = builder.build()?;
        let wide = |reference: Reference, (block, (.., limit)): (&BlockId, (&str, &str, f64, f64))| {
            reference.with(*block, &[30.0 * limit])
        };
        let reference = blocks.iter().zip(PARAMETERS).fold(Reference::new(nominal.clone()), wide);
        Ok((problem.with_reference(reference), nominal, blocks))
    }

    /// Readings with the noise that they show, from this start.
    fn noise(&self, environment: &SolveEnvironment<'_>) -> Result<f64, Box<dyn Error>> {
        let mut noise = 0.1;
        for _ in 0..ROUNDS {
            let (problem, start, _) = self.problem(noise)?;
            let Fit { problem, estimate } = fit(&problem, &start, BATHS.len(), environment)?;
            let known = Known::at::<Box<dyn Error>>(&problem, &estimate)?;
            let rows = row_residuals(&problem, &estimate.values, &known.analysis, BATHS.len())?;
            let readings = rows.into_iter().map(|row| ReadingResidual { channel: 0, std: noise, row });
            let found = noise_by_squares(&readings.collect::<Vec<_>>(), &[None]);
            noise = found[0].ok_or("the readings have no noise")?.std;
        }
        Ok(noise)
    }
}

/// A parameter as it is told.
struct Reported {
    name: &'static str,
    unit: &'static str,
    /// With its standard deviation, where it is determined.
    value: Option<(f64, f64)>,
}

/// What is told.
struct Answer {
    parameters: Vec<Reported>,
    /// What is not determined, by name: shares of values.
    open: Vec<Combination<&'static str>>,
    /// V.
    noise: f64,
}

fn calibrate(thermometer: &Thermometer, environment: &SolveEnvironment<'_>) -> Result<Answer, Box<dyn Error>> {
    let noise = thermometer.noise(environment)?;
    let (problem, nominal, blocks) = thermometer.problem(noise)?;
    let Fit { problem, estimate } = likeliest_fit(&problem, &nominal, blocks[0], environment)?;
    let known = Known::at::<Box<dyn Error>>(&problem, &estimate)?;
    let asked = blocks.iter().zip(PARAMETERS).map(|(block, (name, .., limit))| {
        let value = estimate.values.scalar(*block);
        Parameter { id: name, block: *block, limit, unit: value.abs() }
    });
    let asked: Vec<Parameter<&str>> = asked.collect();
    let (values, analysis, reference) = (&estimate.values, &known.analysis, problem.reference());
    let limits = limits_of_use(&problem, &asked);
    let profiled =
        Profiled { problem: &problem, values, analysis, reference, matters: share_that_matters(false), starts: &[] };
    let mut widened = vec![1.0; problem.columns().len()];
    for (column, std) in profiled.wider(&limits, environment)? {
        widened[column] = std / analysis.covariance().std(column);
    }
    let uncertainty = known.uncertainty.widened(&widened);
    let judgement = judge(&problem, analysis, uncertainty.covariance(), &asked);

    let reported = |(parameter, (name, unit, ..)): (&Parameter<&str>, (&'static str, &'static str, f64, f64))| {
        let std = uncertainty.covariance().std(problem.columns_of(parameter.block).start);
        Reported {
            name,
            unit,
            value: judgement.determines(parameter.id).then(|| (values.scalar(parameter.block), std)),
        }
    };
    let parameters = asked.iter().zip(PARAMETERS).map(reported).collect();
    Ok(Answer { parameters, open: judgement.combinations.clone(), noise })
}

/// From the data sheet, or from another material where that is likelier.
fn likeliest_fit(
    problem: &Problem,
    nominal: &Values,
    material: BlockId,
    environment: &SolveEnvironment<'_>,
) -> Result<Fit, Box<dyn Error>> {
    let follow = |start: Values, environment: &SolveEnvironment<'_>| -> Result<End<Fit, Values>, SolveError> {
        let fit = fit(problem, &start, BATHS.len(), environment)?;
        let Estimate { cost, termination, values, .. } = &fit.estimate;
        let place = Place { minus_log_likelihood: *cost, values: values.clone(), start: values.clone() };
        Ok(End { place, termination: *termination, solution: fit })
    };
    let other = |value: f64| {
        let mut start = nominal.clone();
        start.set(material, &[value]);
        start
    };
    let mut likeliest = Likeliest::first(follow(nominal.clone(), environment)?);
    let is_another = |best: &Fit, place: &Place<Values>| {
        let [here, there] = [&best.estimate.values, &place.values].map(|values| values.scalar(material));
        (here - there).abs() > SAME_B * here.abs()
    };
    likeliest.or_from(OTHER_B.map(other).to_vec(), follow, is_another, environment);
    Ok(likeliest.best.solution)
}

fn print(answer: &Answer) {
    println!("noise {:.2} mV", 1e3 * answer.noise);
    for Reported { name, unit, value } in &answer.parameters {
        match value {
            Some((value, std)) => println!("{name:<4} {value:>9.3} ± {std:.3} {unit}"),
            None => println!("{name:<4} not determined"),
        }
    }
    for Combination { parameters, .. } in &answer.open {
        let words: Vec<String> = parameters.iter().map(|(name, share)| format!("{share:+.2} {name}")).collect();
        println!("the readings do not tell {}, as shares of their values: measure one of them", words.join(" "));
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let solver = SolverName::LevenbergMarquardt.build();
    let environment = SolveEnvironment::new(solver.as_ref(), &|_| {});
    for series in [None, Some((9.95, 0.02))] {
        print(&calibrate(&Thermometer { series }, &environment)?);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: [f64; 4] = [3950.0, 4.987, 10.3, 9.95];

    fn answered(series: Option<(f64, f64)>) -> Answer {
        let solver = SolverName::LevenbergMarquardt.build();
        calibrate(&Thermometer { series }, &SolveEnvironment::new(solver.as_ref(), &|_| {})).unwrap()
    }

    /// Those that are told lie within four standard deviations.
    fn reported(answer: &Answer) -> Vec<&'static str> {
        let reported = answer.parameters.iter().zip(TRUTH).filter_map(|(Reported { name, value, .. }, truth)| {
            let (value, std) = (*value)?;
            assert!((value - truth).abs() < 4.0 * std, "{name}: {value} ± {std}");
            Some(*name)
        });
        reported.collect()
    }

    #[test]
    fn without_a_measured_resistor_only_the_ratio_of_both_is_known() {
        let answer = answered(None);
        assert_eq!(reported(&answer), ["B", "V"]);
        let [Combination { parameters, std_over_limit: None }] = &answer.open[..] else { panic!("{:?}", answer.open) };
        let [("R_0", a), ("R_s", b)] = parameters[..] else { panic!("{parameters:?}") };
        assert!((a / b - 1.0).abs() < 1e-6, "both by the same share: {a} {b}");
        assert!((2.5e-4..1e-3).contains(&answer.noise), "{}", answer.noise);
    }

    #[test]
    fn with_it_all_are() {
        let answer = answered(Some((9.95, 0.02)));
        assert_eq!(reported(&answer), ["B", "V", "R_0", "R_s"]);
        assert!(answer.open.is_empty());
        // R_0 is known as well, in shares, as the resistor is.
        let share = |index: usize| answer.parameters[index].value.map(|(value, std)| std / value).unwrap();
        assert!((share(2) / share(3) - 1.0).abs() < 0.2, "{} {}", share(2), share(3));
    }
}
