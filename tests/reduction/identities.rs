//! Do the identities of the method hold, evaluated by other means than the reducer's own quality report?
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::needless_range_loop
)]

use dcb_formats::{Component, Superelement};
use dcb_reducer::inertia::invariants::inertia_invariants;
use dcb_reducer::model::rigid_body::{MassProperties, component_columns};
use dcb_samples::spatial_beam::SpatialBeam;
use dcb_samples::{PseudoRandom, RodSection, SolidElement};
use dcb_tests::accuracy::basis;
use dcb_tests::dense::{diagonal_roots, identity, largest, scaled_difference, times};
use dcb_tests::oracle::{Oracle, centre_of_mass, rigid_motions};
use dcb_tests::{fields, lowest, nodal, parts};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

/// Energy norms of columns: with K (or M) times them.
fn norms(x: &Mat<f64>, product: &Mat<f64>) -> Vec<f64> {
    diagonal_roots(&(x.transpose() * product))
}

fn largest_cosine(a: &Mat<f64>, b: &Mat<f64>, na: &[f64], nb: &[f64]) -> f64 {
    let gram = a.transpose() * b;
    let mut worst = 0.0_f64;
    for j in 0..gram.ncols() {
        for i in 0..gram.nrows() {
            if na[i] * nb[j] > 0.0 {
                worst = worst.max((gram[(i, j)] / (na[i] * nb[j])).abs());
            }
        }
    }
    worst
}

/// Every sample that can be reduced, with the limit that its conditioning allows for K-identities.
fn samples() -> Vec<(Component, f64)> {
    [
        "rod",
        "beam",
        "timoshenko-beam",
        "block",
        "block-tetra10",
        "reference-hexahedra",
        "reference-tetrahedra",
    ]
    .into_iter()
    .map(|name| (name, 1e-10))
    .chain([
        ("square-block", 1e-10),
        ("symmetric-ring", 1e-8),
        ("slender-block", 1e-7),
        ("thin-plate", 1e-7),
    ])
    .map(|(name, limit)| {
        (
            dcb_samples::catalogue::find(name).unwrap().make(None),
            limit,
        )
    })
    .collect()
}

#[test]
fn modes_and_attachments_are_orthogonal_in_mass_and_stiffness() {
    for (component, limit) in samples() {
        let reduced = lowest(&component, 8);
        let (phi, x) = (&reduced.recovery.modes, &reduced.recovery.residual);
        let (k_phi, m_phi) = (
            times(&component.stiffness, phi.as_ref()),
            times(&component.mass, phi.as_ref()),
        );
        let (k_x, m_x) = (
            times(&component.stiffness, x.as_ref()),
            times(&component.mass, x.as_ref()),
        );
        let name = &component.name;
        // Eq. 29, 30
        assert!(
            largest_cosine(phi, &k_x, &norms(phi, &k_phi), &norms(x, &k_x)) < limit,
            "{name}: Φᵀ K G_res"
        );
        let cosine = largest_cosine(phi, &m_x, &norms(phi, &m_phi), &norms(x, &m_x));
        // What convergence and rounding leave of the modes' residuals comes back here where it is harmless: up to the share of
        // kept modes that an attachment column may hold.
        assert!(cosine < 2e-9, "{name}: Φᵀ M G_res {cosine:e}");
        // Eq. 31
        let n = reduced.superelement.mode_count();
        assert!(
            largest((phi.transpose() * &m_phi - identity(n)).as_ref()) < 1e-12,
            "{name}: Φᵀ M Φ"
        );
        let omega = dcb_tests::dense::diagonal(&reduced.superelement.modes.eigenvalues);
        let scale: Vec<f64> = reduced
            .superelement
            .modes
            .eigenvalues
            .iter()
            .map(|v| v.sqrt())
            .collect();
        assert!(
            scaled_difference(&(phi.transpose() * &k_phi), &omega, &scale) < limit,
            "{name}: Φᵀ K Φ"
        );
        // Eq. 32
        let f = &reduced.superelement.residual.flexibility;
        assert!(
            scaled_difference(&(x.transpose() * &k_x), f, &diagonal_roots(f)) < limit,
            "{name}: XᵀKX = F_res"
        );
        let m = &reduced.superelement.residual.mass;
        assert!(
            scaled_difference(&(x.transpose() * &m_x), m, &diagonal_roots(m)) < 1e-11,
            "{name}: XᵀMX = M_res"
        );
        // Eq. 39, 40: the columns are M-orthogonal to the rigid motions.
        let r = rigid_motions(&component, centre_of_mass_sparse(&component));
        let m_r = times(&component.mass, r.as_ref());
        let rigid = norms(&r, &m_r);
        assert!(
            largest_cosine(&m_r, phi, &rigid, &norms(phi, &m_phi)) < 1e-11,
            "{name}: L1, I3 of modes"
        );
        assert!(
            largest_cosine(&m_r, x, &rigid, &norms(x, &m_x)) < 1e-10,
            "{name}: L1, I3 of attachments"
        );
    }
}

