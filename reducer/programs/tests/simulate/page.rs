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
        "generalized_alpha",
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
