//! Are estimated errors of superelements that are made for some forces only bounds of the true ones, and close? Against the whole part's matrices, solved at every
//! frequency between these forces.

use super::ports::TruePorts;
use dcb_formats::Component;
use dcb_formats::component::{InterfaceKind, Role};
use dcb_formats::dcb::read_superelement;
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::Compatibility;
use dcb_formats::superelement::Superelement;
use dcb_reducer::Reduction;
use dcb_samples::{SolidElement, hard};
use dcb_superelement::FrequencyBand;
use dcb_superelement::Selection;
use dcb_superelement::error_bounds::{Bracket, ErrorBounds, Estimate};
use dcb_superelement::selection::{InPlane, InterfaceSelection, Normal};
use dcb_tests::error_estimate::{LOSS_FACTOR, Truth};
use dcb_tests::{lowest, parts};
use dcb_workflow::scene::{ComponentDemand, Extent, Fitted, Limits, PartInScene, Search};
use faer::Mat;
use serde_json::json;

/// What dense solutions of the whole matrices leave of an error.
const NOISE: f64 = 1e-9;
/// Errors below this aren't told from rounding closely enough for an effectivity.
const CLEAR: f64 = 1e-6;

fn lies_between(truth: f64, Bracket { lower, upper }: Bracket) -> bool {
    lower <= truth * (1.0 + 1e-6) + NOISE && truth <= upper * (1.0 + 1e-6) + NOISE
}

fn measures(truth: &Truth, found: &Estimate) -> Vec<(&'static str, f64, Bracket)> {
    let mut measures = vec![
        ("static", truth.fixed.unwrap(), found.static_response),
        ("collocated", truth.collocated, found.collocated.largest),
    ];
    if let (Some(held), Some(bracket)) = (truth.held, found.held_frequency) {
        measures.push(("held", held, bracket));
    }
    assert_eq!(truth.transfer.is_some(), found.transfer.is_some());
    if let (Some(transfer), Some(found)) = (truth.transfer, found.transfer) {
        measures.push(("transfer", transfer, found.largest));
    }
    measures
}

/// Bounds over the usual band and up to nine tenths of the first frequency left out of those that take part.
fn assert_bounded(
    part: &Component,
    element: &Superelement,
    ports: &TruePorts,
    motions: Option<&Mat<f64>>,
) {
    // Observed rows that lead out of a plane don't move, which bounds near the first frequency left out don't know.
    let watches = motions.is_some() && ports.attached.contains(&false);
    for form in [Compatibility::Strong, Compatibility::Static] {
        let estimate = ErrorBounds::of(element, form).unwrap().unwrap();
        let top = 0.81 * estimate.eigenvalue_bound();
        let usual = estimate.usual_band(20).unwrap();
        for (band, is_wide) in [
            (usual, false),
            (estimate.band(Some(top / 400.0), top, 20), true),
        ] {
            let truth = ports.truth(part, element, form, &band, motions);
            let found = over(&estimate, &band);
            for (measure, truth, bracket) in measures(&truth, &found) {
                let what = format!("{} {form:?} {measure}", part.name);
                println!("{what}: {truth:.3e} in {bracket:?}");
                assert!(
                    lies_between(truth, bracket),
                    "{what}: {truth:e} {bracket:?}"
                );
                if truth > CLEAR && !(is_wide && watches) {
                    assert!(
                        bracket.upper < 10.0 * truth,
                        "{what}: {truth:e} {bracket:?}"
                    );
                }
            }
        }
    }
}

/// Of all rows, those that are only observed too.
fn over(estimate: &ErrorBounds, band: &FrequencyBand) -> Estimate {
    let rows: Vec<usize> = (0..estimate.forces().ncols()).collect();
    estimate.over(&rows, band, LOSS_FACTOR).unwrap()
}

fn round_trip(element: &Superelement) -> Superelement {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.dcb.h5");
    dcb_tests::write_bare(&path, element);
    read_superelement(&path).unwrap()
}

/// A box with frames at both ends and a node that is looked at.
fn watched_box() -> Component {
    let part = parts::steel_box([4, 1, 1], SolidElement::Hexahedron);
    let mut interfaces = part.interfaces.clone();
    let mut sensor = parts::interface("sensor", InterfaceKind::Nodes, vec![8]);
    sensor.role = Role::Output;
    interfaces.push(sensor);
    parts::with_interfaces(&part, interfaces)
}

fn every(count: usize) -> Mat<f64> {
    Mat::identity(count, count)
}

/// Two forces that mix translations with rotations, and their directions.
fn skew() -> Mat<f64> {
    Mat::from_fn(6, 2, |i, j| match (i, j) {
        (0, 0) => 0.3,
        (1, 0) => 1.0,
        (5, 0) => 0.02,
        (2, 1) => 0.4,
        (4, 1) => -0.03,
        _ => 0.0,
    })
}

