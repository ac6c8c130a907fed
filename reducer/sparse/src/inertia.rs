//! Signs of the eigenvalues of a symmetric matrix, counted by a factorization with pivoting that keeps nothing.

use crate::multifrontal::{Fronts, Indefinite, Matrix, eliminate};

/// Signs of the pivots of a symmetric matrix; by Sylvester's law those of its eigenvalues.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Inertia {
    /// Number of negative eigenvalues.
    pub negative: usize,
    /// Number of exactly zero pivots; anything but 0 makes the count worthless.
    pub zero: usize,
    /// Original dofs at which the first negative pivots stood (at most [`Inertia::LISTED`]); none where other processes counted.
    pub negative_dofs: Vec<usize>,
}

impl Inertia {
    /// How many negative pivots are listed by dof.
    pub const LISTED: usize = 8;
}

/// Counts in this process.
pub(crate) fn counted(fronts: &Fronts, matrix: Matrix<'_>) -> Inertia {
    let Ok(signs) = eliminate(fronts, matrix, &Indefinite, &mut []) else {
        return Inertia {
            negative: 0,
            zero: matrix.stiffness.ncols(),
            negative_dofs: Vec::new(),
        };
    };
    Inertia {
        negative: signs.negative,
        zero: signs.zero,
        negative_dofs: signs
            .negative_positions
            .iter()
            .map(|position| fronts.forward[*position] as usize)
            .collect(),
    }
}
