//! Interface reduction: is what is kept the best that so many directions can do, and is what is lost as reported?

use std::sync::Arc;

use super::dense_reduction::DenseReduction;
use dcb_formats::Component;
use dcb_formats::TimeFunction;
use dcb_formats::component::{Interface, InterfaceKind, Role};
use dcb_formats::function::Function;
use dcb_reducer::attachments::interface_reduction::InterfaceReduction;
use dcb_reducer::{InterfaceModes, Reduced, Reduction};
use dcb_runtime::analysis::equilibrium::{EquilibriumSettings, find_equilibrium};
use dcb_runtime::joint::{Fixed, JointKind};
use dcb_runtime::system::builder::Drawn;
use dcb_runtime::system::evaluation::Evaluation;
use dcb_runtime::system::{LoadAxes, Signal};
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::units::{UnitScale, in_units};
use dcb_samples::{PseudoRandom, SolidElement, hard};
use dcb_tests::dense::{diagonal_roots, difference, largest, relative, scaled_difference};
use dcb_tests::mechanism::{Scene, method, revolute, run};
use dcb_tests::oracle::Oracle;
use dcb_tests::{lowest, parts, with};
use faer::Mat;
use nalgebra::Vector3;

fn softest(component: &Component, modes: usize, wanted: usize) -> Reduced {
    let options = Reduction {
        interface_modes: InterfaceModes::Softest(wanted),
        ..Reduction::lowest(modes)
    };
    with(component, &options)
}

fn report(reduced: &Reduced) -> &InterfaceReduction {
    reduced.quality.interface_reduction.as_ref().unwrap()
}

/// A box held by one frame, with 64 nodes of which every direction is an interface row: 198 rows.
fn many_rows() -> Component {
    let part = parts::steel_box([5, 3, 3], SolidElement::Hexahedron);
    let held = part.mesh.point_sets["x_min"].clone();
    let others: Vec<u32> = (0..part.mesh.node_count() as u32)
        .filter(|node| !held.contains(node))
        .take(64)
        .collect();
    let interfaces = vec![
        parts::interface("held", InterfaceKind::Average, held),
        parts::interface("skin", InterfaceKind::Nodes, others),
    ];
    parts::with_interfaces(&part, interfaces)
}

/// A box with frames at both ends and twelve nodes of its own interface each: 48 rows, all of which can be loaded.
fn many_frames() -> Component {
    let part = parts::steel_box([5, 2, 2], SolidElement::Hexahedron);
    let ends = ["x_min", "x_max"].map(|name| part.mesh.point_sets[name].clone());
    let mut interfaces: Vec<Interface> = ends
        .iter()
        .zip(["left", "right"])
        .map(|(nodes, name)| parts::interface(name, InterfaceKind::Average, nodes.clone()))
        .collect();
    let inner = (0..part.mesh.node_count() as u32)
        .filter(|node| ends.iter().all(|end| !end.contains(node)))
        .step_by(3)
        .take(12);
    interfaces.extend(
        inner.map(|node| parts::interface(&format!("n{node}"), InterfaceKind::Nodes, vec![node])),
    );
    parts::with_interfaces(&part, interfaces)
}

fn quadratic(matrix: &Mat<f64>, g: &Mat<f64>) -> f64 {
    (g.transpose() * matrix * g)[(0, 0)]
}

#[test]
fn hundreds_of_rows_agree_with_dense_algebra() {
    let component = many_rows();
    let oracle = Oracle::of(&component);
    let modes = 6;
    for kept in [9, 40] {
        let reduced = softest(&component, modes, kept);
        let dense = DenseReduction::of(&oracle, modes, kept);
        let gap = dense.values[kept - 1] / dense.values[kept];
        assert!(gap > 1.001, "{kept}: the space is defined, {gap}");
        let (found, residual) = (report(&reduced), &reduced.superelement.residual);
        assert_eq!((found.kept, found.available), (kept, 198));
        assert_eq!(residual.sigma_squared.len(), kept);
        assert_eq!(
            (residual.transform.nrows(), residual.transform.ncols()),
            (198, kept)
        );
        let (f, m) = (
            diagonal_roots(&dense.flexibility0),
            diagonal_roots(&oracle.residual_mass(0)),
        );
        let apart = [
            scaled_difference(&residual.flexibility, &dense.flexibility, &f),
            scaled_difference(&residual.mass, &dense.mass, &m),
            relative(&residual.sigma_squared, &dense.sigma_squared),
            difference(&reduced.recovery.residual, &dense.shapes),
            relative(
                &[
                    found.flexibility_error,
                    found.residual_error,
                    found.worst_direction_error,
                    found.largest_left_out,
                    found.lowest_left_out.unwrap(),
                ],
                &[
                    dense.flexibility_error,
                    dense.residual_error,
                    dense.worst_direction_error,
                    dense.values[kept],
                    dense.lowest_left_out.sqrt() / std::f64::consts::TAU,
                ],
            ),
        ];
        println!(
            "{kept} of 198: F', M', σ², X', report differ by {apart:?}; lost at a row {:.2e}, in any direction {:.2e}",
            found.flexibility_error, found.worst_direction_error
        );
        assert!(apart.iter().all(|apart| *apart < 1e-7), "{apart:?}");
        let t = &residual.transform;
        let in_mass = t.transpose() * &residual.mass * t - Mat::<f64>::identity(kept, kept);
        assert!(largest(in_mass.as_ref()) < 1e-10);
    }
}

