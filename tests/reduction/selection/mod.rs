//! What is selected of a superelement: is it the one that the reducer makes, or dense algebra, of the component with these options?

mod estimates;
mod fewer_modes;
mod in_plane;
mod ports;
mod same_superelement;

use std::sync::Arc;

use dcb_formats::Component;
use dcb_formats::component::{Interface, InterfaceKind, Role};
use dcb_formats::dcb::{Contents, WriteOptions, read_superelement, write_superelement};
use dcb_formats::mesh::Direction;
use dcb_formats::superelement::Superelement;
use dcb_reducer::{EnrichmentSource, Reduced, Reduction};
use dcb_runtime::body::RigidBody;
use dcb_runtime::system::builder::Drawn;
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::SolidElement;
use dcb_superelement::LOSS_FACTOR;
use dcb_superelement::Selection;
use dcb_superelement::selection::{InPlane, InterfaceSelection, NodeSelection, Normal};
use dcb_tests::dense::{dense, difference, largest, scaled_difference};
use dcb_tests::mechanism::{Scene, method, revolute, run};
use dcb_tests::oracle::Oracle;
use dcb_tests::{assert_says, lowest, parts, with};
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use nalgebra::Vector3;
use same_superelement::{ROUNDING, compare, compare_fields};

/// A box with averaged frames at both ends, two nodes and a frame that is only observed between them.
fn box_with_places() -> Component {
    let part = parts::steel_box([5, 2, 2], SolidElement::Hexahedron);
    let ends = ["x_min", "x_max"].map(|set| part.mesh.point_sets[set].clone());
    let inner: Vec<u32> = (0..part.mesh.node_count() as u32)
        .filter(|node| ends.iter().all(|end| !end.contains(node)))
        .collect();
    let mut watched = parts::interface("watched", InterfaceKind::Nodes, vec![inner[9]]);
    watched.role = Role::Output;
    let interfaces = vec![
        parts::interface("left", InterfaceKind::Average, ends[0].clone()),
        parts::interface("top", InterfaceKind::Nodes, vec![inner[3], inner[17]]),
        watched,
        parts::interface("right", InterfaceKind::Average, ends[1].clone()),
    ];
    parts::with_interfaces(&part, interfaces)
}

fn rod_with_places() -> Component {
    let rod = parts::tilted_rod(6);
    let node = |name: &str, node| parts::interface(name, InterfaceKind::Nodes, vec![node]);
    let interfaces = vec![node("left", 0), node("middle", 3), node("right", 6)];
    parts::with_interfaces(&rod, interfaces)
}

fn changed(component: &Component, change: impl Fn(&mut Vec<Interface>)) -> Component {
    let mut interfaces = component.interfaces.clone();
    change(&mut interfaces);
    parts::with_interfaces(component, interfaces)
}

fn check(name: &str, whole: &Reduced, selection: &Selection, expected: &Reduced) {
    let found = selection.superelement(&whole.superelement).unwrap();
    let all = &expected.superelement;
    assert_eq!(found.interfaces, all.interfaces, "{name}");
    assert_eq!(found.rows, all.rows, "{name}");
    compare(name, &found, all);
    let fields = selection
        .recovery(&whole.superelement, &whole.recovery)
        .unwrap();
    compare_fields(name, &fields, &expected.recovery);
}

