//! The component file as it stands on disk. The texts here are the descriptions in the published JSON schema.

use crate::component::{InterfaceKind, Role, StressComponent, StressQuantity};
use crate::named::{Named, Object, unique};
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::IgnoredAny;

use super::dofs::Dofs;
use super::lists::{Connectivity, Keys, NodeList, PointSets, Points};
use super::values::{DirectionName, ModalDamping, Number, RayleighDamping, WeightsValue};

/// Component description: a meshio-compatible JSON mesh with one extra key, `component`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ComponentFile", extend("required" = ["points", "component"]))]
#[expect(
    dead_code,
    reason = "the skipped members are declared so that they are not taken for typing errors"
)]
pub struct FilePart {
    /// Where this schema is, for editors; not used.
    #[serde(rename = "$schema", default)]
    #[schemars(with = "Option<String>")]
    pub schema: Option<IgnoredAny>,
    /// `meshio-json`, or absent.
    #[serde(default)]
    #[schemars(extend("const" = "meshio-json"))]
    pub format: Option<String>,
    /// 1, or absent.
    #[serde(default)]
    #[schemars(extend("const" = 1))]
    pub version: Option<Number>,
    /// Node coordinates in component axes: all with two (planar) or all with three.
    pub points: Points,
    /// Cell blocks; may be empty or absent.
    #[serde(default)]
    pub cells: Vec<Object<CellPart>>,
    /// Skipped.
    #[serde(default)]
    #[schemars(with = "Option<serde_json::Map<String, serde_json::Value>>")]
    pub point_data: Option<IgnoredAny>,
    /// Skipped.
    #[serde(default)]
    #[schemars(with = "Option<serde_json::Map<String, serde_json::Value>>")]
    pub cell_data: Option<IgnoredAny>,
    /// Skipped.
    #[serde(default)]
    #[schemars(with = "Option<serde_json::Map<String, serde_json::Value>>")]
    pub field_data: Option<IgnoredAny>,
    /// Set name -> 0-based node ids.
    #[serde(default)]
    pub point_sets: PointSets,
    /// Skipped, except that its names help to explain an unknown point set.
    #[serde(default)]
    pub cell_sets: Keys,
    /// The component, beyond its mesh.
    pub component: Option<Object<ComponentPart>>,
}

/// Cells of one type.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "CellBlock")]
pub struct CellPart {
    /// meshio cell name, for example `tetra10`.
    #[serde(rename = "type")]
    pub cell_type: String,
    /// One list of 0-based node ids per cell, in meshio's node order.
    pub data: Connectivity,
}

/// Name, units, dofs, interfaces, stresses and damping of the component.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Component")]
pub struct ComponentPart {
    /// Name of the component.
    #[schemars(extend("minLength" = 1))]
    pub name: String,
    /// Units of every number here and in the matrices; force is mass * length / time^2.
    pub units: Object<UnitsPart>,
    /// Directions of every node in matrix order (node after node), or a table `[[node, "ux"], ...]` with one entry per
    /// matrix row.
    pub dofs: Dofs,
    /// Where forces act and motion is observed, in row order.
    #[serde(default)]
    pub interfaces: Vec<Object<InterfacePart>>,
    /// Stress and strain matrices `part.stress.NAME.mtx` by NAME: what their rows are.
    #[serde(default, deserialize_with = "unique")]
    #[schemars(with = "std::collections::BTreeMap<String, StressPart>")]
    pub stresses: Named<Object<StressPart>>,
    /// Damping; none where absent.
    #[serde(default)]
    pub damping: Option<Object<DampingPart>>,
}

/// Unit names, copied to the results.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Units")]
pub struct UnitsPart {
    /// Length unit, for example `m`.
    #[schemars(extend("minLength" = 1))]
    pub length: String,
    /// Mass unit, for example `kg`.
    #[schemars(extend("minLength" = 1))]
    pub mass: String,
    /// Time unit, for example `s`.
    #[schemars(extend("minLength" = 1))]
    pub time: String,
}

/// One interface; exactly one of `point_set` and `nodes` says where.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Interface", extend("oneOf" = [{"required": ["point_set"]}, {"required": ["nodes"]}]))]
pub struct InterfacePart {
    /// Unique name, without `/`.
    #[schemars(extend("minLength" = 1, "pattern" = "^[^/]+$"))]
    pub name: String,
    /// `nodes`, `average` or `rigid`.
    pub kind: InterfaceKind,
    /// Name of a set in `point_sets`.
    #[serde(default)]
    pub point_set: Option<String>,
    /// 0-based node ids, no repeats.
    #[serde(default)]
    pub nodes: Option<NodeList>,
    /// Reference point of an `average` or `rigid` frame; the (weighted) centroid of the nodes where absent.
    #[serde(default)]
    #[schemars(extend("minItems" = 2, "maxItems" = 3))]
    pub position: Option<Vec<Number>>,
    /// Node weights of an `average`; `uniform` where absent.
    #[serde(default)]
    pub weights: Option<WeightsValue>,
    /// The frame's own axes: right-handed orthogonal unit vectors, one a row; the component's axes where absent.
    #[serde(default)]
    #[schemars(extend("minItems" = 2, "maxItems" = 3))]
    pub axes: Option<Vec<Vec<Number>>>,
    /// Directions wanted, in component axes; all that the kind has where absent.
    #[serde(default)]
    #[schemars(extend("minItems" = 1, "maxItems" = 6, "uniqueItems" = true))]
    pub dofs: Option<Vec<DirectionName>>,
    /// `attachment` (the default) or `output`.
    #[serde(default)]
    pub role: Option<Role>,
}

/// Rows of a stress matrix: place after place, at each its components. Exactly one of `point_set`, `nodes` and `positions` says where.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Stress", extend("oneOf" = [{"required": ["point_set"]}, {"required": ["nodes"]}, {"required": ["positions"]}]))]
pub struct StressPart {
    /// `stress` (the default) or `strain`; shear strains are those of the tensor, half of the engineering ones.
    #[serde(default)]
    pub quantity: StressQuantity,
    /// Name of a set in `point_sets`.
    #[serde(default)]
    pub point_set: Option<String>,
    /// 0-based node ids.
    #[serde(default)]
    pub nodes: Option<NodeList>,
    /// Places in component coordinates, for example integration points.
    #[serde(default)]
    pub positions: Option<Points>,
    /// Components at each place, in the order of the rows: all six, planar `xx`, `yy`, `xy` where absent.
    #[serde(default)]
    pub components: Option<Vec<StressComponent>>,
}

/// Exactly one of `modal` and `rayleigh`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Damping", extend("oneOf" = [{"required": ["modal"]}, {"required": ["rayleigh"]}]))]
pub struct DampingPart {
    /// Ratio to critical: one for all modes, or one per elastic mode of which the last holds for all further ones.
    #[serde(default)]
    pub modal: Option<ModalDamping>,
    /// C = alpha M + beta K, by `[alpha, beta]` or by the ratios to critical at two frequencies.
    #[serde(default)]
    pub rayleigh: Option<RayleighDamping>,
}
