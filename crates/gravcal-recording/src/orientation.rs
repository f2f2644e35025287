//! How a body stood in a pose, as columns of a table: a unit quaternion, or a rotation matrix.
//!
//! ```text
//!     v_base = R v_body
//!
//!     q = w + x i + y j + z k,  |q| = 1:
//!         | 1 − 2(y² + z²)   2(xy − wz)       2(xz + wy)     |
//!     R = | 2(xy + wz)       1 − 2(x² + z²)   2(yz − wx)     |
//!         | 2(xz − wy)       2(yz + wx)       1 − 2(x² + y²) |
//! ```
//!
//! The columns may give `Rᵀ` instead. Printed numbers are rounded: what is a rotation within [`TOLERANCE`] becomes the nearest
//! one, anything else is refused, as are mirror images (determinant −1).

use crate::error::ReadError;
use crate::table::Table;

/// How far the length of a quaternion, or an entry of `RᵀR`, may be from what it should be: what three printed decimals leave.
const TOLERANCE: f64 = 5e-3;
/// Each squares the distance to the nearest rotation.
const POLISHING: usize = 4;

/// Rotation of a body's frame in the base's, row by row.
pub type Orientation = [[f64; 3]; 3];

/// What the columns of an orientation are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OrientationForm {
    /// Four: x, y, z, w.
    QuaternionXyzw,
    /// Four: w, x, y, z.
    QuaternionWxyz,
    /// Nine, row by row.
    Matrix,
}

/// Where the orientation of a body stands.
#[derive(Clone, Debug, PartialEq)]
pub struct OrientationColumns {
    /// Four or nine names, as the form says.
    pub columns: Vec<String>,
    /// What they are.
    pub form: OrientationForm,
    /// Whether what stands there turns vectors of the base into the body's frame, and not the other way round.
    pub body_from_base: bool,
}

impl OrientationForm {
    /// How many columns it has.
    pub fn columns(self) -> usize {
        match self {
            OrientationForm::QuaternionXyzw | OrientationForm::QuaternionWxyz => 4,
            OrientationForm::Matrix => 9,
        }
    }

    /// The rotation that the cells of a row say, as it is written: from the body's frame into the base's, or the other way round. Row by row.
    ///
    /// # Errors
    /// What they are instead, in words.
    pub fn rotation(self, cells: &[f64]) -> Result<Orientation, String> {
        match (self, cells) {
            (OrientationForm::QuaternionXyzw, &[x, y, z, w]) | (OrientationForm::QuaternionWxyz, &[w, x, y, z]) => {
                of_quaternion([x, y, z, w])
            }
            (OrientationForm::Matrix, &[a, b, c, d, e, f, g, h, i]) => nearest([[a, b, c], [d, e, f], [g, h, i]]),
            _ => Err(format!("{} numbers", cells.len())),
        }
    }
}

/// Such columns found in one table.
pub(crate) struct FoundOrientation<'a> {
    mapped: &'a OrientationColumns,
    places: Vec<usize>,
}

impl<'a> FoundOrientation<'a> {
    pub fn find(table: &Table, mapped: &'a OrientationColumns) -> Result<Self, ReadError> {
        let places = mapped.columns.iter().map(|column| table.column(column)).collect::<Result<_, _>>()?;
        Ok(FoundOrientation { mapped, places })
    }

    pub fn read(&self, table: &Table, row: usize) -> Result<Orientation, ReadError> {
        let cell = |place: &usize| {
            table.number(row, *place)?.ok_or_else(|| ReadError::NoOrientation { place: table.place(row, *place) })
        };
        let cells: Vec<f64> = self.places.iter().map(cell).collect::<Result<_, _>>()?;
        let written = self
            .mapped
            .form
            .rotation(&cells)
            .map_err(|found| ReadError::NoRotation { place: table.place(row, self.places[0]), found })?;
        Ok(if self.mapped.body_from_base { transposed(&written) } else { written })
    }
}

fn of_quaternion(q: [f64; 4]) -> Result<Orientation, String> {
    let norm = q.iter().fold(0.0, |norm: f64, part| norm.hypot(*part));
    if (norm - 1.0).abs() > TOLERANCE {
        return Err(format!("a quaternion of length {norm:.4}"));
    }
    let [x, y, z, w] = q.map(|part| part / norm);
    Ok([
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ])
}