#[test]
fn forces_that_a_part_is_loaded_along_have_bounds() {
    let part = watched_box();
    let whole = lowest(&part, 6).superelement;
    let wanted = |forces: Mat<f64>| {
        Selection::everything(&whole)
            .with_interface("right", InterfaceSelection::LoadedAlong(forces))
            .unwrap()
    };
    let rows: Vec<usize> = (0..whole.rows.len()).collect();
    let forces = [every(6), skew(), Mat::zeros(0, 0)];
    for kept in [6, 4] {
        let element = wanted(skew()).with_modes(0..kept).unwrap();
        let element = round_trip(&element.superelement(&whole).unwrap());
        assert_eq!(element.interfaces[1].name, "right");
        let estimate = ErrorBounds::of(&element, Compatibility::Strong)
            .unwrap()
            .unwrap();
        assert_eq!(estimate.forces().ncols(), 6 + 2 + 3);
        assert_eq!(estimate.loaded_along(&element), [(1, [2, 6])]);
        let ports = TruePorts::of(&part, &element, &rows, &forces);
        assert_bounded(&part, &element, &ports, None);
    }
    // Both ends, and no sensor.
    let both = wanted(skew())
        .with_interface("left", InterfaceSelection::LoadedAlong(skew()))
        .unwrap()
        .with_interface("sensor", InterfaceSelection::Dropped)
        .unwrap();
    let element = both.superelement(&whole).unwrap();
    let rows: Vec<usize> = (0..12).collect();
    let ports = TruePorts::of(&part, &element, &rows, &[skew(), skew()]);
    assert_bounded(&part, &element, &ports, None);
}

#[test]
fn other_forces_than_those_of_the_file_have_other_errors() {
    let part = parts::steel_box([4, 1, 1], SolidElement::Hexahedron);
    let whole = lowest(&part, 6).superelement;
    let selection = Selection::everything(&whole)
        .with_interface("right", InterfaceSelection::LoadedAlong(skew()))
        .unwrap();
    let element = selection.superelement(&whole).unwrap();
    let rows: Vec<usize> = (0..12).collect();
    let other = Mat::from_fn(6, 2, |i, j| match (i, j) {
        (0, 0) | (3, 1) => 1.0,
        (2, 0) => -0.6,
        _ => 0.0,
    });
    let of = |forces: &Mat<f64>| TruePorts::of(&part, &element, &rows, &[every(6), forces.clone()]);
    let mut wrong = element.clone();
    let loaded = wrong.moments.as_mut().unwrap().loaded.as_mut().unwrap();
    loaded.forces = Mat::from_fn(12, 8, |i, j| match (i.checked_sub(6), j.checked_sub(6)) {
        (None, None) => f64::from(u8::from(i == j)),
        (Some(i), Some(j)) => other[(i, j)],
        _ => 0.0,
    });
    // Along forces that the file has no attachments for bounds are those of the errors that this makes, static ones too.
    assert_bounded_loosely(&part, &wrong, &of(&other));
    let (right, estimated) = (of(&skew()), ErrorBounds::of(&wrong, Compatibility::Strong));
    let estimate = estimated.unwrap().unwrap();
    let band = estimate.usual_band(20).unwrap();
    let found = over(&estimate, &band);
    let truth = right.truth(&part, &element, Compatibility::Strong, &band, None);
    assert!(found.static_response.lower > 1e-2, "{found:?}");
    assert!(truth.fixed.unwrap() < 1e-10);
    for (measure, truth, bracket) in measures(&truth, &found) {
        if measure != "held" {
            assert!(
                !lies_between(truth, bracket),
                "{measure}: {truth:e} {bracket:?}"
            );
        }
    }
    // Without a word of the forces the errors are those of all rows.
    let mut silent = element.clone();
    silent.moments.as_mut().unwrap().loaded = None;
    let estimate = ErrorBounds::of(&silent, Compatibility::Strong)
        .unwrap()
        .unwrap();
    let found = over(&estimate, &band);
    let all = TruePorts::of(&part, &element, &rows, &[every(6), every(6)]);
    let truth = all.truth(&part, &element, Compatibility::Strong, &band, None);
    for (measure, truth, bracket) in measures(&truth, &found) {
        assert!(
            lies_between(truth, bracket),
            "{measure}: {truth:e} {bracket:?}"
        );
    }
    assert!(found.static_response.lower > 1e-2);
}

fn assert_bounded_loosely(part: &Component, element: &Superelement, ports: &TruePorts) {
    for form in [Compatibility::Strong, Compatibility::Static] {
        let estimate = ErrorBounds::of(element, form).unwrap().unwrap();
        let band = estimate.usual_band(20).unwrap();
        let truth = ports.truth(part, element, form, &band, None);
        for (measure, truth, bracket) in measures(&truth, &over(&estimate, &band)) {
            assert!(
                lies_between(truth, bracket),
                "{measure}: {truth:e} {bracket:?}"
            );
        }
    }
}

