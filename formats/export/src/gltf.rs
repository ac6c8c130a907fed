//! glTF 2.0, binary: the surface of the mesh, one morph target a free mode, one animation a mode: a cycle of one second.
//!
//! Lengths are metres, as glTF wants them; a mode's largest displacement is a tenth of the part's extent. Numbers are single precision: pictures, not data.

use std::collections::BTreeMap;

use dcb_formats::mesh::Mesh;
use dcb_formats::units::si_factor;
use dcb_formats::{Error, Superelement};
use dcb_view::{Drawing, Glb, extras};
use faer::Mat;
use gltf_json::accessor::Type;
use gltf_json::animation::{Animation, Channel, Interpolation, Property, Sampler};
use gltf_json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use gltf_json::validation::Checked::Valid;
use gltf_json::{Index, Node, Scene};
use serde_json::json;

use crate::files::product::{Content, Product};
use crate::mesh::mode_names;
use crate::mesh::node_shapes::NodeShapes;
use crate::part::Source;
use crate::{Axes, Request};

/// Largest displacement of a mode over the part's extent.
const AMPLITUDE: f64 = 0.1;
/// Key frames: seconds, and how much of the mode is shown.
const TIMES: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
const WEIGHTS: [f32; 5] = [0.0, 1.0, 0.0, -1.0, 0.0];

/// Moving modes as a picture.
pub(crate) fn product(source: &Source, request: &Request<'_>) -> Result<Product, Error> {
    let Some((fields, mesh)) = source.fields()? else {
        return Err(source.refused("has no nodal fields, or no mesh, and glTF shows both; reduce it without --without-fields".to_owned()));
    };
    let element = source.superelement();
    let (n, n_k) = (element.basis_count(), element.mode_count());
    let modes = Mat::from_fn(n, n_k, |i, j| f64::from(u8::from(i == j)));
    let drawing = Drawing::of(&mesh);
    let picture = Picture {
        shapes: NodeShapes::of(&fields, &mesh, &modes),
        drawing: &drawing,
        mesh: &mesh,
    };
    let rest = picture.at_rest(element, request.axes);
    let extent = extent(&rest);
    let names = mode_names(element);
    let mut scene = Builder::default();
    let moved = (0..n_k).map(|mode| picture.moved(mode, extent));
    scene.mesh(source, &drawing, &rest, moved, &names);
    scene.animations(&names);
    let bytes = scene
        .glb
        .finish("dual Craig-Bampton, reduce export", &source.origin_line())
        .map_err(|why| source.refused(why))?;
    let summary = format!(
        "{} nodes, {} {}, {n_k} modes as morph targets and animations",
        drawing.nodes.len(),
        drawing.cells.len() / drawing.corners,
        drawing.what()
    );
    let mut product = Product::new(Content::Bytes(bytes), summary);
    product.notes = picture.notes(&element.units.length);
    product.left_out.push("everything but shapes and frequencies: this is a picture; numbers are single precision, displacements scaled to be seen".to_owned());
    let attachments = element.residual.sigma_squared.len();
    if attachments > 0 {
        product.left_out.push(format!(
            "{attachments} attachments: only free modes are shown"
        ));
    }
    Ok(product)
}

/// Nodes that are drawn, and how they move.
struct Picture<'a> {
    shapes: NodeShapes,
    drawing: &'a Drawing,
    mesh: &'a Mesh,
}

