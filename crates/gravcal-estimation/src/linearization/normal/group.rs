//! Some components that look alike, in lanes: each number has one lane a component.
//!
//! Of the rows of a component those that touch shared columns are *mixed*, with eliminated columns `M`, shared columns `J_s` and residuals `r`;
//! the others, such as what is known beforehand, have the normal equations `P` (damping included) and the slopes `g_P`. To eliminate the
//! eliminated columns is to reweigh the mixed rows (by Woodbury's identity):
//!
//! ```text
//!     H_ss − H_se H_ee⁻¹ H_es = J_sᵀ W J_s,     g_s − H_se H_ee⁻¹ g_e = J_sᵀ W (r − M P⁻¹ g_P),     W = (I + M P⁻¹ Mᵀ)⁻¹
//! ```
//!
//! With `W⁻¹ = L D Lᵀ` these are products of the rows `D^-½ L⁻¹ [J_s, r − M P⁻¹ g_P]`: nothing is subtracted, and what couples eliminated
//! and shared columns is never formed.

use pulp::{Arch, NullaryFnOnce};

use super::lanes::{Factored, Lanes, add_product, lanes, take_product};
use crate::problem::{Component, Kind, Piece, RowPlace, Rows, Run, Slot};
use crate::{EvaluateError, LANES, Problem};

const ZERO: Lanes = [0.0; LANES];

/// Components of one kind.
pub(super) struct Group<'p> {
    problem: &'p Problem,
    pub kind: &'p Kind,
    instructions: Arch,
    /// How many components there are; lanes beyond them hold zeros.
    count: usize,
    /// Shared columns of the mixed rows, in the kind's order.
    mixed: Vec<Lanes>,
    residuals: Vec<Lanes>,
    /// Eliminated columns of the mixed rows, row after row.
    own: Vec<Lanes>,
    /// `P` without damping, row-major, and `g_P`.
    known: Vec<Lanes>,
    slopes: Vec<Lanes>,
    work: Work,
}

/// What is computed on the way.
struct Work {
    /// Of `P` or of `H_ee`.
    eliminated: Factored,
    /// Of `W⁻¹`.
    weight: Factored,
    /// `Lp⁻¹ Mᵀ`, one row a mixed row, for `P = Lp Dp Lpᵀ`.
    solved: Vec<Lanes>,
    /// One number an eliminated column.
    step: Vec<Lanes>,
    /// One number a mixed row.
    along: Vec<Lanes>,
    /// Reweighed rows and residuals, still to be multiplied by `scales`.
    mixed: Vec<Lanes>,
    residuals: Vec<Lanes>,
    scales: Vec<Lanes>,
    /// A row of one component.
    compact: Vec<f64>,
}

/// What is worth vector instructions.
enum Task<'a, 'r> {
    Take { rows: &'a Rows<'r>, slot: &'a Slot },
    AddShared { gradient: &'a mut [Lanes], squares: &'a mut [Lanes] },
    Reweigh,
    Substitute { shared: &'a [f64] },
}

struct Vectorized<'g, 'p, 'a, 'r> {
    group: &'g mut Group<'p>,
    task: Task<'a, 'r>,
}

impl NullaryFnOnce for Vectorized<'_, '_, '_, '_> {
    /// Whether enough digits are kept.
    type Output = bool;

    #[inline(always)]
    fn call(self) -> bool {
        let Vectorized { group, task } = self;
        match task {
            Task::Take { rows, slot } => group.take_batch(rows, slot),
            Task::AddShared { gradient, squares } => group.add_shared_in(gradient, squares),
            Task::Reweigh if !group.factor_weight() => return false,
            Task::Reweigh => group.reweigh_rows(),
            Task::Substitute { shared } => return group.substitute_in(shared),
        }
        true
    }
}

/// A reweighed row of each component.
pub(super) struct Reweighed<'a> {
    /// The first of the kind's columns, and the residual.
    pub entries: &'a [Lanes],
    pub residual: &'a Lanes,
    /// By which all of them are still to be multiplied.
    pub scale: &'a Lanes,
}

impl Reweighed<'_> {
    /// `(row · v)²` for a vector over the shared columns, summed over the components.
    pub fn image_norm_squared(&self, columns: &[usize], v: &[f64]) -> f64 {
        let mut along = ZERO;
        self.entries
            .iter()
            .zip(columns)
            .for_each(|(entry, column)| add_product(&mut along, entry, &[v[*column]; LANES]));
        along.iter().zip(self.scale).map(|(along, scale)| (along * scale).powi(2)).sum()
    }
}

