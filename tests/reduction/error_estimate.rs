//! Are estimated errors bounds, and close ones? Against the whole matrices, solved at every frequency.

use dcb_formats::component::{Component, Role};
use dcb_formats::dcb::read_superelement;
use dcb_formats::scene::Compatibility;
use dcb_reducer::{EnrichmentSource, Reduction};
use dcb_samples::{SolidElement, UnitScale, in_units};
use dcb_superelement::FrequencyBand;
use dcb_superelement::error_bounds::{Bracket, ErrorBounds, Estimate};
use dcb_tests::error_estimate::{
    LOSS_FACTOR, Outcome, System, attached, cases, outcomes, truth, with_interface_modes,
};
use dcb_tests::pages::error_estimate::PAGE;
use dcb_tests::{lowest, parts, with};

/// What dense solutions of the whole matrices leave of an error.
const NOISE: f64 = 1e-9;
/// Errors below this aren't told from rounding closely enough for an effectivity.
const CLEAR: f64 = 1e-6;

fn assert_between(what: &str, truth: f64, Bracket { lower, upper }: Bracket) {
    assert!(
        lower <= truth * (1.0 + 1e-6) + NOISE && truth <= upper * (1.0 + 1e-6) + NOISE,
        "{what}: {truth:e} is not between {lower:e} and {upper:e}"
    );
}

fn assert_effective(outcome: &Outcome) {
    for (measure, truth, bracket) in outcome.measures() {
        let what = format!(
            "{} {:?} {measure} {:.2}",
            outcome.name, outcome.form, outcome.share
        );
        println!(
            "{what}: {truth:.2e} in {:.2e} to {:.2e}",
            bracket.lower, bracket.upper
        );
        assert_between(&what, truth, bracket);
        if truth > CLEAR {
            assert!(
                bracket.upper < 10.0 * truth,
                "{what}: {}",
                bracket.upper / truth
            );
        }
    }
}

#[test]
fn true_errors_lie_between_close_bounds() {
    for case in cases() {
        for outcome in outcomes(&case, 20) {
            assert_effective(&outcome);
        }
    }
}

#[test]
fn directions_that_are_left_out_are_bounded_too() {
    for outcome in outcomes(&with_interface_modes(), 20) {
        assert_effective(&outcome);
        let fixed = outcome.estimate.static_response;
        assert!(fixed.lower > 1e-6, "{fixed:?}");
        assert!(fixed.upper < 1.001 * fixed.lower, "{fixed:?}");
    }
}

#[test]
fn further_columns_count() {
    let component = parts::steel_box([4, 1, 1], SolidElement::Hexahedron);
    let options = Reduction {
        enrichment: vec![EnrichmentSource::Spin, EnrichmentSource::Krylov],
        ..Reduction::lowest(6)
    };
    let (plain, enriched) = (lowest(&component, 6), with(&component, &options));
    let of = |reduced: &dcb_reducer::Reduced| {
        ErrorBounds::of(&reduced.superelement, Compatibility::Strong)
            .unwrap()
            .unwrap()
    };
    let (before, after) = (of(&plain), of(&enriched));
    let first = plain.superelement.modes.first_omitted_eigenvalue;
    let band = after.band(Some(0.001 * first), 0.7 * first, 20);
    let rows = after.attached_rows();
    let (before, after) = (
        before.over(&rows, &band, LOSS_FACTOR).unwrap(),
        after.over(&rows, &band, LOSS_FACTOR).unwrap(),
    );
    let found = truth(&component, &enriched, Compatibility::Strong, &rows, &band);
    assert_between("collocated", found.collocated, after.collocated.largest);
    assert_between(
        "transfer",
        found.transfer.unwrap(),
        after.transfer.unwrap().largest,
    );
    assert_between("held", found.held.unwrap(), after.held_frequency.unwrap());
    assert!(after.collocated.largest.upper < 2.0 * found.collocated);
    assert!(after.collocated.largest.upper < 0.1 * before.collocated.largest.lower);
}

