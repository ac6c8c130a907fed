//! Mechanisms of which A, B, C and D can be written down.

use dcb_runtime::OperatingPoint;
use serde_json::json;

use super::support::{about, at_start, close, pendulum, place, response};
use crate::scenes::parts::{Folder, rigid_scene, scene_text};

const GRAVITY: f64 = 9.81;
/// About the pivot: 0.1 + 2 · 0.5².
const INERTIA: f64 = 0.6;

#[test]
fn a_mass_on_a_spring_with_a_damper() {
    let (m, k, c) = (2.0, 800.0, 3.0);
    let system = at_start(&scene_text(
        2,
        json!({
            "bodies": {"block": {"rigid": {"mass": m, "inertia": 1, "points": {"pin": [0, 0]}}, "position": [1, 0]}},
            "joints": {"guide": {"prismatic": {"a": "ground", "b": "block/pin", "axis": [1, 0]}}},
            "springs": {"spring": {"spring": {"a": "ground", "b": "block/pin", "stiffness": k, "damping": c}}},
            "loads": {"push": {"force": {"at": "block/pin", "components": [{"input": {"initial": 0}}, 0]}}},
            "outputs": {
                "place": {"position": {"at": "block/pin"}}, "acceleration": {"acceleration": {"at": "block/pin"}},
                "force": {"spring_force": {"spring": "spring"}}
            }
        }),
    ));
    let expected = [[0.0, 1.0], [-k / m, -c / m]];
    for (i, row) in expected.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            close(system.a[(i, j)], *entry, k / m, 1e-12);
        }
    }
    close(system.b[(0, 0)], 0.0, 1.0, 1e-14);
    close(system.b[(1, 0)], 1.0 / m, 1.0, 1e-13);
    // The spring pulls it back.
    for (name, row, by_force) in [
        ("place.x", [1.0, 0.0], 0.0),
        ("place.y", [0.0, 0.0], 0.0),
        ("acceleration.x", [-k / m, -c / m], 1.0 / m),
        ("force", [-k, -c], 0.0),
    ] {
        let i = place(&system.outputs, name);
        for (j, entry) in row.iter().enumerate() {
            close(system.c[(i, j)], *entry, k, 1e-10);
        }
        close(system.d[(i, 0)], by_force, 1.0, 1e-12);
    }
    let names = |of: &[dcb_formats::linear_system::Variable]| -> Vec<String> {
        of.iter()
            .map(|one| format!("{} [{}]", one.name, one.unit))
            .collect()
    };
    assert_eq!(
        names(&system.states),
        ["block/x [m]", "rate of block/x [m/s]"]
    );
    assert_eq!(names(&system.inputs), ["push [N]"]);
    assert!(names(&system.outputs).contains(&"force [N]".to_owned()));
    assert_eq!(system.outputs[place(&system.outputs, "place.x")].at, 1.0);
    assert!(system.is_equilibrium);
    let pole = system.poles[0];
    close(pole.growth, -c / (2.0 * m), 1.0, 1e-10);
    close(pole.magnitude(), f64::sqrt(k / m), 20.0, 1e-12);
    close(pole.damping_ratio(), c / (2.0 * (k * m).sqrt()), 1.0, 1e-12);
    assert!(pole.is_stable() && !pole.is_unstable());
}

