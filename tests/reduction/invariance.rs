//! Does the result stay the same when only the description changes: units, origin, numbering, axes, threads?
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::needless_range_loop
)]

use dcb_formats::component::{Component, Interface};
use dcb_reducer::Reduced;
use dcb_samples::solid::solid_component;
use dcb_samples::{
    Material, PseudoRandom, RodSection, SolidElement, UnitScale, in_units, planar_rod,
};
use dcb_tests::dense::{diagonal_roots, relative, scaled_difference};
use dcb_tests::{lowest, parts};
use faer::Mat;
use nalgebra::{Rotation3, Vector3};

/// Relative difference of frequencies, and what rounding in K allows.
fn frequency_change(a: &Reduced, b: &Reduced) -> (f64, f64) {
    let roots = |r: &Reduced| {
        r.superelement
            .modes
            .eigenvalues
            .iter()
            .map(|v| v.sqrt())
            .collect::<Vec<_>>()
    };
    let rounding = a
        .quality
        .eigenvalue_roundings
        .iter()
        .copied()
        .fold(0.0, f64::max);
    (
        relative(&roots(b), &roots(a)),
        1e-10_f64.max(10.0 * rounding),
    )
}

#[test]
fn units_change_nothing_but_the_numbers() {
    let slender = planar_rod(8, &RodSection::round(0.3, 0.0003, 0.2e12, 7870.0));
    let with_rotation = |rod: Component| {
        let all = |interface: &mut Interface| interface.directions = None;
        rod.changed(|draft| draft.interfaces.iter_mut().for_each(all))
            .unwrap()
    };
    for component in [
        parts::rod(4),
        with_rotation(parts::rod(4)),
        slender.clone(),
        with_rotation(slender),
        parts::skew_beam(),
        parts::steel_box([4, 2, 1], SolidElement::Hexahedron20),
        parts::rotor(),
    ] {
        let scale = UnitScale::mm_t_s();
        let other = in_units(&component, &scale);
        for count in [0, 1, 3, 8, 9, 12] {
            let (a, b) = (lowest(&component, count), lowest(&other, count));
            let name = format!("{} with {count} modes", component.name);
            assert_eq!(
                a.superelement.mode_count(),
                b.superelement.mode_count(),
                "{name}"
            );
            let rank = |r: &Reduced| {
                (
                    r.quality.residual_rank,
                    r.quality.static_directions,
                    r.quality.flexibility_rank,
                )
            };
            assert_eq!(rank(&a), rank(&b), "{name}");
            let (change, limit) = frequency_change(&a, &b);
            assert!(change < limit, "{name}: {change:e}");
            // mm/N, rad/N, rad/(N mm)
            let power: Vec<i32> = a
                .superelement
                .rows
                .iter()
                .map(|row| i32::from(row.direction >= 3))
                .collect();
            let f = &a.superelement.residual.flexibility;
            let expected = Mat::from_fn(f.nrows(), f.ncols(), |i, j| {
                f[(i, j)] / scale.mass
                    * scale.time.powi(2)
                    * (1.0 / scale.length).powi(power[i] + power[j])
            });
            // With most modes kept the residual is as exact as the whole is.
            let whole = lowest(&other, 0).superelement.residual.flexibility;
            let error = scaled_difference(
                &b.superelement.residual.flexibility,
                &expected,
                &diagonal_roots(&whole),
            );
            assert!(error < limit, "{name}: F_res {error:e}");
        }
    }
}

#[test]
fn a_part_far_from_the_origin_is_the_same_part() {
    for component in [
        parts::rod(4),
        parts::steel_box([4, 2, 1], SolidElement::Hexahedron),
        parts::skew_beam(),
    ] {
        // A power of two near a million keeps coordinates of the part to 1e-10 m.
        let by = [
            1_048_576.0,
            -1_048_576.0,
            if component.dimension().coordinate_count() == 3 {
                524_288.0
            } else {
                0.0
            },
        ];
        let (near, far) = (
            lowest(&component, 6),
            lowest(&parts::moved(&component, by), 6),
        );
        let (change, limit) = frequency_change(&near, &far);
        assert!(change < limit, "{}: {change:e}", component.name);
        let (a, b) = (&near.superelement, &far.superelement);
        let scale = diagonal_roots(&a.residual.flexibility);
        let error = scaled_difference(&b.residual.flexibility, &a.residual.flexibility, &scale);
        assert!(error < 3e-8, "{}: F_res {error:e}", component.name);
        for i in 0..3 {
            assert!((b.origin[i] - by[i] - a.origin[i]).abs() < 1e-9);
            for j in 0..3 {
                let scale = a.inertia.tensor[2][2];
                assert!(
                    (b.inertia.tensor[i][j] - a.inertia.tensor[i][j]).abs() < 1e-8 * scale,
                    "{}",
                    component.name
                );
            }
        }
        let i1_size = (a.inertia.mass * a.inertia.tensor[2][2]).sqrt();
        let i1_change = a
            .inertia
            .i1
            .iter()
            .zip(&b.inertia.i1)
            .take(6)
            .map(|(a, b)| {
                // Signs of modes may change.
                (0..9)
                    .map(|at| (a[at / 3][at % 3].abs() - b[at / 3][at % 3].abs()).abs())
                    .fold(0.0, f64::max)
            });
        assert!(
            i1_change.fold(0.0, f64::max) < 1e-7 * i1_size,
            "{}: J1",
            component.name
        );
    }
}