impl Picture<'_> {
    /// Places in metres.
    fn at_rest(&self, element: &Superelement, axes: Axes) -> Vec<[f64; 3]> {
        let metre = si_factor(&element.units.length).unwrap_or(1.0);
        let offset = match axes {
            Axes::Body => element.origin,
            Axes::Component => [0.0; 3],
        };
        let place = |node: &u32| {
            let at = self.mesh.position(*node);
            [0, 1, 2].map(|a| metre * (at[a] - offset[a]))
        };
        self.drawing.nodes.iter().map(place).collect()
    }

    /// Displacements of a mode, as large as can be seen; nodes without fields stay.
    fn moved(&self, mode: usize, extent: f64) -> Vec<[f64; 3]> {
        let of = |node: &u32| match self.shapes.nodes.binary_search(node) {
            Ok(place) => [0, 1, 2].map(|a| self.shapes.shapes[(3 * place + a, mode)]),
            Err(_) => [0.0; 3],
        };
        let shape: Vec<[f64; 3]> = self.drawing.nodes.iter().map(of).collect();
        let sizes = shape.iter().map(|[x, y, z]| (x * x + y * y + z * z).sqrt());
        let largest = sizes.fold(0.0, f64::max);
        let scale = match largest > 0.0 {
            true => AMPLITUDE * extent / largest,
            false => 0.0,
        };
        let scaled = shape.iter().map(|at| at.map(|value| scale * value));
        scaled.collect()
    }

    fn notes(&self, length: &str) -> Vec<String> {
        let mut notes = Vec::new();
        if !self.drawing.others.is_empty() {
            let others = self.drawing.others.join(", ");
            notes.push(format!("not drawn: cells of type {others}"));
        }
        let is_still = |node: &&u32| self.shapes.nodes.binary_search(node).is_err();
        let still = self.drawing.nodes.iter().filter(is_still).count();
        if still > 0 {
            notes.push(format!(
                "{still} of {} nodes drawn have no displacements in the file and stay at rest",
                self.drawing.nodes.len()
            ));
        }
        if si_factor(length).is_none() {
            notes.push(format!("one {length} is shown as one metre"));
        }
        notes
    }
}

/// Largest side of the box round all points.
fn extent(points: &[[f64; 3]]) -> f64 {
    let sides = [0, 1, 2].map(|a| {
        let values = points.iter().map(|at| at[a]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    });
    sides.into_iter().fold(0.0, f64::max)
}

/// A scene, while it grows.
#[derive(Default)]
struct Builder {
    glb: Glb,
}

impl Builder {
    fn mesh(
        &mut self,
        source: &Source,
        drawing: &Drawing,
        rest: &[[f64; 3]],
        modes: impl Iterator<Item = Vec<[f64; 3]>>,
        names: &[String],
    ) {
        let positions = self.glb.vectors(rest);
        let indices = self.glb.places(&drawing.cells);
        let targets: Vec<MorphTarget> = modes
            .map(|mode| MorphTarget {
                positions: Some(self.glb.vectors(&mode)),
                normals: None,
                tangents: None,
            })
            .collect();
        let moves = !targets.is_empty();
        let primitive = Primitive {
            attributes: BTreeMap::from([(Valid(Semantic::Positions), positions)]),
            extensions: None,
            extras: None,
            indices: Some(indices),
            material: None,
            mode: Valid(mode(drawing)),
            targets: moves.then_some(targets),
        };
        let name = source.superelement().name.clone();
        let mesh = self.glb.root.push(gltf_json::Mesh {
            extensions: None,
            extras: extras(&json!({ "targetNames": names })),
            name: Some(name.clone()),
            primitives: vec![primitive],
            weights: moves.then(|| vec![0.0; names.len()]),
        });
        let node = self.glb.root.push(Node {
            mesh: Some(mesh),
            name: Some(name),
            ..Node::default()
        });
        let scene = self.glb.root.push(Scene {
            extensions: None,
            extras: None,
            name: None,
            nodes: vec![node],
        });
        self.glb.root.scene = Some(scene);
    }

    /// Each mode alone goes through a cycle.
    fn animations(&mut self, names: &[String]) {
        if names.is_empty() {
            return;
        }
        let input = self.glb.times(&TIMES);
        for (mode, name) in names.iter().enumerate() {
            let weights = WEIGHTS.iter();
            let weights: Vec<f32> = weights
                .flat_map(|weight| {
                    (0..names.len()).map(move |k| if k == mode { *weight } else { 0.0 })
                })
                .collect();
            let output = self.glb.reals(&weights, Type::Scalar, weights.len());
            self.glb.root.animations.push(Animation {
                extensions: None,
                extras: None,
                name: Some(name.clone()),
                channels: vec![Channel {
                    sampler: Index::new(0),
                    target: gltf_json::animation::Target {
                        extensions: None,
                        extras: None,
                        node: Index::new(0),
                        path: Valid(Property::MorphTargetWeights),
                    },
                    extensions: None,
                    extras: None,
                }],
                samplers: vec![Sampler {
                    extensions: None,
                    extras: None,
                    input,
                    interpolation: Valid(Interpolation::Linear),
                    output,
                }],
            });
        }
    }
}

fn mode(drawing: &Drawing) -> Mode {
    match drawing.corners {
        3 => Mode::Triangles,
        2 => Mode::Lines,
        _ => Mode::Points,
    }
}
