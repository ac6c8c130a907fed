//! A body in dynamic coordinates, and what is refused.

mod free_motion;
mod inertia;
mod scope;
mod stiffening;
mod tangents;

use crate::support;
use crate::support::cloud::Cloud;
use crate::support::{Part, parts, product};
use dcb_formats::component::Role;
use dcb_formats::mesh::Dimension;
use dcb_formats::superelement::{Enrichment, FrameKind, Superelement};
use dcb_runtime::{Compatibility, FlexibleBody, InertiaTerms, RigidBody, RigidPoint};
use dcb_samples::{RodSection, planar_rod};
use dcb_tests::dense::dense;
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

fn largest(matrix: &Mat<f64>) -> f64 {
    matrix
        .col_iter()
        .flat_map(|column| column.iter())
        .fold(0.0, |most, x| f64::max(most, x.abs()))
}

#[test]
fn dynamic_coordinates_are_orthonormal_and_uncoupled() {
    for (name, part) in parts() {
        let basis = part.basis();
        let n = part.body.coordinate_count();
        assert_eq!(
            n,
            part.body.mode_count + part.reduced.superelement.residual.sigma_squared.len()
        );
        let mass = basis.transpose() * dense(&part.component.mass) * &basis;
        let identity = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == j)));
        assert!(
            largest(&(&mass - &identity)) < 1e-8,
            "{name}: {:e}",
            largest(&(&mass - &identity))
        );
        let stiffness = basis.transpose() * dense(&part.component.stiffness) * &basis;
        let expected = Mat::from_fn(
            n,
            n,
            |i, j| if i == j { part.body.stiffness[i] } else { 0.0 },
        );
        assert!(
            largest(&(&stiffness - &expected)) < 1e-7 * largest(&expected),
            "{name}"
        );
    }
}

#[test]
fn interface_shapes_are_the_field_at_the_interface_nodes() {
    let component = planar_rod(4, &RodSection::default())
        .changed(|draft| draft.interfaces[1].role = Role::Output)
        .unwrap();
    for (name, part) in [
        ("output", Part::reduced(component, 3)),
        (
            "both",
            Part::reduced(planar_rod(4, &RodSection::default()), 3),
        ),
    ] {
        let basis = part.basis();
        let y = support::deflection(&basis, 1e-3, 5);
        let u = product(&basis, &y);
        let at_rows = product(&part.body.interface_shapes, &y);
        for (row, seen) in part.body.rows.iter().zip(at_rows) {
            let direction =
                dcb_formats::mesh::Direction::from_index(row.direction as usize).unwrap();
            let dof = part.component.dofs.row(row.node as u32, direction).unwrap();
            assert!(
                (u[dof] - seen).abs() < 1e-14,
                "{name}: {} against {seen}",
                u[dof]
            );
        }
    }
}

#[test]
fn internal_forces_are_the_gradient_of_the_strain_energy() {
    let part = Part::reduced(planar_rod(4, &RodSection::default()), 3);
    let n = part.body.coordinate_count();
    let y = support::numbers(n, 9);
    let mut forces = vec![0.0; n];
    part.body.internal_forces(&y, &vec![0.0; n], &mut forces);
    for (i, force) in forces.iter().enumerate() {
        let (mut more, mut less) = (y.clone(), y.clone());
        more[i] += 0.5;
        less[i] -= 0.5;
        let slope = part.body.strain_energy(&more) - part.body.strain_energy(&less);
        assert!(
            (slope - force).abs() < 1e-9 * part.body.stiffness[n - 1],
            "{i}: {slope} against {force}"
        );
    }
}

#[test]
fn damping_follows_the_ratios() {
    let component = planar_rod(4, &RodSection::default())
        .changed(|draft| draft.damping = dcb_formats::component::Damping::Uniform(0.02))
        .unwrap();
    let part = Part::reduced(component, 3);
    let n = part.body.coordinate_count();
    let mut forces = vec![0.0; n];
    part.body
        .internal_forces(&vec![0.0; n], &vec![1.0; n], &mut forces);
    for (force, stiffness) in forces.iter().zip(&part.body.stiffness) {
        assert!((force - 2.0 * 0.02 * stiffness.sqrt()).abs() < 1e-12 * force);
    }
}