#[test]
fn node_numbers_do_not_matter() {
    for component in [
        parts::tilted_rod(6),
        parts::skew_beam(),
        parts::steel_box([3, 2, 2], SolidElement::Hexahedron),
        parts::steel_box([2, 1, 1], SolidElement::Tetra10),
        parts::rotor(),
    ] {
        let count = component.mesh.node_count() as u32;
        let mut order: Vec<u32> = (0..count).collect();
        let mut random = PseudoRandom::new(3);
        for i in (1..order.len()).rev() {
            order.swap(
                i,
                (((random.number() + 1.0) * 0.5 * (i + 1) as f64) as usize).min(i),
            );
        }
        let (a, b) = (
            lowest(&component, 5),
            lowest(&parts::renumbered(&component, &order), 5),
        );
        let (change, limit) = frequency_change(&a, &b);
        assert!(change < limit, "{}: {change:e}", component.name);
        let f = &a.superelement.residual.flexibility;
        let error = scaled_difference(&b.superelement.residual.flexibility, f, &diagonal_roots(f));
        assert!(error < 1e-9, "{}: F_res {error:e}", component.name);
        let m = &a.superelement.residual.mass;
        assert!(scaled_difference(&b.superelement.residual.mass, m, &diagonal_roots(m)) < 1e-9);
    }
}

#[test]
fn turning_the_part_turns_the_results() {
    let turn = Rotation3::from_axis_angle(
        &nalgebra::Unit::new_normalize(Vector3::new(1.0, -2.0, 0.5)),
        0.83,
    );
    let turned = |x: [f64; 3]| -> [f64; 3] { (turn * Vector3::from(x)).into() };
    for element in [
        SolidElement::Hexahedron,
        SolidElement::Hexahedron20,
        SolidElement::Tetra10,
    ] {
        let straight = parts::steel_box([3, 1, 1], element);
        let mut mesh = straight.mesh.clone();
        for point in mesh.coordinates.chunks_exact_mut(3) {
            point.copy_from_slice(&turned([point[0], point[1], point[2]]));
        }
        let mut interfaces = straight.interfaces.clone();
        for interface in &mut interfaces {
            interface.position = interface.position.map(turned);
        }
        let skew = solid_component("turned", mesh, &Material::STEEL, interfaces);
        let (a, b) = (lowest(&straight, 6), lowest(&skew, 6));
        let (change, limit) = frequency_change(&a, &b);
        assert!(change < limit, "{element:?}: {change:e}");
        let m = turn.matrix();
        // Force and moment of each interface turn with the part.
        let blocks = Mat::from_fn(12, 12, |i, j| {
            if i / 3 == j / 3 {
                m[(i % 3, j % 3)]
            } else {
                0.0
            }
        });
        let (f, g) = (
            &a.superelement.residual.flexibility,
            &b.superelement.residual.flexibility,
        );
        let expected = &blocks * f * blocks.transpose();
        let error = scaled_difference(g, &expected, &diagonal_roots(&expected));
        assert!(error < 1e-9, "{element:?}: F_res {error:e}");
        let tensor =
            |r: &Reduced| nalgebra::Matrix3::from_fn(|i, j| r.superelement.inertia.tensor[i][j]);
        assert!(
            (m * tensor(&a) * m.transpose() - tensor(&b)).abs().max() < 1e-12 * tensor(&a).max()
        );
        let placed: [f64; 3] = turned(a.superelement.origin);
        assert!((0..3).all(|i| (placed[i] - b.superelement.origin[i]).abs() < 1e-13));
    }
}

/// Large enough that every product is cut into several chunks.
fn large_parts() -> [Component; 2] {
    [
        dcb_samples::connecting_rod(0),
        dcb_samples::hard::thin_plate(),
    ]
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    for component in large_parts() {
        let with_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| lowest(&component, 10))
        };
        let one = with_threads(1);
        for threads in [2, 4] {
            let other = with_threads(threads);
            assert!(
                one.superelement == other.superelement,
                "{}: {threads} threads",
                component.name
            );
            assert!(
                one.recovery == other.recovery,
                "{}: {threads} threads",
                component.name
            );
        }
    }
}

#[test]
fn reductions_at_the_same_time_do_not_disturb_each_other() {
    let component = dcb_samples::connecting_rod(0);
    let alone = lowest(&component, 4);
    let together: Vec<Reduced> = std::thread::scope(|scope| {
        let running: Vec<_> = (0..4)
            .map(|_| scope.spawn(|| lowest(&component, 4)))
            .collect();
        running
            .into_iter()
            .map(|thread| thread.join().unwrap())
            .collect()
    });
    for other in together {
        assert!(alone.superelement == other.superelement && alone.recovery == other.recovery);
    }
}

#[test]
fn a_second_run_changes_no_bit() {
    for component in [parts::rod(8), dcb_samples::hard::symmetric_ring(8)] {
        let (one, two) = (lowest(&component, 9), lowest(&component, 9));
        assert!(
            one.superelement == two.superelement && one.recovery == two.recovery,
            "{}",
            component.name
        );
        // Also the signs of zeros and the digits of the report.
        assert_eq!(
            format!("{:?}", one.superelement),
            format!("{:?}", two.superelement)
        );
    }
}
