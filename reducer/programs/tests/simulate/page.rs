//! Pages of runs: what a browser would draw is where the results say that the bodies are.

use std::fs;
use std::io::Read as _;

use base64::Engine as _;
use flate2::read::ZlibDecoder;
use serde_json::{Value, json};

use crate::support::Folder;

/// Description and arrays of a page, as its script reads them.
struct Page {
    html: String,
    description: Value,
    bytes: Vec<u8>,
}

impl Page {
    fn read(folder: &Folder, name: &str) -> Self {
        let html = folder.read(name);
        let inside = |start: &str| {
            let from = html.find(start).unwrap() + start.len();
            let to = from + html[from..].find("</script>").unwrap();
            html[from..to].to_owned()
        };
        let description = inside("<script type=\"application/json\" id=\"description\">");
        let arrays = inside("<script type=\"text/plain\" id=\"arrays\">");
        let stream = base64::engine::general_purpose::STANDARD.decode(arrays);
        let mut bytes = Vec::new();
        ZlibDecoder::new(&stream.unwrap()[..])
            .read_to_end(&mut bytes)
            .unwrap();
        Self {
            description: serde_json::from_str(&description).unwrap(),
            html,
            bytes,
        }
    }

    fn numbers(&self, array: &Value) -> Vec<f64> {
        let [offset, length] =
            ["offset", "length"].map(|key| array[key].as_u64().unwrap() as usize);
        let four = |k: usize| -> [u8; 4] {
            let at = offset + 4 * k;
            self.bytes[at..at + 4].try_into().unwrap()
        };
        let two = |k: usize| -> [u8; 2] {
            let at = offset + 2 * k;
            self.bytes[at..at + 2].try_into().unwrap()
        };
        (0..length)
            .map(|k| match array["type"].as_str().unwrap() {
                "f32" => f64::from(f32::from_le_bytes(four(k))),
                "u32" => f64::from(u32::from_le_bytes(four(k))),
                "i16" => f64::from(i16::from_le_bytes(two(k))),
                other => panic!("{other}"),
            })
            .collect()
    }

    fn body(&self, name: &str) -> &Value {
        let bodies = self.description["bodies"].as_array().unwrap();
        bodies.iter().find(|body| body["name"] == name).unwrap()
    }

    /// Place of a mesh node in the world at a frame, and the largest elastic displacement along an axis, planar.
    fn node(&self, body: &Value, node: usize, frame: usize) -> ([f64; 2], f64) {
        let shape = &self.description["shapes"][body["shape"].as_u64().unwrap() as usize];
        let nodes = self.numbers(&shape["nodes"]);
        let index = nodes
            .iter()
            .position(|known| *known == node as f64)
            .unwrap();
        let positions = self.numbers(&shape["positions"]);
        let columns = shape["columns"].as_array().unwrap();
        let amplitudes = self.numbers(&body["amplitudes"]);
        let mut u = [0.0; 2];
        for (k, column) in columns.iter().enumerate() {
            let values = self.numbers(&column["values"]);
            let scale = column["scale"].as_f64().unwrap() * amplitudes[frame * columns.len() + k];
            for axis in 0..2 {
                u[axis] += scale * values[3 * index + axis];
            }
        }
        let f = &self.numbers(&body["frames"])[7 * frame..7 * frame + 7];
        let angle = 2.0 * f[6].atan2(f[3]);
        let x = [0, 1].map(|axis| positions[3 * index + axis] + u[axis]);
        let world = [
            f[0] + angle.cos() * x[0] - angle.sin() * x[1],
            f[1] + angle.sin() * x[0] + angle.cos() * x[1],
        ];
        (world, u[0].abs().max(u[1].abs()))
    }
}

/// The slider-crank with the place of the rod's middle node recorded.
fn recorded(compatibility: &str) -> Folder {
    let folder = Folder::slider_crank();
    let mut scene = folder.json("scene.json");
    scene["outputs"]["middle"] = json!({"node_position": {"body": "rod", "node": 2}});
    scene["compatibility"] = json!(compatibility);
    folder.write("scene.json", scene.to_string());
    folder.done("scene.json --end 0.01");
    folder
}