/// The softest directions lose least: no other choice of as many keeps the scaled norm smaller, and forces of any kind lose less
/// with every direction more, never more than reported.
#[test]
fn what_is_lost_falls_with_every_direction_and_is_bounded_by_the_report() {
    let component = many_rows();
    let whole = lowest(&component, 6).superelement;
    let shapes = &whole.modes.interface_shapes;
    let modal = Mat::from_fn(198, 198, |i, j| {
        (0..6)
            .map(|k| shapes[(i, k)] * shapes[(j, k)] / whole.modes.eigenvalues[k])
            .sum::<f64>()
    });
    let flexibility0 = &modal + &whole.residual.flexibility;
    let mut random = PseudoRandom::new(7);
    let forces: Vec<Mat<f64>> = (0..6)
        .map(|one| {
            Mat::from_fn(198, 1, |i, _| {
                // A single row, then all rows at once, each in its own unit.
                let size = 1.0 / flexibility0[(i, i)].sqrt();
                if one < 3 {
                    size * f64::from(u8::from(i == 60 * one + 5))
                } else {
                    size * random.number()
                }
            })
        })
        .collect();
    let mut last = vec![f64::INFINITY; forces.len() + 2];
    for kept in [0, 1, 3, 6, 12, 25, 50, 100, 150, 198] {
        let reduced = softest(&component, 6, kept);
        let found = report(&reduced);
        assert_eq!(found.kept, kept);
        let lost = &whole.residual.flexibility - &reduced.superelement.residual.flexibility;
        let mut now: Vec<f64> = forces.iter().map(|g| quadratic(&lost, g)).collect();
        for (g, lost) in forces.iter().zip(&now) {
            let energy = quadratic(&flexibility0, g);
            let norm: f64 = (0..198)
                .map(|i| flexibility0[(i, i)] * g[(i, 0)].powi(2))
                .sum();
            let rounding = 1e-10 * energy;
            assert!(
                *lost <= found.worst_direction_error * energy + rounding,
                "{kept}"
            );
            assert!(*lost <= found.largest_left_out * norm + rounding, "{kept}");
            assert!(*lost >= -rounding, "{kept}: a part becomes stiffer");
        }
        for i in 0..198 {
            assert!(lost[(i, i)] <= (found.flexibility_error + 1e-10) * flexibility0[(i, i)]);
        }
        now.extend([found.flexibility_error, found.largest_left_out]);
        println!("{kept:4}: {now:?}");
        for (now, last) in now.iter().zip(&last) {
            assert!(*now <= last + 1e-9 * last.min(1.0), "{kept}: {now} {last}");
        }
        last = now;
    }
    assert_eq!(last[forces.len()..], [0.0, 0.0]);
}

#[test]
fn every_direction_kept_changes_nothing() {
    let component = many_frames();
    let whole = lowest(&component, 5);
    let available = report(&softest(&component, 5, 0)).available;
    assert_eq!(available, whole.quality.flexibility_rank);
    for wanted in [available, available + 1, 10_000] {
        let reduced = softest(&component, 5, wanted);
        let found = report(&reduced);
        assert_eq!((found.wanted, found.kept), (wanted, available));
        assert!(!found.leaves_out());
        assert_eq!(
            (found.flexibility_error, found.worst_direction_error),
            (0.0, 0.0)
        );
        let (a, b) = (&reduced.superelement, &whole.superelement);
        assert_eq!((&a.residual, &a.modes), (&b.residual, &b.modes));
        assert_eq!(a.inertia, b.inertia);
        assert_eq!(reduced.recovery, whole.recovery);
    }
}