impl<'p> Group<'p> {
    pub fn new(problem: &'p Problem, kind: &'p Kind) -> Self {
        let (rows, eliminated, columns) = (kind.widths.len(), kind.eliminated, kind.columns.len());
        let zeros = |length: usize| vec![ZERO; length];
        let work = Work {
            eliminated: Factored::new(eliminated),
            weight: Factored::new(rows),
            solved: zeros(rows * eliminated),
            step: zeros(eliminated),
            along: zeros(rows),
            mixed: zeros(rows * columns),
            residuals: zeros(rows),
            scales: zeros(rows),
            compact: vec![0.0; columns + 1],
        };
        Group {
            problem,
            kind,
            instructions: Arch::new(),
            count: 0,
            mixed: zeros(rows * columns),
            residuals: zeros(rows),
            own: zeros(rows * eliminated),
            known: zeros(eliminated * eliminated),
            slopes: zeros(eliminated),
            work,
        }
    }

    /// Loads the rows of at most [`LANES`] components of its kind, and gives their cost. `left_out`: columns that count as zeros.
    ///
    /// # Errors
    /// Where a residual cannot be evaluated there.
    pub fn load(
        &mut self,
        rows: &mut Rows<'_>,
        components: &'p [Component],
        left_out: &[usize],
    ) -> Result<f64, EvaluateError> {
        self.known.fill(ZERO);
        self.slopes.fill(ZERO);
        if components.len() < LANES {
            [&mut self.mixed, &mut self.residuals, &mut self.own].into_iter().for_each(|lanes| lanes.fill(ZERO));
        }
        self.count = components.len();
        let order = &self.problem.structure().order;
        let mut cost = 0.0;
        for (index, slot) in self.kind.slots.iter().enumerate() {
            let factor = |component: &Component| order[component.factors.start + index];
            let mut alone = 0..components.len();
            if let [a, b, c, d] = components {
                let (count, own) = rows.linearize_some(&[factor(a), factor(b), factor(c), factor(d)])?;
                cost += own;
                alone.start = count;
                if count == LANES {
                    self.vectorized(Task::Take { rows, slot });
                } else {
                    self.take(rows, slot, factor(a), 0);
                }
            }
            for lane in alone {
                cost += rows.linearize(factor(&components[lane]), true)?;
                self.take(rows, slot, factor(&components[lane]), lane);
            }
        }
        left_out.iter().for_each(|column| self.leave_out(components, *column));
        Ok(cost)
    }

    /// Takes the rows of batched factors.
    #[inline(always)]
    fn take_batch(&mut self, rows: &Rows<'_>, slot: &Slot) {
        let (eliminated, columns) = (self.kind.eliminated, self.kind.columns.len());
        for (row, place) in slot.rows.iter().enumerate() {
            let (stored, scales, residual) =
                (rows.local_row_lanes(row), rows.scale_lanes(row), rows.residual_lanes(row));
            let scaled = |entry: &Lanes| lanes(|lane| scales[lane] * entry[lane]);
            match place {
                RowPlace::Mixed { index, runs } => {
                    let mixed = &mut self.mixed[index * columns..(index + 1) * columns];
                    for Run { piece: Piece { from, length, curved }, place } in runs {
                        let out = &mut mixed[*place..place + length];
                        let put = |(out, entry): (&mut Lanes, &Lanes)| *out = scaled(entry);
                        match curved {
                            None => out.iter_mut().zip(&stored[*from..]).for_each(put),
                            Some(block) => {
                                let basis = rows.basis(*block);
                                let along = |index: usize| basis.along_lanes(index, &stored[*from..]);
                                out.iter_mut().enumerate().for_each(|(index, out)| *out = scaled(&along(index)));
                            }
                        }
                    }
                    self.residuals[*index] = residual;
                    let own = &mut self.own[index * eliminated..(index + 1) * eliminated];
                    slot.own.iter().for_each(|(from, column)| own[*column] = scaled(&stored[*from]));
                }
                RowPlace::Own => {
                    for (from, i) in slot.own.iter().filter(|(from, _)| stored[*from] != ZERO) {
                        let own = scaled(&stored[*from]);
                        add_product(&mut self.slopes[*i], &own, &residual);
                        for (from, j) in &slot.own {
                            add_product(&mut self.known[i * eliminated + j], &own, &scaled(&stored[*from]));
                        }
                    }
                }
            }
        }
    }