#[test]
fn nodes_of_a_page_are_where_the_outputs_say() {
    for compatibility in ["strong", "static"] {
        let folder = recorded(compatibility);
        folder.done("animate scene.h5");
        let page = Page::read(&folder, "scene.html");
        let expected = folder.results().history("middle").unwrap();
        let times = page.numbers(&page.description["times"]);
        assert_eq!(times.len(), expected.nrows());
        let rod = page.body("rod");
        let shape = &page.description["shapes"][0];
        let error = shape["error"].as_f64().unwrap();
        let mut bends = 0.0_f64;
        for frame in 0..times.len() {
            let (found, deflection) = page.node(rod, 2, frame);
            bends = bends.max(deflection);
            for axis in 0..2 {
                // Single precision of half a metre, and what the page says of the deflection.
                let allowed = 1e-7 + 2.0 * error * 0.02;
                let off = (found[axis] - expected[(frame, axis)]).abs();
                assert!(off < allowed, "{compatibility}, frame {frame}: {off:.1e}");
            }
        }
        assert!(bends > 1e-4, "{bends}");
        assert!(error < 1e-3, "{error}");
    }
}

#[test]
fn pages_need_nothing_from_elsewhere() {
    let folder = recorded("strong");
    folder.done("report scene.h5");
    let page = Page::read(&folder, "scene.report.html");
    for forbidden in ["src=\"", "href=\"http", "@import", "url(http"] {
        assert!(!page.html.contains(forbidden), "{forbidden}");
    }
    for said in [
        "The run is complete",
        "energy balance is good",
        "SHA-256",
        "generalized alpha",
    ] {
        assert!(page.html.contains(said), "{said}");
    }
    let titles = page.description["histories"].as_array().unwrap();
    assert!(titles.iter().any(|one| one["name"] == "outputs/middle"));
    assert!(
        titles
            .iter()
            .all(|one| !one["name"].as_str().unwrap().starts_with("motion/"))
    );
}

#[test]
fn names_of_strangers_stay_text() {
    let folder = Folder::slider_crank();
    let hostile = "</script><img src=x onerror=alert(1)>".replace('/', "");
    let mut scene = folder.json("scene.json");
    let text = scene.to_string().replace("crank/", &format!("{hostile}/"));
    scene = serde_json::from_str(&text).unwrap();
    let bodies = scene["bodies"].as_object_mut().unwrap();
    let crank = bodies.remove("crank").unwrap();
    bodies.insert(hostile.clone(), crank);
    folder.write("scene.json", scene.to_string());
    folder.done("scene.json --end 0.001");
    folder.done("report scene.h5");
    let page = Page::read(&folder, "scene.report.html");
    assert!(!page.html.contains("<img src=x"));
    assert_eq!(page.body(&hostile)["name"], json!(hostile));
}

#[test]
fn a_page_is_of_the_superelements_of_the_run() {
    let folder = Folder::slider_crank();
    folder.done("scene.json --end 0.001");
    folder.done("animate scene.h5");
    // A page can be made again, another file is not lost.
    folder.done("animate scene.h5");
    folder.write("other.html", "<!DOCTYPE html>");
    folder.refused(
        "animate scene.h5 -o other.html",
        &["other.html: exists already; use --force"],
    );
    folder.refused(
        "animate scene.h5 -o scene.h5 --force",
        &["scene.h5: is the file of the results"],
    );
    fs::rename(folder.path("rod.dcb.h5"), folder.path("kept.h5")).unwrap();
    folder.refused(
        "animate scene.h5 --force",
        &["rod.dcb.h5", "is not there", "--scene"],
    );
    fs::create_dir(folder.path("elsewhere")).unwrap();
    fs::rename(folder.path("kept.h5"), folder.path("elsewhere/rod.dcb.h5")).unwrap();
    folder.done("animate scene.h5 --force --scene elsewhere/scene.json");
    // The same name with other contents.
    let other = Folder::slider_crank();
    let rod = other.path("rod.dcb.h5");
    let mut element = dcb_formats::dcb::read_superelement(&rod).unwrap();
    element.modes.residual_damping += 0.01;
    folder.store_superelement("rod.dcb.h5", &element);
    folder.refused(
        "animate scene.h5 --force",
        &[
            "rod.dcb.h5",
            "is not the file that the run of",
            "run the scene again",
        ],
    );
}

