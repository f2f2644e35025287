//! An instrument: a level on a link reads how far one of its axes is inclined; it sees gravity.
//!
//! ```text
//!     reading = asin(−u·v/|v|) + zero        v: gravity in the link's frame, u: the axis
//! ```

use gravcal::calibration::parameter::Limit;
use gravcal::calibration::residual_models::{
    DeclaredResidual, DifferentiatedResidual, ResidualFormula, ResidualModel, Scene, Sees, Setting, Tie,
};
use gravcal::calibration::sensors::{Options, ParameterSpec, RefusedOption};
use gravcal::calibration::session::Pose;
use gravcal::estimation::Number;

/// `kind = "inclinometer"`; `link`: what it is fastened to; `axis`: which way it points there; `std_rad`: how well it reads.
#[derive(Debug)]
pub struct Inclinometer;

#[derive(Debug)]
struct Inclination {
    link: usize,
    joints: Vec<usize>,
    axis: [f64; 3],
    std: f64,
    column: usize,
}

impl ResidualFormula for Inclination {
    fn sees(&self) -> Sees {
        Sees::nothing().gravity().coordinates(&self.joints)
    }

    fn ties(&self, poses: &[Pose]) -> Vec<Tie> {
        Tie::in_each(poses, self.column, self.std)
    }

    fn value<N: Number>(&self, _tie: &Tie, at: &[Scene<'_, N>], x: &[N]) -> N {
        let [a, b, c] = at[0].gravity_on(self.link);
        let [u, v, w] = self.axis;
        let down = (a * u + b * v + c * w) / (a * a + b * b + c * c).sqrt();
        (-down).asin() + x[0] - at[0].column(self.column)
    }
}

impl ResidualModel for Inclinometer {
    fn name(&self) -> &str {
        "inclinometer"
    }

    fn help(&self) -> &str {
        "a level on a link reads how far an axis of it is inclined"
    }

    fn options(&self) -> &[&str] {
        &["link", "axis", "std_rad"]
    }

    fn columns(&self) -> Vec<&str> {
        vec!["reading"]
    }

    fn declare(&self, setting: &Setting<'_>, options: &Options) -> Result<DeclaredResidual, RefusedOption> {
        let link = setting.link(options, "link")?;
        let zero = ParameterSpec::new("zero", "rad", Limit::Absolute(0.01))
            .in_equation("reading = inclination of the axis + zero")
            .cured_by("read the level in more poses that incline the link");
        let inclination = Inclination {
            link,
            joints: setting.joints_moving(link),
            axis: setting.vector(options, "axis")?.unwrap_or([1.0, 0.0, 0.0]),
            std: setting.positive(options, "std_rad", "how well is the level read?")?,
            column: setting.column("reading"),
        };
        Ok(DeclaredResidual::new([zero], DifferentiatedResidual(inclination)))
    }
}
