//! Small superelements through their files, their energy summed over the nodes, and an explicit integrator.

#![allow(dead_code, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use dcb_formats::Component;
use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::mesh::Dimension;
use dcb_reducer::{Reduced, Reduction, reduce};
use dcb_runtime::{FlexibleBody, InertiaTerms};
use dcb_samples::spatial_beam::BeamSection;
use dcb_samples::{Material, RodSection, SolidElement, SpatialBeam, box_block, planar_rod, spatial_beam};
use faer::{Mat, MatRef};
use nalgebra::{Matrix3, Quaternion, Vector3};

/// A component, its reduction, and the body that a reader of the file gets.
pub struct Part {
    pub component: Component,
    pub reduced: Reduced,
    pub body: FlexibleBody,
}

impl Part {
    pub fn reduced(component: Component, modes: usize) -> Self {
        let reduced = reduce(&component, &Reduction::lowest(modes), &mut ()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.dcb.h5");
        let contents = Contents { superelement: &reduced.superelement, recovery: None, mesh: None };
        write_superelement(&path, &contents, &WriteOptions::default()).unwrap();
        let body = FlexibleBody::load(&path).unwrap();
        Self { component, reduced, body }
    }

    /// Ψ_r over all dofs, (n_e, n).
    pub fn basis(&self) -> Mat<f64> {
        let recovery = &self.reduced.recovery;
        let attachments = &recovery.residual * &self.body.attachment_transform;
        let n_k = recovery.modes.ncols();
        Mat::from_fn(recovery.modes.nrows(), n_k + attachments.ncols(), |i, j| match j < n_k {
            true => recovery.modes[(i, j)],
            false => attachments[(i, j - n_k)],
        })
    }

    pub fn terms(&self) -> InertiaTerms {
        InertiaTerms::for_coordinates(self.body.coordinate_count())
    }

    /// Axis-aligned spin that the part can have.
    pub fn spin(&self, spin: Vector3<f64>) -> Vector3<f64> {
        match self.component.dimension() {
            Dimension::Planar => Vector3::new(0.0, 0.0, spin.z),
            Dimension::Spatial => spin,
        }
    }

    pub fn velocity(&self, velocity: Vector3<f64>) -> Vector3<f64> {
        match self.component.dimension() {
            Dimension::Planar => Vector3::new(velocity.x, velocity.y, 0.0),
            Dimension::Spatial => velocity,
        }
    }
}

/// The parts that every identity is tried on: a beam with exact component masses in the plane and in space, and a solid.
pub fn parts() -> Vec<(&'static str, Part)> {
    let beam = SpatialBeam {
        start: [0.1, 0.2, -0.1],
        end: [0.7, 0.5, 0.3],
        roll: 0.4,
        section: BeamSection::rectangle(0.02, 0.05),
        ..SpatialBeam::default()
    };
    vec![
        ("planar rod", Part::reduced(planar_rod(4, &RodSection { angle: 0.3, ..RodSection::default() }), 4)),
        ("spatial beam", Part::reduced(spatial_beam(&beam), 5)),
        ("box", Part::reduced(box_block([3, 2, 2], [0.4, 0.2, 0.1], SolidElement::Hexahedron, &Material::SOFT), 6)),
    ]
}

/// Repeatable numbers in (-1, 1).
pub fn numbers(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    (0..count)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        })
        .collect()
}

/// Coordinates whose largest nodal translation is `size`.
pub fn deflection(basis: &Mat<f64>, size: f64, seed: u64) -> Vec<f64> {
    let y = numbers(basis.ncols(), seed);
    let u = product(basis, &y);
    let largest = u.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    y.iter().map(|y| y * size / largest).collect()
}

pub fn product(matrix: &Mat<f64>, x: &[f64]) -> Vec<f64> {
    (0..matrix.nrows()).map(|i| (0..x.len()).map(|j| matrix[(i, j)] * x[j]).sum()).collect()
}

pub fn dense(matrix: &dcb_formats::SparseMatrix) -> Mat<f64> {
    let mut full = Mat::zeros(matrix.nrows(), matrix.ncols());
    for column in 0..matrix.ncols() {
        for (row, value) in matrix.row_idx_of_col_raw(column).iter().zip(matrix.val_of_col(column)) {
            full[(*row as usize, column)] = *value;
        }
    }
    full
}

