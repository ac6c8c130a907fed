//! A page as its script reads it.

use std::io::Read as _;

use base64::Engine as _;
use flate2::read::ZlibDecoder;
use serde_json::Value;

use crate::support::Folder;

/// Description and arrays of a page, as its script reads them.
pub struct Page {
    pub html: String,
    pub description: Value,
    bytes: Vec<u8>,
}

impl Page {
    pub fn read(folder: &Folder, name: &str) -> Self {
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

    pub fn numbers(&self, array: &Value) -> Vec<f64> {
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

    pub fn body(&self, name: &str) -> &Value {
        let bodies = self.description["bodies"].as_array().unwrap();
        bodies.iter().find(|body| body["name"] == name).unwrap()
    }

    /// Place of a mesh node in the world at a frame, and the largest elastic displacement along an axis, planar.
    pub fn node(&self, body: &Value, node: usize, frame: usize) -> ([f64; 2], f64) {
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
