//! The wrenches that a scene can exert on a part's interfaces, by the scene's text alone, against those that runs record.
//!
//! Each example moves far. What is recorded at the interface must lie in the space predicted, and fill it.

use dcb_demand::demand::{Demand, PartInterface, Parts};
use dcb_formats::Component;
use dcb_formats::mesh::Direction;
use dcb_reducer::{Reduction, reduce};
use dcb_runtime::kinematics::rotation_vector::right_jacobian_inverse;
use dcb_runtime::{Mechanism, Scene};
use nalgebra::{DMatrix, Matrix3, SVector, UnitQuaternion, Vector3};
use serde_json::{Value, json};
use tempfile::TempDir;

use super::parts::{scene_text, soft_beam, soft_rod, store};

const STEP: f64 = 2e-4;
const STEPS: u32 = 400;

/// A beam in space or a rod in the plane, 0.3 m from `a` to `b` along its x, whose frame at `b` is turned.
struct Part {
    place: TempDir,
    dimension: u32,
    interfaces: Vec<PartInterface>,
}

/// The component's axes to the world's.
fn turn(dimension: u32) -> UnitQuaternion<f64> {
    match dimension {
        2 => UnitQuaternion::from_scaled_axis(Vector3::z() * 0.4),
        _ => UnitQuaternion::from_scaled_axis(Vector3::new(0.5, -0.8, 0.3)),
    }
}

/// Axes of interface `b` to the component's.
fn turn_of_b(dimension: u32) -> UnitQuaternion<f64> {
    match dimension {
        2 => UnitQuaternion::identity(),
        _ => UnitQuaternion::from_scaled_axis(Vector3::new(-0.4, 0.9, 1.1)),
    }
}

fn end_of(dimension: u32) -> Vector3<f64> {
    turn(dimension) * Vector3::new(0.3, 0.0, 0.0)
}

impl Part {
    /// With all directions at `b`, or only these.
    fn with(dimension: u32, directions: Option<Vec<Direction>>) -> Self {
        let mut component = match dimension {
            2 => soft_rod(),
            _ => soft_beam(),
        }
        .into_draft();
        for interface in &mut component.interfaces {
            interface.directions = None;
            if interface.name == "b" {
                let axes = turn_of_b(dimension).to_rotation_matrix();
                let column = |axis: usize| axes.matrix().column(axis).into_owned().into();
                interface.axes = Some([column(0), column(1), column(2)]);
                interface.directions = directions.clone();
            }
        }
        let component = Component::checked(component).unwrap();
        let place = tempfile::tempdir().unwrap();
        store(&component, &place.path().join("part.dcb.h5"));
        let reduced = reduce(&component, &Reduction::lowest(3), &mut ()).unwrap();
        Self {
            place,
            dimension,
            interfaces: PartInterface::all_of(&reduced.superelement),
        }
    }

    fn of(dimension: u32) -> Self {
        Self::with(dimension, None)
    }

    fn scene(&self, text: &Value) -> Scene {
        let at = self.place.path().join("scene.json");
        Scene::parse(&text.to_string(), &at).unwrap()
    }

    fn body(&self) -> Value {
        let turn = turn(self.dimension);
        let orientation = match self.dimension {
            2 => json!(turn.angle()),
            _ => json!([turn.w, turn.i, turn.j, turn.k]),
        };
        json!({"superelement": "part.dcb.h5", "orientation": orientation, "damping": {"modal": 0.01}})
    }

    /// Runs a scene, and compares what its demand says of `b` with what is recorded there.
    fn assert_predicted(&self, what: &str, text: &Value, forces: usize, moments: usize) {
        self.assert_within(what, text, [forces, moments], |_| 1e-9);
    }

