//! Panels of curves with error bars, as SVG.

use plotters::coord::Shift;
use plotters::prelude::*;
use thiserror::Error;

use gravcal_robot_model::number::shortest;

/// A figure cannot be drawn.
#[derive(Debug, Error)]
#[error("a figure cannot be drawn: {0}")]
pub struct FigureError(String);

/// A figure of several panels that have the same curves.
pub(super) struct Figure {
    pub title: String,
    pub panels: Vec<Panel>,
}

/// One diagram.
pub(super) struct Panel {
    pub title: String,
    pub horizontal: Horizontal,
    pub vertical: Scale,
    /// A line across, where the curves should be.
    pub reference: Option<f64>,
    pub curves: Vec<Curve>,
}

/// What runs along a panel.
pub(super) enum Horizontal {
    /// Dots stand at these numbers.
    Numbers(Vec<f64>),
    /// Dots stand at the places of these names.
    Names(Vec<String>),
}

/// How a panel's height is divided.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Scale {
    Plain,
    Decades,
}

/// What is said of one estimator.
pub(super) struct Curve {
    pub name: String,
    pub dots: Vec<Dot>,
    /// Whether a line joins the dots.
    pub joined: bool,
}

/// A number with its standard error.
pub(super) struct Dot {
    pub x: f64,
    pub y: f64,
    pub error: f64,
}

/// Of one panel of several, and of a single one, without what stands below it; pixels.
const SMALL: (u32, u32) = (300, 184);
const LARGE: (u32, u32) = (900, 380);
/// Room for numbers below a panel, and for each letter of names that stand on their side; pixels.
const NUMBERS: u32 = 26;
const LETTER: u32 = 7;
/// Panels beside each other.
const ACROSS: usize = 4;
/// Where the legend begins, and the height of its lines, pixels.
const LEGEND_TOP: i32 = 36;
const LEGEND_LINE: i32 = 24;
/// Okabe and Ito's colours, which everyone can tell apart, and grey.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x00, 0x00, 0x00),
    RGBColor(0x99, 0x99, 0x99),
];
/// Half-width of a 95 % interval in standard errors.
const NORMAL_95: f64 = 1.96;
/// Numbers that differ by more than this factor stand on a scale of decades.
const WIDE: f64 = 8.0;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn colour(curve: usize) -> RGBColor {
    COLOURS[curve % COLOURS.len()]
}

fn failed(error: impl std::fmt::Display) -> FigureError {
    FigureError(error.to_string())
}

impl Figure {
    /// Draws it.
    pub fn svg(&self) -> Result<String, FigureError> {
        let across = self.panels.len().clamp(1, ACROSS);
        let down = self.panels.len().div_ceil(across).max(1);
        let (width, height) = if self.panels.len() == 1 { LARGE } else { SMALL };
        let height = height + self.panels.first().map_or(NUMBERS, Panel::below);
        let width = width * across as u32;
        let legend = self.legend(width as i32);
        let head = legend.last().map_or(LEGEND_TOP, |(_, (_, top))| *top) as u32 + LEGEND_LINE as u32;
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, (width, height * down as u32 + head)).into_drawing_area();
            area.fill(&WHITE).map_err(failed)?;
            let text = |size: i32| ("sans-serif", size).into_font();
            area.draw(&Text::new(self.title.clone(), (10, 8), text(18))).map_err(failed)?;
            for (index, (name, (left, top))) in legend.into_iter().enumerate() {
                area.draw(&Circle::new((left, top + 7), 4, colour(index).filled())).map_err(failed)?;
                area.draw(&Text::new(name, (left + 10, top), text(14))).map_err(failed)?;
            }
            let (_, body) = area.split_vertically(head);
            for (panel, area) in self.panels.iter().zip(body.split_evenly((down, across))) {
                panel.draw(&area)?;
            }
            area.present().map_err(failed)?;
        }
        Ok(svg)
    }

    /// The names of the curves, each with its place.
    fn legend(&self, width: i32) -> Vec<(String, (i32, i32))> {
        let mut legend: Vec<(String, (i32, i32))> = Vec::new();
        let (mut left, mut top) = (16, LEGEND_TOP);
        for curve in self.panels.iter().flat_map(|panel| &panel.curves) {
            if legend.iter().any(|(name, _)| *name == curve.name) {
                continue;
            }
            let needed = 40 + 8 * curve.name.chars().count() as i32;
            if left > 16 && left + needed > width {
                (left, top) = (16, top + LEGEND_LINE);
            }
            legend.push((curve.name.clone(), (left, top)));
            left += needed;
        }
        legend
    }
}

/// From a number to its place along a scale, and back.
impl Scale {
    fn place(self, number: f64) -> f64 {
        match self {
            Scale::Plain => number,
            Scale::Decades => number.log10(),
        }
    }

    fn number(self, place: f64) -> f64 {
        match self {
            Scale::Plain => place,
            Scale::Decades => 10f64.powf(place),
        }
    }

    /// For numbers along a panel.
    fn of(numbers: &[f64]) -> Scale {
        let least = numbers.iter().copied().fold(f64::INFINITY, f64::min);
        let most = numbers.iter().copied().fold(0.0, f64::max);
        if least > 0.0 && most / least > WIDE { Scale::Decades } else { Scale::Plain }
    }
}