/// The rotation nearest to a matrix, by Newton's iteration for its polar factor: `R ← R (3 − RᵀR) / 2`.
fn nearest(matrix: Orientation) -> Result<Orientation, String> {
    let off = off_orthogonal(&matrix);
    if off.is_nan() || off > TOLERANCE {
        return Err(format!("a matrix whose columns are not orthogonal unit vectors (RᵀR is off by {off:.4})"));
    }
    if determinant(&matrix) < 0.0 {
        return Err("a mirror image (its determinant is -1)".to_owned());
    }
    let mut rotation = matrix;
    for _ in 0..POLISHING {
        let squares = product(&transposed(&rotation), &rotation);
        let factor = entries(|i, j| if i == j { 1.5 } else { 0.0 } - 0.5 * squares[i][j]);
        rotation = product(&rotation, &factor);
    }
    Ok(rotation)
}

/// Largest entry of `RᵀR − 1`.
fn off_orthogonal(matrix: &Orientation) -> f64 {
    let squares = product(&transposed(matrix), matrix);
    let off = |i: usize, j: usize| (squares[i][j] - if i == j { 1.0 } else { 0.0 }).abs();
    // `f64::max` would pass over what is no number.
    entries(off).iter().flatten().fold(0.0, |most, off| if *off <= most { most } else { *off })
}

fn determinant([a, b, c]: &Orientation) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}

fn product(a: &Orientation, b: &Orientation) -> Orientation {
    entries(|i, j| (0..3).map(|k| a[i][k] * b[k][j]).sum())
}

fn transposed(matrix: &Orientation) -> Orientation {
    entries(|i, j| matrix[j][i])
}

fn entries(entry: impl Fn(usize, usize) -> f64) -> Orientation {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const QUARTER_ABOUT_Z: Orientation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];

    fn distance(a: &Orientation, b: &Orientation) -> f64 {
        a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_quarter_turn_about_z_takes_x_to_y_in_either_order() {
        let half = 0.5f64.sqrt();
        let xyzw = OrientationForm::QuaternionXyzw.rotation(&[0.0, 0.0, half, half]).unwrap();
        let wxyz = OrientationForm::QuaternionWxyz.rotation(&[half, 0.0, 0.0, half]).unwrap();
        assert!(distance(&xyzw, &QUARTER_ABOUT_Z) < 1e-15 && xyzw == wxyz, "{xyzw:?} {wxyz:?}");
    }

    #[test]
    fn what_is_no_rotation_is_refused_in_words() {
        let refused = |form: OrientationForm, cells: &[f64]| form.rotation(cells).unwrap_err();
        let quaternion = OrientationForm::QuaternionXyzw;
        assert_eq!(refused(quaternion, &[0.0, 0.0, 0.0, 0.9]), "a quaternion of length 0.9000");
        assert_eq!(refused(quaternion, &[0.0; 4]), "a quaternion of length 0.0000");
        let mirrored = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0];
        assert_eq!(refused(OrientationForm::Matrix, &mirrored), "a mirror image (its determinant is -1)");
        let skew = [1.0, 0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        assert!(refused(OrientationForm::Matrix, &skew).contains("RᵀR is off by 0.1"));
        assert!(refused(OrientationForm::Matrix, &[1e200; 9]).contains("off by inf"));
    }

    proptest! {
        #[test]
        fn rounded_matrices_become_the_rotation_they_were(parts in prop::array::uniform4(-1.0..1.0f64)) {
            let norm = parts.iter().fold(0.0, |norm: f64, part| norm.hypot(*part));
            prop_assume!(norm > 0.1);
            let exact = of_quaternion(parts.map(|part| part / norm)).unwrap();
            let rounded = entries(|i, j| (exact[i][j] * 1e3).round() / 1e3);
            let found = nearest(rounded).unwrap();
            prop_assert!(off_orthogonal(&found) < 1e-14 && determinant(&found) > 0.0);
            prop_assert!(distance(&found, &exact) < 1.5e-3);
        }
    }
}