/// `Tᵀ M x / m` by entries.
fn centre_of_mass_sparse(component: &Component) -> [f64; 3] {
    let x = rigid_motions(component, [0.0; 3]);
    let d = component.dimension().coordinate_count();
    let dofs = component.dofs.nodal_dofs();
    let field = Mat::from_fn(dofs.len(), d, |row, axis| {
        let dof = dofs[row];
        let along = !dof.direction.is_rotation() && dof.direction.axis() == axis;
        if along {
            component.mesh.position(dof.node)[axis]
        } else {
            0.0
        }
    });
    let translations = x.as_ref().subcols(0, d).to_owned();
    let moment = translations.transpose() * times(&component.mass, field.as_ref());
    let mass = translations.transpose() * times(&component.mass, translations.as_ref());
    std::array::from_fn(|i| {
        if i < d {
            moment[(i, i)] / mass[(i, i)]
        } else {
            0.0
        }
    })
}

/// ½ m|R'|² + R'·L1 y' + ½ ωᵀJ(y)ω + ωᵀ(L(y) + I3) y' + ½ y'ᵀ M_f y' from the file's numbers.
fn energy(
    element: &Superelement,
    velocity: Vector3<f64>,
    omega: Vector3<f64>,
    y: &[f64],
    rate: &[f64],
) -> f64 {
    let inertia = &element.inertia;
    let (n, n_k) = (y.len(), element.mode_count());
    let mut total = 0.5 * inertia.mass * velocity.norm_squared();
    let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
    for a in 0..3 {
        for b in 0..3 {
            let pair = pairs
                .iter()
                .position(|p| *p == (a, b) || *p == (b, a))
                .unwrap();
            let mut j = inertia.tensor[a][b];
            for k in 0..n {
                j += inertia.i1[k][a][b] * y[k];
                for l in 0..n {
                    j += y[k] * inertia.i2[pair][(k, l)] * y[l];
                }
            }
            total += 0.5 * omega[a] * j * omega[b];
        }
        for l in 0..n {
            total += (velocity[a] * inertia.l1[(a, l)] + omega[a] * inertia.i3[(a, l)]) * rate[l];
            for k in 0..n {
                total += omega[a] * y[k] * inertia.l3[a][(k, l)] * rate[l];
            }
        }
    }
    total + 0.5 * flexible_energy(element, n_k, rate)
}

/// y'ᵀ diag(I, M_res) y'
fn flexible_energy(element: &Superelement, n_k: usize, rate: &[f64]) -> f64 {
    let modes: f64 = rate[..n_k].iter().map(|v| v * v).sum();
    let m = &element.residual.mass;
    let attached: f64 = (0..m.nrows())
        .flat_map(|i| (0..m.ncols()).map(move |j| (i, j)))
        .map(|(i, j)| rate[n_k + i] * m[(i, j)] * rate[n_k + j])
        .sum();
    modes + attached
}

/// Coordinates of comparable effect: a tenth of the part's size each.
fn random_state(
    element: &Superelement,
    seed: u64,
) -> (Vector3<f64>, Vector3<f64>, Vec<f64>, Vec<f64>) {
    let mut random = PseudoRandom::new(seed);
    let n_k = element.mode_count();
    let scale: Vec<f64> = (0..element.basis_count())
        .map(|k| {
            if k < n_k {
                1.0
            } else {
                1.0 / element.residual.mass[(k - n_k, k - n_k)].sqrt()
            }
        })
        .map(|s| 0.05 * element.inertia.mass.sqrt() * s)
        .collect();
    let velocity = Vector3::from_fn(|_, _| random.number());
    let omega = Vector3::from_fn(|_, _| 3.0 * random.number());
    let y = scale.iter().map(|s| s * random.number()).collect();
    let rate = scale.iter().map(|s| 2.0 * s * random.number()).collect();
    (velocity, omega, y, rate)
}

