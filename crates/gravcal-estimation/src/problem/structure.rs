//! How a problem is laid out for linearization: which columns belong to whom, which factors look alike, in which order
//! and in which chunks they are summed. Found once, when the problem is built.
//!
//! *Shared* columns are those of blocks not marked [`eliminated`](crate::Block::eliminated). Eliminated blocks that meet in a factor
//! form a *connected component*; components meet only through shared columns, so each can be eliminated by itself. Factors of the same
//! *shape* read the same shared blocks in the same places, so that each of their rows has the same compact columns.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use super::kinds::{EliminatedBlock, FactorSlot, Kind, Kinds, Slots};
use super::offsets::offsets;
use crate::{Block, BlockId, Factor, Noise};

/// Least [work](crate::Residual::work) that is worth a chunk of its own.
const WORK_PER_CHUNK: usize = 512;
/// Most chunks: each holds a Hessian of its own while the sums run.
const MAX_CHUNKS: usize = 64;
/// Most numbers in the Hessians of all chunks together.
const MAX_CHUNK_NUMBERS: usize = 1 << 24;

/// Where a column is solved for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// Among the shared columns.
    Shared(usize),
    /// Within a component.
    Component { component: usize, index: usize },
}

/// Blocks that are eliminated together.
#[derive(Clone, Debug)]
pub(crate) struct Component {
    /// Its own columns.
    pub columns: Vec<usize>,
    /// The shared columns (as indices among them) that its factors touch, ascending.
    pub shared: Arc<[usize]>,
    /// Place among [`Structure::kinds`] of what it is like.
    pub kind: usize,
    /// Its factors, as a range of [`Structure::order`].
    pub factors: Range<usize>,
}

/// Consecutive work whose sums are kept apart, so that chunks can run on any thread.
#[derive(Clone, Debug)]
pub(crate) struct Chunk {
    /// Range of [`Structure::order`].
    pub factors: Range<usize>,
    /// The components among them; factors before the first component's belong to none.
    pub components: Range<usize>,
}

/// What factors of one shape have in common.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    /// Start of each block among the local stored columns, and their number.
    pub local_offsets: Vec<usize>,
    /// Places of eliminated blocks among those read, which differ from factor to factor.
    pub eliminated_blocks: Vec<usize>,
    /// Those of them that are on a manifold.
    pub eliminated_curved: Vec<usize>,
    /// Whether the noise is correlated, so that whitening mixes rows.
    pub correlated: bool,
    /// Whether each row has a pattern, all of whose entries are written.
    pub patterned: bool,
    /// One a row.
    pub rows: Vec<RowPlan>,
    /// The different lists of columns that its rows have.
    pub columns: Vec<Vec<usize>>,
}

/// How the shared columns of one row are picked from the local stored ones.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowPlan {
    /// What is copied.
    pub pieces: Vec<Piece>,
    /// Index among the shared columns of each compact column, ascending.
    pub columns: Vec<usize>,
    /// Place of these columns among [`Shape::columns`].
    pub place: usize,
}

/// A run of columns.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    /// First local stored column.
    pub from: usize,
    /// Number of compact columns.
    pub length: usize,
    /// Place among [`Structure::curved`] of its block, if that is on a manifold: its stored columns become tangent ones.
    pub curved: Option<usize>,
}

#[derive(Clone, Debug)]
pub(crate) struct Structure {
    /// The shared columns.
    pub shared: Vec<usize>,
    /// Place of each column.
    pub places: Vec<Place>,
    /// Shared blocks that are on a manifold, ascending.
    pub curved: Vec<BlockId>,
    pub shapes: Vec<Shape>,
    /// Shape of each factor.
    pub shape_of: Vec<usize>,
    /// One kind after another.
    pub components: Vec<Component>,
    pub kinds: Vec<Kind>,
    /// Factors in the order in which they are summed: those without eliminated blocks first, then component by component.
    pub order: Vec<usize>,
    pub chunks: Vec<Chunk>,
}

impl Structure {
    pub fn new(blocks: &[Block], factors: &[Factor], column_offsets: &[usize]) -> Self {
        let curved = blocks.iter().enumerate().filter(|(_, block)| !block.eliminated && !block.is_euclidean());
        let curved: Vec<BlockId> = curved.map(|(index, _)| BlockId(index as u32)).collect();
        let layout = Layout { blocks, factors, column_offsets, curved: &curved };
        let (shared, mut places) = layout.shared_columns();
        let (shapes, shape_of) = layout.shapes(&places);
        let (mut components, kinds, order) = layout.components(&shapes, &shape_of);
        for (index, component) in components.iter().enumerate() {
            for (inside, column) in component.columns.iter().enumerate() {
                places[*column] = Place::Component { component: index, index: inside };
            }
        }
        note_shared(&mut components, &order, &shapes, &shape_of);
        let work: Vec<usize> = order.iter().map(|factor| factors[*factor].residual.work().max(1)).collect();
        let chunks = cut(&work, &components, shared.len());
        Structure { shared, places, curved, shapes, shape_of, components, kinds, order, chunks }
    }