#[test]
fn what_the_dynamics_does_not_handle_is_refused_by_name() {
    let part = Part::reduced(planar_rod(2, &RodSection::default()), 2);
    let refusal = |superelement| {
        FlexibleBody::from_superelement(superelement, Compatibility::Strong)
            .unwrap_err()
            .to_string()
    };
    let mut crooked = part.reduced.superelement.clone();
    crooked.inertia.l1[(0, 0)] = 1e-3;
    let message = refusal(&crooked);
    assert!(
        message.contains("planar-rod") && message.contains("L1"),
        "{message}"
    );

    let mut stiffened = part.reduced.superelement;
    stiffened.stiffening.centrifugal = vec![Mat::identity(6, 6)];
    let weak = FlexibleBody::from_superelement(&stiffened, Compatibility::Weak);
    let message = weak.unwrap_err().to_string();
    assert!(
        message.contains("stiffening") && message.contains("strong"),
        "{message}"
    );

    // A further column that is the first mode again.
    let mut parallel = stiffened;
    let n = parallel.basis_count() + 1;
    let unit =
        |i: usize, j: usize| f64::from(u8::from(i == j || (i.min(j), i.max(j)) == (0, n - 1)));
    parallel.stiffening = Default::default();
    parallel.enrichment = Some(Enrichment {
        names: Vec::new(),
        interface_shapes: Mat::zeros(4, 1),
        reduced_mass: Mat::from_fn(n, n, unit),
        reduced_stiffness: Mat::from_fn(n, n, unit),
    });
    let message = refusal(&parallel);
    assert!(message.contains("orthogonal"), "{message}");
}

#[test]
fn a_missing_file_is_reported_with_its_path() {
    let message = FlexibleBody::load("nowhere.dcb.h5".as_ref())
        .unwrap_err()
        .to_string();
    assert!(message.contains("nowhere.dcb.h5"), "{message}");
}

/// A column with momentum moves the centre of mass: P = L1 y'.
#[test]
fn a_given_frame_carries_its_momentum() {
    let part = Part::reduced(planar_rod(3, &RodSection::default()), 3);
    let mut given = part.reduced.superelement.clone();
    given.frame_kind = FrameKind::Given;
    given.inertia.l1[(0, 1)] = 0.02;
    let body = FlexibleBody::from_superelement(&given, Compatibility::Strong).unwrap();
    let n = body.coordinate_count();
    let mut terms = part.terms();
    let still = vec![0.0; n];
    let mut rates = still.clone();
    rates[1] = 3.0;
    body.inertia
        .evaluate(&still, &Vector3::zeros(), &rates, &mut terms);
    let (linear, _) = terms.momenta(body.inertia.mass(), &Vector3::zeros(), &Vector3::zeros());
    assert!((linear.x - 0.06).abs() < 1e-9, "{linear}");
    let refused = terms.accelerations(body.inertia.dimension(), &Vector3::zeros(), &mut rates);
    assert!(refused.unwrap_err().to_string().contains("mean axes"));
}

