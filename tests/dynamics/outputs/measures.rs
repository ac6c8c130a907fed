//! Measures between frames, each kind, against differences of its value.

use crate::support::frames::{Random, turn, varied};
use dcb_runtime::kinematics::frame_motion::{FrameMotion, Six};
use dcb_runtime::measure::{
    Alignment, Angle, Displacement, Distance, Elongation, Gradient, Measure, Rotation,
    WorldDisplacement,
};
use nalgebra::{Matrix6, Unit, Vector3};

const POSES: u64 = 60;

/// One of every kind; without a wildcard below, so that the compiler asks for a new kind's example.
fn examples(random: &mut Random) -> Vec<Measure> {
    let first_a = random.unit();
    let second_a = Unit::new_normalize(first_a.cross(random.unit().as_ref()));
    let all = vec![
        Measure::Displacement(Displacement {
            direction: random.unit(),
        }),
        Measure::WorldDisplacement(WorldDisplacement {
            direction: random.unit(),
        }),
        Measure::Alignment(Alignment {
            direction_a: random.unit(),
            direction_b: random.unit(),
        }),
        Measure::Distance(Distance { length: 0.7 }),
        Measure::Elongation(Elongation { length: 0.7 }),
        Measure::Angle(Angle {
            first_a,
            second_a,
            first_b: random.unit(),
        }),
        Measure::Rotation(Rotation {
            direction: random.unit(),
            rest: random.axes(),
        }),
    ];
    let mut seen = [0; 7];
    for measure in &all {
        seen[match measure {
            Measure::Displacement(_) => 0,
            Measure::WorldDisplacement(_) => 1,
            Measure::Alignment(_) => 2,
            Measure::Distance(_) => 3,
            Measure::Elongation(_) => 4,
            Measure::Angle(_) => 5,
            Measure::Rotation(_) => 6,
        }] += 1;
    }
    assert_eq!(seen, [1; 7]);
    all
}

/// How fast a measure bends near these poses, squared and at least 1: what scales the error of a difference.
fn sharpness(measure: &Measure, a: &FrameMotion, b: &FrameMotion) -> f64 {
    let separation = (b.position - a.position).norm();
    let near = match measure {
        Measure::Elongation(_) => separation,
        // Distance of the direction of b from the axis, where the angle is singular.
        Measure::Angle(angle) => {
            let axis = a.axes * angle.first_a.cross(angle.second_a.as_ref());
            axis.cross(&(b.axes * angle.first_b.as_ref())).norm()
        }
        // Distance from the half turn.
        Measure::Rotation(rotation) => {
            let turned = a.axes.transpose() * b.axes * rotation.rest.transpose();
            std::f64::consts::PI - nalgebra::Rotation3::from_matrix_unchecked(turned).angle()
        }
        _ => 1.0,
    };
    1.0 / near.min(1.0).powi(2)
}

/// Poses and measures away from their singularities.
fn for_every_example(mut check: impl FnMut(&Measure, &FrameMotion, &FrameMotion, &mut Random)) {
    let mut count = [0; 7];
    for seed in 0..POSES {
        let mut random = Random::new(seed);
        random.number();
        let (a, b) = (random.frame(), random.frame());
        for (kind, measure) in examples(&mut random).iter().enumerate() {
            if sharpness(measure, &a, &b) < 10.0 {
                check(measure, &a, &b, &mut random);
                count[kind] += 1;
            }
        }
    }
    assert!(count.iter().all(|count| *count > 30), "{count:?}");
}

fn unit_six(index: usize) -> Six {
    Six::ith(index, 1.0)
}

#[test]
fn the_gradient_is_the_change_of_the_value() {
    let step = 1e-5;
    for_every_example(|measure, a, b, _| {
        let difference = |varied_a: &dyn Fn(f64) -> FrameMotion,
                          varied_b: &dyn Fn(f64) -> FrameMotion| {
            let at = |h: f64| measure.value(&varied_a(h), &varied_b(h));
            measure.deviation(at(step), at(-step)) / (2.0 * step)
        };
        let gradient = measure.gradient(a, b);
        for i in 0..6 {
            let with_a = difference(&|h| varied(a, &(h * unit_six(i))), &|_| *b);
            let with_b = difference(&|_| *a, &|h| varied(b, &(h * unit_six(i))));
            for (exact, found) in [(gradient.a[i], with_a), (gradient.b[i], with_b)] {
                assert!(
                    (exact - found).abs() < 3e-8,
                    "{measure:?} [{i}]: {exact} or {found}"
                );
            }
        }
    });
}