#[test]
fn results_may_stand_elsewhere_than_their_scene() {
    let folder = Folder::slider_crank();
    fs::create_dir(folder.path("out")).unwrap();
    folder.done("scene.json --end 0.001 -o out/run.h5");
    folder.done("animate out/run.h5");
    assert!(folder.path("out/run.html").is_file());
}

/// Bodies of a scene get more keys.
fn with(folder: &Folder, change: impl FnOnce(&mut Value)) {
    let mut scene = folder.json("scene.json");
    change(&mut scene);
    folder.write("scene.json", scene.to_string());
}

/// A second rod that stands by itself, fixed to the ground.
fn with_post(scene: &mut Value, keys: Value) {
    let mut post = json!({"superelement": "rod.dcb.h5", "position": [1, 1]});
    let keys = keys.as_object().unwrap().clone();
    post.as_object_mut().unwrap().extend(keys);
    scene["bodies"]["post"] = post;
    scene["ground"] = json!({"points": {"post": [1, 1]}});
    scene["joints"]["post"] =
        json!({"fixed": {"a": "ground/post", "b": "post/a", "orientation": "body"}});
}

#[test]
fn bodies_of_one_file_may_carry_different_coordinates() {
    let folder = Folder::slider_crank();
    with(&folder, |scene| with_post(scene, json!({"modes": 2})));
    folder.done("scene.json --end 0.001 --model everything");
    folder.done("animate scene.h5");
    let page = Page::read(&folder, "scene.html");
    let shape = |name: &str| page.body(name)["shape"].as_u64().unwrap();
    assert_ne!(shape("rod"), shape("post"));
}

#[test]
fn a_body_of_which_nothing_is_carried_is_drawn_at_rest() {
    let folder = Folder::slider_crank();
    // It floats where it is: nothing loads it.
    with(&folder, |scene| {
        scene["bodies"]["post"] = json!({"superelement": "rod.dcb.h5", "position": [1, 1]});
    });
    folder.done("scene.json --end 0.001");
    let left_out = folder
        .results()
        .channels()
        .iter()
        .all(|channel| channel.path != "motion/post/coordinates");
    assert!(
        left_out,
        "nothing moves the post: its coordinates aren't carried"
    );
    folder.done("animate scene.h5");
    let page = Page::read(&folder, "scene.html");
    let post = page.body("post");
    let shape = &page.description["shapes"][post["shape"].as_u64().unwrap() as usize];
    assert_eq!(shape["columns"], json!([]));
    assert!(!page.numbers(&shape["positions"]).is_empty());
}