/// J φ'' = M - m g l sin φ, about hanging and about standing; the tip, 1 m from the pivot, has the acceleration φ'' across.
#[test]
fn a_pendulum_about_both_equilibria_in_any_units() {
    for (length, mass) in [(1.0, 1.0), (1000.0, 1e-3)] {
        for (angle, sign) in [(0.0, -1.0), (std::f64::consts::PI, 1.0)] {
            let system = at_start(&pendulum(angle, length, mass));
            let slope = sign * 2.0 * GRAVITY * 0.5 / INERTIA;
            let by_torque = 1.0 / (INERTIA * mass * length * length);
            assert_eq!(system.order(), 2);
            close(system.a[(1, 0)] * system.a[(0, 1)], slope, 20.0, 1e-11);
            // Angle by torque, whatever coordinate the angle is measured by.
            for omega in [0.0, 1.0, 30.0] {
                let (real, imaginary) = response(&system, omega);
                let expected = by_torque / (-omega * omega - slope);
                close(real[(0, 0)], expected, expected.abs(), 1e-10);
                close(imaginary[(0, 0)], 0.0, expected.abs(), 1e-10);
                // The tip moves to the right for a turn to the left, hanging; standing it is turned around.
                let across = place(&system.outputs, "tip.x");
                let expected = -omega * omega * expected * length * -sign;
                close(real[(across, 0)], expected, by_torque * length, 1e-9);
            }
            let unstable = system
                .poles
                .iter()
                .filter(|pole| pole.is_unstable())
                .count();
            assert_eq!(unstable, usize::from(sign > 0.0));
            close(system.poles[1].magnitude(), slope.abs().sqrt(), 4.0, 1e-10);
            let pull = place(&system.outputs, "pull.fy");
            close(
                system.outputs[pull].at,
                -2.0 * GRAVITY * mass * length,
                20.0 * mass * length,
                1e-10,
            );
        }
    }
}

/// J φ'' + m g l φ = τ + P (φ_target - φ) - D φ', in m and kg and in mm and t; by the target it moves as by the torque P.
#[test]
fn a_pendulum_under_a_motor_and_a_servo() {
    let (proportional, derivative) = (7.0, 0.4);
    for (length, mass) in [(1.0, 1.0), (1000.0, 1e-3)] {
        let unit = mass * length * length;
        let mut scene = pendulum(0.0, length, mass);
        scene["actuators"] = json!({
            "spindle": {"torque": {"joint": "pivot", "input": {"initial": 0}}},
            "hold": {"servo": {"joint": "pivot", "target": {"input": {"initial": 0}}, "proportional": proportional * unit, "derivative": derivative * unit}}
        });
        scene["outputs"]["effort"] = json!({"actuator_effort": {"actuator": "hold"}});
        let system = at_start(&scene);
        let [motor, hold] = ["spindle", "hold"].map(|name| place(&system.inputs, name));
        assert_eq!(system.inputs[hold].unit, "rad");
        let stiffness = 2.0 * GRAVITY * 0.5 + proportional;
        for omega in [0.0, 1.0, 4.0, 30.0] {
            // 1/(a + i b)
            let (a, b) = (stiffness - INERTIA * omega * omega, derivative * omega);
            let square = a * a + b * b;
            let expected = [a / square, -b / square];
            let size = square.sqrt().recip();
            let (real, imaginary) = response(&system, omega);
            let angle = place(&system.outputs, "angle");
            for (found, expected) in [real[(angle, motor)], imaginary[(angle, motor)]]
                .iter()
                .zip(expected)
            {
                close(found * unit, expected, size, 1e-10);
            }
            for (found, expected) in [real[(angle, hold)], imaginary[(angle, hold)]]
                .iter()
                .zip(expected)
            {
                close(*found, proportional * expected, size, 1e-9);
            }
            // P - (P + i ω D) φ by the target.
            let effort = place(&system.outputs, "effort");
            let [re, im] = expected.map(|part| part * proportional);
            let by_target = [
                proportional - proportional * re + omega * derivative * im,
                -proportional * im - omega * derivative * re,
            ];
            for (found, expected) in [real[(effort, hold)], imaginary[(effort, hold)]]
                .iter()
                .zip(by_target)
            {
                close(found / unit, expected, proportional, 1e-8);
            }
        }
    }
}