/// What the error estimate of a selection sums over: the modes that the other reduction left out.
fn compare_moments(name: &str, whole: &Reduced, selection: &Selection, expected: &Reduced) {
    let found = selection.superelement(&whole.superelement).unwrap();
    let modes = &expected.superelement.modes;
    let (of, all) = (
        found.moments.as_ref().unwrap(),
        expected.superelement.moments.as_ref().unwrap(),
    );
    let pairs = [
        (&of.first, &all.first),
        (&of.second, &all.second),
        (&of.third, &all.third),
        (&of.fourth, &all.fourth),
    ];
    for (power, (found, all)) in (1..).zip(pairs) {
        let scale: Vec<f64> = (0..all.nrows())
            .map(|row| {
                let elastic = modes.eigenvalues.iter().enumerate();
                let kept = elastic.filter(|(_, square)| **square > 0.0);
                let kept = kept.map(|(k, square)| {
                    modes.interface_shapes[(row, k)].powi(2) / square.powi(power)
                });
                (all[(row, row)] + kept.sum::<f64>()).sqrt()
            })
            .collect();
        let error = scaled_difference(found, all, &scale);
        assert!(error < ROUNDING, "{name}: M_{power} differs by {error:.1e}");
    }
    assert!(difference(&of.rigid_shapes, &all.rigid_shapes) < ROUNDING);
    assert_eq!(of.eigenvalue_errors.len(), found.mode_count());
    assert_eq!(of.rounding.len(), all.rounding.len());
    let first = found.modes.first_omitted_eigenvalue;
    assert!(of.eigenvalue_bound <= first, "{name}");
    assert!(
        of.eigenvalue_bound > all.eigenvalue_bound * (1.0 - 1e-6),
        "{name}"
    );
}

#[test]
fn fewer_interfaces_are_those_of_a_component_without_the_others() {
    for (part, modes) in [(box_with_places(), 10), (rod_with_places(), 7)] {
        let whole = lowest(&part, modes);
        for dropped in part
            .interfaces
            .iter()
            .map(|interface| interface.name.as_str())
        {
            let without = changed(&part, |all| all.retain(|other| other.name != dropped));
            let selection = Selection::everything(&whole.superelement)
                .with_interface(dropped, InterfaceSelection::Dropped)
                .unwrap();
            let name = format!("{} without {dropped}", part.name);
            check(&name, &whole, &selection, &lowest(&without, modes));
            // And with fewer modes at once.
            let fewer = selection.with_modes(0..4).unwrap();
            let all = lowest(&without, 4);
            check(&name, &whole, &fewer, &all);
            compare_moments(&name, &whole, &fewer, &all);
        }
    }
}

#[test]
fn interfaces_that_are_only_observed_are_output_interfaces() {
    for (part, modes) in [(box_with_places(), 10), (rod_with_places(), 7)] {
        let whole = lowest(&part, modes);
        for observed in ["left", "right"] {
            let only_seen = changed(&part, |all| {
                let of = all.iter_mut().find(|other| other.name == observed).unwrap();
                of.role = Role::Output;
            });
            let selection = Selection::everything(&whole.superelement)
                .with_interface(observed, InterfaceSelection::Observed)
                .unwrap()
                .with_modes(0..5)
                .unwrap();
            let name = format!("{} with {observed} observed", part.name);
            let all = lowest(&only_seen, 5);
            check(&name, &whole, &selection, &all);
            compare_moments(&name, &whole, &selection, &all);
        }
    }
}

/// F_res, M_res and G_res L_bᵀ from dense sums over the modes that are left out.
#[test]
fn any_modes_may_be_left_out() {
    for (part, kept) in [
        (rod_with_places(), vec![0, 2, 3, 6]),
        (
            parts::with_interfaces(
                &box_with_places(),
                box_with_places().interfaces[..2].to_vec(),
            ),
            vec![1, 4, 5, 8],
        ),
    ] {
        let whole = lowest(&part, 9);
        let selection = Selection::everything(&whole.superelement)
            .with_modes(kept.clone())
            .unwrap();
        let found = selection.superelement(&whole.superelement).unwrap();
        let modes = &whole.superelement.modes;
        let expected: Vec<f64> = kept.iter().map(|k| modes.eigenvalues[*k]).collect();
        assert_eq!(found.modes.eigenvalues, expected);
        let lowest_left_out = (0..9).find(|k| !kept.contains(k)).unwrap();
        assert_eq!(
            found.modes.first_omitted_eigenvalue,
            modes.eigenvalues[lowest_left_out]
        );
        assert!(found.modes.first_omitted_eigenvalue < *expected.last().unwrap());

        let oracle = Oracle::of(&part);
        let l = &oracle.localization;
        let shapes = Mat::from_fn(oracle.shapes.nrows(), kept.len(), |i, j| {
            oracle.shapes[(i, kept[j])]
        });
        let static_part = Mat::from_fn(shapes.nrows(), kept.len(), |i, j| {
            shapes[(i, j)] / oracle.eigenvalues[kept[j]]
        });
        let columns =
            &oracle.inverse * l.transpose() - static_part * (shapes.transpose() * l.transpose());
        let whole_columns = &oracle.inverse * l.transpose();
        let scale = |matrix: &Mat<f64>| -> Vec<f64> {
            (0..matrix.nrows()).map(|i| matrix[(i, i)].sqrt()).collect()
        };
        let (f, f0) = (l * &columns, l * &whole_columns);
        let m = columns.transpose() * &oracle.mass * &columns;
        let m0 = whole_columns.transpose() * &oracle.mass * &whole_columns;
        let apart = [
            scaled_difference(&found.residual.flexibility, &f, &scale(&f0)),
            scaled_difference(&found.residual.mass, &m, &scale(&m0)),
        ];
        assert!(apart.iter().all(|apart| *apart < ROUNDING), "{apart:?}");
        let fields = selection
            .recovery(&whole.superelement, &whole.recovery)
            .unwrap();
        assert!(difference(&fields.residual, &columns) < ROUNDING);

        // The file holds it.
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("some.dcb.h5");
        let contents = Contents {
            superelement: &found,
            recovery: Some(&fields),
            mesh: Some(&part.mesh),
        };
        write_superelement(&path, &contents, &WriteOptions::default()).unwrap();
        assert_eq!(read_superelement(&path).unwrap(), found);
    }
}

