//! Rotary inertia of a body over its dynamic coordinates.
//!
//! ```text
//! J(y)     =  I0 + Σ_k y_k J1_k + Σ_kl y_k y_l J2_kl               (3, 3)
//! L(y)     =  Σ_k y_k L3[:, k, :]                                  (3, n)
//! moment   = -(J' ω + ω × (J ω + (I3 + L) y'))
//! force_k  =  ½ ωᵀ J'_k ω - 2 Σ_a ω_a (L3_aᵀ y')_k,                J'_k = ∂J/∂y_k = J1_k + 2 Σ_l y_l J2_kl
//! ```
//! A planar body has the pair zz and the axis z only, J1 is 2 I1, and J2 is the reduced mass: I_z + 2 I1 y + yᵀ M y. The term
//! yᵀ M y of the paper's appendix is kept: dropping it alone would leave forces that derive from no energy. The part of the
//! moment that would come from L' y' vanishes, because L3 is antisymmetric.
//!
//! Geometric stiffening by spins is a part of J2. A spin's prestress has the potential ½ Σ ω_a ω_b yᵀ K_ab y, and what shortens a part
//! across its axis brings its ends nearer to the centre: subtracting K_aa from J2_aa and ½ K_ab from J2_ab makes both of one energy, so
//! that energy and angular momentum are conserved with it as without.

use std::ops::Range;

use dcb_formats::mesh::Dimension;
use dcb_formats::scene::InertiaChange;
use dcb_formats::superelement::Inertia;
use faer::{Mat, MatMut, MatRef};
use nalgebra::{Matrix3, Vector3};
use pulp::Simd;

use super::stacked::{Stacked, add_scaled, dot, dot_and_add};
use super::{AttachmentMass, BodyState, InertiaTerms};

/// Pairs of axes in the order of six-fold quantities: xx, yy, zz, xy, yz, zx.
pub const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// J2, where it is followed.
#[derive(Clone, Debug, PartialEq)]
enum SecondOrder {
    None,
    /// Planar: J2 is the reduced mass.
    ReducedMass,
    /// One matrix for each pair of axes: six in space, and one in the plane where it isn't the reduced mass.
    Pairs(Stacked),
}

/// I0, J1, J2 and L3.
#[derive(Clone, Debug, PartialEq)]
pub struct RotaryInertia {
    dimension: Dimension,
    count: usize,
    tensor: Matrix3<f64>,
    change: InertiaChange,
    /// J1, pair by pair, (n) each; empty if the inertia is constant.
    first_order: Vec<f64>,
    second_order: SecondOrder,
    /// Whether geometric stiffening is a part of `second_order`.
    is_stiffened: bool,
    /// L3ᵀ, axis by axis.
    coupling: Stacked,
}

impl RotaryInertia {
    /// The invariants `Bᵀ · B` over the coordinates that the columns B combine.
    pub fn over(inertia: &Inertia, dimension: Dimension, columns: MatRef<'_, f64>) -> Self {
        let congruent = |matrix: &Mat<f64>| columns.transpose() * matrix * columns;
        let sign = |matrix: &Mat<f64>, sign: f64| {
            let full = congruent(matrix);
            Mat::from_fn(full.nrows(), full.ncols(), |i, j| {
                0.5 * (full[(i, j)] + sign * full[(j, i)])
            })
        };
        // Planar files hold I1, half of J1.
        let (pairs, doubled) = match dimension {
            Dimension::Planar => (&PAIRS[2..3], 2.0),
            Dimension::Spatial => (&PAIRS[..], 1.0),
        };
        let stored = Mat::from_fn(inertia.i1.len(), pairs.len(), |k, pair| {
            let (a, b) = pairs[pair];
            doubled * inertia.i1[k][a][b]
        });
        let first_order = columns.transpose() * stored;
        let second_order: Vec<Mat<f64>> = inertia.i2.iter().map(|m| sign(m, 1.0)).collect();
        let transposed: Vec<Mat<f64>> = inertia.l3.iter().map(|m| sign(m, -1.0)).collect();
        Self {
            dimension,
            count: columns.ncols(),
            tensor: Matrix3::from_fn(|a, b| match dimension {
                Dimension::Planar if (a, b) != (2, 2) => 0.0,
                _ => inertia.tensor[a][b],
            }),
            change: InertiaChange::SecondOrder,
            first_order: first_order
                .col_iter()
                .flat_map(|column| column.iter().copied())
                .collect(),
            second_order: match dimension {
                Dimension::Planar => SecondOrder::ReducedMass,
                Dimension::Spatial => {
                    SecondOrder::Pairs(Stacked::of(second_order.iter().map(|m| m.as_ref())))
                }
            },
            is_stiffened: false,
            coupling: Stacked::of(transposed.iter().map(|m| m.transpose())),
        }
    }