#[test]
fn a_page_says_how_exact_it_is_without_its_script() {
    let folder = recorded("strong");
    folder.done("animate scene.h5");
    let page = Page::read(&folder, "scene.html");
    let shape = &page.description["shapes"][0];
    let rod = page.body("rod");
    let columns = shape["columns"].as_array().unwrap();
    let amplitudes = page.numbers(&rod["amplitudes"]);
    // What rounding alone can do in the worst frame, over the largest deflection of all.
    let (mut rounding, mut largest) = (0.0_f64, 0.0_f64);
    let values: Vec<Vec<f64>> = columns
        .iter()
        .map(|column| page.numbers(&column["values"]))
        .collect();
    let scales: Vec<f64> = columns
        .iter()
        .map(|column| column["scale"].as_f64().unwrap())
        .collect();
    for frame in amplitudes.chunks(columns.len()) {
        let each = frame.iter().zip(&scales);
        let off: f64 = each
            .clone()
            .map(|(amplitude, scale)| amplitude.abs() * scale)
            .sum();
        rounding = rounding.max(0.5 * 3.0_f64.sqrt() * off);
        for node in 0..values[0].len() / 3 {
            let along = |axis: usize| -> f64 {
                let each = each.clone().zip(&values);
                each.map(|((amplitude, scale), values)| amplitude * scale * values[3 * node + axis])
                    .sum()
            };
            largest = largest.max(along(0).hypot(along(1)).hypot(along(2)));
        }
    }
    let error = shape["error"].as_f64().unwrap();
    assert!(
        error >= 0.999 * rounding / largest,
        "{error} {}",
        rounding / largest
    );
    let text = &page.html[..page.html.find("id=\"description\"").unwrap()];
    let said = format!("within {:.2} %", (1e4 * error).ceil() / 100.0);
    assert!(text.contains(&said), "{said}");
}

#[test]
fn solids_of_the_scene_are_drawn_and_move_nothing() {
    let folder = Folder::slider_crank();
    with(&folder, |scene| {
        scene["bodies"]["crank"]["rigid"]["center_of_mass"] = json!([0.05, 0.0])
    });
    folder.done("scene.json --end 0.001 -o plain.h5");
    folder.write(
        "wedge.obj",
        "v 0 0 0\nv 20 0 0\nv 0 30 0\nv 0 0 40\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n",
    );
    with(&folder, |scene| {
        scene["bodies"]["crank"]["geometry"] = json!([
            {"cylinder": {"radius": 0.02, "from": [0, 0], "to": [0.15, 0]}, "color": "#aa3311"},
            {"box": [0.01, 0.02, 0.005], "position": [0.15, 0], "orientation": 0.5},
            {"sphere": {"radius": 0.004}}
        ]);
        scene["bodies"]["slider"]["geometry"] = json!([{"file": "wedge.obj", "scale": 0.001}]);
        scene["ground"] = json!({"geometry": [{"box": [1, 0.01, 0.1], "position": [0.5, -0.1]}]});
    });
    folder.done("scene.json --end 0.001");
    let [plain, drawn] = ["plain.h5", "scene.h5"].map(|name| {
        let results = dcb_formats::results::Results::open(folder.path(name)).unwrap();
        results.history("motion/rod/frame").unwrap()
    });
    assert_eq!(plain, drawn);
    folder.done("animate scene.h5");
    let page = Page::read(&folder, "scene.html");
    let crank = page.body("crank");
    let pin = crank["points"]
        .as_array()
        .unwrap()
        .iter()
        .find(|point| point["name"] == "pin")
        .unwrap();
    let [rod, block, ball] = [0, 1, 2].map(|index| &crank["solids"][index]);
    assert_eq!(
        (&rod["kind"], &rod["color"]),
        (&json!("cylinder"), &json!("#aa3311"))
    );
    assert!((rod["length"].as_f64().unwrap() - 0.15).abs() < 1e-12);
    // Component coordinates in the scene, from the centre of mass in the page.
    assert_eq!(block["position"], pin["position"]);
    assert_eq!(ball["position"], json!([-0.05, 0.0, 0.0]));
    let turn = block["turn"].as_array().unwrap();
    assert!((turn[3].as_f64().unwrap() - 0.25_f64.sin()).abs() < 1e-12);
    let wedge = &page.body("slider")["solids"][0];
    assert_eq!(page.numbers(&wedge["cells"]).len(), 12);
    let highest = page
        .numbers(&wedge["positions"])
        .into_iter()
        .fold(0.0, f64::max);
    assert!((highest - 0.04).abs() < 1e-8);
    assert_eq!(page.body("ground")["solids"][0]["kind"], "box");
    fs::remove_file(folder.path("wedge.obj")).unwrap();
    folder.refused("animate scene.h5 --force", &["wedge.obj", "cannot read"]);
}