#[test]
fn the_gradient_derivative_is_the_change_of_the_gradient() {
    let step = 1e-5;
    for_every_example(|measure, a, b, _| {
        let columns = |with: &dyn Fn(&Six) -> Gradient| {
            let (mut of_a, mut of_b) = (Matrix6::zeros(), Matrix6::zeros());
            for i in 0..6 {
                let (plus, minus) = (with(&(step * unit_six(i))), with(&(-step * unit_six(i))));
                of_a.set_column(i, &((plus.a - minus.a) / (2.0 * step)));
                of_b.set_column(i, &((plus.b - minus.b) / (2.0 * step)));
            }
            (of_a, of_b)
        };
        let (aa, ba) = columns(&|h| measure.gradient(&varied(a, h), b));
        let (ab, bb) = columns(&|h| measure.gradient(a, &varied(b, h)));
        let exact = measure.gradient_derivative(a, b);
        for (name, exact, found) in [
            ("aa", exact.aa, aa),
            ("ab", exact.ab, ab),
            ("ba", exact.ba, ba),
            ("bb", exact.bb, bb),
        ] {
            let error = (exact - found).amax();
            assert!(error < 1e-6, "{measure:?} {name}: {error:e}");
        }
    });
}

/// `p(t) = p_0 + v t + ½ α t² + …`, `R(t) = exp(t w_1) exp(t² w_2) R_0`.
struct Path {
    start: FrameMotion,
    jerk: Vector3<f64>,
    w: [Vector3<f64>; 2],
}

impl Path {
    fn random(start: &FrameMotion, random: &mut Random) -> Self {
        Self {
            start: *start,
            jerk: random.vector(),
            w: [random.vector(), random.vector()],
        }
    }

    /// The spin is `w_1 + 2 t exp(t w_1) w_2`, because `exp(t² w_2)` turns about a fixed axis.
    fn at(&self, t: f64) -> FrameMotion {
        let [w_1, w_2] = self.w;
        let first = turn(&(t * w_1));
        let start = &self.start;
        FrameMotion {
            position: start.position
                + t * start.velocity
                + 0.5 * t * t * start.acceleration
                + t.powi(3) * self.jerk,
            velocity: start.velocity + t * start.acceleration + 3.0 * t * t * self.jerk,
            acceleration: start.acceleration + 6.0 * t * self.jerk,
            axes: first * turn(&(t * t * w_2)) * start.axes,
            spin: w_1 + 2.0 * t * first * w_2,
            spin_rate: 2.0 * first * w_2 + 2.0 * t * w_1.cross(&(first * w_2)),
        }
    }
}

#[test]
fn rates_are_the_time_derivatives_along_a_motion() {
    let step = 1e-4;
    for_every_example(|measure, a, b, random| {
        let (path_a, path_b) = (Path::random(a, random), Path::random(b, random));
        let value = |t: f64| measure.value(&path_a.at(t), &path_b.at(t));
        // At a time when the spin isn't constant to first order; the pose is close to the one checked for singularities.
        let t = 0.02;
        let (now_a, now_b) = (path_a.at(t), path_b.at(t));
        let middle = value(t);
        let (before, after) = (
            measure.deviation(value(t - step), middle),
            measure.deviation(value(t + step), middle),
        );
        let (rate, second) = (
            measure.rate(&now_a, &now_b),
            measure.second_rate(&now_a, &now_b),
        );
        let (rate_found, second_found) = (
            (after - before) / (2.0 * step),
            (after + before) / (step * step),
        );
        assert!(
            (rate - rate_found).abs() < 3e-5,
            "{measure:?}: e' = {rate} or {rate_found}"
        );
        // Second differences of the value round to 1e-16 / step²: differences of the rate are sharper.
        assert!(
            (second - second_found).abs() < 3e-3,
            "{measure:?}: e'' = {second} or {second_found}"
        );
        let rate_at = |t: f64| measure.rate(&path_a.at(t), &path_b.at(t));
        let by_rates = (rate_at(t + step) - rate_at(t - step)) / (2.0 * step);
        assert!(
            (second - by_rates).abs() < 3e-4 * (1.0 + second.abs()),
            "{measure:?}: e'' = {second} or {by_rates}"
        );
    });
}

