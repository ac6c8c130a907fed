//! Point masses: pendulums, springs, and what they can't be asked.

use std::path::Path;

use dcb_formats::output::Replace;
use dcb_runtime::model::Model;
use dcb_runtime::run::{Profiling, Target, run};
use dcb_runtime::{Mechanism, Scene};
use serde_json::{Value, json};

use super::parts::{Folder, rigid_scene, scene_text, started};

const G: f64 = 9.81;

/// Angles of a double pendulum of two masses on massless rods, against the vertical: θ1, θ2, θ1', θ2'.
fn double_pendulum(mut x: [f64; 4], [m1, m2]: [f64; 2], [l1, l2]: [f64; 2], end: f64) -> [f64; 4] {
    let slope = |[a, b, u, v]: [f64; 4]| {
        let (s, c) = (a - b).sin_cos();
        let mass = m1 + m2 * s * s;
        let first = (-m2 * l1 * u * u * s * c + m2 * G * b.sin() * c
            - m2 * l2 * v * v * s
            - (m1 + m2) * G * a.sin())
            / (l1 * mass);
        let second = (m2 * l2 * v * v * s * c
            + (m1 + m2) * (G * a.sin() * c + l1 * u * u * s - G * b.sin()))
            / (l2 * mass);
        [u, v, first, second]
    };
    let steps = 20_000;
    let h = end / f64::from(steps);
    let along = |x: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| x[i] + h * k[i]);
    for _ in 0..steps {
        let a = slope(x);
        let b = slope(along(x, a, h / 2.0));
        let c = slope(along(x, b, h / 2.0));
        let d = slope(along(x, c, h));
        x = std::array::from_fn(|i| x[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    x
}

fn chain(dimension: usize) -> Value {
    let cut = |v: [f64; 3]| json!(&v[..dimension]);
    let inertia = if dimension == 2 {
        json!(0)
    } else {
        json!([0, 0, 0])
    };

    scene_text(
        dimension as u32,
        json!({
            "gravity": cut([0.0, -G, 0.0]),
            "bodies": {
                "one": {"rigid": {"mass": 1.0, "inertia": inertia, "points": {"p": cut([0.0; 3])}}, "position": cut([0.5, 0.0, 0.0])},
                "two": {"rigid": {"mass": 0.4, "inertia": inertia, "center_of_mass": cut([0.1, 0.2, 0.0]), "points": {"p": cut([0.1, 0.2, 0.0])}},
                    "position": cut([0.4, -0.5, 0.0])}
            },
            "joints": {
                "first": {"distance": {"a": "ground", "b": "one/p"}},
                "second": {"distance": {"a": "one/p", "b": "two/p"}}
            },
            "outputs": {"one": {"position": {"at": "one/p"}}, "two": {"position": {"at": "two/p"}}, "h": {"angular_momentum": {}}, "energy": "energy"},
            "integrator": {"generalized_alpha": {"step": 5e-4, "end": 1, "rho_infinity": 0.9}}
        }),
    )
}

#[test]
fn a_double_pendulum_of_point_masses_follows_its_equations() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let [a, b, u, v] = double_pendulum([quarter, 0.0, 0.0, 0.0], [1.0, 0.4], [0.5, 0.3], 1.0);
    let (x1, y1) = (0.5 * a.sin(), -0.5 * a.cos());
    let (x2, y2) = (x1 + 0.3 * b.sin(), y1 - 0.3 * b.cos());
    let (vx1, vy1) = (0.5 * u * a.cos(), 0.5 * u * a.sin());
    let (vx2, vy2) = (vx1 + 0.3 * v * b.cos(), vy1 + 0.3 * v * b.sin());
    let spin = x1 * vy1 - y1 * vx1 + 0.4 * (x2 * vy2 - y2 * vx2);
    for dimension in [2, 3] {
        let mut mechanism = started(&chain(dimension));
        for _ in 0..2000 {
            mechanism.step(5e-4).unwrap();
        }
        for (name, expected) in [("one", [x1, y1]), ("two", [x2, y2])] {
            let found = mechanism.output(name).unwrap();
            for axis in 0..2 {
                let error = (found[axis] - expected[axis]).abs();
                assert!(error < 2e-5, "{dimension} {name}: {found:?}, {expected:?}");
            }
        }
        let found = *mechanism.output("h").unwrap().last().unwrap();
        assert!((found - spin).abs() < 1e-4, "{dimension}: {found} {spin}");
        let balance = mechanism.output("energy").unwrap();
        assert!(balance[7].abs() < 1e-4, "{dimension}: {balance:?}");
        // Nothing turned.
        let state = mechanism.simulation().state();
        assert!(state.orientations.iter().all(|turn| turn.angle() == 0.0));
        assert!((3..6).all(|k| state.velocities[k] == 0.0));
    }
}

#[test]
fn a_mass_on_a_spring_has_its_frequency() {
    for dimension in [2_usize, 3] {
        let inertia = if dimension == 2 {
            json!(0)
        } else {
            json!([0, 0, 0])
        };
        let cut = |v: [f64; 3]| json!(&v[..dimension]);
        let mut text = scene_text(
            dimension as u32,
            json!({
                "ground": {"points": {"hook": cut([-0.2, 0.0, 0.0])}},
                "bodies": {"mass": {"rigid": {"mass": 0.25, "inertia": inertia, "points": {"p": cut([0.0; 3])}}}},
                "joints": {"line": {"point_on_line": {"a": "ground", "b": "mass/p", "axis": cut([1.0, 0.0, 0.0])}}},
                "springs": {"spring": {"spring": {"a": "ground/hook", "b": "mass/p", "stiffness": 400}}}
            }),
        );
        text["analysis"] = json!({"modes": {"count": 1}});
        text.as_object_mut().unwrap().remove("integrator");
        let folder = tempfile::tempdir().unwrap();
        let scene = rigid_scene(&text);
        let results = folder.path().join("results.h5");
        let target = Target {
            path: results.clone(),
            replace: Replace::Refuse,
            fields_in: None,
            kept: Vec::new(),
            options: json!({}),
            profiling: Profiling::Off,
        };
        run(&scene, Model::load(&scene).unwrap(), &target, &mut ()).unwrap();
        let found = dcb_formats::results::Results::open(&results).unwrap();
        let modes = found.modes().unwrap().unwrap();
        let expected = (400.0_f64 / 0.25).sqrt() / std::f64::consts::TAU;
        assert_eq!(modes.frequency.len(), 1);
        assert!((modes.frequency[0] / expected - 1.0).abs() < 1e-12);
    }
}

/// A mass at the tip of a flexible beam is that of a body with hardly any inertia.
#[test]
fn a_point_mass_at_a_tip_is_a_small_body() {
    let folder = Folder::with_parts();
    let tip = |inertia: f64, joint: &str| {
        let text = scene_text(
            3,
            json!({
                "gravity": [0, 0, -G],
                "bodies": {
                    "beam": {"superelement": "beam.dcb.h5"},
                    "tip": {"rigid": {"mass": 0.05, "inertia": [inertia, inertia, inertia], "points": {"p": [0, 0, 0]}}, "position": [0.3, 0, 0]}
                },
                "joints": {
                    "clamp": {"fixed": {"a": "ground", "b": "beam/a"}},
                    "held": {joint: {"a": "beam/b", "b": "tip/p"}}
                },
                "outputs": {"tip": {"position": {"at": "tip/p"}}, "pull": {"reaction": {"joint": "held"}}}
            }),
        );
        let mut mechanism = Mechanism::start(&folder.scene(&text)).unwrap();
        for _ in 0..200 {
            mechanism.step(1e-3).unwrap();
        }
        let mut found = mechanism.output("tip").unwrap().to_vec();
        found.extend_from_slice(mechanism.output("pull").unwrap());
        found
    };
    let (point, body) = (tip(0.0, "spherical"), tip(1e-9, "fixed"));
    assert!(point[2] < -5e-3, "{point:?}");
    for axis in 0..3 {
        assert!(
            (point[axis] - body[axis]).abs() < 1e-6,
            "{point:?} {body:?}"
        );
        assert!(
            (point[3 + axis] - body[3 + axis]).abs() < 1e-2,
            "{point:?} {body:?}"
        );
        assert_eq!(point[6 + axis], 0.0);
    }
}

#[test]
fn what_would_need_a_rotation_is_refused() {
    let refused = |dimension: usize, change: &dyn Fn(&mut Value)| {
        let mut text = chain(dimension);
        change(&mut text);
        match Scene::parse(&text.to_string(), Path::new("scene.json")) {
            Ok(_) => panic!("taken: {text}"),
            Err(error) => error.to_string(),
        }
    };
    let on = |pointer: &'static str, value: Value| {
        move |text: &mut Value| {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            text.pointer_mut(parent).unwrap()[key] = value.clone();
        }
    };
    let ends = |kind: &str, rest: Value| {
        let mut joint = json!({"a": "ground", "b": "one/p"});
        joint
            .as_object_mut()
            .unwrap()
            .extend(rest.as_object().unwrap().clone());
        json!({kind: joint})
    };
    let space: [(&'static str, Value, [&str; 2]); 12] = [
        (
            "/joints/first",
            ends("fixed", json!({})),
            ["joints.first.fixed.b", "use spherical"],
        ),
        (
            "/joints/first",
            ends("revolute", json!({"axis": [0, 0, 1]})),
            ["revolute.b", "no rotation for a revolute joint"],
        ),
        (
            "/joints/first",
            ends("prismatic", json!({"axis": [0, 0, 1]})),
            ["prismatic.b", "use point_on_line"],
        ),
        (
            "/joints/first",
            ends("universal", json!({"axis": [0, 0, 1], "axis_b": [1, 0, 0]})),
            ["universal.b", "use spherical"],
        ),
        (
            "/joints/second",
            json!({"point_on_line": {"a": "one/p", "b": "two/p", "axis": [1, 0, 0]}}),
            ["point_on_line.a", "make the point mass `b`"],
        ),
        (
            "/bodies/one/angular_velocity",
            json!([0, 0, 1]),
            ["bodies.one.angular_velocity", "doesn't turn"],
        ),
        (
            "/bodies/one/rigid/points/q",
            json!([0, 0.1, 0]),
            ["points.q", "0.1 away from the centre of mass"],
        ),
        (
            "/loads/t",
            json!({"torque": {"at": "one/p", "components": [0, 0, 1]}}),
            ["loads.t.torque.at", "a torque"],
        ),
        (
            "/springs/b",
            json!({"bushing": {"a": "ground", "b": "one/p", "rotation": [1, 1, 1]}}),
            ["bushing.b", "rotational part"],
        ),
        (
            "/outputs/o",
            json!({"orientation": {"at": "one/p"}}),
            ["outputs.o.orientation.at", "point mass"],
        ),
        (
            "/outputs/o",
            json!({"body_angular_velocity": {"body": "one"}}),
            ["body_angular_velocity.body", "point mass"],
        ),
        (
            "/bodies/one/rigid/inertia",
            json!([1, 1, 0]),
            ["principal moment 0", "[0, 0, 0] for a point mass"],
        ),
    ];
    for (pointer, value, wanted) in space {
        let said = refused(3, &|text| {
            for list in ["loads", "springs"] {
                text[list] = json!({});
            }
            on(pointer, value.clone())(text);
        });
        for part in wanted {
            assert!(said.contains(part), "{pointer}: {said}");
        }
    }
    let pinned = |key: &'static str, value: Value| {
        refused(2, &|text| {
            text["joints"]["first"] = json!({"revolute": {"a": "ground", "b": "one/p"}});
            text[key]["x"] = value.clone();
        })
    };
    for (key, value) in [
        (
            "drives",
            json!({"angle": {"joint": "first", "constant": 0}}),
        ),
        (
            "drives",
            json!({"speed": {"joint": "first", "constant": 0}}),
        ),
        (
            "springs",
            json!({"torsion_spring": {"joint": "first", "stiffness": 1}}),
        ),
        (
            "actuators",
            json!({"torque": {"joint": "first", "constant": 1}}),
        ),
        ("outputs", json!({"joint_coordinate": {"joint": "first"}})),
    ] {
        let said = pinned(key, value);
        assert!(
            said.contains("the angle of a revolute joint"),
            "{key}: {said}"
        );
    }
    let said = refused(2, &on("/bodies/one/rigid/inertia", json!(-1)));
    assert!(said.contains("or 0 for a point mass"), "{said}");
}