    /// `allowed` is the part outside by the largest turn of the interface.
    fn assert_within(
        &self,
        what: &str,
        text: &Value,
        [forces, moments]: [usize; 2],
        allowed: impl Fn(f64) -> f64,
    ) {
        let scene = self.scene(text);
        let parts = Parts::from_iter([("part".to_owned(), self.interfaces.clone())]);
        let demand = Demand::of(&scene, "part", &parts).unwrap();
        let at_b = demand
            .interfaces
            .iter()
            .find(|one| one.name == "b")
            .unwrap();
        let bases = [0, 3].map(|first| {
            let own = at_b.wrenches.iter();
            let own = own.map(|six| Vector3::from_column_slice(&six[first..first + 3]));
            let own: Vec<Vector3<f64>> = own.filter(|vector| vector.norm() > 0.0).collect();
            DMatrix::from_fn(3, own.len(), |row, column| own[column][row])
        });
        let counts = [bases[0].ncols(), bases[1].ncols()];
        assert_eq!(counts, [forces, moments], "{what}: {:?}", at_b.wrenches);

        let (recorded, largest_turn) = recorded(&scene, what);
        for (half, basis) in bases.iter().enumerate() {
            // A direction that the interface has no rows for doesn't load it.
            let known = self.interfaces[1].directions;
            let own: Vec<Vector3<f64>> = recorded.iter().map(|wrench| wrench[half]).collect();
            let own = own.iter().map(|vector| {
                Vector3::from_fn(|axis, _| {
                    if known[3 * half + axis] {
                        vector[axis]
                    } else {
                        0.0
                    }
                })
            });
            let own: Vec<Vector3<f64>> = own.collect();
            let largest = own.iter().map(Vector3::norm).fold(0.0, f64::max);
            let scale = match half {
                0 => largest,
                _ => largest.max(
                    1e-3 * recorded
                        .iter()
                        .map(|wrench| wrench[0].norm())
                        .fold(0.0, f64::max),
                ),
            };
            let outside = own.iter().map(|vector| {
                let inside = basis * (basis.transpose() * vector);
                (vector - inside).norm()
            });
            let outside = outside.fold(0.0, f64::max);
            assert!(
                outside <= allowed(largest_turn) * scale,
                "{what}: {outside:.2e} of {scale:.2e} is outside, half {half}"
            );
            if basis.ncols() == 0 {
                continue;
            }
            let inside = DMatrix::from_fn(basis.ncols(), own.len(), |row, column| {
                basis.column(row).dot(&own[column])
            });
            let values = inside.singular_values();
            assert!(
                values.min() > 1e-5 * values.max(),
                "{what}: half {half} isn't filled: {values:?}"
            );
        }
    }
}

/// Force and moment on interface `b` of the part in component axes, turned back with the interface; and its largest turn.
fn recorded(scene: &Scene, what: &str) -> (Vec<[Vector3<f64>; 2]>, f64) {
    let mut mechanism = Mechanism::start(scene).unwrap_or_else(|error| panic!("{what}: {error}"));
    let (mut all, mut largest_turn) = (Vec::new(), 0.0_f64);
    for _ in 0..STEPS {
        mechanism
            .step(STEP)
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        let wrench = mechanism.output("interface_forces/part/b").unwrap();
        let (force, moment) = match wrench {
            [x, y, z] => (Vector3::new(*x, *y, 0.0), Vector3::new(0.0, 0.0, *z)),
            all => (
                Vector3::from_column_slice(&all[..3]),
                Vector3::from_column_slice(&all[3..]),
            ),
        };
        let (system, state) = (
            mechanism.simulation().system(),
            mechanism.simulation().state(),
        );
        let index = system
            .bodies
            .iter()
            .position(|body| body.name == "part")
            .unwrap();
        let [marker] = system.markers_on(index, 1)[..] else {
            panic!("{what}: b has one marker")
        };
        let y = &state.coordinates[system.bodies[index].coordinates.clone()];
        let (_, theta) = system.markers[marker].displacement(y);
        largest_turn = largest_turn.max(theta.norm());
        // What is recorded is conjugate to θ, J_lᵀ τ with J_lᵀ(θ) = J_r(θ).
        let back: Matrix3<f64> = UnitQuaternion::new(-theta)
            .to_rotation_matrix()
            .into_inner();
        all.push([back * force, back * right_jacobian_inverse(&theta) * moment]);
    }
    (all, largest_turn)
}