/// Motions of a part that its mirror image across z makes too, by its nodes.
fn mirrored(part: &Component) -> Mat<f64> {
    let count = part.mesh.node_count() as u32;
    let at = |node: u32| part.mesh.position(node);
    let heights: Vec<f64> = (0..count).map(|node| at(node)[2]).collect();
    let ends = heights.iter().fold([f64::MAX, f64::MIN], |[low, high], z| {
        [low.min(*z), high.max(*z)]
    });
    let twin = |node: u32| {
        let [x, y, z] = at(node);
        let image = [x, y, ends[0] + ends[1] - z];
        let apart = |other: &u32| (0..3).all(|a| (at(*other)[a] - image[a]).abs() < 1e-9);
        (0..count).find(apart).expect("a symmetric mesh")
    };
    let twins: Vec<u32> = (0..count).map(twin).collect();
    let dofs = part.dofs.nodal_dofs();
    let place = |node: u32, direction| {
        let found = dofs
            .iter()
            .position(|dof| dof.node == node && dof.direction == direction);
        found.expect("a dof")
    };
    let mut columns = Vec::new();
    for (row, dof) in dofs.iter().enumerate() {
        let other = place(twins[dof.node as usize], dof.direction);
        let sign = if dof.direction.index() == 2 {
            -1.0
        } else {
            1.0
        };
        match other.cmp(&row) {
            std::cmp::Ordering::Greater => columns.push((row, other, sign)),
            std::cmp::Ordering::Equal if sign > 0.0 => columns.push((row, row, 0.0)),
            _ => {}
        }
    }
    let half = 0.5_f64.sqrt();
    Mat::from_fn(dofs.len(), columns.len(), |i, j| match columns[j] {
        (row, _, 0.0) => f64::from(u8::from(i == row)),
        (row, _, _) if i == row => half,
        (_, other, sign) if i == other => sign * half,
        _ => 0.0,
    })
}

/// Rows of a spatial file that lie in the plane across z, interface by interface.
fn rows_in_plane(element: &Superelement) -> Vec<usize> {
    let rows = 0..element.rows.len();
    rows.filter(|row| [0, 1, 5].contains(&element.rows[*row].direction))
        .collect()
}

/// ω² of the lowest mode that was left out.
fn lowest_left_out(whole: &Superelement, kept: &[usize]) -> f64 {
    let left_out = (0..whole.mode_count()).filter(|mode| !kept.contains(mode));
    let squares = left_out.map(|mode| whole.modes.eigenvalues[mode]);
    squares.fold(f64::INFINITY, f64::min)
}

#[test]
fn parts_in_a_plane_have_bounds_in_space_and_as_planar_ones() {
    let mut sensed = parts::steel_box([5, 2, 2], SolidElement::Hexahedron);
    let middle = (0..sensed.mesh.node_count() as u32).find(|node| {
        let [x, _, z] = sensed.mesh.position(*node);
        let ends = sensed.mesh.position(0);
        (z - ends[2] - 0.03).abs() < 1e-9 && x > 0.1
    });
    let mut sensor = parts::interface("sensor", InterfaceKind::Nodes, vec![middle.unwrap()]);
    sensor.role = Role::Output;
    let mut interfaces = sensed.interfaces.clone();
    interfaces.push(sensor);
    sensed = parts::with_interfaces(&sensed, interfaces);
    // The bar has every bending mode twice.
    for (part, modes) in [(hard::square_block(), 12), (sensed, 8)] {
        let whole = lowest(&part, modes).superelement;
        let motions = mirrored(&part);
        let in_plane = InPlane::of(&whole, Normal::Z, 1e-7).unwrap();
        let spatial = in_plane.selection().superelement(&whole).unwrap();
        let spatial = round_trip(&spatial);
        let moments = spatial.moments.as_ref().unwrap();
        let left_out = lowest_left_out(&whole, in_plane.selection().modes());
        // Modes out of the plane bound what all forces move, and not what those in the plane do.
        assert!(moments.eigenvalue_bound <= left_out);
        let estimate = ErrorBounds::of(&spatial, Compatibility::Strong)
            .unwrap()
            .unwrap();
        let of_whole = whole.moments.as_ref().unwrap().eigenvalue_bound;
        assert_eq!(estimate.eigenvalue_bound(), of_whole);
        assert!(left_out < 0.5 * of_whole);

        let attachments = whole
            .interfaces
            .iter()
            .filter(|of| of.role == Role::Attachment);
        let along = Mat::from_fn(6, 3, |i, j| f64::from(u8::from(i == [0, 1, 5][j])));
        let mut forces = vec![along; attachments.count()];
        forces.push(Mat::zeros(0, 0));
        let all: Vec<usize> = (0..spatial.rows.len()).collect();
        let ports = TruePorts::of(&part, &spatial, &all, &forces);
        assert_bounded(&part, &spatial, &ports, Some(&motions));

        let planar = round_trip(&in_plane.superelement(&whole).unwrap());
        let rows = rows_in_plane(&whole);
        assert_eq!(planar.rows.len(), rows.len());
        let moments = planar.moments.as_ref().unwrap();
        assert_eq!(moments.rigid_shapes.ncols(), 3);
        assert_eq!(moments.eigenvalue_bound, of_whole);
        assert!(moments.loaded.is_none());
        let mut forces = vec![every(3); forces.len() - 1];
        forces.push(Mat::zeros(0, 0));
        let ports = TruePorts::of(&part, &planar, &rows, &forces);
        assert_bounded(&part, &planar, &ports, Some(&motions));

        // Rows that belong to other moments.
        let mut wrong = planar.clone();
        let moments = wrong.moments.as_mut().unwrap();
        let spatial = whole.moments.as_ref().unwrap();
        moments.first = spatial.first.get(..rows.len(), ..rows.len()).to_owned();
        let estimate = ErrorBounds::of(&wrong, Compatibility::Strong)
            .unwrap()
            .unwrap();
        let band = estimate.usual_band(20).unwrap();
        let truth = ports.truth(&part, &planar, Compatibility::Strong, &band, Some(&motions));
        let found = over(&estimate, &band);
        assert!(!lies_between(truth.collocated, found.collocated.largest));
    }
}