#[test]
fn further_columns_are_kept_or_dropped_by_name() {
    let part = parts::steel_box([5, 2, 2], SolidElement::Hexahedron20);
    let options = Reduction {
        enrichment: vec![EnrichmentSource::Spin],
        ..Reduction::lowest(6)
    };
    let whole = with(&part, &options);
    let everything = Selection::everything(&whole.superelement);
    let none = everything.clone().with_enrichment(&[]).unwrap();
    check("without further columns", &whole, &none, &lowest(&part, 6));
    let fewer = none.with_modes(0..3).unwrap();
    check("nor three modes", &whole, &fewer, &lowest(&part, 3));

    let some = everything
        .clone()
        .with_enrichment(&["spin zz", "spin xx"])
        .unwrap();
    let found = some.superelement(&whole.superelement).unwrap();
    let [all, kept] = [&whole.superelement, &found].map(|of| of.enrichment.as_ref().unwrap());
    assert_eq!(kept.names, ["spin xx", "spin zz"]);
    let n = found.basis_count();
    let first = n - 2;
    let places = [0, 2].map(|place| whole.superelement.basis_count() - all.names.len() + place);
    for (i, place) in places.iter().enumerate() {
        let found = kept.reduced_stiffness[(first + i, 0)];
        assert_eq!(found, all.reduced_stiffness[(*place, 0)]);
        assert_eq!(
            kept.reduced_mass[(first + i, first)],
            all.reduced_mass[(*place, places[0])]
        );
    }
    let body = FlexibleBody::from_superelement(&found, Compatibility::Strong).unwrap();
    assert_eq!(body.coordinate_count(), 6 + 12 + 2);
    let refused = everything
        .with_modes(0..3)
        .unwrap()
        .superelement(&whole.superelement);
    assert_says(&refused.unwrap_err().to_string(), &["enrichment columns"]);
}

#[test]
fn fields_of_chosen_nodes_are_those_rows() {
    let part = box_with_places();
    let whole = lowest(&part, 6);
    let nodes = NodeSelection::Only([3, 8, 30].into());
    let everything = Selection::everything(&whole.superelement)
        .with_modes([0, 1, 4])
        .unwrap();
    let all = everything
        .recovery(&whole.superelement, &whole.recovery)
        .unwrap();
    let some = everything.with_nodes(nodes);
    let some = some.recovery(&whole.superelement, &whole.recovery).unwrap();
    assert_eq!(some.dofs.len(), 9);
    for (row, dof) in some.dofs.iter().enumerate() {
        let at = all.dofs.iter().position(|other| other == dof).unwrap();
        assert!((0..3).all(|k| some.modes[(row, k)] == all.modes[(at, k)]));
        assert!((0..some.residual.ncols()).all(|b| {
            (some.residual[(row, b)] - all.residual[(at, b)]).abs()
                <= 1e-15 * largest(all.residual.as_ref())
        }));
    }
}