fn in_scene(vector: &Vector3<f64>, dimension: u32) -> Value {
    json!(&vector.as_slice()[..dimension as usize])
}

/// The part clamped at `a`, and a block that a joint holds at `b`; the part is the joint's first or second body.
fn clamped(dimension: u32, bodies: Value, connections: Value) -> Value {
    let mut text = json!({
        "gravity": &[1.5, -9.81, -2.0][..dimension as usize],
        "joints": {"clamp": {"fixed": {"a": "ground", "b": "part/a"}}},
        "bodies": bodies,
        "loads": {}
    });
    for (list, entries) in connections.as_object().unwrap() {
        if text.get(list).is_none() {
            text[list] = json!({});
        }
        for (name, entry) in entries.as_object().unwrap() {
            text[list][name] = entry.clone();
        }
    }
    scene_text(dimension, text)
}

/// A block whose place `pin` is at a point of the world; its axes are the world's.
fn block(dimension: u32, pin: &Vector3<f64>) -> Value {
    let own = Vector3::new(-0.05, 0.01, if dimension == 2 { 0.0 } else { 0.02 });
    let inertia = match dimension {
        2 => json!(3e-4),
        _ => json!([[2e-4, 3e-5, 0], [3e-5, 3e-4, -2e-5], [0, -2e-5, 4e-4]]),
    };
    let tip = Vector3::new(0.06, 0.03, if dimension == 2 { 0.0 } else { -0.02 });
    json!({
        "rigid": {"mass": 0.2, "inertia": inertia, "points": {"pin": in_scene(&own, dimension), "tip": in_scene(&tip, dimension)}},
        "position": in_scene(&(pin - own), dimension)
    })
}

