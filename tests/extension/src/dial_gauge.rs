//! An instrument: a gauge that stands on the ground reads how high a point of a link is; derivatives by dual numbers.
//!
//! ```text
//!     reading = height of the point + zero
//! ```

use gravcal::calibration::parameter::Limit;
use gravcal::calibration::residual_models::{
    DeclaredResidual, DifferentiatedResidual, ResidualFormula, ResidualModel, Scene, Sees, Setting, Tie,
};
use gravcal::calibration::sensors::{Options, ParameterSpec, RefusedOption};
use gravcal::calibration::session::Pose;
use gravcal::estimation::Number;

/// `kind = "dial-gauge"`; `link` and `point_m`: what it touches; `std_m`: how well it reads.
#[derive(Debug)]
pub struct DialGauge;

#[derive(Debug)]
struct Height {
    link: usize,
    joints: Vec<usize>,
    point: [f64; 3],
    std: f64,
    column: usize,
}

impl ResidualFormula for Height {
    fn sees(&self) -> Sees {
        Sees::nothing().coordinates(&self.joints)
    }

    fn ties(&self, poses: &[Pose]) -> Vec<Tie> {
        Tie::in_each(poses, self.column, self.std)
    }

    fn value<N: Number>(&self, _tie: &Tie, at: &[Scene<'_, N>], x: &[N]) -> N {
        let [_, _, height] = at[0].frame(self.link).point(self.point.map(N::from));
        height + x[0] - at[0].column(self.column)
    }
}

impl ResidualModel for DialGauge {
    fn name(&self) -> &str {
        "dial-gauge"
    }

    fn help(&self) -> &str {
        "a gauge on the ground reads how high a point of a link is"
    }

    fn options(&self) -> &[&str] {
        &["link", "point_m", "std_m"]
    }

    fn columns(&self) -> Vec<&str> {
        vec!["reading"]
    }

    fn declare(&self, setting: &Setting<'_>, options: &Options) -> Result<DeclaredResidual, RefusedOption> {
        let link = setting.link(options, "link")?;
        let zero = ParameterSpec::new("zero", "m", Limit::Absolute(0.001))
            .in_equation("reading = height of the point + zero")
            .cured_by("read the gauge in more poses");
        let height = Height {
            link,
            joints: setting.joints_moving(link),
            point: setting.vector(options, "point_m")?.unwrap_or_default(),
            std: setting.positive(options, "std_m", "how well is the gauge read?")?,
            column: setting.column("reading"),
        };
        Ok(DeclaredResidual::new([zero], DifferentiatedResidual(height)))
    }
}