/// The weak form's coordinates (η, g) at g = T_r ζ are the strong form's motion: the same energies and interface motion.
#[test]
fn compatibilities_describe_the_same_body() {
    for (name, part) in parts() {
        let superelement = &part.reduced.superelement;
        let of = |compatibility| FlexibleBody::from_superelement(superelement, compatibility);
        let (strong, weak) = (&part.body, of(Compatibility::Weak).unwrap());
        let n = strong.coordinate_count();
        let spin = part.spin(Vector3::new(0.3, -0.7, 0.5));
        let (y, rates) = (support::numbers(n, 4), support::numbers(n, 5));
        let energies = |body: &FlexibleBody, y: &[f64], rates: &[f64]| {
            let mut terms = InertiaTerms::for_coordinates(y.len());
            body.inertia.evaluate(y, &spin, rates, &mut terms);
            let still = Vector3::zeros();
            let kinetic = terms.kinetic_energy(1.0, &still, &spin, rates);
            (kinetic, body.strain_energy(y))
        };
        let to_weak = |y: &[f64]| support::cloud::original(strong, y);
        let (a, b) = (
            energies(strong, &y, &rates),
            energies(&weak, &to_weak(&y), &to_weak(&rates)),
        );
        assert!((a.0 - b.0).abs() < 1e-8 * a.0, "{name}: {a:?}, {b:?}");
        assert!((a.1 - b.1).abs() < 1e-8 * a.1, "{name}: {a:?}, {b:?}");
        let (u, v) = (
            product(&strong.interface_shapes, &y),
            product(&weak.interface_shapes, &to_weak(&y)),
        );
        for (u, v) in u.iter().zip(&v) {
            assert!((u - v).abs() < 1e-9 * u.abs().max(1e-3), "{name}: {u}, {v}");
        }

        // Static: under constant interface forces, u_Γ = L_b Φ η + F_res g is what the strong form settles at.
        let statics = of(Compatibility::Static).unwrap();
        assert_eq!(statics.coordinate_count(), statics.mode_count, "{name}");
        assert!(strong.residual_flexibility.is_none(), "{name}");
        let g = support::numbers(strong.rows.len(), 6);
        let settled = |body: &FlexibleBody| -> Vec<f64> {
            let on_y = product(&body.interface_shapes.transpose().to_owned(), &g);
            let y: Vec<f64> = on_y
                .iter()
                .zip(&body.stiffness)
                .map(|(f, k)| f / k)
                .collect();
            product(&body.interface_shapes, &y)
        };
        let residual = product(statics.residual_flexibility.as_ref().unwrap(), &g);
        let by_static: Vec<f64> = settled(&statics)
            .iter()
            .zip(residual)
            .map(|(a, b)| a + b)
            .collect();
        let size = by_static.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
        for (u, v) in settled(strong).iter().zip(&by_static) {
            assert!((u - v).abs() < 1e-8 * size, "{name}: {u}, {v}");
        }
    }
}

/// A direction of F_res that T_r leaves out acts without mass: what stays is invisible to T_r.
#[test]
fn massless_flexibility_is_kept_by_the_strong_form() {
    let mut superelement = Part::reduced(planar_rod(3, &RodSection::default()), 2)
        .reduced
        .superelement;
    let body = |superelement: &Superelement| {
        FlexibleBody::from_superelement(superelement, Compatibility::Strong).unwrap()
    };
    assert!(body(&superelement).residual_flexibility.is_none());
    let whole = superelement.residual.flexibility.clone();
    let rank = superelement.residual.sigma_squared.len();
    let dropped = rank - 1;
    superelement.residual.sigma_squared.truncate(dropped);
    let kept = superelement
        .residual
        .transform
        .subcols(0, dropped)
        .to_owned();
    superelement.residual.transform = kept;
    let rest = body(&superelement).residual_flexibility.unwrap();
    let unseen = superelement.residual.transform.transpose() * &rest;
    assert!(
        largest(&unseen) < 1e-8 * largest(&(superelement.residual.transform.transpose() * &whole))
    );
    assert!(largest(&rest) > 0.0);
}

#[test]
fn generalized_coordinates_are_given_back() {
    let cloud = Cloud::with_momentum(Dimension::Spatial, 4);
    let given = cloud.generalized();
    let body = cloud.body();
    let y = support::numbers(4, 3);
    let q = support::cloud::original(&body, &y);
    let quadratic =
        |m: &Mat<f64>| -> f64 { product(m, &q).iter().zip(&q).map(|(a, b)| a * b).sum() };
    let unit: f64 = y.iter().map(|y| y * y).sum();
    assert!((quadratic(&given.mass) - unit).abs() < 1e-12 * unit);
    let energy = body.strain_energy(&y);
    assert!((0.5 * quadratic(&given.stiffness) - energy).abs() < 1e-12 * energy);
    assert_eq!(body.damping, [0.01, 0.02, 0.02, 0.02]);
    let (displacement, rotation) = body.attachment(0).unwrap().products(&y);
    assert!((displacement - cloud.field(&q)[0]).norm() < 1e-13);
    assert_eq!(rotation, Vector3::zeros());
    assert_eq!(body.attachment(0).unwrap().rotations, [false; 3]);

    let mut indefinite = given.clone();
    indefinite.mass[(0, 0)] = -1.0;
    let message = FlexibleBody::from_generalized(&indefinite)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("mass") && message.contains("cloud"),
        "{message}"
    );
    let mut short = given;
    short.inertia.l3.pop();
    let message = FlexibleBody::from_generalized(&short)
        .unwrap_err()
        .to_string();
    assert!(message.contains("L3"), "{message}");
}

