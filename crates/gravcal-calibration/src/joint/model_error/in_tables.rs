//! Friction and compliance of an arm whose poses are rows of tables: unknowns where residuals show them.
//!
//! Recordings tell from which side joints came to a pose, and that readings err beyond their noise; a table need not. Its rows mostly stand in the order in
//! which they were read (`sides_by_order.rs`). Where a residual goes with the side from which its joint came by that order, the arm has friction, and the
//! rows stand as they were read: in an arm without, chance makes any test name something once in a hundred sessions. So it does where errors last as long
//! as a joint stands (`lasting.rs`). Then what friction leaves at rest,
//! and how far joints bend, are unknowns as they are in recordings (`at_rest.rs`, `bending.rs`), and all is solved again. Compliance that residuals show by
//! themselves is an unknown, too.
//!
//! The prior of what friction leaves at rest is as wide as the largest of what the test found, of the noise of the joint's readings, which is mostly found
//! from residuals and holds the friction, too, and of errors that last.

use std::sync::Arc;

use gravcal_robot_model::number::significant;
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::{ReadingId, Session};
use gravcal_robot_model::sweeps::sweeping;

use crate::joint::error::EstimateError;
use crate::joint::measurement_set::{Bending, MeasurementSet};
use crate::joint::model_error::at_rest::{CHANCE, LEAN};
use crate::joint::model_error::bending::is_stiffness_unsaid;
use crate::joint::model_error::sides_by_order::{moved_to, sides_at_rest};
use crate::joint::order::Order;
use crate::joint::solved::Solved;
use crate::result::{ResidualTest, ResidualTestKind};

/// A joint that came from one side to so large a share of its poses leaves its friction in its bias. Rows in random order do so in one of 360 tables of
/// six rows (2/6!), and hardly ever in longer ones.
const ONE_SIDED: f64 = 0.9;

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
        let spoiling: Vec<&ResidualTest> = tests.iter().filter(|test| test.named && test.spoils_intervals).collect();
        let friction = |joint: usize| {
            let name = session.channel_name(joint);
            let shown = spoiling.iter().find(|test| test.kind == ResidualTestKind::Direction && test.channel == name);
            let by_side = shown.map_or(0.0, |test| test.size.abs().max(self.error_of(session, joint)));
            by_side.max(found.lasting_variance(joint).sqrt())
        };
        let errors: Vec<f64> = (0..session.joints.len()).map(friction).collect();
        let sides = sides_at_rest(session).into();
        let with_friction = MeasurementSet { sides, ..readings.clone() }.with_friction_shown(
            session,
            &errors,
            &self.carried_by_joints(session)?,
        );
        let gives_way = spoiling.iter().any(|test| test.kind == ResidualTestKind::Compliance);
        let Some(with) = with_friction.or_else(|| gives_way.then(|| readings.clone())) else { return Ok(None) };
        let bending = is_stiffness_unsaid(session).then(|| Bending::as_built(session, self)).transpose()?;
        Ok(Some(MeasurementSet { bending: bending.map(Arc::new), ..with }))
    }

    /// Joints that came to their poses from one side in tables that show no friction, as nothing would.
    pub(in crate::joint) fn joints_from_one_side(&self, session: &Session) -> Vec<usize> {
        let shows = !self.readings().at_rest.is_empty() || sweeping(session).iter().any(Option::is_some);
        if shows || !session.searched.is_empty() || session.has_windows() {
            return Vec::new();
        }
        let order = MeasurementSet { sides: moved_to(session).into(), ..self.readings().clone() };
        let estimated = session.terms.with_friction();
        let is_read = |joint: usize| self.built.rows.iter().any(|id| id.channel == joint);
        let from_one_side = |joint: &usize| {
            !estimated.contains(joint) && is_read(*joint) && order.share_of_one_side(session, *joint) >= ONE_SIDED
        };
        (0..session.joints.len()).filter(from_one_side).collect()
    }

    /// By how much their biases may be off, for friction that their noise may hide: one entry a column of each.
    pub(in crate::joint) fn moved_by_hidden_friction(&self, session: &Session) -> Vec<Vec<f64>> {
        let moved = |joint: usize| {
            let bias = self.built.variables.block(ParameterId::Sensor(joint, SensorParameter::TorqueBias));
            let mut moved = vec![0.0; self.judged_problem().columns().len()];
            self.judged_problem()
                .columns_of(bias)
                .for_each(|column| moved[column] = self.hidden_friction(session, joint));
            moved
        };
        self.joints_from_one_side(session).into_iter().map(moved).collect()
    }

    /// The same in words.
    pub(in crate::joint) fn biases_that_may_hold_friction(&self, session: &Session) -> Option<String> {
        let joints = self.joints_from_one_side(session);
        let by = if moved_to(session).is_empty() { "direction says" } else { "the order of the rows tells" };
        let told = |joint: &usize| {
            let size = significant(self.hidden_friction(session, *joint), 2);
            format!("{} (± {size} {})", session.channel_name(*joint), session.channel_unit(*joint))
        };
        (!joints.is_empty()).then(|| {
            format!(
                "Joints came to at least nine of ten poses from the same side, as {by}: {}. If the arm has friction, their torque biases hold what is left of it \
                 at rest, and no residual shows it: intervals allow for as much as the noise may hide. Come to the same poses from both sides, and say from \
                 which (direction in [readings]).",
                joints.iter().map(told).collect::<Vec<_>>().join(", ")
            )
        })
    }

    /// What friction may leave at rest of which residuals show nothing: its spread is no more than the noise that is found, or than chance lets hide in
    /// the noise that is stated.
    fn hidden_friction(&self, session: &Session, joint: usize) -> f64 {
        let (std, count) =
            (self.error_of(session, joint), self.built.rows.iter().filter(|id| id.channel == joint).count());
        let share = match session.noise_estimated()[joint] {
            true => 1.0,
            false => (CHANCE * (2.0 / count.max(1) as f64).sqrt()).min(1.0),
        };
        LEAN * share.sqrt() * std
    }

    /// Root mean square of the standard deviations with which a joint's readings count.
    fn error_of(&self, session: &Session, joint: usize) -> f64 {
        let rows = self.built.rows.iter().filter(|id| id.channel == joint);
        let squares: Vec<f64> = rows.map(|id: &ReadingId| self.readings().std(session, *id).powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
    }
}
