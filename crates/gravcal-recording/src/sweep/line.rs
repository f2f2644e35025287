//! The straight line through successive points, in memory that does not grow with them.
//!
//! ```text
//!     y(x) = ȳ + s (x − x̄),   s = Sxy / Sxx,   variance of y(x): σ² (1/n + (x − x̄)² / Sxx)
//! ```

/// Sums over points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Line {
    pub count: f64,
    x: f64,
    pub y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
    /// The last point, and sums of the products of steps from point to point.
    last: Option<(f64, f64)>,
    steps: [f64; 3],
}

impl Line {
    pub fn take(&mut self, x: f64, y: f64) {
        if let Some((x_before, y_before)) = self.last.replace((x, y)) {
            let (dx, dy) = (x - x_before, y - y_before);
            self.steps = [self.steps[0] + dx * dx, self.steps[1] + dx * dy, self.steps[2] + dy * dy];
        }
        self.count += 1.0;
        let (dx, dy) = (x - self.x, y - self.y);
        self.x += dx / self.count;
        self.y += dy / self.count;
        self.xx += dx * (x - self.x);
        self.xy += dx * (y - self.y);
        self.yy += dy * (y - self.y);
    }

    pub fn slope(&self) -> f64 {
        if self.xx > 0.0 { self.xy / self.xx } else { 0.0 }
    }

    /// Where the line is at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.y + self.slope() * (x - self.x)
    }

    /// By how much the line exceeds a parabola with the second derivative 2 at `x`, but for the third moment of the points' places.
    pub fn above_parabola(&self, x: f64) -> f64 {
        self.xx / self.count - (x - self.x).powi(2)
    }

    /// Its variance there, in units of that of a point.
    pub fn leverage(&self, x: f64) -> f64 {
        1.0 / self.count + if self.xx > 0.0 { (x - self.x).powi(2) / self.xx } else { 0.0 }
    }

    /// Sum of squared distances of the points from the line, and degrees of freedom.
    pub fn squares(&self) -> (f64, f64) {
        ((self.yy - self.slope() * self.xy).max(0.0), self.count - 2.0)
    }

    /// Sum of squared steps of these distances from point to point, and how many steps there are.
    pub fn stepped(&self) -> (f64, f64) {
        let ([xx, xy, yy], slope) = (self.steps, self.slope());
        ((yy - 2.0 * slope * xy + slope * slope * xx).max(0.0), self.count - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_least_squares() {
        let mut line = Line::default();
        // About 2 + 3 x with distances 1, −1, −1, 1, which are orthogonal to 1 and x.
        [(0.0, 3.0), (1.0, 4.0), (2.0, 7.0), (3.0, 12.0)].iter().for_each(|(x, y)| line.take(*x, *y));
        assert!((line.slope() - 3.0).abs() < 1e-12 && (line.at(10.0) - 32.0).abs() < 1e-12);
        let (squares, degrees) = line.squares();
        assert!((squares - 4.0).abs() < 1e-12 && degrees == 2.0);
        assert!((line.above_parabola(1.5) - 1.25).abs() < 1e-12 && (line.above_parabola(2.5) - 0.25).abs() < 1e-12);
        assert!((line.leverage(1.5) - 0.25).abs() < 1e-12 && (line.leverage(4.0) - 0.25 - 1.25).abs() < 1e-12);
        // Steps of −2, 0, 2.
        let (stepped, steps) = line.stepped();
        assert!((stepped - 8.0).abs() < 1e-12 && steps == 3.0);
    }

    #[test]
    fn points_at_one_place_have_a_mean() {
        let mut line = Line::default();
        [1.0, 2.0, 3.0].iter().for_each(|y| line.take(7.0, *y));
        assert_eq!((line.at(9.0), line.slope()), (2.0, 0.0));
    }
}
