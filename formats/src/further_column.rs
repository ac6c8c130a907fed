//! Sources of the further columns of a basis, as files name them, and the effect of centrifugal forces on any column.

use std::fmt;

use crate::mesh::Dimension;
use crate::superelement::Inertia;

/// Patterns of centrifugal forces in space, in the order of the second-order change of inertia.
const PAIRS: [(usize, usize, &str); 6] = [
    (0, 0, "xx"),
    (1, 1, "yy"),
    (2, 2, "zz"),
    (0, 1, "xy"),
    (1, 2, "yz"),
    (2, 0, "zx"),
];

/// The forces that a further column is the response to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer<'a> {
    /// Centrifugal forces ∫ ρ Nᵀ S r of this pattern: S = I in the plane, e_a e_aᵀ or e_a e_bᵀ + e_b e_aᵀ in space.
    Spin(Dimension, usize),
    /// A load on the inside of the component, by its name.
    Load(&'a str),
    /// Inertia of the attachment of a row of the boundary localization, by its name.
    Krylov(&'a str),
}

impl Answer<'static> {
    /// All patterns of centrifugal forces: six in space, one in the plane.
    pub fn spins(dimension: Dimension) -> Vec<Self> {
        let count = match dimension {
            Dimension::Planar => 1,
            Dimension::Spatial => PAIRS.len(),
        };
        (0..count)
            .map(|pattern| Self::Spin(dimension, pattern))
            .collect()
    }
}

impl<'a> Answer<'a> {
    /// Source of a column of this name; `None` for a name that `reduce` doesn't give.
    pub fn named(name: &'a str, dimension: Dimension) -> Option<Self> {
        let mut spins = Answer::spins(dimension).into_iter();
        match name.split_once(' ') {
            Some(("load", load)) => Some(Self::Load(load)),
            Some(("krylov", row)) => Some(Self::Krylov(row)),
            _ => spins.find(|spin| spin.to_string() == name),
        }
    }
}

impl fmt::Display for Answer<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Spin(Dimension::Planar, _) => write!(formatter, "spin"),
            Self::Spin(Dimension::Spatial, pattern) => {
                write!(formatter, "spin {}", PAIRS[*pattern].2)
            }
            Self::Load(name) => write!(formatter, "load {name}"),
            Self::Krylov(row) => write!(formatter, "krylov {row}"),
        }
    }
}

impl Inertia {
    /// ψᵀ f of a column ψ of the basis for each pattern f of [`Answer::spins`], which the first-order change of inertia holds: planar it is
    /// I1, in space J1 = 2 tr(G) I - G - Gᵀ with G_ab = ∫ ρ r_a ψ_b.
    pub fn spin_work(&self, dimension: Dimension, column: usize) -> Vec<f64> {
        let first_order = &self.i1[column];
        match dimension {
            Dimension::Planar => vec![first_order[2][2]],
            Dimension::Spatial => {
                let trace: f64 = (0..3).map(|a| first_order[a][a]).sum::<f64>() / 4.0;
                let work = |(a, b, _): &(usize, usize, &str)| match a == b {
                    true => trace - 0.5 * first_order[*a][*a],
                    false => -first_order[*a][*b],
                };
                PAIRS.iter().map(work).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn names_are_read_back() {
        for dimension in [Dimension::Planar, Dimension::Spatial] {
            let mut all = Answer::spins(dimension);
            all.extend([Answer::Load("a b"), Answer::Krylov("left/ux at node 3")]);
            for answer in all {
                let name = answer.to_string();
                assert_eq!(
                    Answer::named(&name, dimension).map(|a| a.to_string()),
                    Some(name)
                );
            }
        }
        for name in ["spin xx", "gust", "load", "krylov"] {
            assert_eq!(Answer::named(name, Dimension::Planar), None);
        }
        assert_eq!(
            Answer::named("spin zx", Dimension::Spatial),
            Some(Answer::Spin(Dimension::Spatial, 5))
        );
    }
}