/// Loaded along some forces only: F_res and M_res are energies of the columns in the component's matrices, what the forces do is
/// as it was, in every direction, and there is nothing else.
#[test]
fn attachments_of_chosen_forces_answer_to_them_as_before() {
    let part = box_with_places();
    let whole = lowest(&part, 6);
    let forces = Mat::from_fn(6, 2, |i, j| match (i, j) {
        (1, 0) => 1.0,
        (2, 1) => 0.4,
        (4, 1) => -0.03,
        _ => 0.0,
    });
    for kept in [6, 3] {
        let selection = Selection::everything(&whole.superelement)
            .with_interface("right", InterfaceSelection::LoadedAlong(forces.clone()))
            .unwrap()
            .with_interface("top", InterfaceSelection::Observed)
            .unwrap()
            .with_modes(0..kept)
            .unwrap();
        let found = selection.superelement(&whole.superelement).unwrap();
        let fields = selection
            .recovery(&whole.superelement, &whole.recovery)
            .unwrap();
        let reference = lowest(&part, kept);
        let (stiffness, mass) = (dense(&part.stiffness), dense(&part.mass));
        let energy = fields.residual.transpose() * &stiffness * &fields.residual;
        let kinetic = fields.residual.transpose() * &mass * &fields.residual;
        assert!(difference(&found.residual.flexibility, &energy) < ROUNDING);
        assert!(difference(&found.residual.mass, &kinetic) < ROUNDING);
        assert_eq!(found.residual.sigma_squared.len(), 6 + 2);
        // The rule of the file for the diagonal with no mode kept.
        let (modes, residual) = (&found.modes, &found.residual);
        for (row, of) in found.rows.iter().enumerate() {
            let modal: f64 = (0..kept)
                .map(|k| (modes.interface_shapes[(row, k)] / modes.eigenvalues[k]).powi(2))
                .sum();
            let expected = match found.interfaces[of.interface].role {
                Role::Attachment => residual.mass[(row, row)] + modal,
                Role::Output => 0.0,
            };
            let apart = (residual.mass_diagonal0[row] - expected).abs();
            assert!(apart <= 1e-9 * expected, "row {row}");
        }
        let first = found
            .rows
            .iter()
            .position(|row| row.interface == 3)
            .unwrap();
        let all = &reference.superelement;
        let at = all.rows.iter().position(|row| row.interface == 3).unwrap();
        assert_eq!(first, at);
        for force in forces.col_iter() {
            let load = Mat::from_fn(found.rows.len(), 1, |i, _| match i.checked_sub(first) {
                Some(i) => force[i],
                None => 0.0,
            });
            let shapes = |of: &Superelement| of.residual.output_shapes.clone().unwrap();
            let (seen, before) = (shapes(&found) * &load, shapes(all) * &load);
            assert!(difference(&seen, &before) < ROUNDING);
            let (moved, before) = (
                &fields.residual * &load,
                &reference.recovery.residual * &load,
            );
            assert!(difference(&moved, &before) < ROUNDING);
        }
        // A file of it loses no more modes: the forces that it has are of these.
        let again = Selection::everything(&found).with_modes(0..1).unwrap();
        let refused = again.superelement(&found).unwrap_err().to_string();
        assert_says(&refused, &["along some forces only"]);
    }
}

/// A pendulum of the box on its left frame about z, with a force on the right one.
fn swings(element: &Superelement, compatibility: Compatibility) -> (usize, Vec<Vector3<f64>>) {
    let body = FlexibleBody::from_superelement(element, compatibility).unwrap();
    let count = body.coordinate_count();
    let mut scene = Scene::new(element.dimension, Vector3::new(0.0, -9.81, 0.0));
    let drawn = Drawn {
        angular_velocity: Vector3::new(0.0, 0.0, 60.0),
        velocity: Vector3::new(3.0, 0.0, 0.0),
        ..Drawn::default()
    };
    let body = scene.body(&Arc::new(body), &drawn);
    let [left, right] = ["left", "right"].map(|name| {
        element
            .interfaces
            .iter()
            .position(|interface| interface.name == name)
            .unwrap()
    });
    let (root, tip) = (scene.on(body, left), scene.on(body, right));
    let ground = scene.ground([0.0, 0.05, 0.03]);
    scene.join(&revolute(Vector3::z()), ground, root);
    scene.push(tip, [300.0, 8000.0]);
    let (mut simulation, _) = scene.start(method(0.8));
    let mut seen = Vec::new();
    run(&mut simulation, 0.02, 200, |simulation| {
        let at = &simulation.refresh().motions[tip];
        seen.push(at.position);
    });
    (count, seen)
}