fn bilinear(x: &[f64], matrix: MatRef<'_, f64>, y: &[f64]) -> f64 {
    (0..x.len()).map(|i| x[i] * (0..y.len()).map(|j| matrix[(i, j)] * y[j]).sum::<f64>()).sum()
}

/// Kinetic energy of the finite element model itself: no invariants, only nodal velocities (body axes) and the mass matrix;
/// nodes with rotations through the element-integrated component masses.
pub fn nodal_energy(part: &Part, velocity: &Vector3<f64>, spin: &Vector3<f64>, y: &[f64], rates: &[f64]) -> f64 {
    let component = &part.component;
    let origin = Vector3::from(part.body.origin);
    let basis = part.basis();
    let (u, du) = (product(&basis, y), product(&basis, rates));
    let dofs = component.dofs.dofs();
    let position = |row: usize| Vector3::from(component.mesh.position(dofs[row].node)) - origin;
    // A nodal vector field's value at the node of a row, all three components.
    let at_node = |field: &[f64], row: usize| {
        Vector3::from_fn(|axis, _| {
            let direction = dcb_formats::mesh::Direction::ALL[axis];
            component.dofs.row(dofs[row].node, direction).map_or(0.0, |at| field[at])
        })
    };
    // Rigid motion and rate of deflection at every dof.
    let rigid: Vec<f64> = (0..dofs.len())
        .map(|row| {
            let axis = dofs[row].direction.axis();
            match dofs[row].direction.is_rotation() {
                true => spin[axis] + du[row],
                false => (velocity + spin.cross(&position(row)))[axis] + du[row],
            }
        })
        .collect();
    let mass = dense(&component.mass);
    let Some(masses) = &component.component_masses else {
        let nodal: Vec<f64> =
            (0..dofs.len()).map(|row| rigid[row] + spin.cross(&at_node(&u, row))[dofs[row].direction.axis()]).collect();
        return 0.5 * bilinear(&nodal, mass.as_ref(), &nodal);
    };
    // ω × u has components whose shape functions are those of other components: field[c][b] is interpolated by N_b and
    // counts in direction c.
    let d = component.dimension().coordinate_count();
    let order: &[(usize, usize)] = match d {
        2 => &[(0, 0), (1, 1), (0, 1)],
        _ => &[(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)],
    };
    let matrices: Vec<Mat<f64>> = masses.matrices.iter().map(dense).collect();
    let pair = |b: usize, e: usize, x: &[f64], z: &[f64]| match order.iter().position(|p| *p == (b, e)) {
        Some(at) => bilinear(x, matrices[at].as_ref(), z),
        None => bilinear(z, matrices[order.iter().position(|p| *p == (e, b)).unwrap()].as_ref(), x),
    };
    type Fields = Vec<Vec<Vec<f64>>>;
    let inner = |f: &Fields, g: &Fields| -> f64 {
        let mut sum = 0.0;
        for c in 0..d {
            for b in 0..d {
                for e in 0..d {
                    sum += pair(b, e, &f[c][b], &g[c][e]);
                }
            }
        }
        sum
    };
    let skew = Matrix3::new(0.0, -spin.z, spin.y, spin.z, 0.0, -spin.x, -spin.y, spin.x, 0.0);
    let fields = |along: &dyn Fn(usize) -> f64, crossed: &dyn Fn(usize) -> f64| -> Fields {
        let entry = |c: usize, b: usize, row: usize| skew[(c, b)] * crossed(row) + if c == b { along(row) } else { 0.0 };
        (0..d).map(|c| (0..d).map(|b| (0..dofs.len()).map(|row| entry(c, b, row)).collect()).collect()).collect()
    };
    let translation = |row: usize| if dofs[row].direction.is_rotation() { 0.0 } else { 1.0 };
    let axis = |row: usize| dofs[row].direction.axis();
    let rigid_part =
        fields(&|row| velocity[axis(row)] * translation(row) + du[row], &|row| position(row)[axis(row)] * translation(row));
    let turned = fields(&|_| 0.0, &|row| u[row]);
    0.5 * bilinear(&rigid, mass.as_ref(), &rigid) + inner(&rigid_part, &turned) + 0.5 * inner(&turned, &turned)
}

