//! Frequencies of an assembly of truncated parts, and the bounds of what the truncation does.

use dcb_samples::spatial_beam::{SpatialBeam, spatial_beam};
use dcb_samples::{Material, SolidElement, solid::box_block};
use dcb_tests::lowest;

use dcb_tests::dense::{diagonal_roots, scaled_difference};

use crate::{HALVES, loaded, put_together};

const UNITS: &str = r#""units": {"length": "m", "mass": "kg", "time": "s"}"#;

/// A straight beam along x.
fn beam(elements: usize, start: f64, end: f64) -> dcb_formats::Component {
    spatial_beam(&SpatialBeam {
        elements,
        start: [start, 0.0, 0.0],
        end: [end, 0.0, 0.0],
        ..SpatialBeam::default()
    })
}

/// The whole mesh lies between the bounds, whatever few modes the parts have, and the distance is no more than a few times the error.
#[test]
fn frequencies_of_the_mesh_lie_between_the_bounds() {
    let whole = lowest(&beam(40, 0.0, 1.0), 8)
        .superelement
        .modes
        .eigenvalues;
    let mut last = f64::INFINITY;
    for modes in [2, 6, 12] {
        let mut omitted = f64::INFINITY;
        let parts = [(0.0, 0.4, 16), (0.4, 1.0, 24)].map(|(from, to, elements)| {
            let component = beam(elements, from, to);
            let reduced = lowest(&component, modes);
            omitted = omitted.min(reduced.superelement.modes.first_omitted_eigenvalue);
            loaded(
                &component,
                reduced,
                if from == 0.0 { "first" } else { "second" },
            )
        });
        let found = put_together(HALVES, parts.into(), 8).unwrap();
        let bounds = found.report.modes.as_ref().unwrap();
        let (mut error, mut compared) = (0.0_f64, 0);
        for (bound, exact) in bounds.iter().zip(&whole) {
            assert!(
                bound.reduced >= exact * (1.0 - 1e-9),
                "{} is below {exact}",
                bound.reduced
            );
            assert!(
                bound.lower <= exact * (1.0 + 1e-9),
                "{modes} modes: {} is above {exact}",
                bound.lower
            );
            let found = bound.reduced / exact - 1.0;
            error = error.max(found);
            // Well below the parts' first omitted frequency the bound is nearly the error.
            if bound.reduced < 0.25 * omitted {
                let told = bound.reduced / bound.lower - 1.0;
                let shares: f64 = bound.shares.iter().sum();
                assert!(
                    told < 3.0 * found + 1e-8,
                    "{modes} modes: told {told:e}, found {found:e}"
                );
                assert!(
                    shares > 0.7 * found - 1e-9 && shares < 3.0 * found + 1e-9,
                    "{modes} modes: shares {shares:e}, found {found:e}"
                );
                compared += 1;
            }
        }
        assert!(error < last && compared >= 2);
        last = error;
        let moments = found.superelement.moments.unwrap();
        assert!(moments.eigenvalue_bound <= whole_omitted(&beam(40, 0.0, 1.0)) * (1.0 + 1e-9));
    }
    assert!(last < 1e-4, "{last:e}");
}

fn whole_omitted(component: &dcb_formats::Component) -> f64 {
    lowest(component, 8)
        .superelement
        .modes
        .first_omitted_eigenvalue
}

/// Solid blocks joined node by node: all nodes of a face are an interface.
#[test]
fn blocks_joined_at_their_nodes() {
    let steel = Material::STEEL;
    let ends = |component: dcb_formats::Component, kind_of: &[(&str, &str)]| {
        component
            .changed(|draft| {
                for (interface, set) in kind_of {
                    let nodes = draft.mesh.point_sets[*set].clone();
                    let of = draft
                        .interfaces
                        .iter_mut()
                        .find(|of| of.name == *interface)
                        .unwrap();
                    of.kind = dcb_formats::component::InterfaceKind::Nodes;
                    of.nodes = nodes;
                    of.position = None;
                    of.directions = None;
                }
            })
            .unwrap()
    };
    let whole = lowest(
        &box_block(
            [6, 2, 1],
            [0.6, 0.1, 0.05],
            SolidElement::Hexahedron,
            &steel,
        ),
        6,
    );
    let left = ends(
        box_block(
            [3, 2, 1],
            [0.3, 0.1, 0.05],
            SolidElement::Hexahedron,
            &steel,
        ),
        &[("right", "x_max")],
    );
    let right = ends(
        box_block(
            [3, 2, 1],
            [0.3, 0.1, 0.05],
            SolidElement::Hexahedron,
            &steel,
        ),
        &[("left", "x_min")],
    );
    let text = format!(
        r#"{{"dimension": 3, {UNITS},
          "bodies": {{"l": {{"superelement": "l.dcb.h5"}}, "r": {{"superelement": "r.dcb.h5", "position": [0.3, 0, 0]}}}},
          "joints": {{"weld": {{"fixed": {{"a": "l/right", "b": "r/left"}}}}}},
          "interfaces": {{"left": "l/left", "right": "r/right"}}}}"#
    );
    let parts = vec![
        loaded(&left, lowest(&left, 20), "l"),
        loaded(&right, lowest(&right, 20), "r"),
    ];
    let found = put_together(&text, parts, 6).unwrap();
    for (bound, exact) in found
        .report
        .modes
        .unwrap()
        .iter()
        .zip(&whole.superelement.modes.eigenvalues)
    {
        // The files' attachments are nearly dependent at so many rows, and right to that.
        assert!(bound.lower <= exact * (1.0 + 1e-8) && exact * (1.0 - 1e-8) <= bound.reduced);
        assert!(bound.reduced / exact - 1.0 < 1e-5);
    }
    // Statics need no modes: the residual and modal flexibility together are exact.
    let whole_flexibility = |of: &dcb_formats::Superelement, row: usize| -> f64 {
        let modes: f64 = (0..of.mode_count())
            .map(|k| of.modes.interface_shapes[(row, k)].powi(2) / of.modes.eigenvalues[k])
            .sum();
        modes + of.residual.flexibility[(row, row)]
    };
    for row in 0..found.superelement.rows.len() {
        let (a, b) = (
            whole_flexibility(&found.superelement, row),
            whole_flexibility(&whole.superelement, row),
        );
        assert!((a / b - 1.0).abs() < 1e-8, "row {row}: {a:e} and {b:e}");
    }
}