fn apart(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).norm())
        .fold(0.0, f64::max)
}

/// Attachments without inertia of their own are the same for the same forces; those with inertia answer to other forces' patterns as well.
#[test]
fn a_motion_under_chosen_forces_is_that_with_everything() {
    let whole = lowest(&box_with_places(), 8).superelement;
    let right = whole
        .interfaces
        .iter()
        .position(|interface| interface.name == "right")
        .unwrap();
    let along = InterfaceSelection::along(&whole, right, &[Direction::Ux, Direction::Uy]);
    let selection = Selection::everything(&whole)
        .with_interface("right", along)
        .unwrap()
        .with_interface("top", InterfaceSelection::Dropped)
        .unwrap()
        .with_interface("watched", InterfaceSelection::Dropped)
        .unwrap();
    let found = selection.superelement(&whole).unwrap();
    let reach = 0.4;
    let [exact, fewer] = [&whole, &found].map(|of| swings(of, Compatibility::Static));
    let error = apart(&exact.1, &fewer.1);
    println!("static: {error:.1e} m");
    assert!(error < 1e-9 * reach, "{error:.1e}");
    let [exact, fewer] = [&whole, &found].map(|of| swings(of, Compatibility::Strong));
    assert_eq!((exact.0, fewer.0), (8 + 18, 8 + 8));
    let error = apart(&exact.1, &fewer.1);
    let deflection = apart(&exact.1, &swings(&found, Compatibility::Static).1);
    println!("strong: {error:.1e} m, against static {deflection:.1e} m");
    assert!(error < 1e-6 * reach, "{error:.1e}");
}

/// The component by dense algebra, seen as a study sees it: rows in units of their own flexibility.
struct DenseView {
    oracle: Oracle,
    scale: Vec<f64>,
    /// Interface of each row.
    interfaces: Vec<usize>,
}

impl DenseView {
    fn of(part: &Component, whole: &Superelement) -> Self {
        let oracle = Oracle::of(part);
        let l = &oracle.localization;
        let rigid_mass = oracle.rigid.transpose() * &oracle.mass * &oracle.rigid;
        let rigid = l * &oracle.rigid;
        let moved = &rigid
            * rigid_mass
                .partial_piv_lu()
                .solve(rigid.transpose().to_owned());
        let flexibility = l * &oracle.inverse * l.transpose();
        let seen = l * &oracle.shapes;
        let scale = (whole.rows.iter().enumerate())
            .map(|(row, of)| {
                let elastic: f64 = match whole.interfaces[of.interface].role {
                    Role::Attachment => flexibility[(row, row)],
                    Role::Output => (0..whole.mode_count())
                        .map(|k| seen[(row, k)].powi(2) / oracle.eigenvalues[k])
                        .sum(),
                };
                (elastic + moved[(row, row)] / oracle.eigenvalues[0])
                    .sqrt()
                    .recip()
            })
            .collect();
        Self {
            scale,
            interfaces: whole.rows.iter().map(|row| row.interface).collect(),
            oracle,
        }
    }

    /// Rigid motions and the coordinates of a selection as nodal fields.
    fn basis(&self, selection: &Selection, whole: &Reduced) -> Mat<f64> {
        let selected = selection.superelement(&whole.superelement).unwrap();
        let fields = selection
            .recovery(&whole.superelement, &whole.recovery)
            .unwrap();
        let attached = &fields.residual * &selected.residual.transform;
        let parts = [&self.oracle.rigid, &fields.modes, &attached];
        let columns: Vec<_> = parts.iter().flat_map(|part| part.col_iter()).collect();
        Mat::from_fn(attached.nrows(), columns.len(), |i, j| columns[j][i])
    }