#[test]
fn kinetic_energy_of_a_solid_is_that_of_its_nodes() {
    for component in [
        dcb_samples::reference_hexahedra(),
        dcb_samples::reference_tetrahedra(),
        parts::steel_box([3, 1, 1], SolidElement::Hexahedron20),
    ] {
        let reduced = lowest(&component, 6);
        let psi = basis(&reduced);
        let (_, centre) = centre_of_mass(&component);
        let x = nodal::positions(&component, centre);
        for seed in 1..6 {
            let (velocity, omega, y, rate) = random_state(&reduced.superelement, seed);
            let field = |q: &[f64]| {
                nodal::vectors(
                    &component,
                    (&psi * Mat::from_fn(q.len(), 1, |i, _| q[i])).as_ref(),
                )
            };
            let (u, u_rate) = (field(&y), field(&rate));
            let v: Vec<_> = (0..x.len())
                .map(|i| velocity + omega.cross(&(x[i] + u[i])) + u_rate[i])
                .collect();
            let column = nodal::column(&component, &v);
            let exact =
                0.5 * (column.transpose() * times(&component.mass, column.as_ref()))[(0, 0)];
            let found = energy(&reduced.superelement, velocity, omega, &y, &rate);
            assert!(
                (found / exact - 1.0).abs() < 1e-12,
                "{}: {found} {exact}",
                component.name
            );
        }
    }
}

#[test]
fn kinetic_energy_of_beams_is_that_of_their_material_points() {
    let rod = RodSection {
        angle: 0.7,
        ..RodSection::default()
    };
    let planar = (parts::tilted_rod(4), fields::rod_points(4, &rod));
    let beam = SpatialBeam::default();
    let spatial = (dcb_samples::spatial_beam(&beam), fields::beam_points(&beam));
    for (component, points) in [planar, spatial] {
        let reduced = lowest(&component, 5);
        let element = &reduced.superelement;
        let psi = basis(&reduced);
        let (_, centre) = centre_of_mass(&component);
        for seed in 1..6 {
            let (mut velocity, mut omega, y, rate) = random_state(element, seed);
            let is_planar = element.dimension.coordinate_count() == 2;
            if is_planar {
                velocity[2] = 0.0;
                (omega[0], omega[1]) = (0.0, 0.0);
            }
            // The points lie on the axis, where spin about it moves nothing.
            omega[0] = 0.0;
            let mut exact = 0.0;
            for point in &points {
                let columns = fields::displacements(point, psi.as_ref());
                let sum = |q: &[f64]| {
                    columns
                        .iter()
                        .zip(q)
                        .map(|(c, q)| c * *q)
                        .sum::<Vector3<f64>>()
                };
                let r = point.position - Vector3::from(centre);
                exact += 0.5
                    * point.mass
                    * (velocity + omega.cross(&(r + sum(&y))) + sum(&rate)).norm_squared();
            }
            let found = match is_planar {
                true => planar_energy(element, velocity, omega[2], &y, &rate),
                false => energy(element, velocity, omega, &y, &rate),
            };
            assert!(
                (found / exact - 1.0).abs() < 1e-11,
                "{}: {found} {exact}",
                component.name
            );
        }
    }
}

/// ½ m|R'|² + ½ θ'² (Iz + 2 I1 y + yᵀM_f y) + θ' yᵀ L3 y' + ½ y'ᵀ M_f y'
fn planar_energy(
    element: &Superelement,
    velocity: Vector3<f64>,
    spin: f64,
    y: &[f64],
    rate: &[f64],
) -> f64 {
    let (inertia, n_k) = (&element.inertia, element.mode_count());
    let first: f64 = y.iter().zip(&inertia.i1).map(|(y, i1)| y * i1[2][2]).sum();
    let moment = inertia.tensor[2][2] + 2.0 * first + flexible_energy(element, n_k, y);
    let coupling: f64 = (0..y.len())
        .map(|k| {
            (0..y.len())
                .map(|l| y[k] * inertia.l3[0][(k, l)] * rate[l])
                .sum::<f64>()
        })
        .sum();
    0.5 * inertia.mass * velocity.norm_squared()
        + 0.5 * spin * spin * moment
        + spin * coupling
        + 0.5 * flexible_energy(element, n_k, rate)
}

