//! The scene's JSON text, comments allowed: bounded in size, and every complaint with its place.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::component::Units;
use crate::description::json_error;
use json_comments::CommentSettings;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Scene;
use crate::Error;
use crate::named::Object;

/// Largest scene file, bytes. Objects nest at most 128 deep, which is the JSON reader's own limit.
const LARGEST: u64 = 64 << 20;

/// Unit names, copied to the results.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Units", deny_unknown_fields)]
#[schemars(rename = "Units")]
pub(super) struct UnitNames {
    /// Length unit, for example `m`.
    length: String,
    /// Mass unit, for example `kg`.
    mass: String,
    /// Time unit, for example `s`.
    time: String,
}

/// The dimension as a number.
pub(super) mod dimension {
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
    let refused = |source| crate::Error::io(path, "cannot read", source);
    let whole = |message: String| crate::Error::File {
        path: path.to_owned(),
        message,
    };
    let source: Box<dyn Read> = match path == Path::new(super::STANDARD_INPUT) {
        true => Box::new(std::io::stdin()),
        false => Box::new(File::open(path).map_err(refused)?),
    };
    let mut bytes = Vec::new();
    source
        .take(LARGEST + 1)
        .read_to_end(&mut bytes)
        .map_err(refused)?;
    if bytes.len() as u64 > LARGEST {
        return Err(whole(format!(
            "has more than {} MiB; expected a scene (JSON)",
            LARGEST >> 20
        )));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        whole(format!(
            "is not UTF-8 text ({error}); expected a scene (JSON)"
        ))
    })?;
    if text.trim().is_empty() {
        return Err(whole("is empty; expected a scene (JSON)".into()));
    }
    Ok(text)
}

/// The scene as it stands in the text, not yet checked.
pub(super) fn scene(text: &str, path: &Path) -> Result<Scene, Error> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let text = &without_comments(text, path)?;
    let Object(scene) = serde_json::from_str::<Object<Scene>>(text)
        .map_err(|error| json_error(path, text.as_bytes(), &error, example_of))?;
    Ok(scene)
}

/// The same with blanks in place of `// ...` and `/* ... */`, so that places stay where they are.
fn without_comments(text: &str, path: &Path) -> Result<String, Error> {
    if !text.contains("//") && !text.contains("/*") {
        return Ok(text.to_owned());
    }
    let settings = CommentSettings::c_style();
    let mut blank = String::with_capacity(text.len());
    match settings
        .strip_comments(text.as_bytes())
        .read_to_string(&mut blank)
    {
        Ok(_) => Ok(blank),
        Err(_) => Err(Error::File {
            path: path.to_owned(),
            message: "has a comment without an end; expected */ somewhere after /*".into(),
        }),
    }
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
