//! A basis of few numbers, for combinations that a person can read.

/// The sparsest easily found basis of the span of `vectors`: reduced row echelon form with complete pivoting.
///
/// Each result has a coefficient 1 that no other result shares; entries below `tolerance` times the largest are
/// zero. Dependent vectors drop out.
pub fn sparse_basis(vectors: &[Vec<f64>], tolerance: f64) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = vectors.to_vec();
    let largest = rows.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut done = 0;
    while done < rows.len() {
        let (pivot_row, pivot_column) = largest_entry(&rows[done..]);
        let pivot_row = pivot_row + done;
        if rows[pivot_row].get(pivot_column).is_none_or(|v| v.abs() <= tolerance * largest) {
            break;
        }
        rows.swap(done, pivot_row);
        let pivot = rows[done][pivot_column];
        rows[done].iter_mut().for_each(|v| *v /= pivot);
        let reference = rows[done].clone();
        for (index, row) in rows.iter_mut().enumerate() {
            if index != done {
                let factor = row[pivot_column];
                row.iter_mut().zip(&reference).for_each(|(v, r)| *v -= factor * r);
                row[pivot_column] = 0.0;
            }
        }
        done += 1;
    }
    rows.truncate(done);
    for row in &mut rows {
        let largest = row.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        row.iter_mut().filter(|v| v.abs() <= tolerance * largest).for_each(|v| *v = 0.0);
    }
    rows
}

fn largest_entry(rows: &[Vec<f64>]) -> (usize, usize) {
    let mut best = (0, 0, -1.0);
    for (i, row) in rows.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            // A tie goes to the first, up to rounding, so that the basis does not depend on the last digit.
            if value.abs() > best.2 * (1.0 + 1e-6) {
                best = (i, j, value.abs());
            }
        }
    }
    (best.0, best.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_basis_of_sparse_vectors_is_recovered_from_a_mixture() {
        let a = [1.0, 1.0, 1.0, 0.0, 0.0];
        let b = [0.0, 0.0, 0.0, 1.0, -0.5];
        let mix = |p: f64, q: f64| a.iter().zip(b).map(|(a, b)| p * a + q * b).collect::<Vec<f64>>();
        let basis = sparse_basis(&[mix(0.3, -0.7), mix(1.1, 0.2), mix(-2.0, 5.0)], 1e-9);
        assert_eq!(basis.len(), 2);
        for vector in &basis {
            let expected = if vector[0] == 0.0 { &b } else { &a };
            assert!(vector.iter().zip(expected).all(|(v, e)| (v - e).abs() < 1e-12), "{vector:?}");
        }
    }
}