/// Attitude, spin, coordinates and rates of a body that nothing acts on.
#[derive(Clone)]
pub struct FreeState {
    pub orientation: Quaternion<f64>,
    pub spin: Vector3<f64>,
    pub y: Vec<f64>,
    pub rates: Vec<f64>,
}

impl FreeState {
    pub fn spinning(body: &FlexibleBody, spin: Vector3<f64>) -> Self {
        let zeros = vec![0.0; body.coordinate_count()];
        Self { orientation: Quaternion::identity(), spin, y: zeros.clone(), rates: zeros }
    }

    pub fn pack(&self) -> Vec<f64> {
        let q = &self.orientation;
        [q.w, q.i, q.j, q.k].into_iter().chain(self.spin.iter().copied()).chain(self.y.clone()).chain(self.rates.clone()).collect()
    }

    pub fn unpack(x: &[f64]) -> Self {
        let n = (x.len() - 7) / 2;
        Self {
            orientation: Quaternion::new(x[0], x[1], x[2], x[3]),
            spin: Vector3::new(x[4], x[5], x[6]),
            y: x[7..7 + n].to_vec(),
            rates: x[7 + n..].to_vec(),
        }
    }

    /// Energy about the centre of mass, and angular momentum in world axes.
    pub fn invariants(&self, body: &FlexibleBody, terms: &mut InertiaTerms) -> (f64, Vector3<f64>) {
        body.inertia.evaluate(&self.y, &self.spin, &self.rates, terms);
        let kinetic = terms.kinetic_energy(body.inertia.mass(), &Vector3::zeros(), &self.spin, &self.rates);
        let momentum = terms.angular_momentum(&self.spin, &self.rates);
        let unit = nalgebra::UnitQuaternion::from_quaternion(self.orientation);
        (kinetic + body.strain_energy(&self.y), unit * momentum)
    }
}

/// d/dt of a packed free state.
pub fn free_motion(body: &FlexibleBody, terms: &mut InertiaTerms, x: &[f64], dx: &mut [f64]) {
    let n = body.coordinate_count();
    let spin = Vector3::new(x[4], x[5], x[6]);
    let (y, rates) = x[7..].split_at(n);
    let turning = Quaternion::new(x[0], x[1], x[2], x[3]) * Quaternion::from_imag(spin) * 0.5;
    dx[..4].copy_from_slice(&[turning.w, turning.i, turning.j, turning.k]);
    body.inertia.evaluate(y, &spin, rates, terms);
    let (dy, forces) = dx[7..].split_at_mut(n);
    dy.copy_from_slice(rates);
    body.internal_forces(y, rates, forces);
    forces.iter_mut().for_each(|force| *force = -*force);
    let spin_rate = terms.accelerations(body.inertia.dimension(), &Vector3::zeros(), forces).unwrap();
    dx[4..7].copy_from_slice(spin_rate.as_slice());
}

/// Dormand and Prince's pair of orders 5 and 4 with step control, from 0 to `end`; `scale` is each entry's absolute tolerance.
pub fn integrate(mut f: impl FnMut(&[f64], &mut [f64]), x: &mut Vec<f64>, end: f64, scale: &[f64]) {
    const A: [[f64; 6]; 6] = [
        [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
        [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
        [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
        [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
        [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
    ];
    const E: [f64; 7] = [
        71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0,
    ];
    let n = x.len();
    let mut k = vec![vec![0.0; n]; 7];
    let (mut t, mut h) = (0.0, 1e-3 * end);
    let mut trial = vec![0.0; n];
    f(x, &mut k[0]);
    while t < end {
        h = f64::min(h, end - t);
        for stage in 0..6 {
            for i in 0..n {
                trial[i] = x[i] + h * (0..=stage).map(|j| A[stage][j] * k[j][i]).sum::<f64>();
            }
            f(&trial, &mut k[stage + 1]);
        }
        let error = (0..n)
            .map(|i| (h * (0..7).map(|j| E[j] * k[j][i]).sum::<f64>() / scale[i]).abs())
            .fold(0.0, f64::max);
        if error <= 1.0 {
            t += h;
            x.copy_from_slice(&trial);
            k.swap(0, 6);
        }
        h *= (0.9 * error.max(1e-8).powf(-0.2)).clamp(0.2, 4.0);
    }
}