/// The range of places, with some room on both sides.
fn range(places: impl Iterator<Item = f64>, room: f64) -> std::ops::Range<f64> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for place in places.filter(|place| place.is_finite()) {
        (low, high) = (low.min(place), high.max(place));
    }
    if low > high {
        return 0.0..1.0;
    }
    let room = if high > low { room * (high - low) } else { 0.5 * room.max(low.abs() * room) };
    low - room..high + room
}

impl Panel {
    /// Room for what stands below it, pixels.
    fn below(&self) -> u32 {
        match &self.horizontal {
            Horizontal::Numbers(_) => NUMBERS,
            Horizontal::Names(names) => {
                let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
                12 + LETTER * longest as u32
            }
        }
    }

    fn draw(&self, area: &Area<'_>) -> Result<(), FigureError> {
        let across = match &self.horizontal {
            Horizontal::Numbers(numbers) => Scale::of(numbers),
            Horizontal::Names(_) => Scale::Plain,
        };
        let x = match &self.horizontal {
            Horizontal::Numbers(numbers) => range(numbers.iter().map(|number| across.place(*number)), 0.06),
            Horizontal::Names(names) => -0.6..names.len() as f64 - 0.4,
        };
        let ends = |dot: &Dot| [-NORMAL_95, NORMAL_95].map(|factor| self.vertical.place(dot.y + factor * dot.error));
        let dots = self.curves.iter().flat_map(|curve| curve.dots.iter().flat_map(ends));
        let y = range(dots.chain(self.reference.map(|y| self.vertical.place(y))), 0.1);
        let names = matches!(&self.horizontal, Horizontal::Names(_));
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 14))
            .margin(8)
            .x_label_area_size(self.below())
            .y_label_area_size(56)
            .build_cartesian_2d(x.clone(), y)
            .map_err(failed)?;
        let label_x = |place: &f64| match &self.horizontal {
            Horizontal::Numbers(_) => shown(across.number(*place)),
            Horizontal::Names(_) => String::new(),
        };
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(TRANSPARENT).label_style(("sans-serif", 11));
        mesh.x_labels(if names { 0 } else { 5 }).y_labels(5);
        mesh.x_label_formatter(&label_x);
        let label_y = |place: &f64| shown(self.vertical.number(*place));
        mesh.y_label_formatter(&label_y).draw().map_err(failed)?;
        if let Some(reference) = self.reference {
            let y = self.vertical.place(reference);
            let ends = [(x.start, y), (x.end, y)];
            chart.draw_series(LineSeries::new(ends, BLACK.mix(0.5))).map_err(failed)?;
        }
        let curves = self.curves.len();
        for (index, curve) in self.curves.iter().enumerate() {
            // Beside each other where they stand over a name.
            let aside = if names { 0.5 * (index as f64 + 0.5) / curves as f64 - 0.25 } else { 0.0 };
            let dots: Vec<(f64, &Dot)> = curve
                .dots
                .iter()
                .filter(|dot| self.vertical.place(dot.y).is_finite())
                .map(|dot| (across.place(dot.x) + aside, dot))
                .collect();
            let style = colour(index).stroke_width(2);
            if curve.joined {
                let line = dots.iter().map(|(x, dot)| (*x, self.vertical.place(dot.y)));
                chart.draw_series(LineSeries::new(line, style)).map_err(failed)?;
            }
            for (x, dot) in &dots {
                let [low, high] = ends(dot);
                if low.is_finite() && high.is_finite() {
                    chart.draw_series(LineSeries::new([(*x, low), (*x, high)], style)).map_err(failed)?;
                }
            }
            let marks = dots.iter().map(|(x, dot)| Circle::new((*x, self.vertical.place(dot.y)), 3, style.filled()));
            chart.draw_series(marks).map_err(failed)?;
        }
        if let Horizontal::Names(names) = &self.horizontal {
            write_names(area, names, &chart)?;
        }
        Ok(())
    }
}

type Chart<'a, 'b> = ChartContext<
    'a,
    SVGBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// Names stand on their side below their places.
fn write_names(area: &Area<'_>, names: &[String], chart: &Chart<'_, '_>) -> Result<(), FigureError> {
    let style = ("sans-serif", 12).into_font().transform(FontTransform::Rotate90);
    let bottom = chart.plotting_area().get_pixel_range().1.end;
    let (left, top) = area.get_base_pixel();
    for (place, name) in names.iter().enumerate() {
        let x = chart.backend_coord(&(place as f64, 0.0)).0;
        let at = (x - left + 5, bottom - top + 6);
        area.draw(&Text::new(name.clone(), at, style.clone())).map_err(failed)?;
    }
    Ok(())
}

fn shown(number: f64) -> String {
    match number {
        number if number != 0.0 && (number.abs() < 1e-3 || number.abs() >= 1e5) => {
            format!("{number:.1e}").replace(".0e", "e")
        }
        number => shortest(format!("{number:.2e}").parse().unwrap_or(number)),
    }
}
