//! What recorded quantities are of: places, nodes, joints, bodies and masses.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An attachment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AtPlace {
    /// `body/interface` or `body/point`.
    pub at: String,
}

/// A node and the interfaces at the ends of a chord.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChordDeflection {
    /// Name of a superelement's body.
    pub body: String,
    /// Node of its mesh, from 0.
    pub node: u32,
    /// Two interfaces of the body.
    pub between: [String; 2],
}

/// A node of the mesh of a superelement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshNode {
    /// Name of a superelement's body.
    pub body: String,
    /// Node of its mesh, from 0.
    pub node: u32,
}

/// A joint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfJoint {
    /// Name of the joint.
    pub joint: String,
}

/// A joint and the axes of its force and moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reaction {
    /// Name of the joint.
    pub joint: String,
    /// Axes of the components.
    #[serde(default)]
    pub axes: ReactionAxes,
}

/// Axes of a reaction's components.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ReactionAxes {
    /// Fixed.
    #[default]
    World,
    /// Those of the first place.
    First,
    /// Those of the second place.
    Second,
}

/// A drive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfDrive {
    /// Name of the drive.
    pub drive: String,
}

/// A spring.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfSpring {
    /// Name of the spring.
    pub spring: String,
}

/// An actuator.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfActuator {
    /// Name of the actuator.
    pub actuator: String,
}

/// The body of a superelement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfSuperelement {
    /// Name of a superelement's body.
    pub body: String,
}

/// Stress or strain inside a superelement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StressOutput {
    /// Name of a superelement's body.
    pub body: String,
    /// Name of a stress field of its file.
    pub field: String,
    /// Place of the field, from 0; all places where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<usize>,
    /// Which numbers.
    #[serde(default)]
    pub measure: StressMeasure,
}

/// Numbers of a stress field, computed after all coordinates were superposed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum StressMeasure {
    /// Every component, body axes.
    #[default]
    Components,
    /// Von Mises' equivalent stress.
    VonMises,
    /// The largest equivalent stress of all places, and the place that has it.
    LargestVonMises,
}

/// A body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfBody {
    /// Name of a body.
    pub body: String,
}

/// A body, or all of them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OfMass {
    /// Name of a body; all bodies together where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
}

/// A body, or all of them, and the point that angular momentum is about.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AngularMomentum {
    /// Name of a body; all bodies together where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// About which point; the world's origin where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about: Option<MomentPoint>,
}

/// A point that moments are about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected \"center_of_mass\" or the coordinates of a point that doesn't move"
)]
pub enum MomentPoint {
    /// One that the masses have.
    OfMass(MassPoint),
    /// A fixed point, world coordinates.
    Fixed(Vec<f64>),
}

/// A point that masses have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MassPoint {
    /// The centre of mass of what is meant, moving with it.
    CenterOfMass,
}
