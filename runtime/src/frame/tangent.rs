//! Exact derivatives of the inertia forces of [`super::forces`].
//!
//! Columns are accelerations (A, ω', y''), velocities (ω, y') at fixed accelerations, and configuration (φ, y) at fixed velocities
//! and accelerations. φ turns the frame about body axes, δA = A skew(δφ), and enters through the origin's acceleration alone:
//! δ(Aᵀ a) = Aᵀ a × δφ. With p = L1 y, Λ = I3 + L(y), H = J ω + Λ y', L_k = column k of L, s_k(x) = Σ_l L3[:, k, l] x_l:
//!
//! ```text
//!        mass                  damping (ω, y')                          stiffness (φ, y)
//! RR     m I                   -                                        -
//! Rφ    -skew(p)              -2 skew(p') - skew(ω×p) - skew(ω) skew(p)   m skew(A)
//! Ry     L1_k                  2 ω × L1_k                               ω' × L1_k + ω × (ω × L1_k)
//! φφ     J                     J' - skew(H) + skew(ω) J                 skew(p) skew(A)
//! φy     Λ_k                   J'_k ω + ω × Λ_k                         J'_k ω' + 2 (J2 y')_k ω + s_k(y'') + ω × (J'_k ω + s_k(y')) + L1_k × A
//! yφ     Λ_k                   2 L(y')_k - J'_k ω                       L1_k × A
//! yy     M                     2 G(ω)                                   L3(ω')ᵀ - ωᵀ J2 ω
//! ```

use faer::MatMut;
use nalgebra::{Matrix3, Matrix6, Vector3};
use pulp::{Arch, Simd, WithSimd};

use dcb_formats::mesh::Dimension;

use super::rotary_inertia::PAIRS;
use super::{BodyAcceleration, BodyState, FrameInertia, InertiaTerms};

/// One derivative of the inertia forces but for its part over the coordinates alone. Rows and columns of the frame are
/// translation, then rotation, in body axes; planar bodies have entries 0, 1 and 5 only, the others are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct TangentBlock {
    /// Frame by frame.
    pub rigid: Matrix6<f64>,
    /// Force and moment on the frame by coordinates, row by row, (n) each.
    pub rigid_by_elastic: Vec<f64>,
    /// Forces on y by the frame's motion, column by column, (n) each.
    pub elastic_by_rigid: Vec<f64>,
}

/// Derivatives of the inertia forces; made once, overwritten by every evaluation.
///
/// Over the coordinates alone the mass is the constant one of the body, and the diagonal of the damping is zero.
/// [`FrameInertia::write_elastic_tangent`] writes the full blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct InertiaTangent {
    /// By the accelerations of the origin, of the spin, and of y; symmetric.
    pub mass: TangentBlock,
    /// By the spin and y'. The columns of the origin's velocity are zero.
    pub damping: TangentBlock,
    /// By rotation and y. The columns of the origin's position are zero.
    pub stiffness: TangentBlock,
    /// Diagonal of the stiffness over y, (n), not positive: centrifugal softening.
    pub softening: Vec<f64>,
    /// `2 J2 y'` by pairs of axes, (n) each.
    second_order_rates: Vec<f64>,
    /// `L(y'')ᵀ` by axes, (n) each.
    acceleration_coupling: Vec<f64>,
}

impl TangentBlock {
    fn for_coordinates(count: usize) -> Self {
        Self {
            rigid: Matrix6::zeros(),
            rigid_by_elastic: vec![0.0; 6 * count],
            elastic_by_rigid: vec![0.0; 6 * count],
        }
    }

    fn set_rigid(&mut self, at: (usize, usize), block: &Matrix3<f64>) {
        self.rigid
            .fixed_view_mut::<3, 3>(at.0, at.1)
            .copy_from(block);
    }

    /// Planar bodies don't leave their plane.
    fn keep_plane(&mut self) {
        for out in 2..5 {
            self.rigid.row_mut(out).fill(0.0);
            self.rigid.column_mut(out).fill(0.0);
        }
    }
}