    /// Those factors of a chunk that belong to no component.
    pub fn free_factors(&self, chunk: &Chunk) -> &[usize] {
        let first = self.components[chunk.components.clone()].first();
        &self.order[chunk.factors.start..first.map_or(chunk.factors.end, |first| first.factors.start)]
    }

    /// The first factor of each shape.
    pub fn first_of_shapes(&self) -> impl Iterator<Item = usize> {
        (0..self.shapes.len()).filter_map(|shape| self.shape_of.iter().position(|of| *of == shape))
    }
}

/// The parts of a problem that its structure follows from.
struct Layout<'a> {
    blocks: &'a [Block],
    factors: &'a [Factor],
    column_offsets: &'a [usize],
    curved: &'a [BlockId],
}

impl Layout<'_> {
    fn is_eliminated(&self, id: BlockId) -> bool {
        self.blocks[id.index()].eliminated
    }

    fn columns_of(&self, id: BlockId) -> Range<usize> {
        self.column_offsets[id.index()]..self.column_offsets[id.index() + 1]
    }

    /// Columns of blocks that are not eliminated, and by column the place among them (components are filled in later).
    fn shared_columns(&self) -> (Vec<usize>, Vec<Place>) {
        let mut shared = Vec::new();
        let mut places = Vec::new();
        for (index, block) in self.blocks.iter().enumerate() {
            for column in self.columns_of(BlockId(index as u32)) {
                places.push(Place::Shared(shared.len()));
                if !block.eliminated {
                    shared.push(column);
                }
            }
        }
        (shared, places)
    }

    /// The different shapes, and the shape of each factor.
    fn shapes(&self, places: &[Place]) -> (Vec<Shape>, Vec<usize>) {
        let mut shapes: Vec<Shape> = Vec::new();
        let mut first: Vec<usize> = Vec::new();
        let mut known: HashMap<(usize, Vec<BlockId>), Vec<usize>> = HashMap::new();
        let mut shape_of: Vec<usize> = Vec::with_capacity(self.factors.len());
        for factor in 0..self.factors.len() {
            // Poses of one kind follow each other: most often it is the last one's shape.
            if let Some(last) = shape_of.last()
                && self.alike(first[*last], factor)
            {
                shape_of.push(*last);
                continue;
            }
            let residual = &self.factors[factor].residual;
            let shared = residual.blocks().iter().copied().filter(|id| !self.is_eliminated(*id)).collect();
            let candidates = known.entry((residual.len(), shared)).or_default();
            let shape = candidates.iter().copied().find(|shape| self.alike(first[*shape], factor));
            shape_of.push(shape.unwrap_or_else(|| {
                candidates.push(shapes.len());
                first.push(factor);
                shapes.push(self.shape(factor, places));
                shapes.len() - 1
            }));
        }
        (shapes, shape_of)
    }

    /// Whether two factors have the same shape.
    fn alike(&self, a: usize, b: usize) -> bool {
        let (fa, fb) = (&self.factors[a], &self.factors[b]);
        let (ra, rb) = (&fa.residual, &fb.residual);
        let same_block = |(x, y): (&BlockId, &BlockId)| {
            let (bx, by) = (&self.blocks[x.index()], &self.blocks[y.index()]);
            let same_size = bx.len() == by.len() && bx.is_euclidean() == by.is_euclidean();
            x == y || (bx.eliminated && by.eliminated && same_size)
        };
        let same_blocks =
            || ra.blocks().len() == rb.blocks().len() && ra.blocks().iter().zip(rb.blocks()).all(same_block);
        let same_pattern = |row: usize| match (ra.row_pattern(row), rb.row_pattern(row)) {
            (Some(a), Some(b)) => std::ptr::eq(a, b) || a == b,
            (a, b) => a == b,
        };
        // Residuals that share a model have the very same lists.
        ra.len() == rb.len()
            && (std::ptr::eq(ra.blocks(), rb.blocks()) || same_blocks())
            && is_correlated(fa) == is_correlated(fb)
            && (0..ra.len()).all(same_pattern)
    }

    fn shape(&self, factor: usize, places: &[Place]) -> Shape {
        let residual = &self.factors[factor].residual;
        let local_offsets = offsets(residual.blocks().iter().map(|id| self.blocks[id.index()].len()));
        let everything = 0..local_offsets[local_offsets.len() - 1];
        let mut rows: Vec<RowPlan> = (0..residual.len())
            .map(|row| {
                // Whitening of correlated rows mixes them: each touches all columns then.
                let pattern = residual.row_pattern(row).filter(|_| !is_correlated(&self.factors[factor]));
                self.row_plan(
                    residual.blocks(),
                    &local_offsets,
                    pattern.unwrap_or(std::slice::from_ref(&everything)),
                    places,
                )
            })
            .collect();
        let block = |at: &usize| &self.blocks[residual.blocks()[*at].index()];
        let eliminated_blocks: Vec<usize> = (0..residual.blocks().len()).filter(|at| block(at).eliminated).collect();
        let eliminated_curved = eliminated_blocks.iter().copied().filter(|at| !block(at).is_euclidean()).collect();
        let correlated = is_correlated(&self.factors[factor]);
        let patterned = !correlated && (0..residual.len()).all(|row| residual.row_pattern(row).is_some());
        let mut columns: Vec<Vec<usize>> = Vec::new();
        for row in &mut rows {
            row.place = columns.iter().position(|known| *known == row.columns).unwrap_or(columns.len());
            if row.place == columns.len() {
                columns.push(row.columns.clone());
            }
        }
        Shape { local_offsets, eliminated_blocks, eliminated_curved, correlated, patterned, rows, columns }
    }

    fn row_plan(&self, ids: &[BlockId], offsets: &[usize], pattern: &[Range<usize>], places: &[Place]) -> RowPlan {
        let mut runs: Vec<(usize, Piece)> = Vec::with_capacity(ids.len());
        for (place, id) in ids.iter().enumerate().filter(|(_, id)| !self.is_eliminated(**id)) {
            let columns = self.columns_of(*id);
            let Some(Place::Shared(first)) = columns.clone().next().map(|column| places[column]) else { continue };
            let stored = offsets[place]..offsets[place + 1];
            let touched = pattern.iter().map(|range| range.start.max(stored.start)..range.end.min(stored.end));
            for range in touched.filter(|range| !range.is_empty()) {
                runs.push(match self.curved.binary_search(id) {
                    Err(_) => {
                        let piece = Piece { from: range.start, length: range.len(), curved: None };
                        (first + range.start - stored.start, piece)
                    }
                    Ok(curved) => (first, Piece { from: stored.start, length: columns.len(), curved: Some(curved) }),
                });
            }
        }
        runs.sort_by_key(|(to, _)| *to);
        runs.dedup_by_key(|(to, _)| *to); // a block on a manifold that several ranges touch
        let columns = runs.iter().flat_map(|(to, piece)| *to..to + piece.length).collect();
        RowPlan { pieces: join(runs), columns, place: 0 }
    }

    /// Components of eliminated blocks, what they are like, and the factors in order.
    fn components(&self, shapes: &[Shape], shape_of: &[usize]) -> (Vec<Component>, Vec<Kind>, Vec<usize>) {
        if !self.blocks.iter().any(|block| block.eliminated) {
            return (Vec::new(), Vec::new(), in_order_of_shapes((0..self.factors.len()).collect(), shape_of));
        }
        let free_eliminated = |id: &BlockId| self.is_eliminated(*id) && !self.columns_of(*id).is_empty();
        let mut roots = Roots((0..self.blocks.len()).collect());
        for factor in self.factors {
            let mut eliminated = factor.residual.blocks().iter().filter(|id| free_eliminated(id));
            if let Some(first) = eliminated.next() {
                eliminated.for_each(|other| roots.unite(first.index(), other.index()));
            }
        }
        let mut number: HashMap<usize, usize> = HashMap::new();
        let mut components: Vec<(Vec<usize>, Vec<usize>)> = Vec::new();
        for id in (0..self.blocks.len() as u32).map(BlockId).filter(free_eliminated) {
            let component = *number.entry(roots.find(id.index())).or_insert_with(|| {
                components.push(Default::default());
                components.len() - 1
            });
            components[component].0.extend(self.columns_of(id));
        }
        let mut order = Vec::with_capacity(self.factors.len());
        for (index, factor) in self.factors.iter().enumerate() {
            match factor.residual.blocks().iter().find(|id| free_eliminated(id)) {
                Some(id) => components[number[&roots.find(id.index())]].1.push(index),
                None => order.push(index),
            }
        }
        let mut order = in_order_of_shapes(order, shape_of);
        let mut kinds = Kinds::default();
        let mut kind_of =
            |columns: &[usize], factors: &[usize]| kinds.find(self.slots(columns, factors, shape_of), shapes);
        let with_kind = |(columns, factors): (Vec<usize>, Vec<usize>)| (kind_of(&columns, &factors), columns, factors);
        let mut components: Vec<_> = components.into_iter().map(with_kind).collect();
        components.sort_by_key(|(kind, ..)| *kind);
        let components = components
            .into_iter()
            .map(|(kind, columns, factors)| {
                let start = order.len();
                order.extend(factors);
                Component { columns, shared: Arc::from([]), kind, factors: start..order.len() }
            })
            .collect();
        (components, kinds.all, order)
    }

    /// The factors of a component by their shapes, and where their eliminated columns are among the component's.
    fn slots(&self, columns: &[usize], factors: &[usize], shape_of: &[usize]) -> Slots {
        let slot = |factor: &usize| {
            let blocks = self.factors[*factor].residual.blocks();
            let own = blocks.iter().filter(|id| self.is_eliminated(**id));
            let place = |id: &BlockId| {
                let first = self.columns_of(*id).next()?;
                let flat = self.blocks[id.index()].is_euclidean();
                Some(EliminatedBlock { first: columns.iter().position(|column| *column == first)?, flat })
            };
            FactorSlot { shape: shape_of[*factor], blocks: own.map(place).collect() }
        };
        Slots { columns: columns.len(), factors: factors.iter().map(slot).collect() }
    }
}