/// A clamped box under loads at three interfaces, at rest: the work of the loads is what the interfaces' flexibility says, so that
/// it falls short by what the reduction lost.
#[test]
fn a_loaded_mechanism_is_too_stiff_by_what_is_reported() {
    let component = many_frames();
    let at_rest = |reduced: &Reduced| -> (f64, Mat<f64>) {
        let element = &reduced.superelement;
        let body = FlexibleBody::from_superelement(element, Compatibility::Strong).unwrap();
        let mut scene = Scene::new(element.dimension, Vector3::zeros());
        let body = scene.body(&Arc::new(body), &Drawn::default());
        let root = scene.on(body, 0);
        let ground = scene.ground([0.0, 0.05, 0.03]);
        scene.join(&JointKind::Fixed(Fixed), ground, root);
        let loaded = [1, 4, 9].map(|interface| scene.on(body, interface));
        let forces = [
            [300.0, -200.0, 100.0],
            [0.0, 500.0, 50.0],
            [-80.0, 0.0, 400.0],
        ];
        for (marker, force) in loaded.iter().zip(&forces) {
            let signals = force.map(|value| {
                Some(scene.builder().signal(Signal {
                    function: TimeFunction::new(&Function::Polynomial(vec![value])).unwrap(),
                    input: None,
                    offset: 0.0,
                }))
            });
            let none = [None; 3];
            scene
                .builder()
                .load("load", *marker, LoadAxes::World, signals, none);
        }
        let (system, mut state) = scene.finish();
        let mut evaluation = Evaluation::of(&system);
        evaluation.place(&system, &state);
        let before = loaded.map(|marker| evaluation.motions[marker].position);
        find_equilibrium(&system, &mut state, &EquilibriumSettings::default()).unwrap();
        evaluation.place(&system, &state);
        evaluation.measure(&system, &state);
        evaluation.load(&system, &state);
        let work = loaded
            .iter()
            .zip(before)
            .zip(&forces)
            .map(|((marker, before), force)| {
                (evaluation.motions[*marker].position - before).dot(&Vector3::from(*force))
            })
            .sum();
        let mut g = vec![0.0; element.rows.len()];
        evaluation.write_interface_forces(&system, body, &mut g);
        (work, Mat::from_fn(g.len(), 1, |i, _| g[i]))
    };
    let whole = lowest(&component, 5);
    let (work, g) = at_rest(&whole);
    let element = &whole.superelement;
    let f0 = |i: usize| {
        let modal = |k: usize| {
            element.modes.interface_shapes[(i, k)].powi(2) / element.modes.eigenvalues[k]
        };
        element.residual.flexibility[(i, i)] + (0..5).map(modal).sum::<f64>()
    };
    let norm: f64 = (0..g.nrows()).map(|i| f0(i) * g[(i, 0)].powi(2)).sum();
    let mut last = f64::INFINITY;
    for wanted in [0, 2, 5, 10, 20, 30, 1000] {
        let reduced = softest(&component, 5, wanted);
        let found = report(&reduced);
        let (less, _) = at_rest(&reduced);
        let short = work - less;
        let lost = &element.residual.flexibility - &reduced.superelement.residual.flexibility;
        let predicted = quadratic(&lost, &g);
        println!(
            "{wanted}: works {:.3e} less of {work:.3e}, predicted {predicted:.3e}, bounds {:.3e} {:.3e}",
            short,
            found.worst_direction_error * work,
            found.largest_left_out * norm
        );
        let rounding = 1e-5 * work;
        assert!((short - predicted).abs() < rounding, "{wanted}");
        assert!(short <= found.worst_direction_error * work + rounding);
        assert!(short <= found.largest_left_out * norm + rounding);
        assert!(short <= last + 1e-9 * work && short >= -1e-9 * work);
        last = short;
    }
    assert!(last.abs() < 1e-9 * work, "every direction: {last:e}");
}

