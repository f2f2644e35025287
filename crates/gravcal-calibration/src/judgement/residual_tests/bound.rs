//! How small a term's p-value can be, from sums over channels alone: whether it need be tested at all.
//!
//! With `U` the basis of what the fit spans and a term's columns `Z`, all that the test of [`super::score`] asks of `W = M Z` follows from
//! sums over the rows of each channel `c`, without any column of all rows. With `P_c = U_cᵀ Z_c` and `P = Σ P_c`
//!
//! ```text
//!     W_cᵀ W_c = Z_cᵀ Z_c − P_cᵀ P − Pᵀ P_c + Pᵀ U_cᵀ U_c P,      W_cᵀ r_c = Z_cᵀ r_c − Pᵀ U_cᵀ r_c
//! ```
//!
//! A test in blocks of neighbours only makes the p-value larger. These sums lose digits where the fit explains most of a term: what comes
//! near any limit is left to the test itself.

use gravcal_estimation::statistics::ResidualMaker;
use nalgebra::{DMatrix, DVector};

use super::rows::Rows;
use super::score::{EXPLAINED, Scatter, dot};

/// Digits of a p-value that the sums keep at least.
const DIGITS: f64 = 1e-6;

/// Sums of a fit, by owner of rows.
pub struct Sums {
    /// `U_cᵀ U_c`.
    basis: Vec<DMatrix<f64>>,
    /// `U_cᵀ r_c`.
    along: Vec<DVector<f64>>,
    /// `r_cᵀ r_c`.
    squares: Vec<f64>,
}

/// What the sums tell of a term.
pub enum Bound {
    /// The model has it already.
    InModel,
    /// The p-value is no smaller.
    Least(f64),
    /// Nothing: it has to be tested.
    Open,
}

impl Sums {
    pub fn of(maker: &ResidualMaker, rows: &Rows) -> Sums {
        let (rank, owners) = (maker.rank(), rows.owners());
        let mut basis = vec![vec![0.0; rank * rank]; owners];
        let mut along = vec![vec![0.0; rank]; owners];
        let mut squares = vec![0.0; owners];
        for (row, r) in maker.residuals().iter().enumerate() {
            let (owner, u) = (rows.owner(row), maker.shared_of(row));
            for (place, sums) in basis[owner].chunks_exact_mut(rank).enumerate() {
                add(&mut sums[place..], u[place], &u[place..]);
            }
            add(&mut along[owner], *r, u);
            squares[owner] += rows.count(row) * r * r;
        }
        let whole = |sums: Vec<f64>| {
            let mut basis = DMatrix::from_vec(rank, rank, sums);
            basis.fill_upper_triangle_with_lower_triangle();
            basis
        };
        let (basis, along) = (basis.into_iter().map(whole), along.into_iter().map(DVector::from_vec));
        Sums { basis: basis.collect(), along: along.collect(), squares }
    }

    /// Of the p-value of a term with these columns.
    pub fn bound(&self, maker: &ResidualMaker, rows: &Rows, columns: &[Vec<f64>]) -> Bound {
        let (owners, rank, count) = (rows.owners(), maker.rank(), columns.len());
        let lengths: Vec<f64> = columns.iter().map(|z| dot(z, z).sqrt()).collect();
        if lengths.iter().any(|length| !length.is_finite()) {
            return Bound::Open;
        }
        let mut own = vec![DMatrix::zeros(count, count); owners];
        let mut shared = vec![vec![0.0; rank * count]; owners];
        let mut read = vec![DVector::zeros(count); owners];
        let of_unit_length = |(column, length): (&Vec<f64>, &f64)| -> Vec<f64> {
            column.iter().map(|z| if *z == 0.0 { 0.0 } else { z / length }).collect()
        };
        let columns: Vec<Vec<f64>> = columns.iter().zip(&lengths).map(of_unit_length).collect();
        for (place, column) in columns.iter().enumerate() {
            for (row, z) in column.iter().enumerate().filter(|(_, z)| **z != 0.0) {
                let owner = rows.owner(row);
                add(&mut shared[owner][rank * place..rank * (place + 1)], *z, maker.shared_of(row));
                read[owner][place] += z * maker.residuals()[row];
                for (other, column) in columns[..=place].iter().enumerate() {
                    own[owner][(place, other)] += z * column[row];
                }
            }
        }
        let shared: Vec<DMatrix<f64>> = shared.into_iter().map(|sums| DMatrix::from_vec(rank, count, sums)).collect();
        let whole: DMatrix<f64> = shared.iter().sum();
        for owner in 0..owners {
            own[owner].fill_upper_triangle_with_lower_triangle();
            let both = whole.tr_mul(&shared[owner]);
            own[owner] += whole.tr_mul(&(&self.basis[owner] * &whole)) - &both - both.transpose();
            read[owner] -= whole.tr_mul(&self.along[owner]);
        }
        let Some(terms) = orthonormal(&own.iter().sum()) else { return Bound::Open };
        if terms.ncols() == 0 {
            return Bound::InModel;
        }
        let parts: Vec<DMatrix<f64>> = own.iter().map(|part| terms.tr_mul(&(part * &terms))).collect();
        let read: Vec<DVector<f64>> = read.iter().map(|read| terms.tr_mul(read)).collect();
        let along: DVector<f64> = read.iter().sum();
        let left = |((square, part), read): ((&f64, &DMatrix<f64>), &DVector<f64>)| {
            square - 2.0 * along.dot(read) + along.dot(&(part * &along))
        };
        let squares: Vec<f64> = self.squares.iter().zip(&parts).zip(&read).map(left).collect();
        let spent: Vec<f64> = parts.iter().map(DMatrix::trace).collect();
        let tested = Scatter::of(rows, parts, &spent, &squares).and_then(|scatter| scatter.test(&along));
        tested.map_or(Bound::Open, |(_, _, p)| Bound::Least(p * (1.0 - DIGITS)))
    }
}

/// Adds a multiple of some numbers to sums.
fn add(sums: &mut [f64], factor: f64, to: &[f64]) {
    sums.iter_mut().zip(to).for_each(|(sum, number)| *sum += factor * number);
}

/// Columns that make terms of these products perpendicular to each other and of unit length, those left out that others make superfluous;
/// nothing where one is all but superfluous.
fn orthonormal(products: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut terms: Vec<DVector<f64>> = Vec::new();
    for place in 0..products.ncols() {
        let mut term = DVector::zeros(products.ncols());
        term[place] = 1.0;
        let left = products[(place, place)];
        for known in &terms {
            let share = known.dot(&products.column(place));
            term -= known * share;
        }
        let square = term.dot(&(products * &term));
        if [left, square].iter().any(|square| (0.5 * EXPLAINED..2.0 * EXPLAINED).contains(square)) {
            return None;
        }
        if left > EXPLAINED && square > EXPLAINED {
            terms.push(term / square.sqrt());
        }
    }
    Some(DMatrix::from_fn(products.ncols(), terms.len(), |row, term| terms[term][row]))
}
