//! Time of the product JᵀJ alone, and the machine's peak.
//!
//! Counted is what normal equations in batches need: poses that carry the same load, 64 at a time; for each joint i
//! one buffer of 64 rows over the columns that its torque can touch (gravity, its own gain and bias, all position gains
//! and offsets, masses and moments of the links from i on, the load's placement) and the residual, `w_i + 1` together;
//! of each buffer's product with itself the lower triangle, added to a sum:
//!
//! ```text
//!     floating-point operations a pose = Σ_i (w_i + 1)(w_i + 2)          (a product and a sum for each entry and row)
//! ```
//!
//! Filling the buffers, and adding the sums into the matrix of all columns, is not counted.

use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, MatRef, Par};
use gravcal_estimation::BlockId;
use gravcal_robot_model::parameter::SensorParameter;

use gravcal_benches::clock::median_seconds;
use gravcal_benches::seven_joints::SevenJoints;

/// Poses in a batch.
const BATCH: usize = 64;
/// Sizes of the square products whose best rate is the peak: two operands and the result stay in a cache of 2 MB.
const PEAK_SIZES: [usize; 4] = [96, 128, 192, 256];

/// The products of all poses once.
pub struct ProductTime {
    pub seconds: f64,
    pub operations: f64,
}

impl ProductTime {
    /// Floating-point operations a second.
    pub fn rate(&self) -> f64 {
        self.operations / self.seconds
    }
}

/// One joint's rows of one batch, row-major, and the lower triangle of their products.
struct Buffer {
    rows: Vec<f64>,
    width: usize,
    sum: Mat<f64>,
}

impl Buffer {
    fn new(width: usize) -> Self {
        // Any numbers: only the shape matters.
        let rows = (0..BATCH * width).map(|k| (k as f64).sin()).collect();
        Buffer { rows, width, sum: Mat::zeros(width, width) }
    }

    /// Adds the products of the first rows.
    fn add_product(&mut self, rows: usize) {
        let rows = MatRef::from_row_major_slice(&self.rows[..rows * self.width], rows, self.width);
        triangular::matmul(
            self.sum.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Add,
            rows.transpose(),
            BlockStructure::Rectangular,
            rows,
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
    }
}

/// Poses with the same load, and a buffer a joint.
struct Group {
    poses: usize,
    buffers: Vec<Buffer>,
}

impl Group {
    fn new(problem: &SevenJoints, load: Option<usize>) -> Self {
        let poses = problem.session.poses.iter().filter(|pose| pose.load == load).count();
        let width = |joint| columns(problem, load, joint) + 1;
        Group { poses, buffers: (0..problem.session.joints.len()).map(|joint| Buffer::new(width(joint))).collect() }
    }

    fn add_products(&mut self) {
        for start in (0..self.poses).step_by(BATCH) {
            let rows = BATCH.min(self.poses - start);
            self.buffers.iter_mut().for_each(|buffer| buffer.add_product(rows));
        }
    }

    fn operations(&self) -> f64 {
        let each: usize = self.buffers.iter().map(|buffer| buffer.width * (buffer.width + 1)).sum();
        (self.poses * each) as f64
    }
}

/// Time and operations of JᵀJ over all poses of the problem.
pub fn time(problem: &SevenJoints) -> ProductTime {
    let loads = std::iter::once(None).chain((0..problem.session.loads.len()).map(Some));
    let mut groups: Vec<Group> = loads.map(|load| Group::new(problem, load)).collect();
    let seconds = median_seconds(|| groups.iter_mut().for_each(Group::add_products));
    ProductTime { seconds, operations: groups.iter().map(Group::operations).sum() }
}

/// How many columns the torque of one joint can touch.
fn columns(problem: &SevenJoints, load: Option<usize>, joint: usize) -> usize {
    let variables = &problem.built.variables;
    let own = [SensorParameter::TorqueGain, SensorParameter::TorqueBias].map(|q| variables.sensors[joint][q as usize]);
    let coordinates = variables
        .sensors
        .iter()
        .flat_map(|ids| [SensorParameter::PositionGain, SensorParameter::PositionOffset].map(|q| ids[q as usize]));
    let placement = load.and_then(|load| variables.loads[load].clone()).unwrap_or_default();
    std::iter::once(variables.gravity)
        .chain(own)
        .chain(coordinates)
        .chain(variables.inertia[joint..].iter().copied())
        .chain(placement)
        .map(|id: BlockId| problem.built.problem.columns_of(id).len())
        .sum()
}

/// Floating-point operations a second of the fastest square product in cache.
pub fn peak() -> f64 {
    PEAK_SIZES.into_iter().map(square_rate).fold(0.0, f64::max)
}

fn square_rate(size: usize) -> f64 {
    let [a, b] = [1.0, 2.0].map(|shift| Mat::from_fn(size, size, |i, j| (shift + (i * size + j) as f64).sin()));
    let mut product = Mat::zeros(size, size);
    let operations = 2.0 * (size as f64).powi(3);
    let repetitions = (1e9 / operations).ceil() as usize;
    let seconds = median_seconds(|| {
        for _ in 0..repetitions {
            faer::linalg::matmul::matmul(product.as_mut(), Accum::Replace, &a, &b, 1.0, Par::Seq);
        }
    });
    operations * repetitions as f64 / seconds
}
