//! A component reduced by dense algebra: the generalized inverse from a bordered system, the modes from a dense
//! symmetric eigenproblem, residual columns from a bordered system with the kept modes in the border.

use dcb_formats::Component;
use dcb_formats::mesh::Dof;
use faer::{Mat, Side};

use crate::dense::{dense, eigen, largest, solve, symmetric};
use crate::localization::localization;

/// Dense matrices of a component and its complete set of elastic modes.
pub struct Oracle {
    /// K.
    pub stiffness: Mat<f64>,
    /// M.
    pub mass: Mat<f64>,
    /// Rigid motions about the centre of mass, (n, 3 or 6); none for a held part.
    pub rigid: Mat<f64>,
    /// L_b.
    pub localization: Mat<f64>,
    /// G, the mean-axis generalized inverse.
    pub inverse: Mat<f64>,
    /// Every finite elastic ω², ascending.
    pub eigenvalues: Vec<f64>,
    /// Φ, mass-normalised.
    pub shapes: Mat<f64>,
}

/// Centre of mass from the mean node position and `Tᵀ M (x - mean)`.
pub fn centre_of_mass(component: &Component) -> (f64, [f64; 3]) {
    let mass = dense(&component.mass);
    let d = component.dimension().coordinate_count();
    let n = component.mesh.node_count();
    let dofs: Vec<(usize, Dof)> = component.dofs.nodal().collect();
    let (mut total, mut centre) = (0.0, [0.0; 3]);
    for (axis, coordinate) in centre.iter_mut().enumerate().take(d) {
        let mean = (0..n as u32)
            .map(|node| component.mesh.position(node)[axis])
            .sum::<f64>()
            / n as f64;
        let along =
            |(_, dof): &&(usize, Dof)| !dof.direction.is_rotation() && dof.direction.axis() == axis;
        let (mut of_axis, mut moment) = (0.0, 0.0);
        for (i, _) in dofs.iter().filter(along) {
            for (j, dof) in dofs.iter().filter(along) {
                of_axis += mass[(*i, *j)];
                moment += mass[(*i, *j)] * (component.mesh.position(dof.node)[axis] - mean);
            }
        }
        *coordinate = mean + moment / of_axis;
        total += of_axis / d as f64;
    }
    (total, centre)
}

/// Rigid motions about a point: unit translations, then unit rotations; internal rows stay at rest.
pub fn rigid_motions(component: &Component, about: [f64; 3]) -> Mat<f64> {
    let planar = component.dimension().coordinate_count() == 2;
    let axes: &[usize] = if planar { &[2] } else { &[0, 1, 2] };
    let d = if planar { 2 } else { 3 };
    Mat::from_fn(component.dofs.len(), d + axes.len(), |row, column| {
        let Some(Dof { node, direction }) = component.dofs.dof(row) else {
            return 0.0;
        };
        if column < d {
            return f64::from(u8::from(
                !direction.is_rotation() && direction.axis() == column,
            ));
        }
        let axis = axes[column - d];
        if direction.is_rotation() {
            return f64::from(u8::from(direction.axis() == axis));
        }
        let x = component.mesh.position(node);
        let arm = nalgebra::Vector3::from_fn(|i, _| x[i] - about[i]);
        nalgebra::Vector3::from_fn(|i, _| f64::from(u8::from(i == axis))).cross(&arm)
            [direction.axis()]
    })
}

/// `[[K, B], [Bᵀ, 0]] [X; ·] = [F - B (…) ; 0]`: the solution with `Bᵀ X = 0`; B = M Φₐ, F made free of Φₐ.
fn bordered(
    stiffness: &Mat<f64>,
    mass: &Mat<f64>,
    border: &Mat<f64>,
    forces: &Mat<f64>,
) -> Mat<f64> {
    let (n, r) = (stiffness.nrows(), border.ncols());
    let mass_border = mass * border;
    // Columns brought to the size of K, which does not change X.
    let scale: Vec<f64> = (0..r)
        .map(|j| largest(stiffness.as_ref()) / largest(mass_border.as_ref().subcols(j, 1)))
        .collect();
    let matrix = Mat::from_fn(n + r, n + r, |i, j| match (i < n, j < n) {
        (true, true) => stiffness[(i, j)],
        (true, false) => mass_border[(i, j - n)] * scale[j - n],
        (false, true) => mass_border[(j, i - n)] * scale[i - n],
        (false, false) => 0.0,
    });
    let mut free = forces.clone();
    if r > 0 {
        // P' F = F - M Φₐ (Φₐᵀ M Φₐ)⁻¹ Φₐᵀ F
        let amounts = solve(
            &(border.transpose() * &mass_border),
            &(border.transpose() * forces),
        );
        free -= &mass_border * amounts;
    }
    let right = Mat::from_fn(n + r, forces.ncols(), |i, j| {
        if i < n { free[(i, j)] } else { 0.0 }
    });
    solve(&matrix, &right).as_ref().subrows(0, n).to_owned()
}