#[test]
fn solids_that_make_no_sense_are_refused() {
    for (solid, told) in [
        (
            json!({"box": [1, 1, 1], "sphere": {"radius": 1}}),
            "exactly one of",
        ),
        (json!({"box": [1, 0, 1]}), "expected a positive number"),
        (json!({"box": [1, 1, 1], "scale": 2}), "`scale`"),
        (
            json!({"file": "../../etc/passwd.stl"}),
            "in the folder of the scene",
        ),
        (
            json!({"file": "/etc/passwd.stl"}),
            "in the folder of the scene",
        ),
        (json!({"cylinder": {"radius": 1}}), "`from` and `to`"),
        (
            json!({"cylinder": {"radius": 1, "from": [0, 0], "to": [0, 0]}}),
            "another place",
        ),
        (json!({"sphere": {"radius": 1}, "color": "red"}), "#b0b8c4"),
        (
            json!({"sphere": {"radius": 1}, "position": [1, 2, 3]}),
            "position",
        ),
    ] {
        let folder = Folder::slider_crank();
        with(&folder, |scene| {
            scene["bodies"]["crank"]["geometry"] = json!([solid])
        });
        folder.refused("scene.json --end 0.001", &["scene.json", told]);
    }
}

#[test]
fn modes_go_one_after_another() {
    let folder = Folder::slider_crank();
    with(&folder, |scene| {
        scene["analysis"] = json!({"modes": {"count": 3}});
        scene["drives"] = json!({});
    });
    folder.done("scene.json");
    folder.done("animate scene.h5");
    let page = Page::read(&folder, "scene.html");
    let modes = folder.results().modes().unwrap().unwrap();
    let times = page.numbers(&page.description["times"]);
    let per_mode = times.len() / modes.frequency.len();
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
    assert!((times[per_mode] - 1.0).abs() < 1e-6);
    assert_eq!(page.description["histories"], json!([]));
    let text = &page.html[..page.html.find("id=\"description\"").unwrap()];
    assert!(text.contains("the modes one after another") && text.contains("from 1 to 2"));
    for (mode, shape) in (0..modes.frequency.len()).map(|mode| (mode, &modes.shapes)) {
        for of_body in shape {
            let frames = page.numbers(&page.body(&of_body.body)["frames"]);
            let origin = |phase: usize| {
                let at = 7 * (mode * per_mode + phase);
                [frames[at], frames[at + 1]]
            };
            // A quarter and three quarters of a period lie on both sides of the place at rest, as 0 and a half do.
            let half = per_mode / 2;
            for axis in 0..2 {
                let rest = [0, half / 2].map(|k| 0.5 * (origin(k)[axis] + origin(k + half)[axis]));
                assert!((rest[0] - rest[1]).abs() < 1e-6, "{rest:?}");
            }
        }
    }
}

#[test]
fn what_is_no_results_file_is_told_its_command() {
    let folder = Folder::slider_crank();
    folder.refused(
        "animate rod.dcb.h5",
        &["superelement", "reduce report rod.dcb.h5"],
    );
    folder.refused(
        "animate scene.json",
        &["is a scene", "simulate scene.json", "take scene.h5"],
    );
}

/// A `.glb` file by what its specification says, without the crate that writes it.
struct Gltf {
    json: Value,
    bytes: Vec<u8>,
}

impl Gltf {
    fn read(folder: &Folder, name: &str) -> Self {
        let bytes = folder.bytes(name);
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!(&bytes[..4], b"glTF");
        assert_eq!((number(4), number(8)), (2, bytes.len()));
        let of_text = number(12);
        assert_eq!(
            (&bytes[16..20], &bytes[24 + of_text..28 + of_text]),
            (&b"JSON"[..], &b"BIN\0"[..])
        );
        Self {
            json: serde_json::from_slice(&bytes[20..20 + of_text]).unwrap(),
            bytes: bytes[28 + of_text..].to_vec(),
        }
    }

