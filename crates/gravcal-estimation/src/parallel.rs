//! Pieces of work that know nothing of each other, on all threads: replicates, starts, profiles.

use rayon::prelude::*;

/// What becomes of each piece, in their order: the same on any number of threads.
pub fn in_parallel<Piece: Send, Outcome: Send>(
    pieces: impl IntoIterator<Item = Piece>,
    work: impl Fn(Piece) -> Outcome + Sync + Send,
) -> Vec<Outcome> {
    pieces.into_iter().collect::<Vec<_>>().into_par_iter().map(work).collect()
}

#[cfg(test)]
mod tests {
    use super::in_parallel;

    #[test]
    fn outcomes_stand_in_the_order_of_their_pieces() {
        assert_eq!(
            in_parallel(0..1000_usize, |piece| piece * piece),
            (0..1000).map(|piece| piece * piece).collect::<Vec<_>>()
        );
    }
}
