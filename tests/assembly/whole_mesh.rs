//! With all modes kept, an assembly of parts is the reduction of the whole mesh.

use dcb_formats::Superelement;
use dcb_formats::component::Component;
use dcb_reducer::Reduced;
use dcb_samples::spatial_beam::{BeamMass, BeamTheory, SpatialBeam};
use dcb_samples::{RodSection, planar_rod, spatial_beam::spatial_beam};
use dcb_tests::dense::diagonal_roots;
use dcb_tests::lowest;
use faer::Mat;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::{HALVES, loaded, put_together};

/// Enough for every mode of a part.
const EVERY: usize = 1000;
/// Modes of the whole.
const KEPT: usize = 6;
const START: [f64; 3] = [0.1, -0.2, 0.05];
const MIDDLE: [f64; 3] = [0.5, 0.1, 0.35];
const END: [f64; 3] = [0.9, 0.4, 0.65];

fn beam(elements: usize, start: [f64; 3], end: [f64; 3], mass: BeamMass) -> Component {
    spatial_beam(&SpatialBeam {
        elements,
        start,
        end,
        mass,
        roll: 0.3,
        theory: BeamTheory::Timoshenko,
        ..SpatialBeam::default()
    })
}

fn mirrored(point: [f64; 3]) -> [f64; 3] {
    [point[0], -point[1], point[2]]
}

/// Columns with the sign that makes their modes' shapes those of `like`.
fn signs(of: &Superelement, like: &Superelement) -> Vec<f64> {
    let (own, other) = (&of.modes.interface_shapes, &like.modes.interface_shapes);
    let mut signs: Vec<f64> = (0..of.mode_count())
        .map(|k| {
            let product: f64 = (0..own.nrows()).map(|i| own[(i, k)] * other[(i, k)]).sum();
            product.signum()
        })
        .collect();
    signs.resize(of.basis_count(), 1.0);
    signs
}

fn signed(matrix: &Mat<f64>, rows: &[f64], columns: &[f64]) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        rows[i] * matrix[(i, j)] * columns[j]
    })
}

/// Everything that a superelement says of motion, of two that should be the same.
fn assert_same(found: &Superelement, expected: &Superelement, limit: f64) {
    assert_nearly_same(found, expected, limit, limit);
}

