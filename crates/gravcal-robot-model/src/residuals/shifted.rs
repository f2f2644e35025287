//! Readings that are as if some parameters were others in this pose: errors in variables, and what friction leaves at rest.
//!
//! ```text
//!     y = h(…, o_j + a_j δ_j, …)
//! ```
//!
//! Around any residual that reads numbers `o_j`, with one more block `δ` and known scales `a_j`. With position offsets
//! and `a = 1` it is the deflection of joints that stand still, or the noise of their position readings (rad, m for a prismatic joint);
//! with torque biases and the side of approach it is friction that is left at rest; with first moments of links and the mass beyond a joint it is where the
//! joint sits. `δ` needs a prior, whose width says how large such
//! errors are. Because `δ_j` enters like `o_j`, values and derivatives are those of the inner residual at `o + a δ`. Of parameters
//! that the inner residual does not read, `δ` has no effect.

use std::array;
use std::cell::Cell;
use std::ops::Range;
use std::sync::Arc;

use gravcal_estimation::{
    Batched, BlockId, EvaluateError, LANES, LocalValues, Residual, RowsMut, Sample, evaluate_batch,
};

/// One shift of a residual's parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shift {
    /// The block that is shifted.
    pub block: BlockId,
    /// Which of its stored numbers is.
    pub entry: usize,
    /// So many times the shift's own component.
    pub scale: f64,
}

impl Shift {
    /// Of a block of one number.
    pub fn of_scalar(block: BlockId, scale: f64) -> Shift {
        Shift { block, entry: 0, scale }
    }
}

/// A residual some of whose parameters are shifted.
#[derive(Clone, Debug)]
pub struct Shifted {
    inner: Arc<dyn Residual>,
    blocks: Vec<BlockId>,
    /// First stored column of each block of `inner`, and their number.
    starts: Vec<usize>,
    /// Column of each shifted parameter, if it is read, and the scale of its shift.
    shifted: Vec<(Option<usize>, f64)>,
    /// What each row can touch.
    patterns: Vec<Vec<Range<usize>>>,
}

impl Shifted {
    /// `length`: how many numbers store a block; `shifted`: to what the components of `shift` are added, one after the other.
    pub fn new(inner: Arc<dyn Residual>, length: impl Fn(BlockId) -> usize, shifted: &[Shift], shift: BlockId) -> Self {
        Shifted::by_blocks(inner, length, shifted, &[shift])
    }

    /// The same where the components stand in several blocks, one behind the other.
    pub fn by_blocks(
        inner: Arc<dyn Residual>,
        length: impl Fn(BlockId) -> usize,
        shifted: &[Shift],
        shifts: &[BlockId],
    ) -> Self {
        let mut starts = vec![0];
        inner.blocks().iter().for_each(|id| starts.push(starts[starts.len() - 1] + length(*id)));
        let width = starts[starts.len() - 1];
        let column = |Shift { block, entry, .. }: &Shift| {
            Some(starts[inner.blocks().iter().position(|id| id == block)?] + entry)
        };
        let shifted: Vec<(Option<usize>, f64)> = shifted.iter().map(|shift| (column(shift), shift.scale)).collect();
        let columns = width..width + shifted.len();
        let patterns = (0..inner.len()).map(|row| extended(inner.row_pattern(row), width, columns.clone())).collect();
        let blocks = inner.blocks().iter().chain(shifts).copied().collect();
        Shifted { inner, blocks, starts, shifted, patterns }
    }

    fn width(&self) -> usize {
        self.starts[self.starts.len() - 1]
    }

    /// What the inner residual reads.
    fn shift(&self, x: &[f64], shifted: &mut Vec<f64>) {
        let (given, shifts) = x.split_at(self.width());
        shifted.clear();
        shifted.extend_from_slice(given);
        for ((column, scale), shift) in self.shifted.iter().zip(shifts) {
            column.iter().for_each(|column| shifted[*column] += scale * shift);
        }
    }

    /// Whether both shift the same columns, whatever the scales.
    fn shifts_as(&self, other: &Shifted) -> bool {
        let mut pairs = self.shifted.iter().zip(&other.shifted);
        self.starts == other.starts
            && self.shifted.len() == other.shifted.len()
            && pairs.all(|((column, _), (others, _))| column == others)
    }
}

