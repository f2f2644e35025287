//! From a standard deviation to an interval that holds the truth with 95 % probability.
//!
//! ```text
//!     interval   estimate ± q σ             q: 0.975-quantile of the normal distribution, or of Student's t with ν
//!                                           degrees of freedom where σ itself was estimated
//!     cone       radius  √(2 F) σ           F: 0.95-quantile of F(2, ν), in closed form ν/2 (0.05^(−2/ν) − 1);
//!                                           −ln 0.05 for ν → ∞
//! ```
//!
//! The cone is for two coordinates at once, of which σ is the larger standard deviation.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Probability with which an interval holds the truth.
const PROBABILITY: f64 = 0.95;

/// Beyond this many degrees of freedom the t quantile is taken from its expansion about the normal one (Abramowitz and
/// Stegun, eq. 26.7.5, first term: exact to 3e-8), because the library's loses digits.
const MANY: f64 = 1e4;

/// How a standard deviation becomes an interval of 95 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantile {
    /// Half-width of an interval, in standard deviations.
    interval: f64,
    /// Radius of a cone, in standard deviations.
    cone: f64,
}

impl Quantile {
    /// For a standard deviation that is known.
    pub fn normal() -> Quantile {
        let quantile = Normal::standard().inverse_cdf(0.5 + 0.5 * PROBABILITY);
        Quantile { interval: quantile, cone: (-2.0 * (1.0 - PROBABILITY).ln()).sqrt() }
    }

    /// For a standard deviation that was estimated with so many degrees of freedom; infinite where there are none.
    pub fn student(degrees_of_freedom: f64) -> Quantile {
        let normal = Quantile::normal();
        if degrees_of_freedom == f64::INFINITY {
            return normal;
        }
        let Ok(student) = StudentsT::new(0.0, 1.0, degrees_of_freedom) else {
            return Quantile { interval: f64::INFINITY, cone: f64::INFINITY };
        };
        let interval = if degrees_of_freedom < MANY {
            student.inverse_cdf(0.5 + 0.5 * PROBABILITY)
        } else {
            normal.interval + (normal.interval.powi(3) + normal.interval) / (4.0 * degrees_of_freedom)
        };
        let exponent = -2.0 * (1.0 - PROBABILITY).ln() / degrees_of_freedom;
        Quantile { interval, cone: (degrees_of_freedom * exponent.exp_m1()).sqrt() }
    }

    /// For standard deviations that are told so many times larger: intervals and cones stay.
    pub(super) fn for_deviations_larger_by(self, factor: f64) -> Quantile {
        Quantile { interval: self.interval / factor, cone: self.cone / factor }
    }

    /// 95 % interval of a number.
    pub fn interval(self, value: f64, std: f64) -> [f64; 2] {
        [value - self.interval * std, value + self.interval * std]
    }

    /// Radius of the disc that holds two coordinates with 95 % probability, `std` the larger standard deviation.
    pub fn cone(self, std: f64) -> f64 {
        self.cone * std
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables of the t and F distributions.
    #[test]
    fn quantiles_are_those_of_the_tables() {
        let half_width = |q: Quantile| q.interval(0.0, 1.0)[1];
        assert!((half_width(Quantile::normal()) - 1.959_963_985).abs() < 1e-8);
        for (freedom, expected) in [(1.0, 12.706_204_74), (5.0, 2.570_581_836), (30.0, 2.042_272_456)] {
            assert!((half_width(Quantile::student(freedom)) - expected).abs() < 1e-6, "{freedom}");
        }
        assert!((Quantile::student(10.0).cone(1.0).powi(2) / 2.0 - 4.102_821).abs() < 1e-5);
        assert!((half_width(Quantile::student(MANY)) - half_width(Quantile::student(MANY - 1e-6))).abs() < 1e-7);
        for many in [1e9, f64::INFINITY] {
            let (limit, student) = (Quantile::normal(), Quantile::student(many));
            assert!((student.cone - limit.cone).abs() < 1e-6 && (student.interval - limit.interval).abs() < 1e-6);
        }
    }

    #[test]
    fn without_freedom_nothing_is_known() {
        assert_eq!(Quantile::student(0.0).interval(1.0, 0.1), [f64::NEG_INFINITY, f64::INFINITY]);
    }
}