impl Oracle {
    /// A free component.
    pub fn of(component: &Component) -> Self {
        let (_, centre) = centre_of_mass(component);
        Self::from_parts(
            dense(&component.stiffness),
            dense(&component.mass),
            rigid_motions(component, centre),
            localization(component),
        )
    }

    /// From matrices; `rigid` spans every motion without stiffness.
    pub fn from_parts(
        stiffness: Mat<f64>,
        mass: Mat<f64>,
        rigid: Mat<f64>,
        localization: Mat<f64>,
    ) -> Self {
        let n = stiffness.nrows();
        let inverse = symmetric(&bordered(
            &stiffness,
            &mass,
            &rigid,
            &crate::dense::identity(n),
        ));
        // M = W Wᵀ: Cholesky, or the eigenvectors with mass where M is semi-definite.
        let root = match mass.llt(Side::Lower) {
            Ok(factor) => factor.L().to_owned(),
            Err(_) => {
                let (values, vectors) = eigen(&mass);
                let top = values.last().copied().unwrap_or(0.0);
                let kept: Vec<usize> = (0..n).filter(|i| values[*i] > 1e-12 * top).collect();
                Mat::from_fn(n, kept.len(), |i, j| {
                    vectors[(i, kept[j])] * values[kept[j]].sqrt()
                })
            }
        };
        // K φ = ω² M φ with Xᵀ M φ = 0 is φ = ω² G W Wᵀ φ: eigenvalues 1/ω² of Wᵀ G W.
        let projected = symmetric(&(root.transpose() * &inverse * &root));
        let (theta, vectors) = eigen(&projected);
        let count = root.ncols() - rigid.ncols();
        let order: Vec<usize> = (0..theta.len()).rev().take(count).collect();
        let chosen = Mat::from_fn(root.ncols(), count, |i, j| {
            vectors[(i, order[j])] / theta[order[j]]
        });
        let shapes = &inverse * &root * chosen;
        Self {
            eigenvalues: order.iter().map(|i| 1.0 / theta[*i]).collect(),
            stiffness,
            mass,
            rigid,
            localization,
            inverse,
            shapes,
        }
    }

    /// The lowest kept modes.
    pub fn kept(&self, count: usize) -> Mat<f64> {
        self.shapes.as_ref().subcols(0, count).to_owned()
    }

    /// `G_res F` with the `count` lowest modes kept.
    pub fn residual_response(&self, count: usize, forces: &Mat<f64>) -> Mat<f64> {
        let (n, r) = (self.stiffness.nrows(), self.rigid.ncols());
        let border = Mat::from_fn(n, r + count, |i, j| {
            if j < r {
                self.rigid[(i, j)]
            } else {
                self.shapes[(i, j - r)]
            }
        });
        bordered(&self.stiffness, &self.mass, &border, forces)
    }

    /// `G_res L_bᵀ`.
    pub fn residual_shapes(&self, count: usize) -> Mat<f64> {
        self.residual_response(count, &self.localization.transpose().to_owned())
    }

    /// F_res.
    pub fn residual_flexibility(&self, count: usize) -> Mat<f64> {
        symmetric(&(&self.localization * self.residual_shapes(count)))
    }

    /// M_res.
    pub fn residual_mass(&self, count: usize) -> Mat<f64> {
        let shapes = self.residual_shapes(count);
        symmetric(&(shapes.transpose() * &self.mass * &shapes))
    }

    /// ε |φ|ᵀ|K||φ| / ω²: what rounding in K alone does to an eigenvalue.
    pub fn eigenvalue_rounding(&self, mode: usize) -> f64 {
        let n = self.stiffness.nrows();
        let mut sum = 0.0;
        for j in 0..n {
            for i in 0..n {
                sum += (self.shapes[(i, mode)] * self.stiffness[(i, j)] * self.shapes[(j, mode)])
                    .abs();
            }
        }
        f64::EPSILON * sum / self.eigenvalues[mode]
    }
}
