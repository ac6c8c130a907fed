//! What a page's script is told: the fields of `formats/view/web/README.md`, in its order.

use serde::Serialize;

use crate::arrays::Array;
use crate::shape::Shape;

/// What a page shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A part, in one mode at a time.
    Part,
    /// A mechanism over time.
    Scene,
}

/// All of a page's view.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Description {
    /// What it shows.
    pub kind: Kind,
    /// Heading.
    pub title: String,
    /// Names of the units.
    pub units: serde_json::Value,
    /// 2 or 3.
    pub dimension: usize,
    /// Against gravity, or what is up in a picture.
    pub up: [f64; 3],
    /// Diagonal of the box around all that is drawn.
    pub size: f64,
    /// Meshes.
    pub shapes: Vec<Shape>,
    /// Bodies.
    pub bodies: Vec<Body>,
    /// Times of frames and amplitudes.
    pub times: Array,
    /// Joints.
    pub joints: Vec<Joint>,
    /// Loads.
    pub loads: Vec<Load>,
    /// Curves over time.
    pub histories: Vec<History>,
    /// Modes of a part.
    pub modes: Vec<Mode>,
    /// Charts.
    pub charts: Vec<Chart>,
}

/// A body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Body {
    /// Name in the scene.
    pub name: String,
    /// Mesh, by its number.
    pub shape: Option<usize>,
    /// Geometry of a rigid body.
    pub solids: Vec<Solid>,
    /// Interfaces or points.
    pub points: Vec<Place>,
    /// Origin and quaternion, time after time.
    pub frames: Option<Array>,
    /// Origin and quaternion where there are no frames.
    pub rest: [f64; 7],
    /// Amplitudes of the columns, time after time.
    pub amplitudes: Option<Array>,
}

/// A named place of a body, body axes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Name.
    pub name: String,
    /// From the origin of the body's frame.
    pub position: [f64; 3],
    /// Quaternion of its axes.
    pub axes: [f64; 4],
}

/// A simple geometry and where it is, body axes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Solid {
    /// What it is.
    #[serde(flatten)]
    pub form: Form,
    /// Of its centre, or of the origin of its points.
    pub position: [f64; 3],
    /// Quaternion of its axes.
    pub turn: [f64; 4],
    /// `#rrggbb`; that of the body where there is none.
    pub color: Option<String>,
}

/// The kinds of solids, in their own axes.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Form {
    /// A cuboid about the origin.
    Box {
        /// Lengths of its sides.
        sides: [f64; 3],
    },
    /// A cylinder about z and the origin.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Its length.
        length: f64,
    },
    /// A ball about the origin.
    Sphere {
        /// Its radius; a share of the page's size where it is zero.
        radius: f64,
    },
    /// Rods from the first point to each other one.
    Stick {
        /// Points.
        ends: Vec<[f64; 3]>,
        /// Their radius.
        radius: f64,
    },
    /// Triangles.
    Mesh {
        /// Corners.
        positions: Array,
        /// Places in the positions, three a triangle.
        cells: Array,
    },
}

impl Form {
    /// Where a body has it, in the body's own axes and about its origin.
    pub fn unmoved(self) -> Solid {
        Solid {
            form: self,
            position: [0.0; 3],
            turn: [1.0, 0.0, 0.0, 0.0],
            color: None,
        }
    }
}

/// A joint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Joint {
    /// Name in the scene.
    pub name: String,
    /// As the scene calls it.
    pub kind: String,
    /// First end.
    pub a: End,
    /// Second end.
    pub b: End,
}

/// An end of a joint, body axes (ground: world).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct End {
    /// Body by its number; none for the ground.
    pub body: Option<usize>,
    /// From the origin of the body's frame.
    pub position: [f64; 3],
    /// Axis of rotation or sliding.
    pub axis: Option<[f64; 3]>,
}

/// A load.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Load {
    /// Name in the scene.
    pub name: String,
    /// Body by its number.
    pub body: Option<usize>,
    /// From the origin of the body's frame.
    pub position: [f64; 3],
    /// A moment in place of a force.
    pub moment: bool,
    /// Components, time after time.
    pub components: Array,
    /// World axes in place of the body's.
    pub world: bool,
}

/// Curves over time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct History {
    /// Path in the results.
    pub name: String,
    /// What people read.
    pub title: String,
    /// Physical quantity; curves of one quantity and unit share axes.
    pub quantity: String,
    /// Unit.
    pub unit: String,
    /// Curves.
    pub columns: Vec<HistoryColumn>,
    /// Times where they aren't those of the page.
    pub times: Option<Array>,
}

/// One curve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HistoryColumn {
    /// Name.
    pub name: String,
    /// Values.
    pub values: Array,
}

/// A mode that can be chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mode {
    /// Name.
    pub name: String,
    /// Hz; none for what has none.
    pub frequency: Option<f64>,
    /// Part of the critical one.
    pub damping: Option<f64>,
    /// Column of the shape.
    pub column: usize,
}

/// A chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Chart {
    /// Heading.
    pub title: String,
    /// Abscissa.
    pub x: ChartAxis,
    /// Ordinate.
    pub y: ChartAxis,
    /// Curves.
    pub curves: Vec<Curve>,
    /// Bands between two curves.
    pub bands: Vec<Band>,
}

/// An axis of a chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChartAxis {
    /// Quantity and unit.
    pub label: String,
    /// Logarithmic.
    pub log: bool,
}

/// A curve of a chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// Name.
    pub name: String,
    /// Abscissas.
    pub x: Array,
    /// Ordinates.
    pub y: Array,
}

/// A band of a chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Band {
    /// Name.
    pub name: String,
    /// Abscissas.
    pub x: Array,
    /// Lower ordinates.
    pub low: Array,
    /// Upper ordinates.
    pub high: Array,
}