    /// The same body stiffened by its spin: matrices (N, N) per product of spins ω_x², ω_y², ω_z², ω_xω_y, ω_yω_z, ω_zω_x (planar ω²), over
    /// the coordinates that the columns combine. Nothing changes without any.
    pub fn with_stiffening(mut self, centrifugal: &[Mat<f64>], columns: MatRef<'_, f64>) -> Self {
        if centrifugal.iter().all(|matrix| matrix.norm_max() == 0.0) {
            return self;
        }
        let n = self.count;
        let pairs = self.pairs();
        let stiffened: Vec<Mat<f64>> = centrifugal
            .iter()
            .zip(pairs)
            .enumerate()
            .map(|(which, (matrix, pair))| {
                let (a, b) = PAIRS[pair];
                let share = if a == b { 1.0 } else { 0.5 };
                let projected = columns.transpose() * matrix * columns;
                Mat::from_fn(n, n, |i, j| {
                    let inertia = match &self.second_order {
                        SecondOrder::None => 0.0,
                        SecondOrder::ReducedMass => f64::from(u8::from(i == j)),
                        SecondOrder::Pairs(matrices) => matrices.column(which, n, j)[i],
                    };
                    inertia - share * 0.5 * (projected[(i, j)] + projected[(j, i)])
                })
            })
            .collect();
        self.second_order = SecondOrder::Pairs(Stacked::of(stiffened.iter().map(|m| m.as_ref())));
        self.is_stiffened = true;
        self
    }

    /// Whether its spin stiffens it.
    pub fn is_stiffened(&self) -> bool {
        self.is_stiffened
    }

    /// The same body with the change of inertia followed no further than `change`; what isn't needed is dropped, geometric stiffening by
    /// spins as well, which is of second order.
    pub fn with_change(mut self, change: InertiaChange) -> Self {
        self.change = self.change.min(change);
        if self.change < InertiaChange::SecondOrder {
            self.second_order = SecondOrder::None;
            self.is_stiffened = false;
        }
        if self.change < InertiaChange::FirstOrder {
            self.first_order.clear();
        }
        self
    }

    /// Planar or spatial.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// I0, body axes, mass·length² (planar: only (z, z)).
    pub fn tensor(&self) -> &Matrix3<f64> {
        &self.tensor
    }

    /// How far the change of inertia is followed.
    pub fn change(&self) -> InertiaChange {
        self.change
    }

    pub(super) fn axes(&self) -> Range<usize> {
        match self.dimension {
            Dimension::Planar => 2..3,
            Dimension::Spatial => 0..3,
        }
    }

    fn pairs(&self) -> Range<usize> {
        match self.dimension {
            Dimension::Planar => 2..3,
            Dimension::Spatial => 0..6,
        }
    }

    fn spread(&self, range: Range<usize>) -> Range<usize> {
        range.start * self.count..range.end * self.count
    }

    /// `out += 2 J2 x` by pairs of axes, (n, 6).
    #[inline(always)]
    pub(super) fn add_second_order<S: Simd>(
        &self,
        simd: S,
        x: &[f64],
        mass: Option<&AttachmentMass>,
        out: &mut [f64],
    ) {
        let out = &mut out[self.spread(self.pairs())];
        match &self.second_order {
            SecondOrder::None => {}
            SecondOrder::ReducedMass => match mass {
                Some(mass) => mass.add_product(2.0, x, out),
                None => add_scaled(simd, 2.0, x, out),
            },
            SecondOrder::Pairs(matrices) => matrices.add_products(simd, 2.0, [x], [out]),
        }
    }

    /// `out_r += L3ᵀ x_r` by axes, (n, 3).
    #[inline(always)]
    pub(super) fn add_coupling<S: Simd, const R: usize>(
        &self,
        simd: S,
        x: [&[f64]; R],
        out: [&mut [f64]; R],
    ) {
        let range = self.spread(self.axes());
        let out = out.map(|out| &mut out[range.clone()]);
        self.coupling.add_products(simd, 1.0, x, out);
    }

    /// `out += Σ_a w_a L3_aᵀ`, (n, n).
    pub(super) fn add_combined_coupling(&self, w: &Vector3<f64>, mut out: MatMut<'_, f64>) {
        for (which, axis) in self.axes().enumerate() {
            for (l, column) in out.as_mut().col_iter_mut().enumerate() {
                let of_axis = self.coupling.column(which, self.count, l);
                for (out, entry) in column.iter_mut().zip(of_axis) {
                    *out += w[axis] * entry;
                }
            }
        }
    }