#[test]
fn some_rows_alone_and_rows_that_only_move() {
    let mut component = parts::steel_box([4, 1, 1], SolidElement::Hexahedron).into_draft();
    component.interfaces.push({
        let mut sensor = parts::interface(
            "sensor",
            dcb_formats::component::InterfaceKind::Nodes,
            vec![8],
        );
        sensor.role = Role::Output;
        sensor
    });
    let component = Component::checked(component).unwrap();
    let reduced = lowest(&component, 6);
    let element = &reduced.superelement;
    assert_eq!(attached(element).iter().filter(|it| !**it).count(), 3);
    let first = element.modes.first_omitted_eigenvalue;
    for form in [Compatibility::Strong, Compatibility::Static] {
        let estimate = ErrorBounds::of(element, form).unwrap().unwrap();
        let band = estimate.band(Some(0.001 * first), 0.6 * first, 20);
        // One interface; parts of two; everything, with the rows that only move.
        for rows in [
            (0..6).collect::<Vec<usize>>(),
            vec![0, 2, 4, 7, 8],
            (0..15).collect(),
        ] {
            let found = truth(&component, &reduced, form, &rows, &band);
            let estimated = estimate.over(&rows, &band, LOSS_FACTOR).unwrap();
            let what = format!("{form:?} {rows:?}");
            assert_between(&what, found.collocated, estimated.collocated.largest);
            assert_eq!(found.transfer.is_some(), estimated.transfer.is_some());
            if let (Some(found), Some(estimated)) = (found.transfer, estimated.transfer) {
                assert_between(&what, found, estimated.largest);
                assert!(estimated.largest.upper < 3.0 * found, "{what}");
            }
            match (found.held, estimated.held_frequency) {
                (Some(found), Some(estimated)) => assert_between(&what, found, estimated),
                (found, None) => assert_eq!(found, Some(0.0), "{what}"),
                other => panic!("{what}: {other:?}"),
            }
            assert_between(&what, found.fixed.unwrap(), estimated.static_response);
        }
        // Entry by entry.
        let rows: Vec<usize> = (0..15).collect();
        let (whole, part) = (
            System::whole(&component),
            System::reduced(&component, &reduced, form),
        );
        for square in [0.01, 0.2, 0.5, 0.8].map(|share| share * first) {
            let found = estimate.at(&rows, square, LOSS_FACTOR).unwrap();
            let exact = whole.response(square, &found.forced);
            let reduced = part.response(square, &found.forced);
            for (i, row) in rows.iter().enumerate() {
                for j in 0..found.forced.len() {
                    let size = exact[(*row, j)].norm();
                    let off = (found.reduced[(i, j)] - reduced[(*row, j)]).norm();
                    assert!(off < 1e-9 * exact.norm_max(), "{row} {j} {off:e} {size:e}");
                    let error = exact[(*row, j)] - reduced[(*row, j)];
                    let left = (error - found.difference[(i, j)]).norm();
                    let bound = found.radius[(i, j)] + 1e-11 * exact.norm_max();
                    assert!(left < bound, "{row} {j} {left:e} {bound:e}");
                }
            }
        }
    }
}

/// Most points aren't looked at: their errors can't be the largest.
#[test]
fn a_band_has_the_largest_errors_of_its_points() {
    let mut all = cases();
    all.push(with_interface_modes());
    for case in all {
        let reduced = with(&case.component, &case.options);
        for form in [Compatibility::Strong, Compatibility::Static] {
            let bounds = ErrorBounds::of(&reduced.superelement, form)
                .unwrap()
                .unwrap();
            let rows = bounds.attached_rows();
            let wide = 0.81 * reduced.superelement.modes.first_omitted_eigenvalue;
            for band in [
                bounds.usual_band(200).unwrap(),
                bounds.band(None, wide, 200),
            ] {
                let of = |band: &FrequencyBand| bounds.responses(&rows, band, LOSS_FACTOR).unwrap();
                let found = of(&band);
                let points = band.squares.iter().map(|square| {
                    of(&FrequencyBand {
                        squares: vec![*square],
                    })
                });
                let points: Vec<_> = points.collect();
                for (kind, found) in found.iter().enumerate() {
                    let largest = |of: fn(&Bracket) -> f64| {
                        let sides = points.iter().map(|point| of(&point[kind].largest));
                        sides.fold(0.0, f64::max)
                    };
                    let expected = [largest(|of| of.lower), largest(|of| of.upper)];
                    let Bracket { lower, upper } = found.largest;
                    assert_eq!([lower, upper], expected, "{} {form:?} {kind}", case.name);
                    let at = points.iter().find(|point| point[kind].at == found.at);
                    assert_eq!(at.unwrap()[kind].largest.upper, upper);
                }
            }
        }
    }
}

