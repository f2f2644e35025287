//! Whether nothing can be named, without the tests themselves.

use gravcal_estimation::statistics::ResidualMaker;

use super::bound::{Bound, Sums};
use super::candidate::{Candidate, SIGNIFICANCE};
use super::drift::{combined, drift_of_joint};
use super::neighbours::Neighbours;
use super::rows::Rows;
use super::search::Search;

impl Search<'_> {
    /// Whether nothing can be named, as sums over channels tell ([`super::bound`]). Tests that need no columns are made. A p-value counts as often as
    /// there are such tests, and twice where it is of all joints, if not more often: see [`weights`]. Of trends any may be left out.
    pub fn names_nothing(
        &self,
        maker: &ResidualMaker,
        rows: &Rows,
        neighbours: &[Option<Neighbours>],
        candidates: &[Candidate],
    ) -> bool {
        // Under a loss rows count by weights of which the sums know nothing.
        if !maker.is_shared_alone() || rows.are_weighted() {
            return false;
        }
        let sums = Sums::of(maker, rows);
        let (mut own, mut together, mut trends, mut made) = (f64::INFINITY, f64::INFINITY, Vec::new(), 0);
        for candidate in candidates {
            let columns = self.columns_of(candidate);
            let least = match columns.is_empty() {
                true => self.test(maker, rows, neighbours, candidate, &[]).map(|tested| tested.test.p_value),
                false => match sums.bound(maker, rows, &columns) {
                    Bound::InModel => None,
                    Bound::Least(p) => Some(p),
                    Bound::Open => return false,
                },
            };
            let Some(least) = least else { continue };
            made += usize::from(columns.is_empty());
            trends.extend(drift_of_joint(candidate, self.session.joints.len()).map(|_| least));
            match candidate {
                Candidate::OfArm(term) if term.is_of_description() => own = own.min(least),
                Candidate::Together(_) | Candidate::OfArm(_) => together = together.min(least),
                _ => own = own.min(least),
            }
        }
        trends.sort_by(f64::total_cmp);
        let of_trends = (2..=trends.len()).map(|count| combined(trends[..count].iter().copied()));
        let together = of_trends.map(|tested| tested.map_or(0.0, |(_, _, p)| p)).fold(together, f64::min);
        made as f64 * own >= SIGNIFICANCE && 2.0 * together >= SIGNIFICANCE
    }
}
