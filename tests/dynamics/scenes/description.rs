//! Scenes: what is read is what was written, and what can't be meant is refused with its place.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::Function;
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::*;
use nalgebra::{Matrix3, Vector3};
use serde_json::{Value, json};

const PAGE: &str = include_str!("../../../docs/scene.md");

/// The examples of the page: planar, spatial.
fn documented() -> [&'static str; 2] {
    let mut blocks = PAGE
        .split("```json\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap());
    [blocks.next().unwrap(), blocks.next().unwrap()]
}

fn parse(text: &str) -> Result<Scene, Error> {
    Scene::parse(text, Path::new("machines/scene.json"))
}

fn value(example: usize) -> Value {
    serde_json::from_str(documented()[example]).unwrap()
}

/// The complaint about an example in which the value at a JSON pointer was replaced; a missing last key is added.
fn refusal(example: usize, pointer: &str, replacement: Value) -> String {
    let mut scene = value(example);
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = scene.pointer_mut(parent).unwrap();
    match parent {
        Value::Object(map) => {
            map.insert(key.replace("~1", "/"), replacement);
        }
        other => other[key.parse::<usize>().unwrap()] = replacement,
    }
    match parse(&scene.to_string()) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("{pointer} was accepted"),
    }
}

#[test]
fn the_slider_crank_is_read_as_written() {
    let scene = parse(documented()[0]).unwrap();
    assert_eq!(scene.dimension, Dimension::Planar);
    assert_eq!(scene.units.mass, "kg");
    assert_eq!(scene.gravity_in_space(), Vector3::zeros());
    let names: Vec<_> = scene.bodies.keys().collect();
    assert_eq!(names, ["crank", "rod", "slider"]);
    let names: Vec<_> = scene.joints.keys().collect();
    assert_eq!(names, ["axle", "wrist", "pin", "guide"]);
    let BodyKind::Superelement(rod) = &scene.bodies["rod"].kind else {
        panic!("the rod is flexible")
    };
    assert_eq!(rod.inertia_change, InertiaChange::SecondOrder);
    assert_eq!(
        scene.resolve(&rod.file),
        Path::new("machines").join("rod.dcb.h5")
    );
    let placement = scene.bodies["rod"].placement();
    assert_eq!(placement.position, Vector3::new(0.15, 0.0, 0.0));
    assert_eq!(placement.velocity, Vector3::new(0.0, 22.5, 0.0));
    assert_eq!(placement.angular_velocity, Vector3::new(0.0, 0.0, -75.0));
    let BodyKind::Rigid(crank) = &scene.bodies["crank"].kind else {
        panic!("the crank is rigid")
    };
    assert_eq!(crank.inertia.matrix()[(2, 2)], 1e-4);
    assert_eq!(crank.points["pin"].position(), Vector3::new(0.15, 0.0, 0.0));
    assert_eq!(
        scene.joints["guide"].attachments(),
        Some(["ground", "slider/pin"])
    );
    let Drive::Angle(motor) = &scene.drives["motor"] else {
        panic!("the motor drives an angle")
    };
    assert_eq!(motor.joint, "axle");
    assert_eq!(motor.function, Function::Polynomial(vec![0.0, 150.0]));
    assert_eq!(
        scene.outputs["midpoint_deflection"],
        Output::ChordDeflection(ChordDeflection {
            body: "rod".into(),
            node: 2,
            between: ["a".into(), "b".into()]
        })
    );
    let integrator = scene.integrator.unwrap();
    let usual = Integrator::generalized_alpha(1.16e-5, 0.0838);
    assert_eq!(integrator, usual);
    assert_eq!(scene.analysis, Analysis::Transient);
    assert_eq!(scene.compatibility, Compatibility::Strong);
}

#[test]
fn a_program_can_write_the_same_scene_as_a_file() {
    for text in documented() {
        let scene = parse(text).unwrap();
        let written = serde_json::to_string(&scene).unwrap();
        assert_eq!(parse(&written).unwrap(), scene);
    }
    let mut scene = Scene::new(Dimension::Spatial);
    scene.bodies.insert(
        "top".into(),
        Body::at_origin(BodyKind::Rigid(RigidBody {
            mass: 2.0,
            inertia: RotaryInertia::Principal([1.0, 1.0, 1.5]),
            center_of_mass: None,
            points: Named::from([("tip".into(), Point::Coordinates(vec![0.0, 0.0, -1.0]))]),
        })),
    );
    scene.joints.insert(
        "pivot".into(),
        Joint::Spherical(PointJoint {
            a: "ground".into(),
            b: "top/tip".into(),
        }),
    );
    scene.integrator = Some(Integrator::generalized_alpha(1e-3, 1.0));
    scene.check().unwrap();
    scene.bodies["top"].position = Some(vec![0.0, f64::NAN, 0.0]);
    let message = scene.check().unwrap_err().to_string();
    assert!(
        message.starts_with("bodies.top.position[1]: is NaN"),
        "{message}"
    );
}

