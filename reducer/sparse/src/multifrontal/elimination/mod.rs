//! Eliminates the fronts: subtrees of little work as tasks of their own, those of much work one after the other, with all threads.

mod extend_add;

use std::marker::PhantomData;
use std::sync::{Mutex, PoisonError};

use dcb_formats::SparseMatrix;
use rayon::prelude::*;

use super::dense::{Panel, eliminate_positive};

use super::fronts::Fronts;
use super::kernels::{Real, pack};
use crate::zeros;
use extend_add::{Child, add_children};

/// `K + shift · M`, both symmetric in full storage.
#[derive(Clone, Copy)]
pub struct Matrix<'a> {
    /// K.
    pub stiffness: &'a SparseMatrix,
    /// M.
    pub mass: &'a SparseMatrix,
    /// σ.
    pub shift: f64,
}

/// A pivot of a matrix that should be positive definite was not positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotPositive {
    /// Original dof of the pivot.
    pub dof: usize,
}

/// Treatment of each front once it is assembled.
pub trait Elimination: Sync {
    /// Type of the entries that are kept of the eliminated columns.
    type Stored: Real;

    /// Result of a subtree.
    type Outcome: Default + Send;

    /// Whether the eliminated columns are kept among the values.
    const KEEPS: bool;

    /// Eliminates the `columns` of a front; `update` is to hold the Schur complement's lower triangle without the children's
    /// part.
    ///
    /// # Errors
    /// [`NotPositive`] with the position in the elimination order.
    fn eliminate(
        &self,
        first: usize,
        panel: &mut Panel<'_>,
        update: &mut [f64],
        outcome: &mut Self::Outcome,
    ) -> Result<(), NotPositive>;

    /// Adds what another subtree tells.
    fn merge(into: &mut Self::Outcome, other: Self::Outcome);
}

/// `A = L Lᵀ`; the values become L, rounded to `T`.
pub struct Cholesky<T>(PhantomData<T>);

impl<T> Default for Cholesky<T> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<T: Real> Elimination for Cholesky<T> {
    type Stored = T;
    type Outcome = ();
    const KEEPS: bool = true;

    fn eliminate(
        &self,
        first: usize,
        panel: &mut Panel<'_>,
        update: &mut [f64],
        (): &mut (),
    ) -> Result<(), NotPositive> {
        eliminate_positive(panel, update).map_err(|column| NotPositive {
            dof: first + column,
        })
    }

    fn merge((): &mut (), (): ()) {}
}

/// Eliminates all fronts; `values` receives the factor if the elimination keeps it.
///
/// # Errors
/// [`NotPositive`] with the original dof whose pivot was not positive.
pub fn eliminate<E: Elimination>(
    fronts: &Fronts,
    matrix: Matrix<'_>,
    elimination: &E,
    values: &mut [E::Stored],
) -> Result<E::Outcome, NotPositive> {
    let run = Run {
        fronts,
        matrix,
        elimination,
        workspaces: Mutex::new(Vec::new()),
    };
    let done = run.side_by_side(fronts.roots(), values);
    done.map(|(outcome, _)| outcome)
        .map_err(|NotPositive { dof }| NotPositive {
            dof: fronts.forward[dof] as usize,
        })
}

/// Scratch of one task.
struct Workspace {
    /// Position of each dof of the elimination order in the front at hand; right only for the front's rows.
    local: Vec<u32>,
    /// Update matrices of fronts of even and odd depth: a front takes from one what it puts, added up, on the other.
    stacks: [Vec<f64>; 2],
    /// The columns of a front.
    panel: Vec<f64>,
}

struct Run<'a, E> {
    fronts: &'a Fronts,
    matrix: Matrix<'a>,
    elimination: &'a E,
    workspaces: Mutex<Vec<Workspace>>,
}

/// Result of a subtree, and its root's update matrix.
type Done<O> = Result<(O, Vec<f64>), NotPositive>;