/// Virtual work: a wrench on a frame does the work of its generalised forces.
#[test]
fn attachments_move_with_the_interface_rows() {
    for (name, part) in parts() {
        let n = part.body.coordinate_count();
        let y = support::numbers(n, 8);
        let rows = product(&part.body.interface_shapes, &y);
        let mut frames = 0;
        for index in 0..part.body.interfaces.len() {
            let Ok(attachment) = part.body.attachment(index) else {
                continue;
            };
            frames += 1;
            let (u, turn) = attachment.products(&y);
            let six: Vec<f64> = u.iter().chain(turn.iter()).copied().collect();
            let own = part.body.rows.iter().zip(&rows);
            for (place, (row, value)) in own.enumerate() {
                if row.interface != index {
                    continue;
                }
                let found = six[row.direction as usize];
                // Two sums of the same terms in different order.
                let terms = part.body.interface_shapes.row(place).iter().zip(&y);
                let size: f64 = terms.map(|(shape, y)| (shape * y).abs()).sum();
                let apart = (found - value).abs();
                assert!(apart < 1e-14 * size, "{name}: {apart:e} of {size:e}");
            }
            let (force, moment) = (Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.3, 0.7, -1.0));
            let mut forces = vec![0.0; n];
            attachment.add_forces(&force, &moment, &mut forces);
            let work: f64 = forces.iter().zip(&y).map(|(f, y)| f * y).sum();
            assert!(
                (work - force.dot(&u) - moment.dot(&turn)).abs() < 1e-11 * work.abs().max(1.0),
                "{name}"
            );
        }
        assert!(frames > 0, "{name}");
    }
}

#[test]
fn an_interface_of_several_nodes_has_no_frame() {
    let part = Part::reduced(planar_rod(2, &RodSection::default()), 2);
    let mut superelement = part.reduced.superelement;
    for row in &mut superelement.rows {
        row.interface = 0;
    }
    let body = FlexibleBody::from_superelement(&superelement, Compatibility::Strong).unwrap();
    let message = body.attachment(0).unwrap_err().to_string();
    assert!(message.contains("`average` or `rigid`"), "{message}");
}

#[test]
fn a_rigid_body_is_its_mass_and_points() {
    let tensor = Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 2.5));
    let rigid = RigidBody {
        name: "crank".into(),
        units: part_units(),
        dimension: Dimension::Spatial,
        mass: 3.0,
        tensor,
        center: Vector3::new(0.5, 0.0, 0.0),
        points: vec![RigidPoint {
            name: "pin".into(),
            position: Vector3::new(0.7, 0.1, 0.0),
            axes: Matrix3::identity(),
        }],
    };
    let body = FlexibleBody::rigid(&rigid).unwrap();
    let pin = body.attachment(0).unwrap();
    assert!((pin.position - Vector3::new(0.2, 0.1, 0.0)).norm() < 1e-15);
    assert_eq!((pin.translations, pin.rotations), ([true; 3], [true; 3]));
    let spin = Vector3::new(1.0, 1.0, 1.0);
    let mut terms = InertiaTerms::for_coordinates(0);
    body.inertia.evaluate(&[], &spin, &[], &mut terms);
    // Euler: -ω × I ω.
    assert_eq!(terms.moment, -spin.cross(&(tensor * spin)));
    assert_eq!(terms.kinetic_energy(3.0, &spin, &spin, &[]), 4.5 + 2.75);

    let flat = RigidBody {
        tensor: Matrix3::from_diagonal(&Vector3::new(-1.0, 2.0, 2.0)),
        ..rigid
    };
    let message = FlexibleBody::rigid(&flat).unwrap_err().to_string();
    assert!(
        message.contains("crank") && message.contains("inertia"),
        "{message}"
    );
}

fn part_units() -> dcb_formats::component::Units {
    planar_rod(1, &RodSection::default()).into_draft().units
}