/// The pattern of a row with the columns of the shifts behind it.
fn extended(pattern: Option<&[Range<usize>]>, width: usize, shifts: Range<usize>) -> Vec<Range<usize>> {
    let mut ranges = pattern.map_or_else(|| vec![Range { start: 0, end: width }], <[_]>::to_vec);
    ranges.push(shifts);
    ranges
}

impl Residual for Shifted {
    fn blocks(&self) -> &[BlockId] {
        &self.blocks
    }

    fn len(&self) -> usize {
        self.inner.len()
    }

    fn row_pattern(&self, row: usize) -> Option<&[Range<usize>]> {
        Some(&self.patterns[row])
    }

    fn work(&self) -> usize {
        self.inner.work()
    }

    fn evaluate(
        &self,
        x: LocalValues<'_>,
        residual: &mut [f64],
        jacobian: Option<RowsMut<'_>>,
    ) -> Result<(), EvaluateError> {
        let mut shifted = Vec::new();
        self.shift(x.as_slice(), &mut shifted);
        let shifted = LocalValues::new(&shifted, &self.starts);
        let Some(mut rows) = jacobian else {
            return self.inner.evaluate(shifted, residual, None);
        };
        let mut inner = vec![0.0; self.len() * self.width()];
        self.inner.evaluate(shifted, residual, Some(RowsMut::new(&mut inner, self.width())))?;
        for (index, inner) in inner.chunks_exact(self.width()).enumerate() {
            let (by_given, by_shifts) = rows.row(index).split_at_mut(inner.len());
            by_given.copy_from_slice(inner);
            by_shifts.iter_mut().zip(&self.shifted).for_each(|(entry, (column, scale))| {
                *entry = column.map_or(0.0, |column| scale * inner[column]);
            });
        }
        Ok(())
    }

    fn as_sample(&self) -> Option<Sample<'_>> {
        Some(Sample::of(self))
    }
}

impl Batched for Shifted {
    fn evaluate_batch(
        all: [&Shifted; LANES],
        x: [LocalValues<'_>; LANES],
        residual: &mut [[f64; LANES]],
        jacobian: Option<&mut [[f64; LANES]]>,
    ) -> bool {
        let first = all[0];
        if !all[1..].iter().all(|other| other.shifts_as(first)) {
            return false;
        }
        // Another residual of this kind may be within.
        let mut room = ROOM.take();
        for ((own, x), residual) in room.iter_mut().zip(x).zip(all) {
            residual.shift(x.as_slice(), own);
            own.extend_from_slice(&x.as_slice()[own.len()..]);
        }
        let [a, b, c, d] = &room;
        let shifted = [a, b, c, d].map(|own| LocalValues::new(own, &first.starts));
        let inner = all.map(|residual| &*residual.inner);
        let mut jacobian = jacobian;
        let done = evaluate_batch(inner, shifted, residual, jacobian.as_deref_mut());
        ROOM.set(room);
        for row in jacobian.into_iter().flat_map(|jacobian| jacobian.chunks_exact_mut(x[0].as_slice().len())) {
            let (by_given, by_shifts) = row.split_at_mut(first.width());
            for (index, entry) in by_shifts[..first.shifted.len()].iter_mut().enumerate() {
                let scaled = |column: usize| array::from_fn(|lane| all[lane].shifted[index].1 * by_given[column][lane]);
                *entry = first.shifted[index].0.map_or([0.0; LANES], scaled);
            }
        }
        done
    }
}

thread_local! {
    /// What the inner residuals read, kept by each thread from one evaluation to the next.
    static ROOM: Cell<[Vec<f64>; LANES]> = Cell::default();
}

#[cfg(test)]
mod tests {
    use super::super::pose_torque::tests::loaded;
    use super::*;
    use crate::residuals::testing::{check_at_random_points, ids};

