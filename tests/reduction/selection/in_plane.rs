//! Parts that move in their plane of symmetry: does the planar superelement move as the spatial one does, and is a part that isn't symmetric refused?

use std::sync::Arc;

use dcb_formats::Component;
use dcb_formats::component::InterfaceKind;
use dcb_formats::dcb::read_superelement;
use dcb_formats::mesh::Dimension;
use dcb_formats::superelement::Superelement;
use dcb_runtime::system::builder::Drawn;
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::connecting_rod::{RodShape, connecting_rod_of};
use dcb_samples::{Material, SolidElement, box_block, hard};
use dcb_superelement::Error;
use dcb_superelement::selection::{InPlane, Normal};
use dcb_tests::dense::{relative, scaled_difference};
use dcb_tests::mechanism::{Scene, method, revolute, run};
use dcb_tests::{assert_says, lowest, parts};
use nalgebra::Vector3;

/// What may couple: rounding of the shapes of higher modes.
const TOLERANCE: f64 = 1e-7;

/// A pendulum about the normal z at the first interface, with a force at the second: positions and turns of the latter.
fn swings(element: &Superelement, root: [f64; 3], spin: f64) -> (usize, Vec<[f64; 3]>) {
    let body = FlexibleBody::from_superelement(element, Compatibility::Strong).unwrap();
    let count = body.coordinate_count();
    let mut scene = Scene::new(element.dimension, Vector3::new(0.0, -9.81, 0.0));
    let drawn = Drawn {
        angular_velocity: Vector3::new(0.0, 0.0, spin),
        velocity: Vector3::new(spin * root[1], -spin * root[0], 0.0),
        ..Drawn::default()
    };
    let body = scene.body(&Arc::new(body), &drawn);
    let (first, tip) = (scene.on(body, 0), scene.on(body, 1));
    let ground = scene.ground(match element.dimension {
        Dimension::Planar => [root[0], root[1], 0.0],
        Dimension::Spatial => root,
    });
    scene.join(&revolute(Vector3::z()), ground, first);
    scene.push(tip, [2000.0, 12000.0]);
    let (mut simulation, _) = scene.start(method(0.8));
    let mut seen = Vec::new();
    run(&mut simulation, 0.01, 200, |simulation| {
        let at = &simulation.refresh().motions[tip];
        seen.push([at.position.x, at.position.y, at.axes[(1, 0)]]);
    });
    (count, seen)
}