    /// H between all rows, scaled, in a basis or in all dofs.
    fn receptance(&self, basis: Option<&Mat<f64>>, square: f64) -> Mat<c64> {
        let lambda = c64::new(square, 0.0) / c64::new(1.0, LOSS_FACTOR);
        let Oracle {
            stiffness,
            mass,
            localization,
            ..
        } = &self.oracle;
        let (stiffness, mass, l) = match basis {
            None => (stiffness.clone(), mass.clone(), localization.clone()),
            Some(basis) => (
                basis.transpose() * stiffness * basis,
                basis.transpose() * mass * basis,
                localization * basis,
            ),
        };
        let dynamic = Mat::from_fn(stiffness.nrows(), stiffness.ncols(), |i, j| {
            c64::new(stiffness[(i, j)], 0.0) - lambda * mass[(i, j)]
        });
        let forces = Mat::from_fn(l.ncols(), l.nrows(), |i, j| {
            c64::new(l[(j, i)] * self.scale[j], 0.0)
        });
        let moved = dynamic.partial_piv_lu().solve(&forces);
        forces.transpose() * moved
    }

    /// ‖a - b‖ / ‖b‖ over some rows and columns: within interfaces, between them, and both.
    fn apart(&self, a: &Mat<c64>, b: &Mat<c64>, rows: &[usize], columns: &[usize]) -> [f64; 3] {
        let mut sums = [[0.0_f64; 2]; 3];
        for i in rows {
            for j in columns {
                let kind = usize::from(self.interfaces[*i] != self.interfaces[*j]);
                for kind in [kind, 2] {
                    sums[kind][0] += (a[(*i, *j)] - b[(*i, *j)]).norm_sqr();
                    sums[kind][1] += b[(*i, *j)].norm_sqr();
                }
            }
        }
        sums.map(|[apart, all]| (apart / all).sqrt())
    }
}

/// Against the whole component, where the whole superelement has all of its modes.
#[test]
fn receptances_differ_by_what_dense_algebra_says() {
    let part = rod_with_places();
    let whole = lowest(&part, 18);
    let element = &whole.superelement;
    assert_eq!(element.mode_count(), 18, "all elastic modes");
    let selection = Selection::everything(element)
        .with_modes([0, 1, 2, 5])
        .unwrap()
        .with_interface("middle", InterfaceSelection::Observed)
        .unwrap();
    let squares: Vec<f64> = [0.1, 0.8, 2.3, 20.0]
        .map(|factor| factor * element.modes.eigenvalues[0])
        .to_vec();
    let found = selection.receptance_difference(element, &squares).unwrap();
    let view = DenseView::of(&part, element);
    let basis = view.basis(&selection, &whole);
    let (rows, columns): (Vec<usize>, _) = ((0..9).collect(), [0, 1, 2, 6, 7, 8]);
    for (at, square) in squares.iter().enumerate() {
        let reduced = view.receptance(Some(&basis), *square);
        let exact = view.receptance(None, *square);
        let expected = view.apart(&reduced, &exact, &rows, &columns);
        let found = [found.collocated[at], found.transfer[at], found.together[at]];
        println!("{found:?} {expected:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-5 * expected + 1e-9);
        }
    }
    assert!(
        found.together[3] > 1e-3,
        "the last frequency is beyond what is kept"
    );
}

#[test]
fn nothing_differs_where_nothing_is_left_out() {
    let whole = lowest(&box_with_places(), 8).superelement;
    let everything = Selection::everything(&whole);
    let squares: Vec<f64> = whole
        .modes
        .eigenvalues
        .iter()
        .map(|value| 0.7 * value)
        .collect();
    let found = everything.receptance_difference(&whole, &squares).unwrap();
    assert_eq!(found.largest(), [0.0; 3]);
    assert_eq!(everything.superelement(&whole).unwrap(), whole);
    let dropped = everything
        .with_interface("top", InterfaceSelection::Dropped)
        .unwrap();
    let [_, transfer, together] = dropped
        .receptance_difference(&whole, &squares)
        .unwrap()
        .largest();
    println!("without the attachments at the top: {transfer:.1e} {together:.1e}");
    assert!(transfer > 0.0 && together < 1e-2);
}