#[test]
fn units_change_no_error() {
    for component in [
        parts::rod(4),
        parts::skew_beam(),
        parts::steel_box([4, 1, 1], SolidElement::Hexahedron),
    ] {
        let of = |component: &dcb_formats::Component, form| -> Estimate {
            let reduced = lowest(component, 4);
            let estimate = ErrorBounds::of(&reduced.superelement, form)
                .unwrap()
                .unwrap();
            let band = estimate.usual_band(30).unwrap();
            let rows = estimate.attached_rows();
            estimate.over(&rows, &band, LOSS_FACTOR).unwrap()
        };
        let other = in_units(&component, &UnitScale::mm_t_s());
        for form in [Compatibility::Strong, Compatibility::Static] {
            let (a, b) = (of(&component, form), of(&other, form));
            let same = |what: &str, a: Bracket, b: Bracket, tolerance: f64| {
                for (a, b) in [(a.lower, b.lower), (a.upper, b.upper)] {
                    let what = format!("{} {form:?} {what}: {a:e} {b:e}", component.name);
                    assert!((a - b).abs() <= tolerance * a.abs() + 1e-11, "{what}");
                }
            };
            same(
                "collocated",
                a.collocated.largest,
                b.collocated.largest,
                1e-5,
            );
            let transfer = |of: &Estimate| of.transfer.unwrap().largest;
            same("transfer", transfer(&a), transfer(&b), 1e-5);
            same("static", a.static_response, b.static_response, 1e-5);
            // A bisection ends within a percent.
            same(
                "held",
                a.held_frequency.unwrap(),
                b.held_frequency.unwrap(),
                0.03,
            );
        }
    }
}

#[test]
fn a_file_says_what_the_reduction_said() {
    let reduced = lowest(&parts::skew_beam(), 4);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("beam.dcb.h5");
    dcb_tests::write_bare(&path, &reduced.superelement);
    let read = read_superelement(&path).unwrap();
    let of = |element| {
        let estimate = ErrorBounds::of(element, Compatibility::Strong)
            .unwrap()
            .unwrap();
        let band = estimate.usual_band(20).unwrap();
        let rows = estimate.attached_rows();
        estimate.over(&rows, &band, LOSS_FACTOR).unwrap()
    };
    assert_eq!(of(&read), of(&reduced.superelement));
    // Nothing is claimed where nothing is known.
    let estimate = ErrorBounds::of(&read, Compatibility::Strong)
        .unwrap()
        .unwrap();
    let band = estimate.band(None, 1.01 * estimate.eigenvalue_bound(), 20);
    let refusal = estimate.over(&[0, 1], &band, LOSS_FACTOR).unwrap_err();
    assert!(
        refusal.to_string().contains("first frequency left out"),
        "{refusal}"
    );
    let mut old = read;
    old.moments = None;
    assert!(
        ErrorBounds::of(&old, Compatibility::Strong)
            .unwrap()
            .is_none()
    );
}

#[test]
fn every_raw_line_is_between_its_bounds() {
    for line in PAGE.lines().iter().skip(1) {
        let number = |key: &str| line[key].as_f64().unwrap();
        let bracket = Bracket {
            lower: number("lower"),
            upper: number("upper"),
        };
        assert_between(&line.to_string(), number("true"), bracket);
    }
}