#[test]
fn an_orientation_turns_component_axes_into_world_axes() {
    let (sin, cos) = 0.3_f64.sin_cos();
    let turned = Orientation::Angle(0.3).rotation() * Vector3::x();
    assert!((turned - Vector3::new(cos, sin, 0.0)).amax() < 1e-15);
    // A quarter turn about y, as the page writes it to seven digits: x goes to -z; the result is a rotation to rounding.
    let scene = parse(documented()[1]).unwrap();
    let rotation = scene.ground.points["bearing"].rotation();
    assert!((rotation * Vector3::x() + Vector3::z()).amax() < 1e-7);
    let matrix = rotation.to_rotation_matrix().into_inner();
    assert!((matrix.transpose() * matrix - Matrix3::identity()).amax() < 1e-15);
}

#[test]
fn matter_can_have_the_inertia_of_any_box_and_no_other() {
    // A rod on an axis has one vanishing principal moment; a plate fulfils large = small + middle with equality.
    let with = |inertia: Value| {
        let mut scene = value(1);
        scene["bodies"]["hub"]["rigid"]["inertia"] = inertia;
        parse(&scene.to_string())
    };
    for [a, b, c] in [[1.0, 1.0, 1.0], [1.0, 1e-3, 0.0], [2.0, 0.3, 1e-5]] {
        let moments = [b * b + c * c, a * a + c * c, a * a + b * b];
        assert!(with(json!(moments)).is_ok(), "{moments:?}");
        let axes = Orientation::Quaternion([0.5, -0.5, 0.1, 0.7_f64]).rotation();
        let turned = axes.to_rotation_matrix()
            * Matrix3::from_diagonal(&moments.into())
            * axes.inverse().to_rotation_matrix();
        let rows: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| turned[(i, j)]));
        assert!(with(json!(rows)).is_ok(), "{rows:?}");
    }
    for (bad, said) in [
        (json!([1, 1, 2.1]), "which no matter has"),
        (json!([1, 1, -1]), "has the principal moment -1"),
        (
            json!([[1, 0.1, 0], [0.2, 1, 0], [0, 0, 1]]),
            "is not symmetric",
        ),
        (
            json!([[1, 2, 0], [2, 1, 0], [0, 0, 1]]),
            "has the principal moment -1",
        ),
        (json!(1), "is a number, but the scene is spatial"),
        (json!([1, 1]), "three principal moments or a symmetric"),
    ] {
        let message = with(bad).unwrap_err().to_string();
        assert!(message.contains(said), "{message}");
    }
}

