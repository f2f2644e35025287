//! Components that look alike: their factors have the same shapes in the same order, and read the same of the component's columns in the
//! same places. They differ by numbers only, so that some of them are batched.

use std::collections::HashMap;

use super::structure::{Piece, RowPlan, Shape};

/// Most rows with shared columns of a component that is eliminated by reweighing them: the effort grows with the cube of their number.
const MOST_MIXED: usize = 32;

/// What components of one kind have in common.
#[derive(Clone, Debug)]
pub(crate) struct Kind {
    /// Number of eliminated columns.
    pub eliminated: usize,
    /// One a factor.
    pub slots: Vec<Slot>,
    /// Shared columns that its rows touch, in an order in which each mixed row touches some of the first ones.
    pub columns: Vec<usize>,
    /// How many of these the mixed rows up to each one touch.
    pub widths: Vec<usize>,
    /// Whether rows of eliminated columns alone may determine these, so that mixed rows can be reweighed (`linearization/normal/alike.rs`).
    pub reweighed: bool,
}

/// A factor of a component.
#[derive(Clone, Debug)]
pub(crate) struct Slot {
    /// Stored columns of eliminated blocks, and which of the component's they are.
    pub own: Vec<(usize, usize)>,
    pub rows: Vec<RowPlace>,
}

/// Where a row goes.
#[derive(Clone, Debug)]
pub(crate) enum RowPlace {
    /// It touches shared columns: which of the mixed rows it is, and where its columns go.
    Mixed { index: usize, runs: Vec<Run> },
    /// It touches eliminated columns alone.
    Own,
}

/// Columns that stay together.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub piece: Piece,
    /// First of them among [`Kind::columns`].
    pub place: usize,
}

/// What tells one kind from another.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(super) struct Slots {
    pub columns: usize,
    pub factors: Vec<FactorSlot>,
}

/// A factor, by its shape.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(super) struct FactorSlot {
    pub shape: usize,
    /// Its eliminated blocks; nothing for one that is fixed.
    pub blocks: Vec<Option<EliminatedBlock>>,
}

/// An eliminated block within its component.
#[derive(Debug, PartialEq, Eq, Hash)]
pub(super) struct EliminatedBlock {
    /// Its first column.
    pub first: usize,
    /// Whether its columns are its stored ones.
    pub flat: bool,
}

/// All kinds so far.
#[derive(Default)]
pub(super) struct Kinds {
    pub all: Vec<Kind>,
    known: HashMap<Slots, usize>,
}

impl Kinds {
    /// The place of this kind among all, a new one if need be.
    pub fn find(&mut self, slots: Slots, shapes: &[Shape]) -> usize {
        if let Some(known) = self.known.get(&slots) {
            return *known;
        }
        self.all.push(Kind::new(&slots, shapes));
        self.known.insert(slots, self.all.len() - 1);
        self.all.len() - 1
    }
}

impl Kind {
    fn new(slots: &Slots, shapes: &[Shape]) -> Kind {
        let rows = slots.factors.iter().enumerate();
        let rows = rows.flat_map(|(slot, factor)| (0..shapes[factor.shape].rows.len()).map(move |row| (slot, row)));
        let touched = |(slot, row): (usize, usize)| &shapes[slots.factors[slot].shape].rows[row].columns;
        let (mut mixed, own): (Vec<_>, Vec<_>) = rows.partition(|row| !touched(*row).is_empty());
        // Few columns first: the rows that are made of the first ones stay short.
        mixed.sort_by_key(|row| touched(*row).len());
        let (mut columns, mut widths) = (Vec::new(), Vec::new());
        for row in &mixed {
            let new: Vec<usize> = touched(*row).iter().copied().filter(|column| !columns.contains(column)).collect();
            columns.extend(new);
            widths.push(columns.len());
        }
        let row_place = |(slot, row): (usize, usize)| match mixed.iter().position(|other| *other == (slot, row)) {
            Some(index) => {
                RowPlace::Mixed { index, runs: runs(&shapes[slots.factors[slot].shape].rows[row], &columns) }
            }
            None => RowPlace::Own,
        };
        let slot = |(slot, FactorSlot { shape, blocks }): (usize, &FactorSlot)| {
            let shape = &shapes[*shape];
            let of_block = |(at, block): (&usize, &Option<EliminatedBlock>)| {
                let stored = shape.local_offsets[*at]..shape.local_offsets[at + 1];
                block.as_ref().map(|block| stored.zip(block.first..)).into_iter().flatten()
            };
            let own = shape.eliminated_blocks.iter().zip(blocks).flat_map(of_block).collect();
            Slot { own, rows: (0..shape.rows.len()).map(|row| row_place((slot, row))).collect() }
        };
        let all = slots.factors.iter().flat_map(|factor| &factor.blocks);
        let flat = all.flatten().all(|block| block.flat);
        Kind {
            eliminated: slots.columns,
            slots: slots.factors.iter().enumerate().map(slot).collect(),
            reweighed: flat && own.len() >= slots.columns && (1..=MOST_MIXED).contains(&mixed.len()),
            columns,
            widths,
        }
    }
}

/// The pieces of a row, cut where their columns do not follow each other in `order`. All columns of a block on a manifold do: no row touches
/// some alone.
fn runs(plan: &RowPlan, order: &[usize]) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut columns = plan.columns.iter();
    for piece in &plan.pieces {
        for (index, column) in columns.by_ref().take(piece.length).enumerate() {
            let Some(place) = order.iter().position(|known| known == column) else { continue };
            match runs.last_mut() {
                Some(run) if index > 0 && run.place + run.piece.length == place => run.piece.length += 1,
                _ => {
                    let piece = Piece { from: piece.from + index, length: 1, curved: piece.curved };
                    runs.push(Run { piece, place });
                }
            }
        }
    }
    runs
}
