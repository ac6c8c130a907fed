//! Multifrontal factorization of sparse symmetric matrices: Cholesky of `K + σ M` for solving, `L D Lᵀ` with pivoting for
//! counting eigenvalues, over one symbolic analysis.
//!
//! The elimination tree's columns are gathered into *fronts*, dense trapezoids of `m` rows and `k` columns. A front adds what
//! its children hand up, eliminates its `k` columns and hands the rest, an update matrix of order `m - k`, to its parent.
//! Disjoint subtrees are tasks of their own; the fronts above them share the work of their dense kernels. Every sum has a fixed order, so results are the same to the last
//! bit whatever the number of threads (Duff & Reid 1983; Liu 1992).

mod amalgamation;
mod counting;
mod dense;
mod elimination;
mod fronts;
mod kernels;
mod product;
mod solve;
#[cfg(test)]
mod tests;

pub use counting::Indefinite;
pub use elimination::{Cholesky, Matrix, NotPositive, eliminate};
pub use fronts::Fronts;
pub use kernels::Real;
pub use solve::solve_columns;