/// The same with a limit of its own for the couplings of deformations with rotations.
fn assert_nearly_same(found: &Superelement, expected: &Superelement, limit: f64, coupled: f64) {
    let close_to = |limit: f64, what: &str, a: f64, b: f64, size: f64| {
        assert!((a - b).abs() <= limit * size, "{what}: {a:e} and {b:e}");
    };
    let close = |what: &str, a: f64, b: f64, size: f64| close_to(limit, what, a, b, size);
    close(
        "mass",
        found.inertia.mass,
        expected.inertia.mass,
        expected.inertia.mass,
    );
    for a in 0..3 {
        close("centre", found.origin[a], expected.origin[a], 1.0);
        for b in 0..3 {
            close(
                "tensor",
                found.inertia.tensor[a][b],
                expected.inertia.tensor[a][b],
                expected.inertia.mass,
            );
        }
    }
    assert_eq!(found.mode_count(), expected.mode_count());
    for (a, b) in found
        .modes
        .eigenvalues
        .iter()
        .zip(&expected.modes.eigenvalues)
    {
        close("eigenvalue", *a, *b, *b);
    }
    let (omitted, other) = (
        found.modes.first_omitted_eigenvalue,
        expected.modes.first_omitted_eigenvalue,
    );
    close("first omitted", omitted, other, other);
    let ones = vec![1.0; found.rows.len()];
    let signs = signs(found, expected);
    let same = |what: &str, a: &Mat<f64>, b: &Mat<f64>, rows: &[f64], columns: &[f64]| {
        let scaled = |i: usize, j: usize| (a[(i, j)] - b[(i, j)]).abs() / (rows[i] * columns[j]);
        let entries = (0..a.nrows()).flat_map(|i| (0..a.ncols()).map(move |j| (i, j)));
        let limit = if what.starts_with('L') || what.starts_with('I') {
            coupled
        } else {
            limit
        };
        let difference = entries
            .map(|(i, j)| scaled(i, j))
            .filter(|one| one.is_finite())
            .fold(0.0, f64::max);
        assert!(difference < limit, "{what}: {difference:e}");
    };
    let shapes = signed(
        &found.modes.interface_shapes,
        &ones,
        &signs[..found.mode_count()],
    );
    let largest = |matrix: &Mat<f64>| vec![matrix.norm_max(); matrix.nrows().max(matrix.ncols())];
    let unit = vec![1.0; found.basis_count()];
    same(
        "interface shapes",
        &shapes,
        &expected.modes.interface_shapes,
        &largest(&shapes),
        &unit,
    );
    for (what, a, b) in [
        (
            "flexibility",
            &found.residual.flexibility,
            &expected.residual.flexibility,
        ),
        ("mass", &found.residual.mass, &expected.residual.mass),
    ] {
        let roots = diagonal_roots(b);
        same(what, a, b, &roots, &roots);
    }
    assert_eq!(
        found.residual.sigma_squared.len(),
        expected.residual.sigma_squared.len()
    );
    // Sizes of columns: their mass, with no mode kept for attachments.
    let mut sizes = vec![1.0; found.mode_count()];
    sizes.extend(
        expected
            .residual
            .mass_diagonal0
            .iter()
            .map(|mass| mass.sqrt().max(1e-12)),
    );
    for (axis, (a, b)) in found
        .inertia
        .l3
        .iter()
        .zip(&expected.inertia.l3)
        .enumerate()
    {
        same(
            &format!("L3 {axis}"),
            &signed(a, &signs, &signs),
            b,
            &sizes,
            &sizes,
        );
    }
    for (pair, (a, b)) in found
        .inertia
        .i2
        .iter()
        .zip(&expected.inertia.i2)
        .enumerate()
    {
        same(
            &format!("I2 {pair}"),
            &signed(a, &signs, &signs),
            b,
            &sizes,
            &sizes,
        );
    }
    let moment = expected.inertia.mass.sqrt();
    for k in 0..found.basis_count() {
        for a in 0..3 {
            for b in 0..3 {
                close_to(
                    coupled,
                    "I1",
                    signs[k] * found.inertia.i1[k][a][b],
                    expected.inertia.i1[k][a][b],
                    moment * sizes[k],
                );
            }
        }
    }
    if let (Some(a), Some(b)) = (&found.moments, &expected.moments) {
        for (what, one, other) in [("M_1", &a.first, &b.first), ("M_2", &a.second, &b.second)] {
            let roots = diagonal_roots(other);
            same(what, one, other, &roots, &roots);
        }
    }
}

fn halves(mass: BeamMass) -> (Reduced, Vec<(Component, Reduced)>) {
    let whole = lowest(&beam(8, START, END, mass), KEPT);
    let parts = [(START, MIDDLE), (MIDDLE, END)].map(|(from, to)| {
        let component = beam(4, from, to, mass);
        let reduced = lowest(&component, EVERY);
        (component, reduced)
    });
    (whole, parts.into())
}

#[test]
fn two_halves_of_a_beam_are_the_beam() {
    // Inertia of sections that turn at their nodes is no field of displacements, which the couplings of the whole are made of.
    for (mass, coupled) in [
        (BeamMass::Consistent, 2e-7),
        (BeamMass::LumpedWithRoll, 4e-3),
    ] {
        let (whole, parts) = halves(mass);
        let names = ["first", "second"];
        let parts = parts
            .into_iter()
            .zip(names)
            .map(|((component, reduced), name)| loaded(&component, reduced, name));
        let found = put_together(HALVES, parts.collect(), KEPT).unwrap();
        assert!(found.report.redundant.is_empty());
        assert_nearly_same(&found.superelement, &whole.superelement, 2e-7, coupled);
        // Nodal fields: the first node is the whole's, the last too.
        let fields = found.recovery.unwrap();
        let signs = signs(&found.superelement, &whole.superelement);
        for (own, all) in [(0..6, 0..6), (54..60, 48..54)] {
            for (i, j) in own.zip(all) {
                for k in 0..KEPT {
                    let (a, b) = (
                        signs[k] * fields.modes[(i, k)],
                        whole.recovery.modes[(j, k)],
                    );
                    assert!(
                        (a - b).abs() < 1e-6 * whole.recovery.modes.norm_max(),
                        "mode {k}, dof {j}: {a:e} and {b:e}"
                    );
                }
            }
        }
    }
}

