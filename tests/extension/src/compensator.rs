//! An unknown that sensors and a residual share: the force of one spring, whose ropes carry part of several joints' gravity.
//!
//! ```text
//!     reading of torque = k τ + b + k₀ l F cos θ        k₀: the nominal gain, l: the rope's lever
//!     reading of the rope's force gauge = F cos θ
//! ```

use gravcal::calibration::parameter::Limit;
use gravcal::calibration::residual_models::{
    DeclaredResidual, DifferentiatedResidual, ResidualFormula, ResidualModel, Scene, Sees, Setting, Tie,
};
use gravcal::calibration::sensors::{
    Declared, Differentiated, Moment, Options, ParameterSpec, Reads, RefusedOption, SensorFormula, SensorModel, Site,
};
use gravcal::calibration::session::Pose;
use gravcal::estimation::Number;

/// `kind = "gravity-compensator"` of a joint's sensors; `lever_m`: l.
#[derive(Debug)]
pub struct Compensator;

/// `kind = "force-gauge"` of `[[residual]]`; `joint`: whose rope it is in; `std_n`: how well it reads.
#[derive(Debug)]
pub struct ForceGauge;

/// F, of all that have a part in it.
fn force() -> ParameterSpec {
    ParameterSpec::new("force", "N", Limit::Absolute(2.0))
        .starting_at(20.0)
        .in_equation("reading = ... + nominal torque_gain * lever * force * cos(coordinate)")
        .cured_by("add poses that turn the joints that the ropes pull further")
        .shared("compensator")
}

#[derive(Debug)]
struct Pull {
    joint: usize,
    factor: f64,
}

impl SensorFormula for Pull {
    fn reads(&self) -> Reads {
        Reads::positions().coordinate(self.joint)
    }

    fn value<N: Number>(&self, at: &Moment<'_, N>, x: &[N]) -> N {
        x[0] * at.coordinate(self.joint).cos() * self.factor
    }
}

impl SensorModel for Compensator {
    fn name(&self) -> &str {
        "gravity-compensator"
    }

    fn help(&self) -> &str {
        "a rope of the arm's one spring carries a part of the joint's torque"
    }

    fn options(&self) -> &[&str] {
        &["lever_m"]
    }

    fn declare(&self, site: &Site<'_>, options: &Options) -> Result<Vec<Declared>, RefusedOption> {
        let lever = options.number("lever_m")?.filter(|lever| *lever > 0.0);
        let lever =
            lever.ok_or_else(|| RefusedOption::new("lever_m", "how far from the axis is the rope? add lever_m"))?;
        let pull = Pull { joint: site.joint(), factor: site.torque_gain() * lever };
        Ok(vec![Declared::new([force()], Differentiated::new(pull))])
    }
}

#[derive(Debug)]
struct Rope {
    joint: usize,
    std: f64,
    column: usize,
}

impl ResidualFormula for Rope {
    fn sees(&self) -> Sees {
        Sees::nothing().coordinates(&[self.joint])
    }

    fn ties(&self, poses: &[Pose]) -> Vec<Tie> {
        Tie::in_each(poses, self.column, self.std)
    }

    fn value<N: Number>(&self, _tie: &Tie, at: &[Scene<'_, N>], x: &[N]) -> N {
        x[0] * at[0].coordinate(self.joint).cos() - at[0].column(self.column)
    }
}

impl ResidualModel for ForceGauge {
    fn name(&self) -> &str {
        "force-gauge"
    }

    fn help(&self) -> &str {
        "a gauge in a rope of the arm's one spring reads its force"
    }

    fn options(&self) -> &[&str] {
        &["joint", "std_n"]
    }

    fn columns(&self) -> Vec<&str> {
        vec!["force"]
    }

    fn declare(&self, setting: &Setting<'_>, options: &Options) -> Result<DeclaredResidual, RefusedOption> {
        let rope = Rope {
            joint: setting.joint(options, "joint")?,
            std: setting.positive(options, "std_n", "how well is the force read?")?,
            column: setting.column("force"),
        };
        Ok(DeclaredResidual::new([force()], DifferentiatedResidual(rope)))
    }
}