    /// Takes the rows of one factor into a lane.
    fn take(&mut self, rows: &Rows<'_>, slot: &Slot, factor: usize, lane: usize) {
        let (eliminated, columns) = (self.kind.eliminated, self.kind.columns.len());
        let compact = &mut self.work.compact;
        for (row, (place, plan)) in slot.rows.iter().zip(self.problem.plans(factor)).enumerate() {
            match place {
                RowPlace::Mixed { index, runs } => {
                    rows.gather(plan, row, compact);
                    let out = &mut self.mixed[index * columns..(index + 1) * columns];
                    let places = runs.iter().flat_map(|run| run.place..run.place + run.piece.length);
                    places.zip(&*compact).for_each(|(place, entry)| out[place][lane] = *entry);
                    self.residuals[*index][lane] = rows.residual(row);
                    for (stored, column) in &slot.own {
                        self.own[index * eliminated + column][lane] = rows.entry(row, *stored);
                    }
                }
                RowPlace::Own => {
                    for (stored, i) in &slot.own {
                        let own = rows.entry(row, *stored);
                        self.slopes[*i][lane] += own * rows.residual(row);
                        for (stored, j) in &slot.own {
                            self.known[i * eliminated + j][lane] += own * rows.entry(row, *stored);
                        }
                    }
                }
            }
        }
    }

    /// Makes one of the problem's columns zero.
    fn leave_out(&mut self, components: &[Component], column: usize) {
        let (eliminated, columns) = (self.kind.eliminated, self.kind.columns.len());
        let shared = &self.problem.structure().shared;
        if let Some(at) = self.kind.columns.iter().position(|index| shared[*index] == column) {
            self.mixed.chunks_exact_mut(columns).for_each(|row| row[at] = ZERO);
        }
        for (lane, component) in components.iter().enumerate() {
            let Some(at) = component.columns.iter().position(|own| *own == column) else { continue };
            self.own.chunks_exact_mut(eliminated).for_each(|row| row[at][lane] = 0.0);
            for k in 0..eliminated {
                self.known[at * eliminated + k][lane] = 0.0;
                self.known[k * eliminated + at][lane] = 0.0;
            }
            self.slopes[at][lane] = 0.0;
        }
    }

    /// Adds `Jᵀr` and the squares of the columns' norms: of the kind's shared columns, with one lane a component.
    pub fn add_shared(&mut self, gradient: &mut [Lanes], squares: &mut [Lanes]) {
        self.vectorized(Task::AddShared { gradient, squares });
    }

    #[inline(always)]
    fn add_shared_in(&self, gradient: &mut [Lanes], squares: &mut [Lanes]) {
        let columns = self.kind.columns.len();
        let rows = self.mixed.chunks_exact(columns).zip(self.residuals.iter().zip(&self.kind.widths));
        for (row, (residual, width)) in rows {
            for (entry, (gradient, square)) in row[..*width].iter().zip(gradient.iter_mut().zip(&mut *squares)) {
                add_product(gradient, entry, residual);
                add_product(square, entry, entry);
            }
        }
    }

    /// `Jᵀr` and the squares of the columns' norms, of the eliminated columns of one component after the other.
    pub fn eliminated_sums(&self) -> impl Iterator<Item = [f64; 2]> {
        let eliminated = self.kind.eliminated;
        let of = move |lane: usize, column: usize| {
            let start = [self.slopes[column][lane], self.known[column * (eliminated + 1)][lane]];
            self.own.chunks_exact(eliminated).zip(&self.residuals).fold(start, |[slope, square], (row, residual)| {
                let entry = row[column][lane];
                [slope + entry * residual[lane], square + entry * entry]
            })
        };
        (0..self.count).flat_map(move |lane| (0..eliminated).map(move |column| of(lane, column)))
    }