/// One shape after another, within each in the order of addition.
fn in_order_of_shapes(mut factors: Vec<usize>, shape_of: &[usize]) -> Vec<usize> {
    factors.sort_by_key(|factor| shape_of[*factor]);
    factors
}

fn is_correlated(factor: &Factor) -> bool {
    matches!(factor.noise, Noise::Correlated(_))
}

/// Runs that continue each other become one.
fn join(runs: Vec<(usize, Piece)>) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::with_capacity(runs.len());
    for (_, piece) in runs {
        match pieces.last_mut() {
            Some(last) if last.curved.is_none() && piece.curved.is_none() && last.from + last.length == piece.from => {
                last.length += piece.length;
            }
            _ => pieces.push(piece),
        }
    }
    pieces
}

/// Notes the shared columns that each component's factors touch; equal lists are kept once.
fn note_shared(components: &mut [Component], order: &[usize], shapes: &[Shape], shape_of: &[usize]) {
    let mut known: HashMap<Vec<usize>, Arc<[usize]>> = HashMap::new();
    for component in components {
        let mut of_component: Vec<usize> =
            order[component.factors.clone()].iter().map(|factor| shape_of[*factor]).collect();
        of_component.sort_unstable();
        of_component.dedup();
        let shared = known.entry(of_component).or_insert_with_key(|of_component| {
            let rows = of_component.iter().flat_map(|shape| &shapes[*shape].rows);
            let mut columns: Vec<usize> = rows.flat_map(|row| row.columns.iter().copied()).collect();
            columns.sort_unstable();
            columns.dedup();
            columns.into()
        });
        component.shared = Arc::clone(shared);
    }
}