    /// The offsets of the first and the last joint are shifted, the last one by twice as much the other way, and the second number of the first
    /// link's moment.
    fn with_shifts() -> (Shifted, Vec<usize>) {
        let (pose, mut lengths) = loaded(&[0, 1, 2]);
        lengths.push(3);
        let ids = ids(&lengths);
        let moment = Shift { block: ids[13], entry: 2, scale: 0.7 };
        let shifts = [Shift::of_scalar(ids[4], 1.0), Shift::of_scalar(ids[12], -2.0), moment];
        let shift = ids[lengths.len() - 1];
        (Shifted::new(Arc::new(pose), |id| lengths[id.index()], &shifts, shift), lengths)
    }

    #[test]
    fn derivatives() {
        let (residual, lengths) = with_shifts();
        check_at_random_points(&residual, &lengths, &vec![0.5; lengths.iter().sum()]);
    }

    #[test]
    fn a_shift_acts_like_another_number() {
        let (residual, _) = with_shifts();
        let width = residual.width();
        let mut x: Vec<f64> = (0..width + 3).map(|k| 1.0 + (k as f64).sin()).collect();
        let starts: Vec<usize> = residual.starts.iter().copied().chain([width + 3]).collect();
        let (mut with, mut without) = ([0.0; 3], [0.0; 3]);
        residual.evaluate(LocalValues::new(&x, &starts), &mut with, None).unwrap();
        // 3 of gravity, then all k, b, s, o, then mass and moment of each link.
        (x[12], x[14], x[17]) = (x[12] + x[width], x[14] - 2.0 * x[width + 1], x[17] + 0.7 * x[width + 2]);
        let inner = LocalValues::new(&x[..width], &residual.starts);
        residual.inner.evaluate(inner, &mut without, None).unwrap();
        assert_eq!(with, without);
    }

    /// Shifted torque readings of one model with another shift each, by another scale.
    #[test]
    fn shifted_poses_are_evaluated_in_batch_to_the_bits_that_each_has_alone() {
        let (pose, mut lengths) = loaded(&[0, 1, 2]);
        lengths.push(2);
        let ids = ids(&lengths);
        let inner: Arc<dyn Residual> = Arc::new(pose);
        // An offset and a bias.
        let shifted = |scale: f64| {
            let shifted = [Shift::of_scalar(ids[4 + 2 * 3], 1.0), Shift::of_scalar(ids[4], scale)];
            Shifted::new(Arc::clone(&inner), |id| lengths[id.index()], &shifted, ids[lengths.len() - 1])
        };
        let all = [1.0, -2.0, 0.5, 3.0].map(shifted);
        let starts: Vec<usize> = std::iter::once(0)
            .chain(lengths.iter().scan(0, |end, n| {
                *end += n;
                Some(*end)
            }))
            .collect();
        let width = starts[starts.len() - 1];
        let x = [0.1, -0.2, 0.3, 0.0].map(|shift| {
            let mut x: Vec<f64> = (0..width).map(|k| 1.0 + (k as f64).sin()).collect();
            x[width - 2..].copy_from_slice(&[shift, 2.0 * shift]);
            x
        });
        let x = [0, 1, 2, 3].map(|lane: usize| LocalValues::new(&x[lane], &starts));
        let (mut together, mut jacobian) = (vec![[f64::NAN; LANES]; 3], vec![[0.0; LANES]; 3 * width]);
        let done = Shifted::evaluate_batch(all.each_ref(), x, &mut together, Some(&mut jacobian));
        // It is not where the processor has no vector instructions of so many lanes.
        let alone = evaluate_batch(
            [&*inner; LANES],
            [LocalValues::new(&x[0].as_slice()[..width - 2], &starts[..starts.len() - 1]); LANES],
            &mut together.clone(),
            None,
        );
        assert_eq!(done, alone);
        for lane in (0..LANES).filter(|_| done) {
            let (mut residual, mut entries) = ([0.0; 3], vec![0.0; 3 * width]);
            all[lane].evaluate(x[lane], &mut residual, Some(RowsMut::new(&mut entries, width))).unwrap();
            assert_eq!(together.iter().map(|lanes| lanes[lane]).collect::<Vec<_>>(), residual);
            assert_eq!(jacobian.iter().map(|lanes| lanes[lane]).collect::<Vec<_>>(), entries);
        }
    }
}