/// The estimate of what truncated parts do to responses, against those of the whole mesh with every mode.
#[test]
fn responses_change_as_estimated() {
    let whole = lowest(&beam(20, 0.0, 1.0), 1000).superelement;
    for modes in [4, 8, 12] {
        let parts =
            [(0.0, 0.4, 8, "first"), (0.4, 1.0, 12, "second")].map(|(from, to, elements, name)| {
                let component = beam(elements, from, to);
                let reduced = lowest(&component, modes);
                loaded(&component, reduced, name)
            });
        // All modes of the assembly: what is left of the error is the parts'.
        let mut found = put_together(HALVES, parts.into(), 1000).unwrap();
        found.superelement.modes.damping.fill(0.0);
        let responses = found.report.responses.unwrap();
        let lambda = faer::c64::new(responses.at, 0.0) / faer::c64::new(1.0, 0.02);
        let (own, exact) = (
            receptance(&found.superelement, lambda),
            receptance(&whole, lambda),
        );
        let flexibility: Vec<f64> = (0..own.nrows())
            .map(|row| exact[(row, row)].norm().sqrt().recip())
            .collect();
        let norm = |of: &dyn Fn(usize, usize) -> faer::c64| -> f64 {
            let entries = (0..own.nrows()).flat_map(|i| (0..own.ncols()).map(move |j| (i, j)));
            entries
                .map(|(i, j)| (of(i, j) * flexibility[i] * flexibility[j]).norm_sqr())
                .sum::<f64>()
                .sqrt()
        };
        let error = norm(&|i, j| own[(i, j)] - exact[(i, j)]) / norm(&|i, j| exact[(i, j)]);
        let effectivity = responses.error / error;
        assert!(
            effectivity > 0.7 && effectivity < 4.0,
            "{modes} modes: estimated {:e}, found {error:e}",
            responses.error
        );
    }
}

/// H between the rows of a free superelement, all of whose modes are kept or whose attachments stand for the rest.
fn receptance(of: &dcb_formats::Superelement, lambda: faer::c64) -> faer::Mat<faer::c64> {
    let coordinates =
        dcb_superelement::DynamicCoordinates::of(of, dcb_formats::scene::Compatibility::Strong)
            .unwrap();
    let rigid = &of.moments.as_ref().unwrap().rigid_shapes;
    let (n, r) = (coordinates.stiffness.len(), rigid.ncols());
    let zero = faer::c64::new(0.0, 0.0);
    faer::Mat::from_fn(rigid.nrows(), rigid.nrows(), |i, j| {
        let mut sum = (0..r).fold(zero, |sum, k| {
            sum - faer::c64::new(rigid[(i, k)] * rigid[(j, k)], 0.0) / lambda
        });
        for k in 0..n {
            let shapes = &coordinates.interface_shapes;
            sum += faer::c64::new(shapes[(i, k)] * shapes[(j, k)], 0.0)
                / (faer::c64::new(coordinates.stiffness[k], 0.0) - lambda);
        }
        sum + coordinates
            .residual_flexibility
            .as_ref()
            .map_or(0.0, |of| of[(i, j)])
    })
}

/// Power moments of an assembly of truncated parts are those of the whole mesh; with no mode kept, so that none of its shapes enters.
#[test]
fn moments_have_what_the_parts_left_out() {
    let exact = lowest(&beam(20, 0.0, 1.0), 0).superelement.moments.unwrap();
    let parts =
        [(0.0, 0.4, 8, "first"), (0.4, 1.0, 12, "second")].map(|(from, to, elements, name)| {
            let component = beam(elements, from, to);
            loaded(&component, lowest(&component, 2), name)
        });
    let found = put_together(HALVES, parts.into(), 0)
        .unwrap()
        .superelement
        .moments
        .unwrap();
    // The file's M_3 and M_4 have a shift: Σ c cᵀ/(ω⁴ (ω² + σ)) and Σ c cᵀ/(ω⁴ (ω² + σ)²).
    let third = &exact.third + &exact.fourth * faer::Scale(exact.shift);
    for (what, own, whole, limit) in [
        ("M_1", &found.first, &exact.first, 1e-9),
        ("M_2", &found.second, &exact.second, 1e-9),
        ("M_3", &found.third, &third, 1e-8),
        ("M_4", &found.fourth, &exact.fourth, 1e-4),
    ] {
        let difference = scaled_difference(own, whole, &diagonal_roots(whole));
        assert!(difference < limit, "{what}: {difference:e}");
    }
}
