//! The scene's JSON text, comments allowed: bounded in size, and every complaint with its place.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::component::Units;
use crate::description::json_error;
use crate::json_text;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Scene;
use crate::Error;
use crate::named::Object;

/// Unit names, copied to the results.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Units", deny_unknown_fields)]
#[schemars(rename = "Units")]
pub(crate) struct UnitNames {
    /// Length unit, for example `m`.
    length: String,
    /// Mass unit, for example `kg`.
    mass: String,
    /// Time unit, for example `s`.
    time: String,
}

/// The dimension as a number.
pub(crate) mod dimension {
    use crate::mesh::Dimension;
    use schemars::{Schema, SchemaGenerator, json_schema};
    use serde::de::{Deserialize, Deserializer, Error, Unexpected};
    use serde::ser::Serializer;

    pub fn serialize<S: Serializer>(
        dimension: &Dimension,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.serialize_u64(dimension.coordinate_count() as u64)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Dimension, D::Error> {
        match u64::deserialize(deserializer)? {
            2 => Ok(Dimension::Planar),
            3 => Ok(Dimension::Spatial),
            other => Err(D::Error::invalid_value(
                Unexpected::Unsigned(other),
                &"2 (planar) or 3 (spatial)",
            )),
        }
    }

    pub fn schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"enum": [2, 3]})
    }
}

/// The text of a scene file.
pub(super) fn text(path: &Path) -> Result<String, Error> {
    let source: Box<dyn Read> = match path == Path::new(super::STANDARD_INPUT) {
        true => Box::new(std::io::stdin()),
        false => {
            Box::new(File::open(path).map_err(|source| Error::io(path, "cannot read", source))?)
        }
    };
    json_text::read(path, source, "a scene", other_file)
}

/// What a file is that was taken for a scene, and where it belongs.
fn other_file(start: &[u8], path: &Path) -> Option<String> {
    let path = path.display();
    if start.starts_with(b"\x89HDF\r\n\x1a\n") {
        return Some(format!(
            "is an HDF5 file, not a scene; of a superelement `simulate init {path}` drafts a scene, and of results `simulate show {path}` lists them"
        ));
    }
    if start.starts_with(b"%%MatrixMarket") {
        return Some(format!(
            "is a matrix, not a scene; `reduce {path}` makes a superelement of it first"
        ));
    }
    None
}

/// That a JSON text describes a component, which has none of a scene's keys.
fn component(text: &str) -> Option<&'static str> {
    let value: serde_json::Value = serde_json::from_str(text).ok()?;
    let is_component = value.get("component").is_some() && value.get("bodies").is_none();
    is_component.then_some(
        "describes a component, not a scene; `reduce PART.mtx` reads it beside the matrices and makes a superelement, which a scene can have as a body",
    )
}

/// The scene as it stands in the text, not yet checked.
pub(super) fn scene(text: &str, path: &Path) -> Result<Scene, Error> {
    let text = &json_text::stripped(text, path)?;
    let Object(scene) =
        serde_json::from_str::<Object<Scene>>(text).map_err(|error| match component(text) {
            Some(message) => Error::File {
                path: path.to_owned(),
                message: message.to_owned(),
            },
            None => json_error(path, text.as_bytes(), &error, example_of),
        })?;
    Ok(scene)
}

fn example_of(field: &str) -> Option<&'static str> {
    Some(match field {
        "dimension" => r#""dimension": 2 (planar) or 3 (spatial)"#,
        "units" => r#""units": {"length": "m", "mass": "kg", "time": "s"}"#,
        "bodies" => r#""bodies": {"rod": {"superelement": "rod.dcb.h5"}}"#,
        "joint" => r#""joint": "axle" (the name of a joint)"#,
        "polynomial" => {
            r#""polynomial": [0, 150] (or "harmonic", "table", "smooth_step", "trapezoid", "chirp", "pulse", "formula", "constant", "input")"#
        }
        "a" | "b" | "at" => r#""body/interface" (or "ground", "body/point")"#,
        "gravity" => r#""gravity": [0, 0, -9.81] (planar: [0, -9.81])"#,
        "position" | "velocity" => r#""position": [0.1, 0, 0] (planar: [0.1, 0])"#,
        "axis" | "axis_b" => r#""axis": [0, 0, 1]"#,
        "step" => r#""step": 1e-4"#,
        "end" => r#""end": 1"#,
        "inertia" => r#""inertia": 1e-4 (planar) or three principal moments (spatial)"#,
        "mass" => r#""mass": 0.1"#,
        "directory" => r#""directory": "fields""#,
        _ => return None,
    })
}