/// The table of `docs/scene-driven.md`.
#[test]
fn attachments_that_a_selection_left_without_inertia_stay_so_in_the_next() {
    let mut whole = lowest(&rod_with_places(), 6).superelement;
    whole.provenance.options = serde_json::json!({});
    let count = whole.residual.sigma_squared.len();
    let first = Selection::everything(&whole)
        .with_modes([0, 1, 2, 3])
        .unwrap();
    let first = first.with_attachments(count - 2);
    // As `reduce --scene` of an earlier build wrote it where nothing was selected.
    let mut null = whole.clone();
    null.provenance.options["selections"] = serde_json::Value::Null;
    for whole in [&whole, &null] {
        let smaller = first.superelement(whole).unwrap();
        let listed = smaller.provenance.options["selections"].as_array();
        assert_eq!(listed.map(Vec::len), Some(1));
        let again = Selection::everything(&smaller)
            .with_modes([0, 1, 2])
            .unwrap();
        let again = again.superelement(&smaller).unwrap();
        assert_eq!(
            again.residual.sigma_squared.len(),
            smaller.residual.sigma_squared.len()
        );
        let listed = again.provenance.options["selections"].as_array();
        assert_eq!(listed.map(Vec::len), Some(2));
    }
}

#[test]
fn costs_are_those_of_the_documentation() {
    let part = parts::steel_box([10, 4, 4], SolidElement::Hexahedron);
    let whole = lowest(&part, 20).superelement;
    let top = 0.25 * whole.modes.eigenvalues[19];
    let squares: Vec<f64> = (1..=400).map(|i| f64::from(i) / 400.0 * top).collect();
    let everything = || Selection::everything(&whole);
    let plane = [Direction::Ux, Direction::Uy];
    let along = || {
        let wanted = InterfaceSelection::along(&whole, 1, &plane);
        everything().with_interface("right", wanted).unwrap()
    };
    let observed = everything().with_interface("right", InterfaceSelection::Observed);
    let in_plane = InPlane::of(&whole, Normal::Z, 1e-7).unwrap();
    for (selection, coordinates, errors) in [
        (everything(), 32, ["0e0", "0e0"]),
        (
            everything().with_modes(0..10).unwrap(),
            22,
            ["2.8e-2", "2.2e-2"],
        ),
        (along(), 28, ["2.5e-4", "1.8e-3"]),
        (along().with_modes(0..10).unwrap(), 18, ["3.6e-2", "4.8e-2"]),
        (observed.unwrap(), 26, ["6.2e-5", "2.1e-3"]),
        (in_plane.selection().clone(), 15, ["", ""]),
    ] {
        let found = selection.superelement(&whole).unwrap();
        let count = found.mode_count() + found.residual.sigma_squared.len();
        assert_eq!(count, coordinates);
        let [collocated, transfer, _] = selection
            .receptance_difference(&whole, &squares)
            .unwrap()
            .largest();
        if errors[0].is_empty() {
            assert!(collocated.max(transfer) < 1e-9, "in the plane");
            continue;
        }
        let shown = [collocated, transfer].map(|error| match error {
            0.0 => "0e0".to_owned(),
            _ => format!("{error:.1e}"),
        });
        assert_eq!(shown, errors);
    }
}

