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
    /// The first point, the last one, and sums of the products of steps from point to point.
    first: Option<(f64, f64)>,
    last: Option<(f64, f64)>,
    steps: [f64; 3],
}

impl Line {
    pub fn take(&mut self, x: f64, y: f64) {
        self.first.get_or_insert((x, y));
        if let Some(before) = self.last.replace((x, y)) {
            self.steps = sum(self.steps, products(before, (x, y)));
        }
        self.count += 1.0;
        let (dx, dy) = (x - self.x, y - self.y);
        self.x += dx / self.count;
        self.y += dy / self.count;
        self.xx += dx * (x - self.x);
        self.xy += dx * (y - self.y);
        self.yy += dy * (y - self.y);
    }

    /// The line through its points and those of `next`, which come after them; `next`'s places are told from `offset`.
    pub fn join(self, next: Line, offset: f64) -> Line {
        let moved = |point: Option<(f64, f64)>| point.map(|(x, y)| (x + offset, y));
        let (next_first, next_last) = (moved(next.first), moved(next.last));
        let count = self.count + next.count;
        if count == 0.0 {
            return self;
        }
        let share = next.count / count;
        let (dx, dy) = (next.x + offset - self.x, next.y - self.y);
        let weight = self.count * share;
        let between = self.last.zip(next_first).map_or([0.0; 3], |(before, after)| products(before, after));
        Line {
            count,
            x: self.x + share * dx,
            y: self.y + share * dy,
            xx: self.xx + next.xx + weight * dx * dx,
            xy: self.xy + next.xy + weight * dx * dy,
            yy: self.yy + next.yy + weight * dy * dy,
            first: self.first.or(next_first),
            last: next_last.or(self.last),
            steps: sum(sum(self.steps, next.steps), between),
        }
    }

    /// The mean of its points.
    pub fn middle(&self) -> (f64, f64) {
        (self.x, self.y)
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

/// Products of a step from one point to the next.
fn products(before: (f64, f64), after: (f64, f64)) -> [f64; 3] {
    let (dx, dy) = (after.0 - before.0, after.1 - before.1);
    [dx * dx, dx * dy, dy * dy]
}

fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
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

    #[test]
    fn lines_that_join_are_the_line_through_all_points() {
        let points = [(0.1, 3.0), (1.0, 4.5), (2.2, 7.0), (3.0, 12.0), (4.5, 11.0)];
        let through = |points: &[(f64, f64)], from: f64| {
            let mut line = Line::default();
            points.iter().for_each(|(x, y)| line.take(*x - from, *y));
            line
        };
        let all = through(&points, 0.0);
        for cut in 0..=points.len() {
            let joined = through(&points[..cut], 0.0).join(through(&points[cut..], 2.0), 2.0);
            let numbers = |line: &Line| {
                let ((squares, degrees), (stepped, steps)) = (line.squares(), line.stepped());
                [line.count, line.slope(), line.at(7.0), line.leverage(7.0), squares, degrees, stepped, steps]
            };
            for (one, other) in numbers(&joined).iter().zip(numbers(&all)) {
                assert!((one - other).abs() < 1e-9, "{joined:?} {all:?}");
            }
        }
    }
}