#[test]
fn what_the_planar_scene_can_not_mean_is_refused_at_its_place() {
    let cases = [
        (
            "/gravity",
            json!([0, 0, -9.81]),
            "gravity: has 3 components, expected 2",
        ),
        (
            "/bodies/rod/position",
            json!([0.15]),
            "bodies.rod.position: has 1 components",
        ),
        (
            "/bodies/rod/orientation",
            json!([1, 0, 0, 0]),
            "bodies.rod.orientation: is a quaternion, but the scene is planar",
        ),
        (
            "/bodies/rod/angular_velocity",
            json!([0, 0, 1]),
            "bodies.rod.angular_velocity: has three components",
        ),
        (
            "/bodies/rod/damping",
            json!({"modal": -0.1}),
            "bodies.rod.damping.modal: is -0.1",
        ),
        (
            "/bodies/crank/rigid/mass",
            json!(-1),
            "bodies.crank.rigid.mass: is -1",
        ),
        (
            "/bodies/crank/rigid/mass",
            json!(0),
            "bodies.crank.rigid.mass: is 0",
        ),
        (
            "/bodies/crank/rigid/inertia",
            json!(-1),
            "bodies.crank.rigid.inertia: is -1",
        ),
        (
            "/bodies/crank/rigid/points/pin",
            json!([0.15, 0, 0]),
            "bodies.crank.rigid.points.pin: has 3",
        ),
        (
            "/bodies/ground",
            json!({"superelement": "x"}),
            "bodies.ground: is the name",
        ),
        ("/bodies/a~1b", json!({"superelement": "x"}), "is no name"),
        (
            "/joints/axle/revolute/axis",
            json!([0, 1]),
            "joints.axle.revolute.axis: a revolute joint of a planar scene",
        ),
        (
            "/joints/axle/revolute/b",
            json!("crank/axel"),
            "no point of body \"crank\" is called \"axel\"; did you mean `axle`?",
        ),
        (
            "/joints/axle/revolute/b",
            json!("crnk/axle"),
            "no body is called \"crnk\"; did you mean `crank`?",
        ),
        (
            "/joints/axle/revolute/b",
            json!("crank"),
            "\"crank\" names a body, but a place on it is needed",
        ),
        (
            "/joints/axle/revolute/a",
            json!("crank/pin"),
            "joints.axle.revolute.b: \"crank/axle\" is on \"crank\" like",
        ),
        (
            "/joints/axle/revolute/a",
            json!("ground/x"),
            "no point of the ground is called \"x\" (there is none)",
        ),
        (
            "/joints/guide/prismatic/axis",
            json!([0, 0]),
            "joints.guide.prismatic.axis: has length zero",
        ),
        (
            "/joints/guide/prismatic/axis",
            Value::Null,
            "joints.guide.prismatic.axis: is missing",
        ),
        (
            "/joints/guide",
            json!({"spherical": {"a": "ground", "b": "slider/pin"}}),
            "use revolute",
        ),
        (
            "/joints/gear",
            json!({"gear": {"first": "axle", "second": "guide", "ratio": 2}}),
            "joint \"guide\" is prismatic, which has no angle",
        ),
        (
            "/joints/gear",
            json!({"gear": {"first": "axle", "second": "wrist", "ratio": 0}}),
            "joints.gear.gear.ratio: is zero",
        ),
        (
            "/joints/rack",
            json!({"rack": {"rotation": "axle", "translation": "wrist", "radius": 1}}),
            "has no translation",
        ),
        (
            "/joints/link",
            json!({"distance": {"a": "crank/pin", "b": "slider/pin", "length": 0}}),
            "joints.link.distance.length: is 0",
        ),
        (
            "/drives/motor/angle/joint",
            json!("axel"),
            "no joint is called \"axel\"; did you mean `axle`?",
        ),
        (
            "/drives/motor/angle/joint",
            json!("guide"),
            "drives.motor.angle.joint: joint \"guide\" is prismatic",
        ),
        (
            "/drives/motor/angle/polynomial",
            json!([]),
            "drives.motor.angle.polynomial: is an empty list",
        ),
        (
            "/drives/second",
            json!({"speed": {"joint": "axle", "constant": 1}}),
            "drives.second.speed.joint: joint \"axle\" is driven by \"motor\"",
        ),
        (
            "/drives/second",
            json!({"position": {"joint": "guide", "formula": "sqrt(t)"}}),
            "at t = 0; all must be finite",
        ),
        (
            "/drives/second",
            json!({"speed": {"joint": "guide", "input": {}}}),
            "drives.second.speed.input: can't be integrated",
        ),
        (
            "/loads",
            json!({"push": {"force": {"at": "slider/pin", "components": [1]}}}),
            "loads.push.force.components: has 1 functions, expected 2",
        ),
        (
            "/loads",
            json!({"push": {"force": {"at": "ground", "components": [1, 1]}}}),
            "loads.push.force.at: is on the ground",
        ),
        (
            "/loads",
            json!({"push": {"torque": {"at": "slider/pin", "components": [{"formula": "2x"}]}}}),
            "loads.push.torque.components[0].formula: \"2x\", position 2",
        ),
        (
            "/springs",
            json!({"s": {"spring": {"a": "ground", "b": "slider/pin", "stiffness": -1}}}),
            "springs.s.spring.stiffness: is -1",
        ),
        (
            "/springs",
            json!({"s": {"spring": {"a": "ground", "b": "slider/pin", "stiffness": [[0, 0], [0, 1]]}}}),
            "springs.s.spring.stiffness[1]: starts with 0, not after 0",
        ),
        (
            "/springs",
            json!({"s": {"bushing": {"a": "ground", "b": "slider/pin", "rotation": [1, 1, 1]}}}),
            "springs.s.bushing.rotation: has 3 entries, expected 1",
        ),
        (
            "/outputs/x",
            json!({"modal": {"body": "crank"}}),
            "outputs.x.modal.body: body \"crank\" is rigid",
        ),
        (
            "/outputs/x",
            json!({"reaction": {"joint": "axl"}}),
            "outputs.x.reaction.joint: no joint is called",
        ),
        (
            "/outputs/x",
            json!({"drive_effort": {"drive": "motro"}}),
            "did you mean `motor`?",
        ),
        (
            "/outputs/x",
            json!({"spring_force": {"spring": "s"}}),
            "no spring is called \"s\" (there is none)",
        ),
        ("/record", json!({"every": 0}), "record.every: is 0"),
        (
            "/fields",
            json!([{"body": "rod", "times": [1, 1], "directory": "f"}]),
            "fields[0].times[1]: is 1",
        ),
        (
            "/fields",
            json!([{"body": "rod", "directory": "f"}]),
            "fields[0]: needs exactly one of",
        ),
        (
            "/initial",
            json!({"hold": ["rodd"]}),
            "initial.hold[0]: no body is called",
        ),
        (
            "/analysis",
            json!({"modes": {"count": 0}}),
            "analysis.modes.count: is 0",
        ),
        ("/integrator", Value::Null, "integrator: is missing"),
        (
            "/integrator/generalized_alpha/step",
            json!(0),
            "integrator.generalized_alpha.step: is 0",
        ),
        (
            "/integrator/generalized_alpha/end",
            json!(-1),
            "integrator.generalized_alpha.end: is -1",
        ),
        (
            "/integrator/generalized_alpha/rho_infinity",
            json!(0.95),
            "weakly unstable",
        ),
        (
            "/integrator/generalized_alpha/rho_infinity",
            json!(1.1),
            "expected a number from 0 to 1",
        ),
        (
            "/integrator",
            json!({"hht": {"step": 1, "end": 1, "alpha": -0.5}}),
            "integrator.hht.alpha: is -0.5",
        ),
        (
            "/integrator",
            json!({"hht": {"step": 1, "end": 1, "alpha": 0}}),
            "use at most -0.053",
        ),
        (
            "/integrator",
            json!({"hht": {"step": 1, "end": 1, "adaptive": {"tolerance": 1e-3, "minimum_step": 2, "maximum_step": 3}}}),
            "allows steps from 2 to 3, but the first is 1",
        ),
    ];
    for (pointer, replacement, said) in cases {
        let message = refusal(0, pointer, replacement);
        assert!(
            message.starts_with("machines/scene.json:") && message.contains(said),
            "{pointer}: {message}"
        );
    }
}

