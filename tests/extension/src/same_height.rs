//! A contact: a point of a link stands on gauge blocks on one level table; derivatives by hand.
//!
//! ```text
//!     0 = (z(θ_1) − h_1) − (z(θ_2) − h_2),    ∂z/∂θ_j = e_zᵀ (∂R/∂θ_j p + ∂t/∂θ_j)
//! ```
//!
//! with the height `h` of the blocks of a pose. Each pose is tied to the one before that touched. Unknowns of its own it has none.

use gravcal::calibration::residual_models::{
    DeclaredResidual, ResidualModel, ResidualTerm, Scene, Sees, Setting, Slopes, Tie,
};
use gravcal::calibration::sensors::{Options, RefusedOption};
use gravcal::calibration::session::Pose;

/// `kind = "same-height"`; `link` and `point_m`: what touches; `std_m`: how flat the table is. The column `block` has the height of the
/// blocks, m, in poses that touch.
#[derive(Debug)]
pub struct SameHeight;

#[derive(Debug)]
struct Contact {
    link: usize,
    joints: Vec<usize>,
    point: [f64; 3],
    std: f64,
    column: usize,
}

impl Contact {
    /// The height of the point, and how it changes with the coordinate of each joint.
    fn height(&self, at: &Scene<'_>) -> (f64, Vec<f64>) {
        let frame = at.link_frame(self.link);
        let turned = |row: &[f64; 3]| row.iter().zip(&self.point).map(|(entry, p)| entry * p).sum::<f64>();
        let slopes = frame.by_coordinate.iter().map(|(rotation, origin)| turned(&rotation[2]) + origin[2]);
        (turned(&frame.rotation[2]) + frame.origin[2], slopes.collect())
    }
}

impl ResidualTerm for Contact {
    fn sees(&self) -> Sees {
        Sees::nothing().coordinates(&self.joints)
    }

    fn ties(&self, poses: &[Pose]) -> Vec<Tie> {
        let touching: Vec<usize> = Tie::in_each(poses, self.column, self.std).iter().map(|tie| tie.poses[0]).collect();
        touching.windows(2).map(|pair| Tie::new(pair, self.std)).collect()
    }

    fn value(&self, _tie: &Tie, at: &[Scene<'_>], _x: &[f64], slopes: Option<Slopes<'_>>) -> f64 {
        let [(first, by_first), (second, by_second)] = [self.height(&at[0]), self.height(&at[1])];
        if let Some(slopes) = slopes {
            let both = by_first.into_iter().chain(by_second.into_iter().map(|slope| -slope));
            slopes.by_coordinate.iter_mut().zip(both).for_each(|(slope, own)| *slope = own);
        }
        (first - at[0].column(self.column)) - (second - at[1].column(self.column))
    }
}

impl ResidualModel for SameHeight {
    fn name(&self) -> &str {
        "same-height"
    }

    fn help(&self) -> &str {
        "a point of a link stands on gauge blocks on one level table"
    }

    fn options(&self) -> &[&str] {
        &["link", "point_m", "std_m"]
    }

    fn columns(&self) -> Vec<&str> {
        vec!["block"]
    }

    fn declare(&self, setting: &Setting<'_>, options: &Options) -> Result<DeclaredResidual, RefusedOption> {
        let link = setting.link(options, "link")?;
        let contact = Contact {
            link,
            joints: setting.joints_moving(link),
            point: setting.vector(options, "point_m")?.unwrap_or_default(),
            std: setting.positive(options, "std_m", "how flat is the table?")?,
            column: setting.column("block"),
        };
        Ok(DeclaredResidual::new([], contact))
    }
}

#[cfg(test)]
mod tests {
    use gravcal::calibration::residual_models::check_residual_derivatives;
    use gravcal::dynamics::{DhConvention, DhRow, JointKind, Link, chain_from_dh};
    use gravcal::recording::Conditions;

    use super::*;

    #[test]
    fn derivatives() {
        let row = |name: &str, alpha| DhRow {
            name: name.into(),
            kind: JointKind::Revolute,
            a: 0.3,
            alpha,
            d: 0.1,
            theta: 0.0,
            limits: None,
            link: Link { name: format!("{name}-link"), inertia: None },
        };
        let rows = [row("one", 1.2), row("two", -0.7), row("three", 0.4)];
        let chain = chain_from_dh("base", DhConvention::Standard, &rows).unwrap();
        let contact = Contact { link: 1, joints: vec![0, 1], point: [0.1, 0.2, 0.3], std: 1.0, column: 0 };
        let conditions = Conditions { further: vec![0.05], ..Conditions::default() };
        let tie = Tie::new([0, 1], 1.0);
        let scene = |coordinates| Scene::new(&chain, (coordinates, &[0.0; 3]), [0.0; 3], &conditions);
        let at = [scene(&[0.3, -0.4, 0.0]), scene(&[-1.0, 0.8, 0.0])];
        check_residual_derivatives(&contact, (&tie, &at), &[], 1e-6).unwrap();
    }
}
