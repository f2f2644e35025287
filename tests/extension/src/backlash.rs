//! A position sensor before a gear with play: the joint lags behind by half of the play, on the side from which it was driven; derivatives
//! by dual numbers.
//!
//! ```text
//!     θ = s q + o − p/2 d        d: the direction from which the joint came, 1 or −1
//! ```

use gravcal::calibration::parameter::Limit;
use gravcal::calibration::sensors::{
    Declared, Differentiated, Moment, Need, Options, ParameterSpec, Reads, RefusedOption, SensorFormula, SensorModel,
    Side, Site,
};
use gravcal::estimation::Number;

/// `kind = "backlash"`.
#[derive(Debug)]
pub struct Backlash;

#[derive(Debug)]
struct Play {
    joint: usize,
}

impl SensorFormula for Play {
    fn reads(&self) -> Reads {
        Reads::positions().condition(Need::Direction)
    }

    fn value<N: Number>(&self, at: &Moment<'_, N>, x: &[N]) -> N {
        -x[0] * 0.5 * at.direction(self.joint)
    }
}

impl SensorModel for Backlash {
    fn name(&self) -> &str {
        "backlash"
    }

    fn help(&self) -> &str {
        "the joint lags behind its position sensor by half of the gear's play"
    }

    fn side(&self) -> Side {
        Side::Position
    }

    fn declare(&self, site: &Site<'_>, _options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let play = ParameterSpec::new("play", site.coordinate(), Limit::Absolute(0.01))
            .in_equation("coordinate = ... - play / 2 * direction of approach")
            .cured_by("record poses that the joint comes to from the other side, too");
        Ok(vec![Declared::new([play], Differentiated::new(Play { joint: site.joint() }))])
    }
}