/// A cart with its drive as an input carries a pendulum: J φ'' + m g l φ = -m l a cos φ; the effort is what both need.
#[test]
fn a_driven_cart_under_a_pendulum() {
    let (m, l, cart) = (2.0, 0.5, 5.0);
    let text = scene_text(
        2,
        json!({
            "gravity": [0, -GRAVITY],
            "bodies": {
                "cart": {"rigid": {"mass": cart, "inertia": 1, "points": {"pin": [0, 0]}}},
                "bob": {"rigid": {"mass": m, "inertia": 0.1, "points": {"pivot": [0, l]}}, "position": [0, -l]}
            },
            "joints": {
                "rail": {"prismatic": {"a": "ground", "b": "cart/pin", "axis": [1, 0]}},
                "pivot": {"revolute": {"a": "cart/pin", "b": "bob/pivot"}}
            },
            "drives": {"carriage": {"position": {"joint": "rail", "input": {"initial": 0}}}},
            "outputs": {
                "place": {"joint_coordinate": {"joint": "rail"}}, "angle": {"joint_coordinate": {"joint": "pivot"}},
                "effort": {"drive_effort": {"drive": "carriage"}}, "acceleration": {"acceleration": {"at": "cart/pin"}}
            }
        }),
    );
    let system = at_start(&text);
    assert_eq!(system.order(), 4);
    assert_eq!(system.inputs[0].unit, "m/s^2");
    assert_eq!(system.states[1].name, "drives/carriage");
    assert_eq!(
        system
            .poles
            .iter()
            .filter(|pole| pole.magnitude() == 0.0)
            .count(),
        2
    );
    for omega in [0.5_f64, 3.0, 40.0] {
        let (real, _) = response(&system, omega);
        let square = omega * omega;
        let real = |name: &str| real[(place(&system.outputs, name), 0)];
        close(real("place"), -1.0 / square, 1.0 / square, 1e-9);
        let angle = -m * l / (m * GRAVITY * l - INERTIA * square);
        close(real("angle"), angle, angle.abs(), 1e-9);
        // (cart + m) a + m l φ''
        let effort = cart + m - m * l * square * angle;
        close(real("effort"), effort, effort.abs(), 1e-9);
        close(real("acceleration.x"), 1.0, 1.0, 1e-9);
    }
}

/// A disc on a soft bending support, spinning: A w' - i C Ω w + k ∫w = τ for w = ω_x + i ω_y. The disc sees its whirls turn by Ω less.
#[test]
fn a_spinning_rotor_whirls() {
    let (a, c, k, spin) = (0.02_f64, 0.03_f64, 50.0_f64, 200.0_f64);
    let text = scene_text(
        3,
        json!({
            "bodies": {"disc": {"rigid": {"mass": 1, "inertia": [a, a, c], "points": {"hub": [0, 0, 0]}}, "angular_velocity": [0, 0, spin]}},
            "joints": {"hub": {"spherical": {"a": "ground", "b": "disc/hub"}}},
            "springs": {"support": {"bushing": {"a": "ground", "b": "disc/hub", "translation": [0, 0, 0], "rotation": [k, k, 0],
                "translation_damping": [0, 0, 0], "rotation_damping": [0, 0, 0]}}},
            "loads": {"tilt": {"torque": {"at": "disc/hub", "axes": "follower", "components": [{"input": {"initial": 0}}, {"input": {"initial": 0}}, 0]}}},
            "outputs": {"turn": {"angular_velocity": {"at": "disc/hub"}}}
        }),
    );
    let system = at_start(&text);
    assert_eq!(system.order(), 6);
    assert!(!system.is_equilibrium);
    let root = (c * spin * c * spin + 4.0 * a * k).sqrt();
    for whirl in [(c * spin + root) / (2.0 * a), (c * spin - root) / (2.0 * a)] {
        let seen = (whirl - spin).abs();
        let nearest = (system.poles.iter())
            .map(|pole| (pole.angular_frequency - seen).abs() + pole.growth.abs())
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-8 * seen, "{seen}: {nearest:e}");
    }
    // A torque about the disc's own x turns it so: C (s - A)⁻¹ B behaves as 1 / (a s) for large s.
    let product = &system.c * &system.b;
    close(product[(0, 0)], 1.0 / a, 1.0 / a, 1e-10);
    close(product[(1, 0)], 0.0, 1.0 / a, 1e-10);
}