impl<E: Elimination> Run<'_, E> {
    fn workspace(&self) -> Workspace {
        let known = self
            .workspaces
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .pop();
        known.unwrap_or_else(|| Workspace {
            local: vec![0; self.fronts.dof_count()],
            stacks: [Vec::new(), Vec::new()],
            panel: Vec::new(),
        })
    }

    fn give_back(&self, workspace: Workspace) {
        self.workspaces
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(workspace);
    }

    /// Disjoint subtrees: large ones one after the other, so that no two hold their largest update matrices together, then the others in
    /// parallel. What they tell is merged in their order.
    fn side_by_side(
        &self,
        subtrees: &[u32],
        values: &mut [E::Stored],
    ) -> Result<(E::Outcome, Vec<Vec<f64>>), NotPositive> {
        let (mut small, mut done) = (Vec::new(), Vec::with_capacity(subtrees.len()));
        let mut rest = values;
        for (place, front) in subtrees.iter().enumerate() {
            let front = *front as usize;
            let length = match E::KEEPS {
                true => self.fronts.subtree_values(front).len(),
                false => 0,
            };
            let (own, after) = rest.split_at_mut(length);
            match self.fronts.stands_alone(front) {
                true => done.push((place, self.subtree(front, own)?)),
                false => small.push((place, front, own)),
            }
            rest = after;
        }
        let in_parallel: Vec<(usize, Done<E::Outcome>)> = small
            .into_par_iter()
            .map(|(place, front, values)| (place, self.subtree(front, values)))
            .collect();
        for (place, result) in in_parallel {
            done.push((place, result?));
        }
        done.sort_unstable_by_key(|(place, _)| *place);
        let mut outcome = E::Outcome::default();
        let mut updates = Vec::with_capacity(done.len());
        for (_, (told, update)) in done {
            E::merge(&mut outcome, told);
            updates.push(update);
        }
        Ok((outcome, updates))
    }

    fn subtree(&self, front: usize, values: &mut [E::Stored]) -> Done<E::Outcome> {
        if self.fronts.is_one_task(front) {
            return self.one_task(front, values);
        }
        let own = if E::KEEPS {
            self.fronts.value_range(front).len()
        } else {
            0
        };
        let (below, panel) = values.split_at_mut(values.len() - own);
        let (mut outcome, updates) = self.side_by_side(self.fronts.children(front), below)?;
        let children: Vec<&[f64]> = updates.iter().map(Vec::as_slice).collect();
        let mut workspace = self.workspace();
        let mut update = Vec::new();
        zeros::extend(&mut update, self.fronts.update_length(front));
        self.front(
            front,
            panel,
            &children,
            &mut update,
            &mut workspace.local,
            &mut workspace.panel,
            &mut outcome,
        )?;
        self.give_back(workspace);
        Ok((outcome, update))
    }

    /// A whole subtree by one thread, its update matrices on two stacks.
    fn one_task(&self, root: usize, values: &mut [E::Stored]) -> Done<E::Outcome> {
        let fronts = self.fronts;
        let mut outcome = E::Outcome::default();
        let mut workspace = self.workspace();
        for (stack, room) in workspace.stacks.iter_mut().zip(fronts.stack_rooms(root)) {
            if stack.len() < room {
                // The old one first, so that both are never held.
                *stack = Vec::new();
                *stack = vec![0.0; room];
            }
        }
        let mut update_of_root = vec![0.0; fronts.update_length(root)];
        let Workspace {
            local,
            stacks,
            panel: scratch,
        } = &mut workspace;
        let mut tops = [0_usize; 2];
        let first = fronts.first_descendant(root);
        let base = fronts.value_range(first).start;
        for front in first..=root {
            let [even, odd] = &mut *stacks;
            let (own, own_top, theirs, their_top) = match fronts.depth(front) % 2 {
                0 => (even, 0, odd, 1),
                _ => (odd, 1, even, 0),
            };
            let sizes = fronts
                .children(front)
                .iter()
                .map(|child| fronts.update_length(*child as usize));
            let mut start = tops[their_top] - sizes.clone().sum::<usize>();
            tops[their_top] = start;
            let children: Vec<&[f64]> = sizes
                .map(|size| {
                    let update = &theirs[start..start + size];
                    start += size;
                    update
                })
                .collect();
            let size = fronts.update_length(front);
            let update = if front == root {
                &mut update_of_root[..]
            } else {
                let top = tops[own_top];
                tops[own_top] += size;
                &mut own[top..top + size]
            };
            let range = fronts.value_range(front);
            let panel = if E::KEEPS {
                &mut values[range.start - base..range.end - base]
            } else {
                &mut []
            };
            self.front(
                front,
                panel,
                &children,
                update,
                local,
                scratch,
                &mut outcome,
            )?;
        }
        self.give_back(workspace);
        Ok((outcome, update_of_root))
    }

    /// Assembles and eliminates one front.
    #[allow(clippy::too_many_arguments)] // what a front is made of, and scratch
    fn front(
        &self,
        front: usize,
        kept: &mut [E::Stored],
        children: &[&[f64]],
        update: &mut [f64],
        local: &mut [u32],
        scratch: &mut Vec<f64>,
        outcome: &mut E::Outcome,
    ) -> Result<(), NotPositive> {
        let fronts = self.fronts;
        let layout = fronts.panel_layout(front);
        if scratch.len() < layout.len() {
            // The old one first, so that both are never held.
            *scratch = Vec::new();
            zeros::extend(scratch, layout.len());
        }
        let values = &mut scratch[..layout.len()];
        zeros::fill(values);
        self.add_entries(front, values, local);
        let own = fronts.children(front).iter().zip(children);
        let children: Vec<Child> = own
            .map(|(child, update)| Child {
                front: *child as usize,
                update,
            })
            .collect();
        add_children(fronts, &children, values, layout, 0);
        let first = fronts.columns(front).start;
        let mut panel = Panel { values, layout };
        self.elimination
            .eliminate(first, &mut panel, update, outcome)?;
        if E::KEEPS {
            pack(values, layout, kept);
        }
        let update_layout = fronts.update_layout(front);
        add_children(fronts, &children, update, update_layout, layout.columns);
        Ok(())
    }

    /// Adds the matrix's own entries in a front's columns, on and below the diagonal.
    fn add_entries(&self, front: usize, values: &mut [f64], local: &mut [u32]) {
        let fronts = self.fronts;
        let layout = fronts.panel_layout(front);
        let columns = fronts.columns(front);
        for (row, position) in columns.clone().enumerate() {
            local[position] = row as u32;
        }
        for run in fronts.rows_below(front) {
            let first = columns.len() as u32 + run.source;
            for offset in 0..run.length {
                local[(run.target + offset) as usize] = first + offset;
            }
        }
        for (column, position) in columns.enumerate() {
            let dof = fronts.forward[position] as usize;
            let (range, start) = layout.column(column);
            let values = &mut values[range];
            let mut add = |matrix: &SparseMatrix, factor: f64| {
                let entries = matrix.row_idx_of_col_raw(dof).iter();
                for (row, value) in entries.zip(matrix.val_of_col(dof)) {
                    let place = fronts.inverse[*row as usize] as usize;
                    if place >= position {
                        values[local[place] as usize - start] += factor * value;
                    }
                }
            };
            add(self.matrix.stiffness, 1.0);
            if self.matrix.shift != 0.0 {
                add(self.matrix.mass, self.matrix.shift);
            }
        }
    }
}