/// What moves the block: forces that turn it, of different frequencies.
fn pushes(dimension: u32) -> Value {
    let components = [
        json!({"formula": "30*sin(60*t)^2"}),
        json!({"formula": "-40*sin(50*t)"}),
        json!({"polynomial": [5, 200]}),
    ];
    json!({"force": {"at": "block/tip", "components": &components[..dimension as usize]}})
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum First {
    Part,
    Block,
}

/// A joint of this kind: its axis and the gap between its places in axes of the first one, and further keys.
fn joined(
    part: &Part,
    kind: &str,
    first: First,
    axis: Option<Vector3<f64>>,
    gap: Vector3<f64>,
    more: Value,
) -> Value {
    let d = part.dimension;
    // Axes of both places to the world's; the block's are the world's.
    let of_part = turn(d) * turn_of_b(d);
    let (of_first, sign) = match first {
        First::Part => (of_part, 1.0),
        First::Block => (UnitQuaternion::identity(), -1.0),
    };
    let pin = end_of(d) + of_first * gap * sign;
    let (a, b) = match first {
        First::Part => ("part/b", "block/pin"),
        First::Block => ("block/pin", "part/b"),
    };
    let mut keys = json!({"a": a, "b": b});
    if let Some(axis) = axis {
        keys["axis"] = in_scene(&axis, d);
        if kind == "universal" {
            // Perpendicular to the first axis, in the axes of the other place.
            let first_axis = of_first * axis;
            let across = first_axis.cross(&Vector3::new(0.3, -0.5, 0.7)).normalize();
            let other = match first {
                First::Part => across,
                First::Block => of_part.inverse() * across,
            };
            keys["axis_b"] = in_scene(&other, d);
        }
    }
    let mut connections = json!({"joints": {"joint": {kind: keys}}, "loads": {"push": pushes(d)}});
    for (list, entries) in more.as_object().unwrap() {
        if connections.get(list).is_none() {
            connections[list] = json!({});
        }
        for (name, entry) in entries.as_object().unwrap() {
            connections[list][name] = entry.clone();
        }
    }
    let mut bodies = json!({"part": part.body(), "block": block(d, &pin)});
    if let Some(wheel) = more.get("bodies").and_then(|bodies| bodies.get("wheel")) {
        bodies["wheel"] = wheel.clone();
        connections.as_object_mut().unwrap().remove("bodies");
    }
    clamped(d, bodies, connections)
}

#[test]
fn joints_transmit_what_they_hold() {
    let none = Vector3::zeros();
    let axis = Vector3::new(1.0, 2.0, 2.0);
    let along = axis * 0.01;
    let across = Vector3::new(0.02, -0.01, 0.0);
    let oblique = Vector3::new(0.06, 0.02, -0.03);
    // Forces and moments on a, and on b.
    let spatial = [
        ("fixed", None, none, [3, 3], [3, 3]),
        ("revolute", Some(axis), none, [3, 2], [3, 2]),
        ("prismatic", Some(axis), along, [2, 3], [2, 3]),
        ("cylindrical", Some(axis), along, [2, 2], [2, 2]),
        ("universal", Some(axis), none, [3, 2], [3, 2]),
        ("spherical", None, none, [3, 0], [3, 0]),
        ("planar", Some(axis), across, [1, 2], [1, 2]),
        ("point_on_line", Some(axis), along, [2, 2], [3, 0]),
        ("distance", None, oblique, [3, 0], [3, 0]),
    ];
    let part = Part::of(3);
    for (kind, axis, gap, on_a, on_b) in spatial {
        for (first, [forces, moments]) in [(First::Part, on_a), (First::Block, on_b)] {
            // The plane's offset is along its normal, which has none here.
            let gap = match axis {
                Some(axis) if kind == "planar" => {
                    gap - axis * (axis.dot(&gap) / axis.norm_squared())
                }
                _ => gap,
            };
            let text = joined(&part, kind, first, axis, gap, json!({}));
            let what = format!("{kind}, first is the {first:?}");
            part.assert_predicted(&what, &text, forces, moments);
        }
    }
    let flat = Vector3::new(2.0, 1.0, 0.0);
    let planar = [
        ("fixed", None, none, [2, 1], [2, 1]),
        ("revolute", None, none, [2, 0], [2, 0]),
        ("prismatic", Some(flat), flat * 0.02, [1, 1], [1, 1]),
        ("point_on_line", Some(flat), flat * 0.02, [1, 1], [2, 0]),
        (
            "distance",
            None,
            Vector3::new(0.06, 0.02, 0.0),
            [2, 0],
            [2, 0],
        ),
    ];
    let part = Part::of(2);
    for (kind, axis, gap, on_a, on_b) in planar {
        for (first, [forces, moments]) in [(First::Part, on_a), (First::Block, on_b)] {
            let text = joined(&part, kind, first, axis, gap, json!({}));
            let what = format!("{kind} in the plane, first is the {first:?}");
            part.assert_predicted(&what, &text, forces, moments);
        }
    }
}

#[test]
fn drives_gears_and_springs_add_the_axis_of_their_joint() {
    let axis = Vector3::new(1.0, 2.0, 2.0);
    let none = Vector3::zeros();
    let turning =
        json!({"drives": {"motor": {"angle": {"joint": "joint", "formula": "0.5*sin(40*t)^2"}}}});
    let pushing = json!({"drives": {"motor": {"position": {"joint": "joint", "formula": "0.02*sin(40*t)^2"}}}});
    let both = json!({"drives": {
        "motor": {"angle": {"joint": "joint", "formula": "0.5*sin(40*t)^2"}},
        "screw": {"position": {"joint": "joint", "formula": "0.02*sin(40*t)^2"}}
    }});
    let spring =
        json!({"springs": {"coil": {"torsion_spring": {"joint": "joint", "stiffness": 2}}}});
    let actuated = json!({"actuators": {
        "motor": {"torque": {"joint": "joint", "formula": "0.02*sin(40*t)^2"}}
    }});
    let pressed = json!({"actuators": {
        "cylinder": {"force": {"joint": "joint", "formula": "0.5*sin(40*t)^2"}}
    }});
    let wheel = |coupling: Value| {
        json!({
            "bodies": {"wheel": {
                "rigid": {"mass": 0.1, "inertia": [1e-4, 1e-4, 1e-4], "center_of_mass": [0.01, 0.02, 0], "points": {"axle": [0, 0, 0]}},
                "position": [0.5, 0.1, 0]
            }},
            "ground": {"points": {"axle": [0.5, 0.1, 0]}},
            "joints": {"wheel": {"revolute": {"a": "ground/axle", "b": "wheel/axle", "axis": [0, 0, 1]}}, "coupling": coupling}
        })
    };
    let gear = wheel(json!({"gear": {"first": "wheel", "second": "joint", "ratio": -1.7}}));
    let rack =
        wheel(json!({"rack": {"rotation": "wheel", "translation": "joint", "radius": 0.08}}));
    let cases = [
        ("revolute", &turning, [3, 3]),
        ("revolute", &spring, [3, 3]),
        ("revolute", &actuated, [3, 3]),
        ("cylindrical", &actuated, [2, 3]),
        ("cylindrical", &pressed, [3, 2]),
        ("prismatic", &pressed, [3, 3]),
        ("revolute", &gear, [3, 3]),
        ("cylindrical", &turning, [2, 3]),
        ("cylindrical", &pushing, [3, 2]),
        ("cylindrical", &both, [3, 3]),
        ("prismatic", &pushing, [3, 3]),
        ("prismatic", &rack, [3, 3]),
        ("cylindrical", &rack, [3, 2]),
    ];
    let part = Part::of(3);
    for (kind, more, [forces, moments]) in cases {
        for first in [First::Part, First::Block] {
            let text = joined(&part, kind, first, Some(axis), none, more.clone());
            let what = format!("{kind} with {more}, first is the {first:?}");
            part.assert_predicted(&what, &text, forces, moments);
        }
    }
    let part = Part::of(2);
    for first in [First::Part, First::Block] {
        let text = joined(&part, "revolute", first, None, none, turning.clone());
        part.assert_predicted("revolute in the plane, driven", &text, 2, 1);
        let axis = Some(Vector3::new(2.0, 1.0, 0.0));
        let text = joined(&part, "prismatic", first, axis, none, pushing.clone());
        part.assert_predicted("prismatic in the plane, driven", &text, 2, 1);
    }
}

#[test]
fn springs_pull_along_their_line_and_bushings_along_their_directions() {
    // Keys of the bushing; forces and moments on a, and on b.
    let all = json!({"translation": [900, 700, 800], "rotation": [2, 1, 3]});
    let one = json!({"translation": [900, 0, 0], "translation_damping": [0.5, 0, 0]});
    let two = json!({"translation": [900, 800, 0]});
    let turns = json!({"rotation": [2, 0, 0], "rotation_damping": [1e-3, 0, 0]});
    let cases = [
        (all, [3, 3], [3, 3]),
        (one, [1, 2], [3, 0]),
        (two, [2, 3], [3, 0]),
        (turns, [0, 3], [0, 3]),
    ];
    let part = Part::of(3);
    let gap = Vector3::new(0.02, 0.03, -0.01);
    for (keys, on_a, on_b) in cases {
        for (first, [forces, moments]) in [(First::Part, on_a), (First::Block, on_b)] {
            let mut text = joined(&part, "fixed", first, None, gap, json!({}));
            let mut bushing = text["joints"]["joint"]["fixed"].clone();
            for (key, value) in keys.as_object().unwrap() {
                bushing[key] = value.clone();
            }
            text["joints"].as_object_mut().unwrap().remove("joint");
            text["springs"] = json!({"mount": {"bushing": bushing}});
            // The block's turn about its own mount is what makes directions turn.
            text["bodies"]["block"]["angular_velocity"] = json!([9, -7, 8]);
            let what = format!("bushing {keys}, first is the {first:?}");
            part.assert_predicted(&what, &text, forces, moments);
        }
    }
    for first in [First::Part, First::Block] {
        let mut text = joined(&part, "fixed", first, None, gap, json!({}));
        let mut spring = text["joints"]["joint"]["fixed"].clone();
        spring["stiffness"] = json!(500);
        text["joints"].as_object_mut().unwrap().remove("joint");
        text["springs"] = json!({"coil": {"spring": spring}});
        part.assert_predicted("spring", &text, 3, 0);
    }
}

#[test]
fn moments_on_body_frames_and_directions_without_rows_load_no_interface() {
    let axis = Vector3::new(1.0, 2.0, 2.0);
    let part = Part::with(3, Some(vec![Direction::Ux, Direction::Uy, Direction::Uz]));
    for (kind, forces) in [
        ("fixed", 3),
        ("revolute", 3),
        ("prismatic", 2),
        ("cylindrical", 2),
    ] {
        let axis = (kind != "fixed").then_some(axis);
        let mut text = joined(&part, kind, First::Part, axis, Vector3::zeros(), json!({}));
        text["joints"]["joint"][kind]["orientation"] = json!("body");
        part.assert_predicted(&format!("{kind} on the body"), &text, forces, 0);
    }
    let line = Vector3::zeros();
    let text = joined(
        &part,
        "point_on_line",
        First::Part,
        Some(axis),
        line,
        json!({}),
    );
    part.assert_predicted("point on line without rotation rows", &text, 2, 0);
}

#[test]
fn loads_act_along_directions_that_stay_in_the_body() {
    let part = Part::of(3);
    let varying = json!([{"formula": "8*sin(60*t)"}, 0, {"formula": "3*t"}]);
    let hinged = |loads: Value| {
        let joint = json!({"revolute": {"a": "ground", "b": "part/a", "axis": [0.2, 0.5, 1]}});
        let mut text = clamped(3, json!({"part": part.body()}), json!({"loads": loads}));
        text["joints"] = json!({"hinge": joint});
        text["bodies"]["part"]["angular_velocity"] = json!([2, 5, 10]);
        text
    };
    let force = |axes: &str, components: &Value| json!({"push": {"force": {"at": "part/b", "axes": axes, "components": components}}});
    let follower = hinged(force("follower", &varying));
    part.assert_predicted("follower force", &follower, 2, 0);
    let constant = hinged(force("follower", &json!([3, 4, 0])));
    part.assert_predicted("constant follower force", &constant, 1, 0);
    let torque = json!({"twist": {"torque": {"at": "part/b", "axes": "follower", "components": [0, {"polynomial": [0, 3]}, 0]}}});
    part.assert_predicted("follower torque", &hinged(torque), 0, 1);
    let world = hinged(force("world", &varying));
    part.assert_predicted("force on a body that turns", &world, 3, 0);

    // Of a body that keeps its orientation the interface turns by the deflection alone.
    let clamp = clamped(
        3,
        json!({"part": part.body()}),
        json!({"loads": force("world", &varying)}),
    );
    part.assert_within("force on a clamped body", &clamp, [2, 0], |turn| turn);
}

#[test]
fn an_axis_seen_from_an_interface_that_is_not_known_may_be_any() {
    let part = Part::of(3);
    let text = clamped(
        3,
        json!({"part": part.body(), "other": part.body()}),
        json!({"joints": {"slide": {"cylindrical": {"a": "other/b", "b": "part/b", "axis": [0, 0, 1]}}}}),
    );
    let scene = part.scene(&text);
    let known = |names: &[&str]| -> Parts {
        let one = |name: &&str| ((*name).to_owned(), part.interfaces.clone());
        names.iter().map(one).collect()
    };
    let wrenches = |parts: &Parts| {
        let demand = Demand::of(&scene, "part", parts).unwrap();
        let at_b = demand.interfaces.iter().find(|one| one.name == "b");
        at_b.unwrap().wrenches.clone()
    };
    assert_eq!(wrenches(&known(&["part"])).len(), 6);
    let found = wrenches(&known(&["part", "other"]));
    assert_eq!(found.len(), 4);
    // Both are drawn alike, so that the axis is z of the frame in either.
    let axis = turn_of_b(3) * Vector3::z();
    for wrench in &found {
        let wrench = SVector::<f64, 6>::from(*wrench);
        let along = wrench.fixed_rows::<3>(0).dot(&axis) + wrench.fixed_rows::<3>(3).dot(&axis);
        assert!(along.abs() < 1e-12);
    }
}
