//! The zero of a position sensor that is another in another table, changes on the way, or hangs on the side from which its joint came.

use super::lacked::{Found, Lacked, Words};
use crate::judgement::residual_tests::columns::{Columns, MOST_RECORDINGS};
use crate::judgement::residual_tests::wording::{shown_amount, shown_size};
use crate::result::{ResidualTest, ResidualTestKind};

/// A zero that changes on the way is looked for behind each but the last of so many parts of the poses, if there are so many poses.
const PARTS: usize = 8;
const FEWEST_PARTED: usize = 24;

/// What is said of other sensors.
const OTHER_OFFSETS: &str = "The zeros of the other position sensors may have changed, too: their intervals include the change that their own residuals allow.";

/// Of a joint's coordinate, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PositionZero {
    /// Of each table but the first.
    InTables,
    /// Another one from this pose on, in the order of their times.
    Jump {
        /// Place of the pose in that order.
        from: usize,
    },
    /// To the side from which the joint came: of a gear with play, or one that twists under its friction.
    BySide,
}

impl PositionZero {
    /// Those that are looked for in a joint.
    pub fn of_joint(of: &Columns) -> Vec<PositionZero> {
        let count = of.in_order.len();
        let table = |place: usize| of.table(of.in_order[place]);
        let froms = (1..PARTS).map(|part| part * count / PARTS);
        // Where a table begins, it is the zero of that table.
        let froms = froms.filter(|from| count >= FEWEST_PARTED && table(*from) == table(from - 1));
        [PositionZero::InTables, PositionZero::BySide]
            .into_iter()
            .chain(froms.map(|from| PositionZero::Jump { from }))
            .collect()
    }
}

impl Lacked for PositionZero {
    fn columns(&self, of: &Columns, channel: usize) -> Vec<Vec<f64>> {
        match self {
            PositionZero::InTables => of.apart(&of.tables_of_all(), MOST_RECORDINGS, |within| {
                vec![of.coordinate(channel, |pose| f64::from(within(pose)))]
            }),
            PositionZero::Jump { from } => vec![of.coordinate(channel, |pose| f64::from(of.places[pose] >= *from))],
            PositionZero::BySide => vec![of.coordinate(channel, |pose| of.side(channel, pose))],
        }
    }

    fn found(&self, of: &Columns, _channel: usize, coefficients: &[f64]) -> Found {
        match self {
            PositionZero::InTables => {
                let (file, size) = of.farthest(&of.tables_of_all(), coefficients);
                Found::new(ResidualTestKind::PositionOffset { file }, size, "rad")
            }
            PositionZero::Jump { from } => {
                let (file, line) = of.session.row_of(of.in_order[*from]);
                let first = coefficients.first().copied().unwrap_or(0.0);
                Found::new(ResidualTestKind::PositionJump { file, line }, first, "rad")
            }
            PositionZero::BySide => {
                Found::new(ResidualTestKind::Backlash, coefficients.first().copied().unwrap_or(0.0), "rad")
            }
        }
    }
}

pub fn of_tables(test: &ResidualTest, file: &str) -> Words {
    Words::new(
        format!(
            "The residuals show that the zero of the position sensor of {} is another in {file}, by {} rad.",
            test.channel,
            shown_size(test)
        ),
        "Either it was homed anew between the tables, or the load is not where position_m says, the joint gives way under it, or lengths of the robot are others. Record all \
         tables after one homing, or calibrate those before and after by themselves.",
    )
    .beside(Some(OTHER_OFFSETS))
}

pub fn of_jump(test: &ResidualTest, file: &str, line: u64) -> Words {
    Words::new(
        format!(
            "The residuals show that the zero of the position sensor of {} changes by {} rad, about row {line} of {file}.",
            test.channel,
            shown_size(test)
        ),
        "The sensor slipped, or was homed anew. What is told lies between both zeros: calibrate the readings before and after by themselves.",
    )
}

pub fn of_backlash(test: &ResidualTest) -> Words {
    Words::new(
        format!(
            "The residuals show that the position sensor of {} reads otherwise on each side from which the joint comes, by ±{}.",
            test.channel,
            shown_amount(test)
        ),
        "The gear between sensor and joint has play, or twists under its friction. Come to all poses from the same side, or to each from both and take the mean; or \
         say how far positions may be off (std of position in [readings]).",
    )
}
