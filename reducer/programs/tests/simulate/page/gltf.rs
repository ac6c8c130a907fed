//! The motion as glTF.

use serde_json::{Value, json};

use super::bodies::with;
use super::reader::Page;
use super::recorded;
use crate::support::Folder;

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
