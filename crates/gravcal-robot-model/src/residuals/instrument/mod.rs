//! Readings, in one static pose, of an instrument that a link carries.
//!
//! ```text
//!     y = K u(v) + b + Σ d φ,     v = R_mᵀ R_kᵀ(θ) Rᵀ g
//! ```
//!
//! `φ` are the time or the temperature of the pose, with which biases drift.
//! `v` is gravity in the instrument's frame: `R_k` the rotation of its link, `R_m` that of its mounting; `R` turns all of it,
//! where the pose itself says how a body without joints stood (`R_k` is then none). What it senses of
//! it, `u`, is its own ([`Wrench`], [`SpecificForce`]); the gains `K` are one an axis, or a full matrix. Axes without a
//! usable reading have no row.

mod coordinates;
mod sensed;
mod specific_force;
mod wrench;

use std::sync::Arc;

use gravcal_dynamics::Chain;
use gravcal_estimation::{BlockId, EvaluateError, LocalValues, Residual, RowsMut};
use nalgebra::{Matrix3, Vector3};

pub(in crate::residuals) use self::coordinates::Further;
pub use self::coordinates::PositionTerms;

pub use sensed::{Sensed, SensedQuantity};
pub use specific_force::SpecificForce;
pub use wrench::Wrench;

/// Stored columns of gravity.
const GRAVITY: usize = 3;

/// One entry of the gains `K`: axis of the reading, axis of what is sensed, and its block.
#[derive(Clone, Copy, Debug)]
pub struct GainEntry {
    /// Row of K.
    pub reading: usize,
    /// Column of K.
    pub sensed: usize,
    /// One number, in units of the reading a unit of what is sensed.
    pub block: BlockId,
}

/// What all poses share: where the instrument sits, and its unknowns.
#[derive(Debug)]
pub struct AuxiliarySensorModel {
    chain: Arc<Chain>,
    link: usize,
    /// `R_m`: axes of the instrument in the link's frame.
    mounting: Matrix3<f64>,
    sensed: Arc<dyn SensedQuantity>,
    gains: Vec<GainEntry>,
    blocks: Vec<BlockId>,
    /// First stored columns of gains, biases and own unknowns.
    columns: [usize; 3],
}

impl AuxiliarySensorModel {
    /// An instrument on link number `link`, `mounting` (row-major) the rotation of its frame in the link's.
    ///
    /// `coordinates`: blocks of one number each on which the coordinates of the joints that move the link depend; `biases`:
    /// one an axis, then one an axis of each drift.
    pub fn new(
        (chain, link): (Arc<Chain>, usize),
        mounting: [[f64; 3]; 3],
        sensed: Arc<dyn SensedQuantity>,
        (gravity, coordinates): (BlockId, &[BlockId]),
        (gains, biases): (Vec<GainEntry>, &[BlockId]),
    ) -> Self {
        let mounting = Matrix3::from_fn(|i, j| mounting[i][j]);
        let mut blocks = vec![gravity];
        blocks.extend(coordinates);
        blocks.extend(gains.iter().map(|gain| gain.block));
        blocks.extend(biases);
        blocks.extend(sensed.blocks());
        let first = GRAVITY + coordinates.len();
        let columns = [first, first + gains.len(), first + gains.len() + biases.len()];
        AuxiliarySensorModel { chain, link, mounting, sensed, gains, blocks, columns }
    }
}

/// The readings of an instrument in one pose.
#[derive(Clone, Debug)]
pub struct AuxiliarySensorReading {
    model: Arc<AuxiliarySensorModel>,
    /// `θ_j = Σ coefficient · block`: joint, place among the coordinates' blocks, coefficient.
    coordinates: Vec<(usize, usize, f64)>,
    /// `R`.
    orientation: Matrix3<f64>,
    /// What position sensors do beyond.
    terms: PositionTerms,
    /// `φ` of each drift.
    drifts: Vec<f64>,
    /// Axis and reading of each row.
    readings: Vec<(usize, f64)>,
}