/// The same machine turned and moved as a whole: the same numbers in its own axes.
#[test]
fn a_turned_assembly_is_turned() {
    let (_, parts) = halves(BeamMass::Consistent);
    let load = || {
        let names = ["first", "second"];
        parts
            .iter()
            .zip(names)
            .map(|((component, reduced), name)| loaded(component, reduced.clone(), name))
            .collect()
    };
    let straight = put_together(HALVES, load(), KEPT).unwrap().superelement;
    let turn = UnitQuaternion::from_euler_angles(0.4, -0.7, 1.1);
    let (q, shift) = (turn.quaternion(), Vector3::new(0.3, 0.2, -0.5));
    let placed = format!(
        r#""orientation": [{}, {}, {}, {}], "position": [{}, {}, {}]"#,
        q.w, q.i, q.j, q.k, shift[0], shift[1], shift[2]
    );
    let text = HALVES
        .replace("\"first.dcb.h5\"", &format!("\"first.dcb.h5\", {placed}"))
        .replace("\"second.dcb.h5\"", &format!("\"second.dcb.h5\", {placed}"));
    let turned = put_together(&text, load(), KEPT).unwrap().superelement;
    let rotation: Matrix3<f64> = turn.to_rotation_matrix().into_inner();
    let origin = rotation * Vector3::from(straight.origin) + shift;
    assert!((origin - Vector3::from(turned.origin)).norm() < 1e-12);
    let tensor = |of: &Superelement| Matrix3::from_fn(|a, b| of.inertia.tensor[a][b]);
    let expected = rotation * tensor(&straight) * rotation.transpose();
    assert!((expected - tensor(&turned)).norm() < 1e-12);
    for (a, b) in straight
        .modes
        .eigenvalues
        .iter()
        .zip(&turned.modes.eigenvalues)
    {
        assert!((a / b - 1.0).abs() < 1e-9);
    }
    // Rows come in blocks of three, which turn like vectors.
    let blocks = straight.rows.len() / 3;
    let (flat, found) = (&straight.residual.flexibility, &turned.residual.flexibility);
    let roots = diagonal_roots(flat);
    for i in 0..blocks {
        for j in 0..blocks {
            let block = |of: &Mat<f64>| Matrix3::from_fn(|a, b| of[(3 * i + a, 3 * j + b)]);
            let size = (0..3).map(|a| roots[3 * i + a]).sum::<f64>()
                * (0..3).map(|a| roots[3 * j + a]).sum::<f64>();
            let expected = rotation * block(flat) * rotation.transpose();
            assert!(
                (expected - block(found)).norm() < 1e-8 * size,
                "blocks {i} and {j}"
            );
        }
    }
    // L3 is an axial vector of the attachments, which turn too.
    let n_k = straight.mode_count();
    let l3 = |of: &Superelement, k: usize, l: usize| {
        Vector3::from_fn(|a, _| of.inertia.l3[a][(n_k + k, n_k + l)])
    };
    let size = straight
        .residual
        .mass_diagonal0
        .iter()
        .copied()
        .fold(0.0, f64::max);
    for (first, second) in [(0, 6), (3, 9)] {
        let mut expected = Vector3::zeros();
        let (k, l) = (first + 1, second + 2);
        for a in 0..3 {
            for b in 0..3 {
                expected += rotation
                    * l3(&straight, first + a, second + b)
                    * rotation[(k - first, a)]
                    * rotation[(l - second, b)];
            }
        }
        assert!((expected - l3(&turned, k, l)).norm() < 1e-8 * size);
    }
}

/// Mirror images of mirrored parts are the parts.
#[test]
fn a_mirrored_part_is_the_part_of_the_mirrored_mesh() {
    let (whole, parts) = halves(BeamMass::Consistent);
    let mut parts = parts.into_iter();
    let (first, reduced) = parts.next().unwrap();
    let first = loaded(&first, reduced, "first");
    // The section's default axes are mirrored with the beam, its roll turns the other way.
    let image = spatial_beam(&SpatialBeam {
        elements: 4,
        start: mirrored(MIDDLE),
        end: mirrored(END),
        roll: -0.3,
        theory: BeamTheory::Timoshenko,
        ..SpatialBeam::default()
    });
    let reduced = lowest(&image, EVERY);
    let second = loaded(&image, reduced, "image");
    let text = HALVES.replace("\"second.dcb.h5\"", "\"image.dcb.h5\", \"mirror\": \"y\"");
    let found = put_together(&text, vec![first, second], KEPT).unwrap();
    assert_same(&found.superelement, &whole.superelement, 2e-7);
    let mesh = found.mesh.unwrap();
    let last = mesh.position(mesh.node_count() as u32 - 1);
    assert!((Vector3::from(last) - Vector3::from(END)).norm() < 1e-12);
}