#[test]
fn a_spatial_part_for_a_planar_scene_has_less_error_than_it_may_have() {
    let part = parts::steel_box([4, 2, 2], SolidElement::Hexahedron);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.json");
    let scene = json!({
        "dimension": 2,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "ground": {"points": {"pin": [0, 0.05]}},
        "bodies": {"block": {"superelement": "block.dcb.h5"}},
        "joints": {"hinge": {"revolute": {"a": "ground/pin", "b": "block/left"}}},
        "loads": {"push": {"force": {"at": "block/right", "components": [3e4, 2e5]}}},
        "outputs": {"tip": {"position": {"at": "block/right"}}},
        "integrator": {"generalized_alpha": {"step": 2e-5, "end": 4e-3}}
    });
    std::fs::write(&path, scene.to_string()).unwrap();
    let usual = folder.path().join("block.dcb.h5");
    let in_scene = PartInScene::find(&path, &[], &usual, &usual).unwrap();
    let asked = ComponentDemand::of(&in_scene, part.clone()).unwrap();
    let limits = Limits {
        tolerance: 1e-3,
        most_modes: None,
        default_modes: 20,
        extent: Extent::Needed,
    };
    let search = Search {
        asked: &asked,
        options: &Reduction::lowest(0),
        limits: &limits,
        cached: None,
    };
    let whole = search.whole(&mut ()).unwrap();
    let band = FrequencyBand {
        squares: whole.squares.iter().copied().step_by(20).collect(),
    };
    let fitted = Fitted::of(whole, &in_scene, &asked, &limits).unwrap();
    let element = fitted.superelement;
    assert_eq!(element.dimension, Dimension::Planar);
    let fit = fitted.quality.scene.unwrap();
    let total = fit.total.unwrap();
    // Where the file's rows are among the part's, which are six for each end.
    let rows: Vec<usize> = (element.rows.iter())
        .map(|row| 6 * row.interface + usize::try_from(row.direction).unwrap())
        .collect();
    assert_eq!(rows, [0, 1, 5, 6, 7, 11]);
    let plane = Mat::from_fn(3, 2, |i, j| f64::from(u8::from(i == j)));
    let ports = TruePorts::of(&part, &element, &rows, &[plane.clone(), plane]);
    let truth = ports.truth(
        &part,
        &element,
        Compatibility::Strong,
        &band,
        Some(&mirrored(&part)),
    );
    println!("{truth:?}, bound {total:.2e}");
    let worst = truth.collocated.max(truth.transfer.unwrap());
    assert!(worst <= 1e-3 && total <= 1e-3, "{worst:e} {total:e}");
    // The file says so itself.
    let estimate = ErrorBounds::of(&element, Compatibility::Strong)
        .unwrap()
        .unwrap();
    assert_eq!(estimate.loaded_along(&element), [(0, [2, 3]), (1, [2, 3])]);
    for (measure, truth, bracket) in measures(&truth, &over(&estimate, &band)) {
        assert!(
            lies_between(truth, bracket),
            "{measure}: {truth:e} {bracket:?}"
        );
        assert!(truth < CLEAR || bracket.upper < 3.0 * truth, "{measure}");
    }
}