    /// `out -= ωᵀ J2 ω`, (n, n).
    pub(super) fn subtract_second_order(
        &self,
        spin: &Vector3<f64>,
        mass: Option<&AttachmentMass>,
        mut out: MatMut<'_, f64>,
    ) {
        match &self.second_order {
            SecondOrder::None => {}
            SecondOrder::ReducedMass => {
                let square = spin.z * spin.z;
                match mass {
                    Some(mass) => mass.add_matrix(-square, out),
                    None => (0..self.count).for_each(|k| out[(k, k)] -= square),
                }
            }
            SecondOrder::Pairs(matrices) => {
                for (which, pair) in self.pairs().enumerate() {
                    let weight = spin_product(spin, pair);
                    for (l, column) in out.as_mut().col_iter_mut().enumerate() {
                        let of_pair = matrices.column(which, self.count, l);
                        for (out, entry) in column.iter_mut().zip(of_pair) {
                            *out -= weight * entry;
                        }
                    }
                }
            }
        }
    }

    /// `ωᵀ J2_kk ω`
    pub(super) fn second_order_diagonal(
        &self,
        spin: &Vector3<f64>,
        mass: Option<&AttachmentMass>,
        k: usize,
    ) -> f64 {
        match &self.second_order {
            SecondOrder::None => 0.0,
            SecondOrder::ReducedMass => {
                spin.z * spin.z * mass.map_or(1.0, |mass| mass.diagonal(self.count, k))
            }
            SecondOrder::Pairs(matrices) => self
                .pairs()
                .enumerate()
                .map(|(which, pair)| {
                    spin_product(spin, pair) * matrices.column(which, self.count, k)[k]
                })
                .sum(),
        }
    }

    /// J, J', J'_k, L and the velocity-dependent moment and forces; `terms.coupling` comes in with I3.
    #[inline(always)]
    pub(super) fn evaluate<S: Simd>(
        &self,
        simd: S,
        motion: &BodyState<'_>,
        mass: Option<&AttachmentMass>,
        terms: &mut InertiaTerms,
    ) {
        let BodyState { y, rates, spin } = *motion;
        let n = self.count;
        terms.rotary = self.tensor;
        terms.rotary_rate = Matrix3::zeros();
        terms.relative = Vector3::zeros();
        terms.force.fill(0.0);
        if n > 0 {
            let pairs = self.spread(self.pairs());
            match self.change {
                InertiaChange::Constant => terms.gradient[pairs].fill(0.0),
                InertiaChange::FirstOrder => {
                    terms.gradient[pairs].copy_from_slice(&self.first_order);
                }
                InertiaChange::SecondOrder => {
                    terms.gradient[pairs].copy_from_slice(&self.first_order);
                    self.add_second_order(simd, y, mass, &mut terms.gradient);
                }
            }
            if self.change > InertiaChange::Constant {
                for (pair, first) in self.pairs().zip(self.first_order.chunks_exact(n)) {
                    let gradient = &terms.gradient[pair * n..(pair + 1) * n];
                    let weight = 0.5 * spin_product(&spin, pair);
                    let [twice, rate] = dot_and_add(
                        simd,
                        [first, gradient],
                        [y, rates],
                        weight,
                        &mut terms.force,
                    );
                    let (a, b) = PAIRS[pair];
                    let rotary = self.tensor[(a, b)] + 0.5 * twice;
                    for (i, j) in [(a, b), (b, a)] {
                        terms.rotary[(i, j)] = rotary;
                        terms.rotary_rate[(i, j)] = rate;
                    }
                }
            }
            terms.rate_coupling.fill(0.0);
            self.add_coupling(
                simd,
                [y, rates],
                [&mut terms.coupling, &mut terms.rate_coupling],
            );
            for axis in self.axes() {
                let range = axis * n..(axis + 1) * n;
                add_scaled(
                    simd,
                    -2.0 * spin[axis],
                    &terms.rate_coupling[range.clone()],
                    &mut terms.force,
                );
                terms.relative[axis] = dot(simd, &terms.coupling[range], rates);
            }
        }
        let momentum = terms.rotary * spin + terms.relative;
        terms.moment = -(terms.rotary_rate * spin + spin.cross(&momentum));
        if self.dimension == Dimension::Planar {
            (terms.moment.x, terms.moment.y) = (0.0, 0.0);
        }
    }
}

/// Weight of a pair of axes in `ωᵀ J ω`: a pair of different axes stands for two entries of the tensor.
fn spin_product(spin: &Vector3<f64>, pair: usize) -> f64 {
    let (a, b) = PAIRS[pair];
    spin[a] * spin[b] * if a == b { 1.0 } else { 2.0 }
}
