//! Where consecutive runs start.

/// Starts of consecutive runs of the given lengths, and the total at the end.
pub(super) fn offsets(lengths: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut total = 0;
    let ends = lengths.map(|length| {
        total += length;
        total
    });
    std::iter::once(0).chain(ends).collect()
}