    fn reals(&self, accessor: &Value) -> Vec<f64> {
        let accessor = &self.json["accessors"][accessor.as_u64().unwrap() as usize];
        assert_eq!(accessor["componentType"], 5126);
        let width = match accessor["type"].as_str().unwrap() {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            other => panic!("{other}"),
        };
        let view = &self.json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let from = view["byteOffset"].as_u64().unwrap() as usize;
        let count = width * accessor["count"].as_u64().unwrap() as usize;
        let four = |k: usize| {
            self.bytes[from + 4 * k..from + 4 * k + 4]
                .try_into()
                .unwrap()
        };
        (0..count)
            .map(|k| f64::from(f32::from_le_bytes(four(k))))
            .collect()
    }

    /// Values of a node's animation, and its times.
    fn track(&self, node: usize, path: &str) -> (Vec<f64>, Vec<f64>) {
        let animation = &self.json["animations"][0];
        let channels = animation["channels"].as_array().unwrap();
        let is_wanted = |one: &&Value| one["target"] == json!({"node": node, "path": path});
        let channel = channels.iter().find(is_wanted).unwrap();
        let sampler = &animation["samplers"][channel["sampler"].as_u64().unwrap() as usize];
        (
            self.reals(&sampler["output"]),
            self.reals(&sampler["input"]),
        )
    }
}

#[test]
fn gltf_has_the_motion_and_the_deflection_of_the_run() {
    let folder = recorded("strong");
    with(&folder, |scene| {
        scene["bodies"]["slider"]["geometry"] = json!([{"box": [0.1, 0.05, 0.05]}])
    });
    folder.done("scene.json --end 0.01 --force");
    folder.done("animate scene.h5 --gltf run.glb");
    folder.done("animate scene.h5");
    let page = Page::read(&folder, "scene.html");
    let shape = &page.description["shapes"][0];
    let middle = page
        .numbers(&shape["nodes"])
        .iter()
        .position(|node| *node == 2.0)
        .unwrap();
    let gltf = Gltf::read(&folder, "run.glb");
    let nodes = gltf.json["nodes"].as_array().unwrap();
    let named = |name: &str| nodes.iter().position(|node| node["name"] == name).unwrap();
    assert!(nodes[named("slider")]["children"].as_array().unwrap().len() == 1);
    let rod = named("rod");
    let mesh = &gltf.json["meshes"][nodes[rod]["mesh"].as_u64().unwrap() as usize];
    let primitive = &mesh["primitives"][0];
    let rest = gltf.reals(&primitive["attributes"]["POSITION"]);
    let targets = primitive["targets"].as_array().unwrap();
    let targets: Vec<Vec<f64>> = targets
        .iter()
        .map(|target| gltf.reals(&target["POSITION"]))
        .collect();
    let (places, times) = gltf.track(rod, "translation");
    let (turns, _) = gltf.track(rod, "rotation");
    let (weights, _) = gltf.track(rod, "weights");
    let expected = folder.results().history("middle").unwrap();
    assert_eq!(
        (times.len(), weights.len()),
        (expected.nrows(), targets.len() * times.len())
    );
    for frame in 0..times.len() {
        let local = [0, 1].map(|axis| {
            let moved = targets.iter().zip(&weights[targets.len() * frame..]);
            rest[3 * middle + axis]
                + moved
                    .map(|(target, weight)| weight * target[3 * middle + axis])
                    .sum::<f64>()
        });
        let angle = 2.0 * turns[4 * frame + 2].atan2(turns[4 * frame + 3]);
        let world = [
            places[3 * frame] + angle.cos() * local[0] - angle.sin() * local[1],
            places[3 * frame + 1] + angle.sin() * local[0] + angle.cos() * local[1],
        ];
        for axis in 0..2 {
            assert!(
                (world[axis] - expected[(frame, axis)]).abs() < 2e-6,
                "frame {frame}: {world:?}"
            );
        }
    }
}