/// e'' with accelerations zero is the quadratic form of the gradient's derivative over the velocities.
#[test]
fn velocity_terms_agree_with_the_gradient_derivative() {
    for_every_example(|measure, a, b, _| {
        let zero = Vector3::zeros();
        let coasting = |frame: &FrameMotion| FrameMotion {
            acceleration: zero,
            spin_rate: zero,
            ..*frame
        };
        let (a, b) = (coasting(a), coasting(b));
        let twist = |frame: &FrameMotion| {
            Six::from_iterator(frame.velocity.iter().chain(&frame.spin).copied())
        };
        let (v_a, v_b) = (twist(&a), twist(&b));
        let derivative = measure.gradient_derivative(&a, &b);
        let form = v_a.dot(&(derivative.aa * v_a + derivative.ab * v_b))
            + v_b.dot(&(derivative.ba * v_a + derivative.bb * v_b));
        let second = measure.second_rate(&a, &b);
        assert!(
            (second - form).abs() < 1e-12 * (1.0 + second.abs()),
            "{measure:?}: {second} or {form}"
        );
    });
}

#[test]
fn moving_both_frames_as_one_body_changes_nothing_and_the_forces_are_internal() {
    for_every_example(|measure, a, b, random| {
        let gradient = measure.gradient(a, b);
        let part = |six: &Six, start: usize| six.fixed_rows::<3>(start).into_owned();
        let force = part(&gradient.a, 0) + part(&gradient.b, 0);
        assert!(force.norm() < 1e-15, "{measure:?}: net force {force}");
        if let Measure::WorldDisplacement(_) = measure {
            return; // its direction belongs to the world
        }
        let about = random.vector();
        let moment = part(&gradient.a, 3)
            + part(&gradient.b, 3)
            + (a.position - about).cross(&part(&gradient.a, 0))
            + (b.position - about).cross(&part(&gradient.b, 0));
        assert!(moment.norm() < 1e-14, "{measure:?}: net moment {moment}");

        let (shift, rotation) = (random.vector(), random.axes());
        let moved = |frame: &FrameMotion| {
            FrameMotion::at_rest(rotation * frame.position + shift, rotation * frame.axes)
        };
        let (before, after) = (measure.value(a, b), measure.value(&moved(a), &moved(b)));
        assert!(
            measure.deviation(before, after).abs() < 1e-13,
            "{measure:?}: {before} or {after}"
        );
    });
}

#[test]
fn coinciding_points_feel_an_internal_force_along_a_world_direction() {
    let mut random = Random::new(5);
    let (a, mut b) = (random.frame(), random.frame());
    b.position = a.position;
    let measure = Measure::WorldDisplacement(WorldDisplacement {
        direction: random.unit(),
    });
    let gradient = measure.gradient(&a, &b);
    assert_eq!(gradient.a, -gradient.b);
    assert_eq!(gradient.a.fixed_rows::<3>(3).norm(), 0.0);
}