    /// Writes `P` with the damping of the components' columns.
    fn damp(&mut self, components: &[Component], damping: &[f64]) {
        let (eliminated, matrix) = (self.kind.eliminated, self.work.eliminated.matrix());
        matrix.copy_from_slice(&self.known);
        for column in 0..eliminated {
            let of = |lane: usize| components.get(lane).map_or(1.0, |component| damping[component.columns[column]]);
            let damping = lanes(of);
            let diagonal = &mut matrix[column * (eliminated + 1)];
            *diagonal = lanes(|lane| diagonal[lane] + damping[lane]);
        }
    }

    /// Eliminates the columns of each component. `None` where that would lose too many digits.
    pub fn reweigh(&mut self, components: &[Component], damping: &[f64]) -> Option<()> {
        self.damp(components, damping);
        self.vectorized(Task::Reweigh).then_some(())
    }

    /// Factors `W⁻¹`, and corrects the residuals by what the other rows say.
    #[inline(always)]
    fn factor_weight(&mut self) -> bool {
        let (eliminated, rows) = (self.kind.eliminated, self.residuals.len());
        let Work { eliminated: known, weight, solved, step, residuals, .. } = &mut self.work;
        if !known.factor() {
            return false;
        }
        step.copy_from_slice(&self.slopes);
        known.forward(step);
        solved.copy_from_slice(&self.own);
        for (i, row) in solved.chunks_exact_mut(eliminated).enumerate() {
            known.forward(row);
            let mut residual = self.residuals[i];
            for (k, (entry, slope)) in row.iter().zip(&*step).enumerate() {
                let inverse = known.inverse_pivot(k);
                take_product(&mut residual, entry, &lanes(|lane| slope[lane] * inverse[lane]));
            }
            residuals[i] = residual;
        }
        let matrix = weight.matrix();
        for i in 0..rows {
            for j in 0..=i {
                let mut sum = [if i == j { 1.0 } else { 0.0 }; LANES];
                for k in 0..eliminated {
                    let (a, b, inverse) =
                        (&solved[i * eliminated + k], &solved[j * eliminated + k], known.inverse_pivot(k));
                    add_product(&mut sum, &lanes(|lane| a[lane] * inverse[lane]), b);
                }
                matrix[i * rows + j] = sum;
            }
        }
        weight.factor()
    }

    #[inline(always)]
    fn reweigh_rows(&mut self) {
        let columns = self.kind.columns.len();
        let Work { weight, mixed, residuals, scales, .. } = &mut self.work;
        weight.forward(residuals);
        for (i, width) in self.kind.widths.iter().enumerate() {
            let (before, rest) = mixed.split_at_mut(i * columns);
            let row = &mut rest[..*width];
            row.copy_from_slice(&self.mixed[i * columns..][..*width]);
            for (k, other) in before.chunks_exact(columns).enumerate() {
                let factor = *weight.below(i, k);
                let other = &other[..self.kind.widths[k]];
                row.iter_mut().zip(other).for_each(|(entry, other)| take_product(entry, &factor, other));
            }
            scales[i] = weight.inverse_pivot(i).map(f64::sqrt);
        }
    }