#[test]
fn what_the_spatial_scene_can_not_mean_is_refused_at_its_place() {
    for (pointer, replacement, said) in [
        (
            "/bodies/hub/orientation",
            json!(0.5),
            "is an angle, but the scene is spatial",
        ),
        (
            "/bodies/hub/orientation",
            json!([1, 0.1, 0, 0]),
            "expected a unit quaternion",
        ),
        (
            "/bodies/hub/angular_velocity",
            json!(1),
            "is a number, but the scene is spatial",
        ),
        (
            "/joints/shaft/revolute/axis",
            json!([1, 0]),
            "joints.shaft.revolute.axis: has 2 components, expected 3",
        ),
        (
            "/joints/shaft/revolute/axis_b",
            json!([0, 0, 0]),
            "joints.shaft.revolute.axis_b: has length zero",
        ),
        (
            "/joints/shaft",
            json!({"universal": {"a": "ground", "b": "hub/shaft", "axis": [1, 0, 0]}}),
            "missing field `axis_b`",
        ),
        (
            "/drives/motor/speed/table/times",
            json!([0, 4, 4]),
            "drives.motor.speed.table.times[2]: is 4",
        ),
        (
            "/loads/gust/force/components/2",
            json!({"formula": "1/t"}),
            "loads.gust.force.components[2]: is inf at t = 0",
        ),
    ] {
        let message = refusal(1, pointer, replacement);
        assert!(message.contains(said), "{pointer}: {message}");
    }
    // With velocities stabilised too, any damping will do.
    let mut scene = value(1);
    scene["integrator"] = json!({"generalized_alpha":
        {"step": 1e-3, "end": 1, "rho_infinity": 1, "formulation": "stabilized-index-2"}});
    parse(&scene.to_string()).unwrap();
}