#[test]
fn values_are_the_lengths_and_angles_they_are_called() {
    let mut random = Random::new(11);
    let a = random.frame();
    let separation = Vector3::new(0.3, -0.4, 1.2);
    let axis = random.unit();
    let relative = turn(&(0.9 * axis.into_inner()));
    let b = FrameMotion::at_rest(a.position + a.axes * separation, a.axes * relative);
    let close = |measure: Measure, expected: f64| {
        let value = measure.value(&a, &b);
        assert!(
            (value - expected).abs() < 1e-14,
            "{measure:?}: {value}, not {expected}"
        );
    };
    let direction = random.unit();
    close(
        Measure::Displacement(Displacement { direction }),
        direction.dot(&separation),
    );
    close(Measure::Elongation(Elongation { length: 1.0 }), 1.3);
    // (1.69 - 1) / 2 by the definition, and 0.1 to first order at the near length.
    close(Measure::Distance(Distance { length: 1.0 }), 0.345);
    let near = Distance { length: 1.3 - 1e-7 };
    let excess = Measure::Distance(near).value(&a, &b);
    assert!((excess / 1e-7 - 1.0).abs() < 1e-7);
    for component in 0..3 {
        let direction = Unit::new_unchecked(Vector3::ith(component, 1.0));
        let rest = nalgebra::Matrix3::identity();
        close(
            Measure::Rotation(Rotation { direction, rest }),
            0.9 * axis[component],
        );
    }
    let first_a = Unit::new_normalize(axis.cross(direction.as_ref()));
    let second_a = Unit::new_normalize(axis.cross(first_a.as_ref()));
    let angle = Angle {
        first_a,
        second_a,
        first_b: first_a,
    };
    close(Measure::Angle(angle), 0.9);
    let cosine = Alignment {
        direction_a: first_a,
        direction_b: first_a,
    };
    close(Measure::Alignment(cosine), 0.9_f64.cos());
}

/// A hinge's angle grows by as much as the hinge turns, through a whole turn, and always about its axis.
#[test]
fn an_angle_goes_round() {
    let angle = Measure::Angle(Angle::in_plane());
    let a = FrameMotion::at_rest(Vector3::zeros(), turn(&Vector3::new(0.0, 0.0, 0.4)));
    for step in -40..=40 {
        let turned = 0.3 * f64::from(step);
        let b = FrameMotion::at_rest(
            Vector3::zeros(),
            turn(&Vector3::new(0.0, 0.0, 0.4 + turned)),
        );
        let deviation = angle.deviation(angle.value(&a, &b), turned);
        assert!(deviation.abs() < 1e-14, "{turned}: off by {deviation:e}");
        let gradient = angle.gradient(&a, &b);
        assert!((gradient.b - Six::new(0.0, 0.0, 0.0, 0.0, 0.0, 1.0)).norm() < 1e-15);
    }
}

/// The series of the small-angle terms and their closed forms, on both sides of where one takes over: κ and its slope
/// are smooth, so the gradient's derivative along a ray of rotations changes by what the step explains and no more.
#[test]
fn a_small_rotation_has_the_same_derivatives_as_a_larger_one() {
    let mut random = Random::new(21);
    let (axis, direction) = (random.unit(), random.unit());
    let rest = nalgebra::Matrix3::identity();
    let measure = Measure::Rotation(Rotation { direction, rest });
    let a = FrameMotion::at_rest(Vector3::zeros(), rest);
    let at = |angle: f64| {
        let b = FrameMotion::at_rest(Vector3::zeros(), turn(&(angle * axis.into_inner())));
        (
            measure.gradient(&a, &b).b,
            measure.gradient_derivative(&a, &b).bb,
        )
    };
    let switch = 0.1_f64.sqrt();
    let (below, above) = (at(switch - 1e-9), at(switch + 1e-9));
    assert!((below.0 - above.0).amax() < 1e-8);
    assert!((below.1 - above.1).amax() < 1e-8);
    // At rest the gradient is the direction itself; about rest, turned by half the rotation.
    let small = 1e-7;
    let (gradient, _) = at(small);
    let expected = direction.into_inner() + 0.5 * small * axis.cross(direction.as_ref());
    assert!((gradient.fixed_rows::<3>(3) - expected).norm() < 1e-14);
}

#[test]
fn a_spring_between_coinciding_points_pulls_nowhere() {
    let mut random = Random::new(3);
    let (a, mut b) = (random.frame(), random.frame());
    b.position = a.position + Vector3::new(1e-13, 0.0, 0.0);
    let measure = Measure::Elongation(Elongation { length: 0.1 });
    let gradient = measure.gradient(&a, &b);
    assert_eq!((gradient.a.norm(), gradient.b.norm()), (0.0, 0.0));
    assert_eq!(measure.second_rate(&a, &b), 0.0);
    assert_eq!(measure.gradient_derivative(&a, &b).bb.norm(), 0.0);
    b.position = a.position + Vector3::new(1e-9, 0.0, 0.0);
    let pulled = measure.gradient(&a, &b).b;
    assert!((pulled.x - 1.0).abs() < 1e-6, "a nanometre has a direction");
}