fn apart(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let entries = a.iter().flatten().zip(b.iter().flatten());
    entries.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn short_rod() -> Component {
    let shape = RodShape {
        element_size: 0.009,
        ..RodShape::default()
    };
    connecting_rod_of(&shape, &Material::STEEL)
}

#[test]
fn a_symmetric_part_moves_in_the_plane_as_in_space() {
    let thick = parts::steel_box([5, 2, 2], SolidElement::Hexahedron20);
    for (part, root, modes) in [
        (thick, [0.0, 0.05, 0.03], 12),
        (short_rod(), [0.0; 3], 10),
        (hard::square_block(), [0.0, 0.05, 0.05], 12),
    ] {
        let whole = lowest(&part, modes).superelement;
        let in_plane = InPlane::of(&whole, Normal::Z, TOLERANCE).unwrap();
        let planar = in_plane.superelement(&whole).unwrap();
        let fewer = in_plane.selection().superelement(&whole).unwrap();
        let [all, half, flat] = [&whole, &fewer, &planar].map(|of| swings(of, root, 250.0));
        let of_planar = apart(&all.1, &flat.1);
        let of_fewer = apart(&all.1, &half.1);
        // What the thickness does to the inertia is seen in these motions.
        let mut thin = planar.clone();
        thin.stiffening.centrifugal.clear();
        let without = apart(&all.1, &swings(&thin, root, 250.0).1);
        println!(
            "{}: {} coordinates in space, {} of them in the plane, {} planar; apart {of_fewer:.1e} and {of_planar:.1e}, without the thickness {without:.1e}",
            part.name, all.0, half.0, flat.0
        );
        assert!(of_planar < 1e-10 && of_fewer < 1e-10);
        assert!(without > 1e-10, "the thickness isn't seen");
        assert_eq!(half.0, flat.0);
        assert!(flat.0 < all.0 && flat.0 > 6);
        assert_eq!(planar.dimension, Dimension::Planar);

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("planar.dcb.h5");
        dcb_tests::write_bare(&path, &planar);
        assert_eq!(read_superelement(&path).unwrap(), planar);
    }
}

/// Both bending directions of a square bar come as double roots: one of each pair is in the plane.
#[test]
fn double_roots_are_turned_apart() {
    let whole = lowest(&hard::square_block(), 12).superelement;
    let planar = InPlane::of(&whole, Normal::Z, TOLERANCE)
        .unwrap()
        .superelement(&whole)
        .unwrap();
    let roots = &planar.modes.eigenvalues;
    let doubles: Vec<f64> = (whole.modes.eigenvalues.windows(2))
        .filter(|pair| pair[1] - pair[0] < 1e-8 * pair[1])
        .map(|pair| pair[0])
        .collect();
    assert!(doubles.len() >= 2, "{:?}", whole.modes.eigenvalues);
    for double in doubles {
        let there = roots
            .iter()
            .filter(|root| (**root / double - 1.0).abs() < 1e-8);
        assert_eq!(there.count(), 1);
    }
}

/// The same block drawn along other axes: the planar part is the same.
#[test]
fn every_axis_may_be_the_normal() {
    let along = |sides: [f64; 3], cells: [usize; 3], axis: &str, normal: Normal| {
        let block = box_block(cells, sides, SolidElement::Hexahedron20, &Material::STEEL);
        let ends = ["min", "max"].map(|end| {
            let nodes = block.mesh.point_sets[&format!("{axis}_{end}")].clone();
            parts::interface(end, InterfaceKind::Average, nodes)
        });
        let whole = lowest(&parts::with_interfaces(&block, ends.to_vec()), 9).superelement;
        InPlane::of(&whole, normal, TOLERANCE)
            .unwrap()
            .superelement(&whole)
            .unwrap()
    };
    let expected = along([0.4, 0.1, 0.06], [4, 2, 1], "x", Normal::Z);
    for found in [
        along([0.06, 0.4, 0.1], [1, 4, 2], "y", Normal::X),
        along([0.1, 0.06, 0.4], [2, 1, 4], "z", Normal::Y),
    ] {
        let directions =
            |of: &Superelement| -> Vec<i64> { of.rows.iter().map(|row| row.direction).collect() };
        assert_eq!(directions(&found), [0, 1, 5, 0, 1, 5]);
        assert_eq!(directions(&found), directions(&expected));
        assert!(relative(&found.modes.eigenvalues, &expected.modes.eigenvalues) < 1e-8);
        assert!(
            relative(
                &found.residual.sigma_squared,
                &expected.residual.sigma_squared
            ) < 1e-7
        );
        let roots = |matrix: &faer::Mat<f64>| -> Vec<f64> {
            (0..6).map(|i| matrix[(i, i)].sqrt()).collect()
        };
        for (found, expected) in [
            (&found.residual.flexibility, &expected.residual.flexibility),
            (&found.residual.mass, &expected.residual.mass),
        ] {
            assert!(scaled_difference(found, expected, &roots(expected)) < 1e-7);
        }
        let (moment, all) = (found.inertia.tensor[2][2], expected.inertia.tensor[2][2]);
        assert!((moment / all - 1.0).abs() < 1e-10);
        for (a, b) in found.rows.iter().zip(&expected.rows) {
            let apart = Vector3::from(a.position) - Vector3::from(b.position);
            assert!(apart.norm() < 1e-12);
        }
    }
}

#[test]
fn parts_without_the_symmetry_are_refused_with_numbers() {
    let refusal = |part: &Component, normal: Normal| {
        let whole = lowest(part, 6).superelement;
        match InPlane::of(&whole, normal, TOLERANCE).unwrap_err() {
            Error::Asymmetric(found) => found,
            other => panic!("{other}"),
        }
    };
    let skew = refusal(&parts::skew_beam(), Normal::Z);
    println!("{skew}");
    assert!(skew.coupling > 0.1 && skew.coupling <= 1.0 + 1e-9, "{skew}");
    // One corner is off the plane.
    let block = parts::steel_box([5, 2, 2], SolidElement::Hexahedron);
    let mut interfaces = block.interfaces.clone();
    interfaces.push(parts::interface("lug", InterfaceKind::Nodes, vec![0]));
    let lug = refusal(&parts::with_interfaces(&block, interfaces), Normal::Z);
    println!("{lug}");
    assert_says(&format!("{} {}", lug.first, lug.second), &["lug/"]);
    assert!(lug.coupling > 1e-2, "{lug}");
    // The rod's rings differ, but only along x.
    let rod = short_rod();
    refusal(&rod, Normal::X);
    let whole = lowest(&rod, 6).superelement;
    assert!(InPlane::of(&whole, Normal::Y, TOLERANCE).is_ok());
    let flat = lowest(&parts::tilted_rod(4), 3).superelement;
    let refused = InPlane::of(&flat, Normal::Z, TOLERANCE)
        .unwrap_err()
        .to_string();
    assert_says(&refused, &["planar already"]);
}