#[test]
fn with_every_mode_kept_nothing_is_left_over() {
    for component in [
        parts::rod(4),
        parts::skew_beam(),
        dcb_samples::reference_tetrahedra(),
    ] {
        let none = lowest(&component, 0).superelement.residual;
        let reduced = lowest(&component, component.dofs.len());
        let element = &reduced.superelement;
        let rigid = component.dimension().rigid_mode_count();
        assert_eq!(
            element.mode_count(),
            component.dofs.len() - rigid,
            "{}",
            component.name
        );
        let zero = Mat::zeros(element.rows.len(), element.rows.len());
        assert!(
            scaled_difference(
                &element.residual.flexibility,
                &zero,
                &diagonal_roots(&none.flexibility)
            ) < 1e-10
        );
        assert!(
            scaled_difference(&element.residual.mass, &zero, &diagonal_roots(&none.mass)) < 1e-12
        );
        assert!(
            element.residual.sigma_squared.is_empty()
                && element.modes.first_omitted_eigenvalue.is_infinite()
        );
    }
}

#[test]
fn interface_loads_deflect_statically_as_the_whole_model_does() {
    for component in [
        parts::rod(4),
        parts::skew_beam(),
        parts::steel_box([4, 1, 1], SolidElement::Hexahedron20),
        parts::rotor(),
    ] {
        let oracle = Oracle::of(&component);
        let exact = &oracle.inverse * oracle.localization.transpose();
        for kept in [0, 1, 7] {
            let reduced = lowest(&component, kept);
            let (phi, seen) = (
                &reduced.recovery.modes,
                &reduced.superelement.modes.interface_shapes,
            );
            let eigenvalues = &reduced.superelement.modes.eigenvalues;
            let response = Mat::from_fn(exact.nrows(), exact.ncols(), |i, b| {
                let modal: f64 = (0..eigenvalues.len())
                    .map(|k| phi[(i, k)] * seen[(b, k)] / eigenvalues[k])
                    .sum();
                modal + reduced.recovery.residual[(i, b)]
            });
            // Column by column: rotational loads have another unit.
            for b in 0..exact.ncols() {
                let column = |m: &Mat<f64>| m.as_ref().subcols(b, 1).to_owned();
                let error = dcb_tests::dense::difference(&column(&response), &column(&exact));
                assert!(
                    error < 1e-9,
                    "{}: row {b} with {kept} modes: {error:e}",
                    component.name
                );
            }
        }
    }
}

/// Under an infinitesimal rigid rotation about e_b the inertia changes by W I + (W I)ᵀ, W = skew(e_b): with the section's own
/// inertia, which node positions on the axis don't show.
#[test]
fn first_order_inertia_of_a_rotation_turns_the_tensor() {
    let beam = SpatialBeam {
        elements: 3,
        theory: dcb_samples::spatial_beam::BeamTheory::Timoshenko,
        end: [0.3, 0.1, -0.05],
        ..Default::default()
    };
    let block = dcb_samples::box_block(
        [2, 1, 1],
        [0.2, 0.1, 0.05],
        SolidElement::Hexahedron20,
        &dcb_samples::Material::STEEL,
    );
    for component in [dcb_samples::spatial_beam(&beam), block] {
        let properties = MassProperties::of(&component).unwrap();
        let rotations = component_columns(&component, properties.centre);
        let (inertia, _) =
            inertia_invariants(&component, &properties, &[rotations.as_ref().subcols(3, 3)]);
        let tensor = Matrix3::from_fn(|i, j| properties.tensor[i][j]);
        for (b, first_order) in inertia.i1.iter().enumerate() {
            let axis = Vector3::from_fn(|i, _| if i == b { 1.0 } else { 0.0 });
            let turned = axis.cross_matrix() * tensor;
            let expected = turned + turned.transpose();
            let found = Matrix3::from_fn(|i, j| first_order[i][j]);
            let error = (found - expected).norm() / tensor.norm();
            assert!(error < 1e-13, "{}, axis {b}: {error:e}", component.name);
        }
    }
}