/// A cantilever pushed at its tip gives way by l³/3EI at rest, and resonates where beam theory says.
#[test]
fn a_cantilever_gives_way_and_rings_as_a_beam() {
    let folder = Folder::with_parts();
    let scene = folder.scene(&scene_text(
        3,
        json!({
            "bodies": {"beam": {"superelement": "beam.dcb.h5", "damping": {"rayleigh": [0, 1e-5]}}},
            "joints": {"clamp": {"fixed": {"a": "ground", "b": "beam/a"}}},
            "loads": {"push": {"force": {"at": "beam/b", "components": [0, 0, {"input": {"initial": 0}}]}}},
            "outputs": {"tip": {"displacement": {"at": "beam/b"}}}
        }),
    ));
    let system = about(
        &scene,
        OperatingPoint::Initial,
        &[],
        &["tip", "reactions/clamp"],
    );
    let (real, _) = response(&system, 0.0);
    let section = dcb_samples::spatial_beam::BeamSection::rectangle(0.03, 0.02);
    let (z, moment) = (place(&system.outputs, "tip.z"), section.second_moment_y);
    let bending = 0.3_f64.powi(3) / (3.0 * 2e7 * moment);
    // Shear gives way by a little besides.
    assert!(
        (real[(z, 0)] / bending - 1.0).abs() < 0.01,
        "{} {bending}",
        real[(z, 0)]
    );
    // The clamp holds the force and its moment about it, on the ground, which is the first body.
    let held = place(&system.outputs, "reactions/clamp.fz");
    close(real[(held, 0)], 1.0, 1.0, 1e-8);
    close(real[(held + 2, 0)], -0.3, 1.0, 1e-8);
    let mass_by_length = 1000.0 * section.area;
    let first = 1.875_104_068_7_f64.powi(2) * (2e7 * moment / mass_by_length).sqrt() / 0.09;
    let nearest = (system.poles.iter())
        .map(|pole| (pole.angular_frequency / first - 1.0).abs())
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 0.01, "{nearest}");
}

/// A follower force at the tip of a standing pendulum: it turns along and does no stiffening, one in the world pushes it over.
#[test]
fn a_follower_force_turns_along() {
    for (axes, stiffness) in [("world", -30.0), ("follower", 0.0)] {
        let text = scene_text(
            2,
            json!({
                "bodies": {"bar": {"rigid": {"mass": 2, "inertia": 0.1, "points": {"pivot": [-0.5, 0], "tip": [0.5, 0]}}, "position": [0.5, 0]}},
                "joints": {"pivot": {"revolute": {"a": "ground", "b": "bar/pivot"}}},
                "springs": {"hold": {"torsion_spring": {"joint": "pivot", "stiffness": 40}}},
                "loads": {"thrust": {"force": {"at": "bar/tip", "axes": axes, "components": [-30, 0]}}},
                "outputs": {"angle": {"joint_coordinate": {"joint": "pivot"}}, "tip": {"position": {"at": "bar/tip"}}}
            }),
        );
        let scene = rigid_scene(&text);
        let system = about(
            &scene,
            OperatingPoint::Initial,
            &["thrust/0", "thrust/1"],
            &[],
        );
        assert_eq!(system.inputs[0].at, -30.0);
        assert_eq!(system.inputs[1].name, "thrust/1");
        let (real, _) = response(&system, 0.0);
        // One newton across at 1 m; along the bar nothing.
        close(real[(0, 1)], 1.0 / (40.0 + stiffness), 0.1, 1e-9);
        close(real[(0, 0)], 0.0, 0.1, 1e-12);
    }
}
