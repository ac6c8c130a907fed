//! Force laws: work, power and derivatives.

use dcb_runtime::Error;
use dcb_runtime::force_law::{Characteristic, Law, Table};

const FREE: f64 = 0.3;

fn linear(slope: f64) -> Characteristic {
    Characteristic::Linear { slope }
}

fn tabulated(points: &[(f64, f64)]) -> Characteristic {
    Characteristic::Tabulated(Table::through(points).unwrap())
}

/// A linear law, and one with a snap-through spring away from the origin and friction that saturates.
fn laws() -> [Law; 2] {
    let snapping = [(0.1, 2.0), (0.25, 5.0), (0.4, -1.0), (0.9, 6.0)];
    let friction = [
        (-1.0, -3.0),
        (-0.1, -2.5),
        (0.0, 0.0),
        (0.1, 2.5),
        (2.0, 2.5),
    ];
    [
        Law::new(FREE, linear(40.0), linear(0.7)).unwrap(),
        Law::new(FREE, tabulated(&snapping), tabulated(&friction)).unwrap(),
    ]
}

/// Away from every point of the tables.
fn samples() -> impl Iterator<Item = (f64, f64)> {
    (-20..20).map(|i| {
        (
            FREE + 0.077 * f64::from(i) + 0.013,
            0.13 * f64::from(i) + 0.017,
        )
    })
}

#[test]
fn the_force_at_rest_is_the_slope_of_the_potential() {
    let step = 1e-5;
    for law in laws() {
        for (value, _) in samples() {
            let slope = (law.potential(value + step) - law.potential(value - step)) / (2.0 * step);
            assert!(
                (law.force(value, 0.0) + slope).abs() < 1e-8,
                "{law:?} at {value}"
            );
        }
        assert_eq!(law.potential(FREE), 0.0);
    }
}

#[test]
fn derivatives_are_those_of_the_force() {
    let step = 1e-5;
    for law in laws() {
        for (value, rate) in samples() {
            let (with_value, with_rate) = law.derivatives(value, rate);
            let by_value =
                (law.force(value + step, rate) - law.force(value - step, rate)) / (2.0 * step);
            let by_rate =
                (law.force(value, rate + step) - law.force(value, rate - step)) / (2.0 * step);
            assert!((with_value - by_value).abs() < 1e-8, "{law:?} at {value}");
            assert!((with_rate - by_rate).abs() < 1e-8, "{law:?} at {rate}");
        }
    }
}

#[test]
fn the_damping_takes_the_power_that_the_force_does_not_store() {
    for law in laws() {
        for (value, rate) in samples() {
            let lost = law.dissipation(rate);
            assert!(lost > 0.0, "{law:?} gives {lost} at {rate}");
            let power = (law.force(value, rate) - law.force(value, 0.0)) * rate;
            assert!((power + lost).abs() < 1e-12, "{law:?}");
        }
        assert_eq!(law.dissipation(0.0), 0.0);
    }
}

#[test]
fn a_linear_law_is_a_spring_and_a_dashpot() {
    let law = Law::new(FREE, linear(40.0), linear(0.7)).unwrap();
    assert_eq!(law.force(FREE + 0.5, 2.0), -(20.0 + 1.4));
    assert_eq!(law.potential(FREE - 0.5), 5.0);
}

#[test]
fn a_table_passes_through_its_points_and_goes_on_straight() {
    let points = [(-1.0, 4.0), (0.5, 1.0), (2.0, 1.0), (3.0, -1.0)];
    let law = Law::new(0.0, tabulated(&points), linear(0.0)).unwrap();
    for (x, y) in points {
        assert!((law.force(x, 0.0) + y).abs() < 1e-15);
    }
    // The first line has the slope -2, the last one too.
    assert!((law.force(-3.0, 0.0) + 8.0).abs() < 1e-14);
    assert!((law.force(5.0, 0.0) + -5.0).abs() < 1e-14);
    // From 0 the areas: (2 + 1)/2 · 0.5, then 1 · 1.5, then none.
    assert!((law.potential(3.0) - 2.25).abs() < 1e-14);
    // Back to -1: minus (2 + 4)/2 · 1.
    assert!((law.potential(-1.0) + 3.0).abs() < 1e-14);
    // At a point, the slope of the line above.
    assert_eq!(law.derivatives(0.5, 0.0).0, 0.0);
}

#[test]
fn a_table_of_a_line_is_the_line() {
    let line = [(-0.3, -12.0), (0.1, 4.0), (0.7, 28.0)];
    let table = Law::new(FREE, tabulated(&line), linear(0.7)).unwrap();
    let straight = Law::new(FREE, linear(40.0), linear(0.7)).unwrap();
    for (value, rate) in samples() {
        assert!((table.force(value, rate) - straight.force(value, rate)).abs() < 1e-12);
        assert!((table.potential(value) - straight.potential(value)).abs() < 1e-12);
    }
}

#[test]
fn laws_that_cannot_be_are_refused() {
    let short = Table::through(&[(0.0, 0.0)]);
    assert!(matches!(short, Err(Error::TableTooShort { count: 1 })));
    let unordered = Table::through(&[(0.0, 0.0), (1.0, 1.0), (1.0, 2.0)]);
    assert!(matches!(
        unordered,
        Err(Error::TableNotIncreasing { index: 2, .. })
    ));
    let endless = Table::through(&[(0.0, 0.0), (1.0, f64::INFINITY)]);
    assert!(matches!(endless, Err(Error::LawNotFinite { .. })));
    let steep = Table::through(&[(0.0, 0.0), (f64::MIN_POSITIVE, 1e10)]);
    assert!(matches!(steep, Err(Error::LawNotFinite { .. })));
    let number = Law::new(f64::NAN, linear(1.0), linear(0.0));
    assert!(matches!(number, Err(Error::LawNotFinite { .. })));
    let number = Law::new(0.0, linear(f64::NAN), linear(0.0));
    assert!(matches!(number, Err(Error::LawNotFinite { .. })));
}

#[test]
fn damping_that_feeds_energy_in_is_refused() {
    let driving = [
        linear(-0.1),
        tabulated(&[(-1.0, -1.0), (1.0, 1.0)]), // the origin is not a point
        tabulated(&[(-1.0, -1.0), (0.0, 0.1), (1.0, 1.0)]),
        tabulated(&[(-1.0, 1.0), (0.0, 0.0), (1.0, 1.0)]),
        tabulated(&[(0.0, 0.0), (1.0, 2.0), (2.0, 1.0)]), // negative beyond 3
        tabulated(&[(0.0, 0.0), (1.0, -1.0)]),
    ];
    for damping in driving {
        let law = Law::new(0.0, linear(1.0), damping.clone());
        assert!(
            matches!(law, Err(Error::DampingNotPassive { .. })),
            "{damping:?}"
        );
    }
    let negative_stiffness = Law::new(0.0, linear(-1.0), linear(0.0)).unwrap();
    assert_eq!(negative_stiffness.force(1.0, 0.0), 1.0);
}