    /// The mixed rows after [`Group::reweigh`].
    pub fn reweighed(&self) -> impl Iterator<Item = Reweighed<'_>> {
        let columns = self.kind.columns.len();
        self.kind.widths.iter().enumerate().map(move |(i, width)| Reweighed {
            entries: &self.work.mixed[i * columns..][..*width],
            residual: &self.work.residuals[i],
            scale: &self.work.scales[i],
        })
    }

    /// `J_s v` for a vector `v` over the shared columns, one number a mixed row.
    #[inline(always)]
    fn along_shared(&mut self, shared: &[f64]) {
        let columns = self.kind.columns.len();
        for (i, width) in self.kind.widths.iter().enumerate() {
            let mut sum = ZERO;
            for (entry, column) in self.mixed[i * columns..][..*width].iter().zip(&self.kind.columns) {
                add_product(&mut sum, entry, &[shared[*column]; LANES]);
            }
            self.work.along[i] = sum;
        }
    }

    /// The eliminated steps that follow from a shared one: `δ_e = −H_ee⁻¹ (g_e + H_es δ_s)`. `None` where that would lose too many digits.
    pub fn substitute(&mut self, components: &[Component], damping: &[f64], shared: &[f64]) -> Option<()> {
        self.damp(components, damping);
        self.vectorized(Task::Substitute { shared }).then_some(())
    }

    #[inline(always)]
    fn substitute_in(&mut self, shared: &[f64]) -> bool {
        self.along_shared(shared);
        let eliminated = self.kind.eliminated;
        let Work { eliminated: normal, step, along, .. } = &mut self.work;
        (0..eliminated).for_each(|k| step[k] = self.slopes[k].map(|slope| -slope));
        let matrix = normal.matrix();
        for (row, (residual, along)) in self.own.chunks_exact(eliminated).zip(self.residuals.iter().zip(along)) {
            let residual = lanes(|lane| residual[lane] + along[lane]);
            for (i, a) in row.iter().enumerate() {
                take_product(&mut step[i], a, &residual);
                let below = &mut matrix[i * eliminated..][..=i];
                below.iter_mut().zip(row).for_each(|(entry, b)| add_product(entry, a, b));
            }
        }
        let sound = normal.factor();
        normal.solve(step);
        sound
    }

    /// Does something with the vector instructions that the processor has.
    fn vectorized(&mut self, task: Task<'_, '_>) -> bool {
        self.instructions.dispatch(Vectorized { group: self, task })
    }

    /// Takes a step of all columns in place of the one that follows.
    pub fn set_step(&mut self, components: &[Component], step: &[f64], shared: &[f64]) {
        self.along_shared(shared);
        for (column, own) in self.work.step.iter_mut().enumerate() {
            *own = lanes(|lane| components.get(lane).map_or(0.0, |component| step[component.columns[column]]));
        }
    }

    /// The eliminated steps of one component after the other.
    pub fn steps(&self) -> impl Iterator<Item = f64> {
        (0..self.count).flat_map(|lane| self.work.step.iter().map(move |step| step[lane]))
    }

    /// `‖J δ‖²` of all rows, for the steps.
    pub fn image_norm_squared(&self) -> f64 {
        let (eliminated, step) = (self.kind.eliminated, &self.work.step);
        let mut sum = ZERO;
        for (row, along) in self.own.chunks_exact(eliminated).zip(&self.work.along) {
            let mut image = *along;
            row.iter().zip(step).for_each(|(entry, step)| add_product(&mut image, entry, step));
            add_product(&mut sum, &image, &image);
        }
        for (row, step_i) in self.known.chunks_exact(eliminated).zip(step) {
            let mut image = ZERO;
            row.iter().zip(step).for_each(|(entry, step)| add_product(&mut image, entry, step));
            add_product(&mut sum, &image, step_i);
        }
        sum[..self.count].iter().sum()
    }

    /// Calls `found` with the entries of `JᵀJ`: two columns of the problem and the number, each pair once or both ways round.
    pub fn for_hessian(&self, components: &[Component], mut found: impl FnMut(usize, usize, f64)) {
        let (eliminated, columns) = (self.kind.eliminated, self.kind.columns.len());
        let shared = &self.problem.structure().shared;
        for (lane, component) in components.iter().enumerate() {
            for (i, a) in component.columns.iter().enumerate() {
                let known = &self.known[i * eliminated..(i + 1) * eliminated];
                component.columns.iter().zip(known).for_each(|(b, entry)| found(*a, *b, entry[lane]));
            }
            for (mixed, own) in self.mixed.chunks_exact(columns).zip(self.own.chunks_exact(eliminated)) {
                let shared = self.kind.columns.iter().map(|index| shared[*index]).zip(mixed);
                let all: Vec<(usize, f64)> = component
                    .columns
                    .iter()
                    .copied()
                    .zip(own)
                    .chain(shared)
                    .map(|(c, entry)| (c, entry[lane]))
                    .collect();
                all.iter().for_each(|(a, x)| all.iter().for_each(|(b, y)| found(*a, *b, x * y)));
            }
        }
    }
}