impl AuxiliarySensorReading {
    /// `coordinates`: joint, place among the model's coordinate blocks and coefficient of each term of
    /// `θ_j = Σ coefficient · block`; `orientation`: of what carries the chain, row-major, where it is turned; `readings`:
    /// axis and reading, one a row. Biases do not drift: see [`drifting`](Self::drifting).
    pub fn new(
        model: Arc<AuxiliarySensorModel>,
        coordinates: Vec<(usize, usize, f64)>,
        orientation: Option<[[f64; 3]; 3]>,
        readings: Vec<(usize, f64)>,
    ) -> Self {
        let orientation = orientation.map_or_else(Matrix3::identity, |rows| Matrix3::from_fn(|i, j| rows[i][j]));
        AuxiliarySensorReading {
            model,
            coordinates,
            terms: PositionTerms::default(),
            orientation,
            drifts: Vec::new(),
            readings,
        }
    }

    /// The same with what position sensors do beyond gain and offset.
    #[must_use]
    pub fn with_terms(self, terms: PositionTerms) -> Self {
        AuxiliarySensorReading { terms, ..self }
    }

    /// The same with `φ` of each drift of the model, in its order.
    #[must_use]
    pub fn drifting(self, drifts: Vec<f64>) -> Self {
        AuxiliarySensorReading { drifts, ..self }
    }

    /// Column and factor of everything that adds to an axis' reading by itself: its bias, its drifts.
    fn offsets(&self, axis: usize) -> impl Iterator<Item = (usize, f64)> {
        let (first, axes) = (self.model.columns[1] + axis, self.model.sensed.axes());
        std::iter::once(&1.0).chain(&self.drifts).enumerate().map(move |(set, factor)| (first + set * axes, *factor))
    }

    fn set_row(&self, row: &mut [f64], x: &[f64], axis: usize, at: &Linearized) {
        let [gains, _, own] = self.model.columns;
        self.offsets(axis).for_each(|(column, factor)| row[column] = factor);
        let mut by_gravity = Vector3::zeros();
        for (place, gain) in self.model.gains.iter().enumerate().filter(|(_, gain)| gain.reading == axis) {
            row[gains + place] = at.sensed.value[gain.sensed];
            let factor = x[gains + place];
            by_gravity += factor * at.sensed.by_gravity[gain.sensed];
            let by_own = &at.sensed.by_own[gain.sensed];
            row[own..].iter_mut().zip(by_own).for_each(|(entry, by)| *entry += factor * by);
        }
        for (entry, by) in row[..GRAVITY].iter_mut().zip(&at.by_gravity) {
            *entry = by_gravity.dot(by);
        }
        for (joint, place, coefficient) in &self.coordinates {
            row[GRAVITY + place] += coefficient * by_gravity.dot(&at.by_coordinate[*joint]);
        }
        for Further { joint, place, slope, .. } in &at.further {
            row[GRAVITY + place] += slope * by_gravity.dot(&at.by_coordinate[*joint]);
        }
    }

    fn linearized(&self, x: &[f64]) -> Linearized {
        let model = &self.model;
        let mut coordinates = vec![0.0; model.chain.joint_count()];
        for (joint, place, coefficient) in &self.coordinates {
            coordinates[*joint] += coefficient * x[GRAVITY + place];
        }
        let further = self.terms.add_to(&mut coordinates, &x[GRAVITY..]);
        let turned = self.orientation.tr_mul(&Vector3::new(x[0], x[1], x[2]));
        let on_link = model.chain.link_gravity(model.link, &coordinates, turned.into());
        let mounted = |v: [f64; 3]| model.mounting.tr_mul(&Vector3::from(v));
        let by_turned = Matrix3::from_fn(|row, column| on_link.by_gravity[row][column]);
        let by_gravity = model.mounting.tr_mul(&by_turned) * self.orientation.transpose();
        let by_axis = |axis: usize| by_gravity.column(axis).into_owned();
        Linearized {
            sensed: model.sensed.sense(&mounted(on_link.value), &x[model.columns[2]..]),
            by_gravity: [0, 1, 2].map(by_axis),
            by_coordinate: on_link.by_coordinate.into_iter().map(mounted).collect(),
            further,
        }
    }
}

