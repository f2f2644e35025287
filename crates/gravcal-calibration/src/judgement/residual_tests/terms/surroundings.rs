//! What is around the arm, of all channels: gravity that is turned in another table, something that pulls, a base that gives way.

use gravcal_recording::file_name;
use gravcal_robot_model::number::significant;

use super::lacked::{Found, Lacked, Words};
use crate::judgement::residual_tests::columns::{Columns, MOST_RECORDINGS};
use crate::judgement::residual_tests::score::dot;
use crate::judgement::residual_tests::wording::shown;
use crate::result::{ResidualTest, ResidualTestKind};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surroundings {
    /// Two coefficients for each table but the first, rad about axes perpendicular to gravity.
    Gravity,
    /// At the last link, N along the axes of the base.
    Pull,
    /// Rad under the largest moment of the arm.
    BaseGivesWay,
}

impl Surroundings {
    /// Those that are looked for.
    pub fn of_arm(of: &Columns) -> Vec<Surroundings> {
        let gravity = (of.tables_of_all().len() > 1).then_some(Surroundings::Gravity);
        let pull = (!of.pulled.is_empty()).then_some(Surroundings::Pull);
        let base = (!of.leaning.is_empty()).then_some(Surroundings::BaseGivesWay);
        gravity.into_iter().chain(pull).chain(base).collect()
    }
}

impl Lacked for Surroundings {
    fn columns(&self, of: &Columns, _channel: usize) -> Vec<Vec<f64>> {
        match self {
            Surroundings::Gravity => of.apart(&of.tables_of_all(), MOST_RECORDINGS, |within| {
                of.turned_gravity.iter().map(|turned| of.only(turned, within)).collect()
            }),
            Surroundings::Pull => of.pulled.clone(),
            Surroundings::BaseGivesWay => of.leaning.clone(),
        }
    }

    fn found(&self, of: &Columns, _channel: usize, coefficients: &[f64]) -> Found {
        match self {
            Surroundings::Gravity => {
                let (file, size) = most_turned(of, coefficients);
                Found::new(ResidualTestKind::Gravity { file }, size, "rad")
            }
            Surroundings::Pull => Found::new(ResidualTestKind::Pull, dot(coefficients, coefficients).sqrt(), "N"),
            Surroundings::BaseGivesWay => {
                Found::new(ResidualTestKind::BaseGivesWay, coefficients.first().copied().unwrap_or(0.0), "rad")
            }
        }
    }

    /// No base turns against what it carries.
    fn may_be(&self, _of: &Columns, _channel: usize, coefficients: &[f64]) -> bool {
        *self != Surroundings::BaseGivesWay || coefficients.first().is_some_and(|turn| *turn > 0.0)
    }
}

/// The file in which gravity is turned most against the first, and by how much, rad.
fn most_turned(of: &Columns, coefficients: &[f64]) -> (String, f64) {
    let turns = coefficients.as_chunks::<2>().0.iter().map(|[a, b]| a.hypot(*b));
    let tables = of.tables_of_all().into_iter().skip(1);
    let (table, size) = tables.zip(turns).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
    (file_name(&of.session.tables[table].path), size)
}

pub fn of_gravity(test: &ResidualTest, file: &str) -> Words {
    Words::new(
        format!(
            "The residuals of all joints show gravity turned by {}° in {file} against the other tables.",
            significant(test.size.to_degrees(), 2)
        ),
        "Either the base stood otherwise, or a load is not as stated (mass_kg, position_m). Record all tables with the base where it is, or \
         calibrate those before and after by themselves.",
    )
}

pub fn of_pull(test: &ResidualTest) -> Words {
    Words::new(
        format!("The residuals of all joints look as if something pulled at the last link, by {}.", shown(test)),
        "A hose, a cable or an air line does so: take it off, or let it hang so that it does not pull, and record all again.",
    )
}

pub fn of_base(test: &ResidualTest) -> Words {
    Words::new(
        format!(
            "The residuals of all joints look as if the base gave way under the arm, by up to {}°.",
            significant(test.size.abs().to_degrees(), 2)
        ),
        "Bolt it to a floor or table that does not, and record all again. Gravity is told as the base sees it on the mean of the poses.",
    )
}