impl InertiaTangent {
    /// Room for a body of `count` dynamic coordinates.
    pub fn for_coordinates(count: usize) -> Self {
        Self {
            mass: TangentBlock::for_coordinates(count),
            damping: TangentBlock::for_coordinates(count),
            stiffness: TangentBlock::for_coordinates(count),
            softening: vec![0.0; count],
            second_order_rates: vec![0.0; PAIRS.len() * count],
            acceleration_coupling: vec![0.0; 3 * count],
        }
    }
}

impl FrameInertia {
    /// The derivatives at a state that `terms` was evaluated at last, but for the full blocks over the coordinates alone.
    pub fn evaluate_tangent(
        &self,
        state: &BodyState<'_>,
        acceleration: &BodyAcceleration<'_>,
        terms: &InertiaTerms,
        tangent: &mut InertiaTangent,
    ) {
        Arch::new().dispatch(TangentEvaluation {
            inertia: self,
            state,
            acceleration,
            terms,
            tangent,
        });
    }

    /// Writes the derivatives of the forces on y by y' and by y, (n, n) each; the second without elasticity.
    ///
    /// ```text
    /// C_kl = 2 Σ_a ω_a L3[a, l, k]            K_lk = Σ_a ω'_a L3[a, k, l] - ωᵀ J2_kl ω
    /// ```
    pub fn write_elastic_tangent(
        &self,
        spin: &Vector3<f64>,
        spin_rate: &Vector3<f64>,
        mut damping: MatMut<'_, f64>,
        mut stiffness: MatMut<'_, f64>,
    ) {
        damping.fill(0.0);
        self.rotation.add_combined_coupling(&(2.0 * spin), damping);
        stiffness.fill(0.0);
        self.rotation
            .add_combined_coupling(spin_rate, stiffness.as_mut());
        self.rotation
            .subtract_second_order(spin, self.attachment_mass.as_ref(), stiffness);
    }
}

struct TangentEvaluation<'a> {
    inertia: &'a FrameInertia,
    state: &'a BodyState<'a>,
    acceleration: &'a BodyAcceleration<'a>,
    terms: &'a InertiaTerms,
    tangent: &'a mut InertiaTangent,
}

impl WithSimd for TangentEvaluation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        self.rigid();
        self.elastic(simd);
    }
}