/// What is sensed, and how gravity in the instrument's frame depends on gravity's components and the coordinates.
struct Linearized {
    sensed: Sensed,
    by_gravity: [Vector3<f64>; 3],
    by_coordinate: Vec<Vector3<f64>>,
    /// How coordinates depend on parameters of position sensors beyond gain and offset.
    further: Vec<Further>,
}

impl Residual for AuxiliarySensorReading {
    fn blocks(&self) -> &[BlockId] {
        &self.model.blocks
    }

    fn len(&self) -> usize {
        self.readings.len()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        mut jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let x = x.as_slice();
        let at = self.linearized(x);
        let [gains, ..] = self.model.columns;
        for (index, (axis, reading)) in self.readings.iter().enumerate() {
            let own = self.model.gains.iter().enumerate().filter(|(_, gain)| gain.reading == *axis);
            let sensed: f64 = own.map(|(place, gain)| x[gains + place] * at.sensed.value[gain.sensed]).sum();
            let offset: f64 = self.offsets(*axis).map(|(column, factor)| factor * x[column]).sum();
            residual[index] = sensed + offset - reading;
            if let Some(rows) = jacobian.as_mut() {
                self.set_row(rows.row(index), x, *axis, &at);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use gravcal_dynamics::{DhConvention, DhRow, JointKind, Link, chain_from_dh};

    use super::*;
    use crate::residuals::testing::{check_at_random_points, ids};

    /// A turning, a sliding and a turning joint.
    fn chain() -> Arc<Chain> {
        let row = |i: usize, kind, alpha| DhRow {
            name: format!("joint{i}"),
            kind,
            a: 0.1,
            alpha,
            d: 0.2,
            theta: 0.1,
            limits: None,
            link: Link { name: format!("link{i}"), inertia: None },
        };
        let kinds = [JointKind::Revolute, JointKind::Prismatic, JointKind::Revolute];
        let rows: Vec<DhRow> = kinds.into_iter().enumerate().map(|(i, kind)| row(i, kind, 0.7 + i as f64)).collect();
        Arc::new(chain_from_dh("base", DhConvention::Standard, &rows).unwrap())
    }

    const HALF_TURN_ABOUT_X: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];

    const QUARTER_ABOUT_Y: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];

    /// Checks an instrument on the last link that reads its first and its last axis; `own` makes it from its own blocks.
    pub fn check(axes: usize, full: bool, own: &[usize], make: impl Fn(&[BlockId]) -> Arc<dyn SensedQuantity>) {
        let entries: Vec<(usize, usize)> =
            (0..axes * axes).map(|k| (k / axes, k % axes)).filter(|(i, j)| full || i == j).collect();
        let mut lengths = vec![3];
        // Of each axis a bias, and two drifts.
        lengths.resize(1 + 6 + entries.len() + 3 * axes, 1);
        lengths.extend(own);
        let ids = ids(&lengths);
        let (coordinates, rest) = ids[1..].split_at(6);
        let (gains, rest) = rest.split_at(entries.len());
        let (biases, own) = rest.split_at(3 * axes);
        let gains = entries.iter().zip(gains);
        let gains =
            gains.map(|((reading, sensed), block)| GainEntry { reading: *reading, sensed: *sensed, block: *block });
        let model = AuxiliarySensorModel::new(
            (chain(), 2),
            HALF_TURN_ABOUT_X,
            make(own),
            (ids[0], coordinates),
            (gains.collect(), biases),
        );
        let terms = [(0, 0, 0.3), (0, 1, 1.0), (1, 2, 0.2), (1, 3, 1.0), (2, 4, -0.8), (2, 5, 1.0)];
        let readings = vec![(0, 2.0), (axes - 1, 1.0)];
        let model = Arc::new(model);
        for orientation in [None, Some(QUARTER_ABOUT_Y)] {
            let residual =
                AuxiliarySensorReading::new(Arc::clone(&model), terms.to_vec(), orientation, readings.clone());
            let residual = residual.drifting(vec![0.7, -2.0]);
            check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
        }
    }
}
