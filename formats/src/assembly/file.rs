//! The assembly's JSON text, comments allowed: bounded in size, and every complaint with its place.

use std::fs::File;
use std::path::Path;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::body::BodyPart;
use super::{Assembly, ChosenInterface};
use crate::Error;
use crate::component::{Role, Units};
use crate::description::json_error;
use crate::json_text;
use crate::mesh::Dimension;
use crate::named::{Named, Object, unique};
use crate::scene::{Analysis, Ground, Joint, Scene, Spring};

/// An assembly: superelements and rigid bodies joined for good.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Assembly")]
struct AssemblyPart {
    /// Where the schema is, for editors; not used.
    #[serde(rename = "$schema", default)]
    #[schemars(with = "Option<String>")]
    _schema: Option<IgnoredAny>,
    /// Name of the whole; that of the file where absent.
    #[serde(default)]
    name: Option<String>,
    /// Planar (2) or spatial (3).
    #[serde(with = "crate::scene::dimension")]
    #[schemars(schema_with = "crate::scene::dimension::schema")]
    dimension: Dimension,
    /// Units of every number; those of all superelements.
    #[serde(with = "crate::scene::UnitNames")]
    #[schemars(with = "crate::scene::UnitNames")]
    units: Units,
    /// Places that don't move, for what is held.
    #[serde(default)]
    ground: Ground,
    /// Bodies by name.
    #[serde(deserialize_with = "unique")]
    bodies: Named<BodyPart>,
    /// Joints by name: what they hold, they hold for good.
    #[serde(default, deserialize_with = "unique")]
    joints: Named<Joint>,
    /// Springs, dampers and bushings by name.
    #[serde(default, deserialize_with = "unique")]
    springs: Named<Spring>,
    /// Interfaces of the whole by their new names: "body/interface", or an object.
    #[serde(deserialize_with = "unique")]
    interfaces: Named<InterfacePart>,
    /// Places that are joined may be this far apart, joined by a rigid link; 1e-6 of the size of the whole where absent.
    #[serde(default)]
    allow_gap: Option<f64>,
}

/// A place that the whole keeps.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected \"body/interface\", or {\"at\": \"body/interface\", \"role\": \"output\"}"
)]
#[schemars(rename = "AssemblyInterface")]
enum InterfacePart {
    /// The place.
    Place(String),
    /// The place and its role.
    WithRole(PlaceWithRole),
}

/// A place and its role.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct PlaceWithRole {
    /// `body/interface` or `body/point`.
    at: String,
    /// `attachment`, or `output` for a place that is only observed; what the part says where absent.
    #[serde(default)]
    role: Option<Role>,
}

/// The assembly as it stands in the text, not yet checked.
pub(super) fn assembly(text: &str, path: &Path) -> Result<Assembly, Error> {
    let stripped = &json_text::stripped(text, path)?;
    let Object(part) = serde_json::from_str::<Object<AssemblyPart>>(stripped)
        .map_err(|error| json_error(path, stripped.as_bytes(), &error, example_of))?;
    part.into_assembly(path)
}

impl AssemblyPart {
    fn into_assembly(self, path: &Path) -> Result<Assembly, Error> {
        let mut scene = Scene::new(self.dimension);
        scene.analysis = Analysis::Static;
        scene.directory = path.parent().map(Path::to_path_buf).unwrap_or_default();
        scene.units = self.units;
        scene.ground = self.ground;
        scene.joints = self.joints;
        scene.springs = self.springs;
        let mut mirrors = Named::new();
        for (name, part) in self.bodies {
            let (body, mirror) = part.into_body().map_err(|message| {
                Error::described(format!("bodies.{name}"), message).in_file(path)
            })?;
            if let Some(mirror) = mirror {
                mirrors.insert(name.clone(), mirror);
            }
            scene.bodies.insert(name, body);
        }
        let interfaces = self.interfaces.into_iter();
        let interfaces = interfaces.map(|(name, part)| {
            let (at, role) = match part {
                InterfacePart::Place(at) => (at, None),
                InterfacePart::WithRole(of) => (of.at, of.role),
            };
            (name, ChosenInterface { at, role })
        });
        let file = path
            .file_stem()
            .map(|stem| stem.to_string_lossy().into_owned());
        Ok(Assembly {
            name: self.name.or(file).unwrap_or_default(),
            scene,
            mirrors,
            interfaces: interfaces.collect(),
            allow_gap: self.allow_gap,
        })
    }
}

/// The text of an assembly file.
pub(super) fn text(path: &Path) -> Result<String, Error> {
    let file = File::open(path).map_err(|source| Error::io(path, "cannot read", source))?;
    json_text::read(path, file, "an assembly", other_file)
}

/// What a file is that was taken for an assembly, and where it belongs.
fn other_file(start: &[u8], path: &Path) -> Option<String> {
    if start.starts_with(b"\x89HDF\r\n\x1a\n") {
        return Some(
            "is an HDF5 file; expected an assembly (JSON), which names superelements under \"bodies\"".into(),
        );
    }
    start.starts_with(b"%%MatrixMarket").then(|| {
        format!(
            "is a matrix; `reduce {}` makes a superelement of it, which an assembly names under \"bodies\"",
            path.display()
        )
    })
}

fn example_of(field: &str) -> Option<&'static str> {
    Some(match field {
        "dimension" => r#""dimension": 2 (planar) or 3 (spatial)"#,
        "units" => r#""units": {"length": "m", "mass": "kg", "time": "s"}"#,
        "bodies" => r#""bodies": {"arm": {"superelement": "arm.dcb.h5"}}"#,
        "interfaces" => r#""interfaces": {"tool": "arm/flange"}"#,
        "a" | "b" | "at" => r#""body/interface" (or "ground", "body/point")"#,
        "position" => r#""position": [0.1, 0, 0] (planar: [0.1, 0])"#,
        "axis" | "axis_b" => r#""axis": [0, 0, 1]"#,
        _ => return None,
    })
}

/// JSON schema of the assembly file.
pub fn assembly_schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(AssemblyPart);
    schema.insert("title".into(), "Assembly".into());
    schema.to_value()
}