/// In the plane, with a hinge that an average of the ends doesn't have: rods in a row, turned by hand.
#[test]
fn planar_rods_joined_are_one_rod() {
    let section = RodSection::default();
    let free = |rod: Component| {
        rod.changed(|draft| {
            draft
                .interfaces
                .iter_mut()
                .for_each(|of| of.directions = None)
        })
        .unwrap()
    };
    let whole = lowest(&free(planar_rod(8, &section)), KEPT);
    let half = free(planar_rod(
        4,
        &RodSection {
            length: 0.5 * section.length,
            ..section
        },
    ));
    let reduced = lowest(&half, EVERY);
    let text = format!(
        r#"{{"dimension": 2, "units": {{"length": "m", "mass": "kg", "time": "s"}},
          "bodies": {{"first": {{"superelement": "half.dcb.h5"}},
                     "second": {{"superelement": "half.dcb.h5", "position": [{}, 0], "orientation": {}}}}},
          "joints": {{"weld": {{"fixed": {{"a": "first/b", "b": "second/b"}}}}}},
          "interfaces": {{"a": "first/a", "b": "second/a"}}}}"#,
        section.length,
        std::f64::consts::PI
    );
    let parts = vec![
        loaded(&half, reduced.clone(), "half"),
        loaded(&half, reduced, "half"),
    ];
    let found = put_together(&text, parts, KEPT).unwrap();
    assert_same(&found.superelement, &whole.superelement, 2e-7);
}

/// An assembly of assemblies is the assembly of all parts.
#[test]
fn two_levels_are_one() {
    let quarter = |k: usize| {
        let at = |k: usize| {
            let share = k as f64 / 4.0;
            std::array::from_fn(|a| START[a] + share * (END[a] - START[a]))
        };
        beam(2, at(k), at(k + 1), BeamMass::Consistent)
    };
    let whole = lowest(&beam(8, START, END, BeamMass::Consistent), KEPT);
    let half = |first: usize| {
        let parts = [first, first + 1].map(|k| {
            let component = quarter(k);
            let reduced = lowest(&component, EVERY);
            loaded(&component, reduced, ["first", "second"][k - first])
        });
        put_together(HALVES, parts.into(), EVERY).unwrap()
    };
    let halves = [half(0), half(2)].into_iter().enumerate().map(|(i, half)| {
        Some(dcb_assembly::LoadedPart {
            superelement: half.superelement,
            inside: dcb_assembly::Inside {
                recovery: half.recovery,
                mesh: half.mesh,
            },
            file: format!("{i}.dcb.h5").into(),
            digest: i.to_string(),
        })
    });
    let found = put_together(HALVES, halves.collect(), KEPT).unwrap();
    assert_same(&found.superelement, &whole.superelement, 2e-7);
    assert_eq!(found.mesh.unwrap().node_count(), 12);
    // Nodal fields through both levels: node i of quarter q is node 2 q + i of the whole.
    let fields = found.recovery.unwrap();
    assert_eq!(fields.dofs.len(), 72);
    let signs = signs(&found.superelement, &whole.superelement);
    for (quarter, i) in (0..4).flat_map(|quarter| (0..3).map(move |i| (quarter, i))) {
        for direction in 0..6 {
            let own = 6 * (3 * quarter + i) + direction;
            let all = 6 * (2 * quarter + i) + direction;
            for (k, sign) in signs.iter().enumerate().take(KEPT) {
                let (a, b) = (
                    sign * fields.modes[(own, k)],
                    whole.recovery.modes[(all, k)],
                );
                assert!(
                    (a - b).abs() < 1e-6 * whole.recovery.modes.norm_max(),
                    "mode {k}, node {i} of quarter {quarter}: {a:e} and {b:e}"
                );
            }
            for row in 0..whole.recovery.residual.ncols() {
                let (a, b) = (
                    fields.residual[(own, row)],
                    whole.recovery.residual[(all, row)],
                );
                let size = (0..72)
                    .map(|j| fields.residual[(j, row)].abs())
                    .fold(0.0, f64::max);
                assert!(
                    (a - b).abs() < 1e-5 * size,
                    "row {row}, node {i} of quarter {quarter}: {a:e} and {b:e}"
                );
            }
        }
    }
}
