//! Which figures a study has: for each axis the errors, their ratio to the last estimator's and the coverage; without an axis,
//! by quantity.

use gravcal_study::batch::Manifest;
use gravcal_study::measures::{Measure, QuantityMeasures, Series};

use super::StudyReport;
use super::figure::{Curve, Dot, Figure, Horizontal, Panel, Scale};

pub(super) fn figures(report: &StudyReport<'_>) -> Vec<(String, Figure)> {
    let axes = report.manifest.axes.len();
    if axes == 0 {
        return vec![
            (
                "error-over-bound".to_owned(),
                by_quantity(report, "rms error over the Cramér-Rao bound", Scale::Decades, |q| q.ratio, 1.0),
            ),
            (
                "coverage".to_owned(),
                by_quantity(report, "share of 95 % intervals that hold the truth", Scale::Plain, |q| q.coverage, 0.95),
            ),
        ];
    }
    let mut figures: Vec<(String, Figure)> = Vec::new();
    for (name, figure) in (0..axes).flat_map(|axis| along(report, axis)) {
        // Axes whose names differ in signs only.
        let name =
            if figures.iter().any(|(other, _)| *other == name) { format!("{name}-{}", figures.len()) } else { name };
        figures.push((name, figure));
    }
    figures
}

/// A curve for each estimator over all quantities.
fn by_quantity(
    report: &StudyReport<'_>,
    title: &str,
    vertical: Scale,
    of: impl Fn(&QuantityMeasures) -> Measure,
    reference: f64,
) -> Figure {
    let names = report.manifest.quantities.iter().map(|(name, _)| name.clone()).collect();
    let curves = report.at(0).map(|series| Curve {
        name: report.name(series),
        dots: series.quantities.iter().enumerate().map(|(place, quantity)| dot(place as f64, of(quantity))).collect(),
        joined: false,
    });
    let panel = Panel {
        title: String::new(),
        horizontal: Horizontal::Names(names),
        vertical,
        reference: Some(reference),
        curves: curves.collect(),
    };
    Figure { title: title.to_owned(), panels: vec![panel] }
}

fn dot(x: f64, measure: Measure) -> Dot {
    Dot { x, y: measure.value, error: if measure.error.is_finite() { measure.error } else { 0.0 } }
}

/// Figures over one axis: a curve for each value of the other axes, or where that is too much only for their first ones.
fn along(report: &StudyReport<'_>, axis: usize) -> Vec<(String, Figure)> {
    let manifest = report.manifest;
    let slug = slug(&manifest.axes[axis].name);
    let figure =
        |what: &str, vertical: Scale, reference: Option<f64>, of: &dyn Fn(&Series, usize) -> Option<Measure>| {
            let panels = manifest.quantities.iter().enumerate().map(|(quantity, (name, unit))| Panel {
                title: if vertical == Scale::Decades && reference.is_none() {
                    format!("{name}, {unit}")
                } else {
                    name.clone()
                },
                horizontal: horizontal(manifest, axis),
                vertical,
                reference,
                curves: curves(report, axis, &|series| of(series, quantity)),
            });
            Figure {
                title: format!("{what} over {}{}", described(manifest, axis), others(manifest, axis)),
                panels: panels.collect(),
            }
        };
    let rms = |series: &Series, quantity: usize| Some(series.quantities[quantity].rms);
    let coverage = |series: &Series, quantity: usize| Some(series.quantities[quantity].coverage);
    let over_last = |series: &Series, quantity: usize| {
        let last = report.reference(series.point).filter(|_| !report.is_reference(series))?;
        let (own, reference) = (series.quantities[quantity].rms, last.quantities[quantity].rms);
        let value = own.value / reference.value;
        let relative = (own.error / own.value).hypot(reference.error / reference.value);
        Some(Measure { value, error: value * relative })
    };
    let mut figures = vec![(format!("error-over-{slug}"), figure("rms error", Scale::Decades, None, &rms))];
    if let Some(last) = report.reference(0) {
        let title = format!("rms error over that of {}", report.name(last));
        figures.push((format!("ratio-over-{slug}"), figure(&title, Scale::Decades, Some(1.0), &over_last)));
    }
    let title = "share of 95 % intervals that hold the truth";
    figures.push((format!("coverage-over-{slug}"), figure(title, Scale::Plain, Some(0.95), &coverage)));
    figures
}

/// Whether there is a curve for each value of the other axes.
fn shows_all(manifest: &Manifest, axis: usize) -> bool {
    let of_each = manifest.estimators.len() * manifest.solvers.len();
    of_each * manifest.points.len() / manifest.axes[axis].labels.len() <= MOST_CURVES
}

/// Where the other axes are, if only one of their values is shown.
fn others(manifest: &Manifest, axis: usize) -> String {
    let others = manifest.axes.iter().enumerate().filter(|(other, _)| *other != axis && !shows_all(manifest, axis));
    let reported: Vec<String> = others.map(|(_, other)| format!("{} = {}", other.name, other.labels[0])).collect();
    if reported.is_empty() { String::new() } else { format!(" (at {} only)", reported.join(", ")) }
}

fn described(manifest: &Manifest, axis: usize) -> String {
    let axis = &manifest.axes[axis];
    axis.unit.as_ref().map_or_else(|| axis.name.clone(), |unit| format!("{}, {unit}", axis.name))
}

fn horizontal(manifest: &Manifest, axis: usize) -> Horizontal {
    match &manifest.axes[axis].numbers {
        Some(numbers) => Horizontal::Numbers(numbers.clone()),
        None => Horizontal::Names(manifest.axes[axis].labels.clone()),
    }
}

/// One curve for each estimator and solver.
fn curves(report: &StudyReport<'_>, axis: usize, of: &dyn Fn(&Series) -> Option<Measure>) -> Vec<Curve> {
    let manifest = report.manifest;
    let all = shows_all(manifest, axis);
    let others = |point: usize| {
        let places = manifest.points[point].iter().enumerate();
        places.filter(|(other, _)| *other != axis).map(|(other, place)| (other, *place)).collect::<Vec<_>>()
    };
    let on_axis = |point: usize| all || others(point).iter().all(|(_, place)| *place == 0);
    let named = |series: &Series| {
        let labels = others(series.point).into_iter().filter(|_| all);
        let labels = labels
            .map(|(other, place)| format!("{} {}", manifest.axes[other].name, manifest.axes[other].labels[place]));
        std::iter::once(report.name(series)).chain(labels).collect::<Vec<_>>().join(", ")
    };
    let mut curves: Vec<Curve> = Vec::new();
    for series in report.series.iter().filter(|series| on_axis(series.point)) {
        let Some(measure) = of(series) else { continue };
        let place = manifest.points[series.point][axis];
        let x = manifest.axes[axis].numbers.as_ref().map_or(place as f64, |numbers| numbers[place]);
        let name = named(series);
        let curve = match curves.iter().position(|curve| curve.name == name) {
            Some(found) => &mut curves[found],
            None => {
                curves.push(Curve { name, dots: Vec::new(), joined: manifest.axes[axis].numbers.is_some() });
                let last = curves.len() - 1;
                &mut curves[last]
            }
        };
        curve.dots.push(dot(x, measure));
    }
    curves
}

/// Curves of a panel that can still be told apart.
const MOST_CURVES: usize = 8;

/// A name as part of a file's.
fn slug(name: &str) -> String {
    let kept = name.chars().map(|c| if c.is_alphanumeric() { c.to_ascii_lowercase() } else { '-' });
    kept.collect::<String>().split('-').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
}