/// Against dense algebra in the bases with and without each mode.
#[test]
fn participation_is_the_difference_that_one_mode_makes() {
    for part in [box_with_places(), rod_with_places()] {
        let whole = lowest(&part, 8);
        let element = &whole.superelement;
        let count = element.rows.len();
        let eigenvalues = &element.modes.eigenvalues;
        let squares: Vec<f64> = [0.05, 0.3, 0.9]
            .map(|share| share * eigenvalues[6])
            .to_vec();
        let everything = Selection::everything(element);
        let every: Vec<usize> = (0..count).collect();
        let loaded =
            |row: &usize| element.interfaces[element.rows[*row].interface].role == Role::Attachment;
        let mut cases = vec![
            (everything.clone(), every.clone()),
            (
                everything.clone().with_modes([0, 2, 3, 4, 7]).unwrap(),
                every.clone(),
            ),
        ];
        if element.interfaces.len() == 4 {
            let along = InterfaceSelection::along(element, 3, &[Direction::Uy]);
            let chosen = everything
                .with_interface("right", along)
                .unwrap()
                .with_interface("top", InterfaceSelection::Observed)
                .unwrap()
                .with_modes(0..6)
                .unwrap();
            let mut columns: Vec<usize> = (0..6).collect();
            columns.push(count - 6 + 1);
            cases.push((chosen, columns));
        }
        let view = DenseView::of(&part, element);
        for (selection, columns) in cases {
            let columns: Vec<usize> = columns.into_iter().filter(loaded).collect();
            let found = selection.participation(element, &squares).unwrap();
            let modes = selection.modes();
            assert_eq!(found.len(), modes.len());
            println!("{}: {found:?}", part.name);
            let with = view.basis(&selection, &whole);
            for (mode, found) in modes.iter().zip(found) {
                let others = modes.iter().copied().filter(|other| other != mode);
                let without = selection.clone().with_modes(others).unwrap();
                let without = view.basis(&without, &whole);
                let expected = (squares.iter())
                    .map(|square| {
                        let reference = view.receptance(Some(&with), *square);
                        let changed = view.receptance(Some(&without), *square);
                        view.apart(&changed, &reference, &every, &columns)[2]
                    })
                    .fold(0.0, f64::max);
                assert!(
                    (found - expected).abs() < 1e-5 * expected + 1e-8,
                    "mode {mode}: {found:e} {expected:e}"
                );
            }
        }
    }
}

#[test]
fn a_locked_part_is_rigid() {
    let part = box_with_places();
    let whole = lowest(&part, 3).superelement;
    let rigid = RigidBody::locked(&whole);
    assert_eq!(rigid.mass, whole.inertia.mass);
    let names: Vec<&str> = rigid
        .points
        .iter()
        .map(|point| point.name.as_str())
        .collect();
    assert_eq!(
        names,
        ["left", "watched", "right"],
        "two nodes aren't one frame"
    );
    assert!((rigid.points[2].position - Vector3::new(0.4, 0.05, 0.03)).norm() < 1e-12);
    assert!((rigid.center - Vector3::new(0.2, 0.05, 0.03)).norm() < 1e-12);
    let moment = rigid.mass / 12.0 * (0.1_f64.powi(2) + 0.4_f64.powi(2));
    assert!((rigid.tensor[(2, 2)] / moment - 1.0).abs() < 1e-9);
    let body = FlexibleBody::rigid(&rigid).unwrap();
    assert_eq!(body.coordinate_count(), 0);
}

#[test]
fn what_is_not_there_is_refused_by_name() {
    let whole = lowest(&box_with_places(), 4).superelement;
    let everything = || Selection::everything(&whole);
    let said =
        |refused: Result<Selection, dcb_superelement::Error>| refused.unwrap_err().to_string();
    assert_says(&said(everything().with_modes([1, 4])), &["no mode 4 of 4"]);
    let unknown = everything().with_interface("rigth", InterfaceSelection::Loaded);
    assert_says(&said(unknown), &["\"rigth\""]);
    let observed = everything().with_interface("watched", InterfaceSelection::Loaded);
    assert_says(&said(observed), &["\"watched\"", "output"]);
    let misfit = InterfaceSelection::LoadedAlong(Mat::from_fn(5, 1, |_, _| 1.0));
    assert_says(
        &said(everything().with_interface("right", misfit)),
        &["5 by 1", "6 rows"],
    );
    let nothing = InterfaceSelection::LoadedAlong(Mat::zeros(6, 1));
    assert_says(
        &said(everything().with_interface("right", nothing)),
        &["zero"],
    );
    assert_says(
        &said(everything().with_enrichment(&["spin zz"])),
        &["\"spin zz\""],
    );
    let other = lowest(&rod_with_places(), 4).superelement;
    let refused = everything().superelement(&other).unwrap_err().to_string();
    assert_says(&refused, &["another superelement"]);
}