/// Cuts the order into chunks of about the same work, without cutting a component. `work`: of each factor in that order.
fn cut(work: &[usize], components: &[Component], shared: usize) -> Vec<Chunk> {
    let most = (MAX_CHUNK_NUMBERS / (shared * shared).max(1)).clamp(1, MAX_CHUNKS);
    let enough = work.iter().sum::<usize>().div_ceil(most).max(WORK_PER_CHUNK);
    let mut chunks: Vec<Chunk> = Vec::new();
    let mut component = 0;
    let mut start = 0;
    while start < work.len() {
        let mut done = 0;
        let is_enough = |own: &usize| {
            done += own;
            done >= enough
        };
        let mut end = work[start..].iter().position(is_enough).map_or(work.len(), |last| start + last + 1);
        let first = component;
        while let Some(next) = components.get(component).filter(|next| next.factors.start < end) {
            end = end.max(next.factors.end);
            component += 1;
        }
        chunks.push(Chunk { factors: start..end, components: first..component });
        start = end;
    }
    chunks
}

/// Disjoint sets by path halving.
struct Roots(Vec<usize>);

impl Roots {
    fn find(&mut self, mut index: usize) -> usize {
        while self.0[index] != index {
            self.0[index] = self.0[self.0[index]];
            index = self.0[index];
        }
        index
    }

    fn unite(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each but the last has the least work that is worth a chunk, in few factors where these are means over many moments.
    #[test]
    fn chunks_are_about_the_same_work() {
        let lengths = |work: &[usize]| -> Vec<usize> {
            let chunks = cut(work, &[], 10);
            let follow = chunks.windows(2).all(|pair| pair[0].factors.end == pair[1].factors.start);
            assert!(follow && chunks[0].factors.start == 0 && chunks[chunks.len() - 1].factors.end == work.len());
            chunks.iter().map(|chunk| chunk.factors.len()).collect()
        };
        assert_eq!(lengths(&[1; 2000]), [512, 512, 512, 464]);
        assert_eq!(lengths(&[64; 20]), [8, 8, 4]);
        assert_eq!(lengths(&[[1; 600].as_slice(), &[128; 4]].concat()), [512, 92]);
        assert_eq!(lengths(&[100; 10_000]).len(), 64);
    }
}