impl TangentEvaluation<'_> {
    fn rigid(&mut self) {
        let (terms, tangent) = (self.terms, &mut *self.tangent);
        let (spin, origin) = (&self.state.spin, &self.acceleration.origin);
        let mass = self.inertia.mass;
        let p = &terms.first_moment;
        let turning = spin.cross_matrix();
        let momentum = terms.rotary * spin + terms.relative;

        tangent
            .mass
            .set_rigid((0, 0), &(Matrix3::identity() * mass));
        tangent.mass.set_rigid((0, 3), &-p.cross_matrix());
        tangent.mass.set_rigid((3, 0), &p.cross_matrix());
        tangent.mass.set_rigid((3, 3), &terms.rotary);

        let of_spin = -2.0 * terms.first_moment_rate.cross_matrix()
            - spin.cross(p).cross_matrix()
            - turning * p.cross_matrix();
        tangent.damping.set_rigid((0, 3), &of_spin);
        let of_spin = terms.rotary_rate - momentum.cross_matrix() + turning * terms.rotary;
        tangent.damping.set_rigid((3, 3), &of_spin);

        let lever = origin.cross_matrix();
        tangent.stiffness.set_rigid((0, 3), &(mass * lever));
        tangent
            .stiffness
            .set_rigid((3, 3), &(p.cross_matrix() * lever));

        if self.inertia.dimension() == Dimension::Planar {
            tangent.mass.keep_plane();
            tangent.damping.keep_plane();
            tangent.stiffness.keep_plane();
        }
    }

    #[inline(always)]
    fn elastic<S: Simd>(&mut self, simd: S) {
        let (inertia, terms) = (self.inertia, self.terms);
        let InertiaTangent {
            mass,
            damping,
            stiffness,
            softening,
            second_order_rates,
            acceleration_coupling,
        } = &mut *self.tangent;
        let n = softening.len();
        if n == 0 {
            return;
        }
        let BodyState { rates, spin, .. } = *self.state;
        let BodyAcceleration {
            origin,
            spin_rate,
            second_rates,
        } = *self.acceleration;
        let attachment_mass = inertia.attachment_mass.as_ref();
        second_order_rates.fill(0.0);
        acceleration_coupling.fill(0.0);
        let rotation = &inertia.rotation;
        rotation.add_second_order(simd, rates, attachment_mass, second_order_rates);
        rotation.add_coupling(simd, [second_rates], [acceleration_coupling]);
        for (k, softening) in softening.iter_mut().enumerate() {
            let gradient = symmetric(&terms.gradient, n, k);
            let column = vector(&terms.coupling, n, k);
            let of_rates = vector(&terms.rate_coupling, n, k);
            let of_accelerations = vector(acceleration_coupling, n, k);
            let along = gradient * spin;
            // L3 is antisymmetric: Σ_l L3[:, k, l] x_l = -L(x)_k.
            let by_y = gradient * spin_rate + symmetric(second_order_rates, n, k) * spin
                - of_accelerations
                + spin.cross(&(along - of_rates));
            set(&mut mass.rigid_by_elastic, 3, n, k, &column);
            set(&mut mass.elastic_by_rigid, 3, n, k, &column);
            set(
                &mut damping.rigid_by_elastic,
                3,
                n,
                k,
                &(along + spin.cross(&column)),
            );
            set(
                &mut damping.elastic_by_rigid,
                3,
                n,
                k,
                &(2.0 * of_rates - along),
            );
            set(&mut stiffness.rigid_by_elastic, 3, n, k, &by_y);
            *softening = -rotation.second_order_diagonal(&spin, attachment_mass, k);
        }
        let Some(momentum) = &inertia.momentum else {
            stiffness.elastic_by_rigid.fill(0.0);
            for block in [mass, damping, stiffness] {
                block.rigid_by_elastic[..3 * n].fill(0.0);
                block.elastic_by_rigid[..3 * n].fill(0.0);
            }
            return;
        };
        for k in 0..n {
            let linear = momentum.linear_column(k);
            set(&mut mass.rigid_by_elastic, 0, n, k, &linear);
            set(&mut mass.elastic_by_rigid, 0, n, k, &linear);
            set(
                &mut damping.rigid_by_elastic,
                0,
                n,
                k,
                &(2.0 * spin.cross(&linear)),
            );
            let carried = spin_rate.cross(&linear) + spin.cross(&spin.cross(&linear));
            set(&mut stiffness.rigid_by_elastic, 0, n, k, &carried);
            let lever = linear.cross(&origin);
            set(&mut stiffness.elastic_by_rigid, 3, n, k, &lever);
            let by_y = vector(&stiffness.rigid_by_elastic[3 * n..], n, k) + lever;
            set(&mut stiffness.rigid_by_elastic, 3, n, k, &by_y);
        }
    }
}

/// Entry k of three rows of length n.
#[inline(always)]
fn vector(rows: &[f64], n: usize, k: usize) -> Vector3<f64> {
    Vector3::new(rows[k], rows[n + k], rows[2 * n + k])
}

/// Entry k of six rows of length n, by pairs of axes.
#[inline(always)]
fn symmetric(rows: &[f64], n: usize, k: usize) -> Matrix3<f64> {
    let [xx, yy, zz, xy, yz, zx] = [0, 1, 2, 3, 4, 5].map(|pair| rows[pair * n + k]);
    Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz)
}

/// Sets entry k of three rows of length n from row `first` on.
#[inline(always)]
fn set(rows: &mut [f64], first: usize, n: usize, k: usize, value: &Vector3<f64>) {
    for axis in 0..3 {
        rows[(first + axis) * n + k] = value[axis];
    }
}
