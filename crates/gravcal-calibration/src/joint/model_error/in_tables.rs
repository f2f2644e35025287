//! Friction and compliance of an arm whose poses are rows of tables: unknowns where residuals show them.
//!
//! Recordings tell from which side joints came to a pose, and that readings err beyond their noise; a table need not. Its rows mostly stand in the order in
//! which they were read (`sides_by_order.rs`). Where a residual goes with the side from which its joint came by that order, the arm has friction, and the
//! rows stand as they were read: in an arm without, chance makes any test name something once in a hundred sessions. Then what friction leaves at rest,
//! and how far joints bend, are unknowns as they are in recordings (`at_rest.rs`, `bending.rs`), and all is solved again. Compliance that residuals show by
//! themselves is an unknown, too.
//!
//! Errors of a joint's readings are at least as large as what friction leaves on one side; the noise of a table is mostly found from its residuals, and
//! holds both.

use std::sync::Arc;

use gravcal_robot_model::session::{ReadingId, Session};

use crate::joint::error::EstimateError;
use crate::joint::measurement_set::{Bending, MeasurementSet};
use crate::joint::model_error::bending::is_stiffness_unsaid;
use crate::joint::model_error::sides_by_order::sides_by_order;
use crate::joint::order::Order;
use crate::joint::solved::Solved;
use crate::result::{ResidualTest, ResidualTestKind};

impl Solved {
    /// The readings with unknowns for friction and compliance, where the residuals of tables show what would spoil intervals otherwise; nothing where they
    /// do not, or the session has those unknowns already. `readings`: as the solution was asked for.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated.
    pub(in crate::joint) fn shown_by_tables(
        &self,
        session: &Session,
        readings: &MeasurementSet,
        tests: &[ResidualTest],
    ) -> Result<Option<MeasurementSet>, EstimateError> {
        let found = self.readings();
        let looked_for = found.at_rest.is_empty() && found.bending.is_none() && found.order == Order::Together;
        let of_tables = session.searched.is_empty() && !session.has_windows();
        if !looked_for || !of_tables {
            return Ok(None);
        }
        let shows = |kind: ResidualTestKind| {
            move |test: &&ResidualTest| test.named && test.spoils_intervals && test.kind == kind
        };
        let sizes = tests.iter().filter(shows(ResidualTestKind::Direction));
        let errors: Vec<f64> = (0..session.joints.len())
            .map(|joint| {
                let name = session.channel_name(joint);
                let shown = sizes.clone().find(|test| test.channel == name);
                shown.map_or(0.0, |test| test.size.abs().max(self.error_of(session, joint)))
            })
            .collect();
        let sides = sides_by_order(session).into();
        let with_friction = MeasurementSet { sides, ..readings.clone() }.with_friction_shown(session, &errors);
        let gives_way = tests.iter().any(|test| shows(ResidualTestKind::Compliance)(&test));
        if with_friction.is_none() && !gives_way {
            return Ok(None);
        }
        let with = with_friction.unwrap_or_else(|| readings.clone());
        let bending = match is_stiffness_unsaid(session) {
            true => Some(Arc::new(Bending::as_built(session, self)?)),
            false => None,
        };
        Ok(Some(MeasurementSet { bending, ..with }))
    }

    /// Root mean square of the standard deviations with which a joint's readings count.
    fn error_of(&self, session: &Session, joint: usize) -> f64 {
        let rows = self.built.rows.iter().filter(|id| id.channel == joint);
        let squares: Vec<f64> = rows.map(|id: &ReadingId| self.readings().std(session, *id).powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
    }
}