/// Fewer directions than the rows of one joint, and two interfaces that say the same.
#[test]
fn joints_hold_with_fewer_directions_than_rows() {
    let component = many_frames();
    let again = Interface {
        name: "again".into(),
        ..component.interfaces[0].clone()
    };
    let component = component
        .changed(|draft| draft.interfaces.push(again))
        .unwrap();
    for (wanted, compatibility) in [
        (0, Compatibility::Strong),
        (3, Compatibility::Strong),
        (3, Compatibility::Static),
        (8, Compatibility::Strong),
    ] {
        let reduced = softest(&component, 4, wanted);
        let residual = &reduced.superelement.residual;
        let n_b = reduced.superelement.rows.len();
        let same = residual.flexibility.as_ref().submatrix(0, 0, 6, n_b)
            - residual.flexibility.as_ref().submatrix(n_b - 6, 0, 6, n_b);
        let scale = largest(residual.flexibility.as_ref()).max(f64::MIN_POSITIVE);
        assert!(largest(same.as_ref()) < 1e-9 * scale);
        let body = FlexibleBody::from_superelement(&reduced.superelement, compatibility).unwrap();
        if compatibility == Compatibility::Strong {
            assert_eq!(body.coordinate_count(), 4 + wanted);
            assert!(
                body.residual_flexibility.is_none(),
                "nothing acts statically"
            );
        }
        let mut scene = Scene::new(
            reduced.superelement.dimension,
            Vector3::new(0.0, 0.0, -9.81),
        );
        let body = scene.body(&Arc::new(body), &Drawn::default());
        let (left, right) = (scene.on(body, 0), scene.on(body, 1));
        let ground = scene.ground([0.0, 0.05, 0.03]);
        scene.join(&revolute(Vector3::y()), ground, left);
        let (mut simulation, started) = scene.start(method(0.8));
        assert!(started.redundant.is_empty(), "{started:?}");
        let mut lowest = 0.0_f64;
        run(&mut simulation, 0.05, 500, |simulation| {
            let evaluation = simulation.refresh();
            lowest = lowest.min(evaluation.motions[right].position.z - 0.03);
            let hinge = evaluation.motions[left].position - Vector3::new(0.0, 0.05, 0.03);
            assert!(hinge.norm() < 1e-9, "{:e}", hinge.norm());
        });
        // A bar that starts to fall about its end: 3/2 g t²/2.
        let expected = -0.75 * 9.81 * 0.05_f64.powi(2);
        assert!(
            (lowest / expected - 1.0).abs() < 0.05,
            "{lowest} {expected}"
        );
    }
}

#[test]
fn the_choice_has_no_unit() {
    let metres = many_rows();
    let millimetres = in_units(&metres, &UnitScale::mm_t_s());
    let (a, b) = (softest(&metres, 6, 20), softest(&millimetres, 6, 20));
    let numbers = |r: &Reduced| {
        let it = report(r);
        [
            it.flexibility_error,
            it.residual_error,
            it.largest_left_out,
            it.worst_direction_error,
            it.lowest_left_out.unwrap(),
        ]
    };
    assert!(relative(&numbers(&a), &numbers(&b)) < 1e-6);
    assert!(
        relative(
            &a.superelement.residual.sigma_squared,
            &b.superelement.residual.sigma_squared
        ) < 1e-8
    );
}

/// A square block bends alike both ways: one way is never kept without the other.
#[test]
fn a_double_direction_is_not_cut() {
    let component = hard::square_block();
    let available = report(&softest(&component, 3, 0)).available;
    let kept: Vec<usize> = (0..=available)
        .map(|wanted| report(&softest(&component, 3, wanted)).kept)
        .collect();
    assert!(
        kept.iter().enumerate().any(|(n, kept)| *kept == n + 1),
        "{kept:?}"
    );
    assert!(
        kept.iter()
            .enumerate()
            .all(|(n, kept)| n <= *kept && *kept <= n + 1),
        "{kept:?}"
    );
    assert_eq!((kept[0], kept[available]), (0, available));
}

#[test]
fn output_rows_see_what_is_kept() {
    let component = many_frames()
        .changed(|draft| draft.interfaces[3].role = Role::Output)
        .unwrap();
    let whole = lowest(&component, 4).superelement.residual;
    let reduced = softest(&component, 4, 6).superelement.residual;
    let (all, some) = (whole.output_shapes.unwrap(), reduced.output_shapes.unwrap());
    for j in 0..some.ncols() {
        // Row 15 is the first of the third node, which only observes.
        assert_eq!(reduced.flexibility[(15, j)], 0.0);
        assert_eq!(some[(j, 15)], 0.0);
    }
    let norm = |of: &Mat<f64>| of.as_ref().subrows(15, 3).norm_l2();
    assert!(0.0 < norm(&some) && norm(&some) < 1.001 * norm(&all));
    assert_eq!(reduced.transform.ncols(), 6);
}