#[test]
fn errors_of_the_text_have_line_and_column() {
    let planar = documented()[0];
    for (from, to, said) in [
        (
            "\"joints\"",
            "\"jonts\"",
            "unknown field `jonts`; did you mean `joints`?",
        ),
        (
            "{\"revolute\": {\"a\": \"ground\"",
            "{\"revolut\": {\"a\": \"ground\"",
            "unknown value `revolut`; did you mean `revolute`?",
        ),
        (
            "\"polynomial\"",
            "\"polinomial\"",
            "unknown field `polinomial`; did you mean `polynomial`?",
        ),
        (
            "\"polynomial\": [0, 150]",
            "\"polynomial\": [0, 150], \"constant\": 1",
            "`constant` is the second",
        ),
        (
            ", \"polynomial\": [0, 150]",
            "",
            "missing field `polynomial`; add for example",
        ),
        (
            "\"dimension\": 2",
            "\"dimension\": 4",
            "expected 2 (planar) or 3 (spatial)",
        ),
        ("\"wrist\":", "\"axle\":", "the name \"axle\" stands twice"),
        (
            "\"gravity\": [0, 0]",
            "\"gravity\": [0, NaN]",
            "`NaN` is not a number JSON can hold",
        ),
        (
            "\"gravity\": [0, 0]",
            "\"gravity\": [0, 1e999]",
            "number out of range",
        ),
        (
            "{\"rigid\": {\"mass\": 0.1",
            "{\"superelement\": \"x\", \"rigid\": {\"mass\": 0.1",
            "found both",
        ),
        ("\"superelement\": \"rod.dcb.h5\", ", "", "found none"),
        (
            "\"orientation\": 0}",
            "\"orientation\": 0, \"damping\": {\"modal\": 1}}",
            "a rigid body has no `damping`",
        ),
        (
            "\"orientation\": 0}",
            "\"orientation\": \"north\"}",
            "expected an angle in rad",
        ),
        (
            "{\"a\": \"ground\", \"b\": \"crank/axle\"}",
            "[\"ground\", \"crank/axle\"]",
            "expected an object",
        ),
    ] {
        assert!(planar.contains(from), "{from}");
        let text = planar.replacen(from, to, 1);
        let message = parse(&text).unwrap_err().to_string();
        assert!(
            message.contains(said) && message.contains("column "),
            "{from}: {message}"
        );
        let line = message
            .strip_prefix("machines/scene.json:")
            .and_then(|rest| rest.split(':').next())
            .and_then(|line| line.parse::<usize>().ok());
        assert!(
            line.is_some_and(|line| line >= 1 && line <= text.lines().count()),
            "{message}"
        );
    }
    let misspelt = planar.replacen("\"wrist\": {\"revolute\"", "\"wrist\": {\"revolut\"", 1);
    let wrong = misspelt
        .lines()
        .position(|line| line.contains("\"revolut\""))
        .unwrap()
        + 1;
    let message = parse(&misspelt).unwrap_err().to_string();
    assert!(
        message.starts_with(&format!("machines/scene.json:{wrong}: column ")),
        "{message}"
    );
}

#[test]
fn a_file_is_read_whole_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.json");
    std::fs::write(&path, format!("\u{feff}{}", documented()[0])).unwrap();
    let scene = Scene::read(&path).unwrap();
    assert_eq!(scene.directory, folder.path());
    let message = |path: &Path| Scene::read(path).unwrap_err().to_string();
    std::fs::write(&path, [0x89, 0xff, 0x00]).unwrap();
    assert!(message(&path).contains("is not UTF-8"));
    std::fs::write(&path, "[".repeat(100_000)).unwrap();
    assert!(message(&path).contains("expected an object"));
    let nested = format!("{{\"dimension\": {}", "[".repeat(100_000));
    std::fs::write(&path, nested).unwrap();
    assert!(message(&path).contains("column "));
    std::fs::write(&path, "").unwrap();
    assert!(message(&path).contains("is empty; expected a scene"));
    assert!(message(folder.path()).contains("cannot read"));
    assert!(message(&folder.path().join("none.json")).contains("cannot read"));
}

#[test]
fn the_published_schema_is_the_one_of_the_code() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/scene.schema.json");
    let published: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    assert!(
        published == scene_schema(),
        "run: cargo run --release -p dcb-runtime --example scene_schema > docs/scene.schema.json"
    );
}

#[test]
fn the_page_names_every_key_of_the_schema() {
    fn names(schema: &Value, found: &mut Vec<String>) {
        match schema {
            Value::Object(map) => {
                if let Some(Value::Object(properties)) = map.get("properties") {
                    found.extend(properties.keys().cloned());
                }
                if let Some(Value::Array(values)) = map.get("enum") {
                    found.extend(values.iter().filter_map(Value::as_str).map(str::to_owned));
                }
                found.extend(map.get("const").and_then(Value::as_str).map(str::to_owned));
                map.values().for_each(|value| names(value, found));
            }
            Value::Array(list) => list.iter().for_each(|value| names(value, found)),
            _ => {}
        }
    }
    let mut found = Vec::new();
    names(&scene_schema(), &mut found);
    assert!(found.len() > 100);
    for name in found {
        let named = [format!("`{name}`"), format!("\"{name}\"")];
        assert!(named.iter().any(|text| PAGE.contains(text)), "{name}");
    }
}
