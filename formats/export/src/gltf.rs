//! glTF 2.0, binary: the surface of the mesh, one morph target a free mode, one animation a mode: a cycle of one second.
//!
//! Lengths are metres, as glTF wants them; a mode's largest displacement is a tenth of the part's extent. Numbers are single precision: pictures, not data.

use std::collections::BTreeMap;

use dcb_formats::Error;
use dcb_formats::mesh::Mesh;
use dcb_formats::units::{hertz, hertz_unit, si_factor};
use faer::Mat;
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::animation::{Animation, Channel, Interpolation, Property, Sampler};
use gltf_json::buffer::{Target as BufferTarget, View};
use gltf_json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use gltf_json::validation::Checked::Valid;
use gltf_json::{Accessor, Index, Node, Root, Scene};
use serde_json::json;

use crate::node_shapes::NodeShapes;
use crate::part::Source;
use crate::product::{Content, Product};
use crate::surface::Surface;
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
    let shapes = NodeShapes::of(&fields, &mesh, &modes);
    let drawing = Drawing::of(&mesh);
    let mut notes = Vec::new();
    if !drawing.others.is_empty() {
        notes.push(format!(
            "not drawn: cells of type {}",
            drawing.others.join(", ")
        ));
    }
    let mut displaced = vec![None; mesh.node_count()];
    for (place, node) in shapes.nodes.iter().enumerate() {
        displaced[*node as usize] = Some(place);
    }
    let at_rest = drawing
        .nodes
        .iter()
        .filter(|node| displaced[**node as usize].is_none())
        .count();
    if at_rest > 0 {
        notes.push(format!(
            "{at_rest} of {} nodes drawn have no displacements in the file and stay at rest",
            drawing.nodes.len()
        ));
    }
    let metre = si_factor(&element.units.length);
    if metre.is_none() {
        notes.push(format!(
            "one {} is shown as one metre",
            element.units.length
        ));
    }
    let offset = match request.axes {
        Axes::Body => element.origin,
        Axes::Component => [0.0; 3],
    };
    let mut scene = Builder::default();
    let metre = metre.unwrap_or(1.0);
    let rest: Vec<[f64; 3]> = (drawing.nodes.iter())
        .map(|node| {
            let at = mesh.position(*node);
            [0, 1, 2].map(|a| metre * (at[a] - offset[a]))
        })
        .collect();
    let extent = extent(&rest);
    let moved = |mode: usize| -> Vec<[f64; 3]> {
        let of = |node: &u32| match displaced[*node as usize] {
            Some(place) => [0, 1, 2].map(|a| shapes.shapes[(3 * place + a, mode)]),
            None => [0.0; 3],
        };
        let shape: Vec<[f64; 3]> = drawing.nodes.iter().map(of).collect();
        let largest = shape
            .iter()
            .map(|[x, y, z]| (x * x + y * y + z * z).sqrt())
            .fold(0.0, f64::max);
        let scale = if largest > 0.0 {
            AMPLITUDE * extent / largest
        } else {
            0.0
        };
        shape
            .iter()
            .map(|at| at.map(|value| scale * value))
            .collect()
    };
    let time = &element.units.time;
    let names: Vec<String> = (element.modes.eigenvalues.iter().enumerate())
        .map(|(k, square)| {
            format!(
                "mode {}: {:.4} {}",
                k + 1,
                hertz(*square, time),
                hertz_unit(time)
            )
        })
        .collect();
    scene.mesh(source, &drawing, &rest, (0..n_k).map(moved), &names);
    scene.animations(&names);
    let bytes = scene.finish(source).map_err(|why| source.refused(why))?;
    let summary = format!(
        "{} nodes, {} {}, {n_k} modes as morph targets and animations",
        drawing.nodes.len(),
        drawing.cells.len() / drawing.corners,
        drawing.what()
    );
    let mut product = Product::new(Content::Bytes(bytes), summary);
    product.notes = notes;
    product.left_out.push("everything but shapes and frequencies: this is a picture; numbers are single precision, displacements scaled to be seen".to_owned());
    let attachments = element.residual.sigma_squared.len();
    if attachments > 0 {
        product.left_out.push(format!(
            "{attachments} attachments: only free modes are shown"
        ));
    }
    Ok(product)
}

/// Largest side of the box round all points.
fn extent(points: &[[f64; 3]]) -> f64 {
    let sides = [0, 1, 2].map(|a| {
        let values = points.iter().map(|at| at[a]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    });
    sides.into_iter().fold(0.0, f64::max)
}

/// What is drawn: triangles, else lines, else points.
struct Drawing {
    /// Nodes of the mesh, ascending.
    nodes: Vec<u32>,
    /// Places in `nodes`.
    cells: Vec<u32>,
    /// Nodes of a cell: 3, 2 or 1.
    corners: usize,
    others: Vec<String>,
}

impl Drawing {
    fn of(mesh: &Mesh) -> Self {
        let surface = Surface::of(mesh);
        let lines = || -> Vec<u32> {
            let blocks = mesh.cells.iter();
            let blocks =
                blocks.filter(|block| matches!(block.cell_type.as_str(), "line" | "line3"));
            let ends = blocks.flat_map(|block| block.cells().filter_map(|cell| cell.get(..2)));
            ends.flatten().copied().collect()
        };
        let (corners, cells, others) = match surface.triangles.is_empty() {
            false => (3, surface.triangles.into_flattened(), surface.others),
            true => match lines() {
                cells if cells.is_empty() => {
                    (1, (0..mesh.node_count() as u32).collect(), Vec::new())
                }
                cells => (2, cells, Vec::new()),
            },
        };
        let mut nodes = cells.clone();
        nodes.sort_unstable();
        nodes.dedup();
        let place = |node: &u32| nodes.partition_point(|known| known < node) as u32;
        Self {
            cells: cells.iter().map(place).collect(),
            nodes,
            corners,
            others,
        }
    }

    fn mode(&self) -> Mode {
        match self.corners {
            3 => Mode::Triangles,
            2 => Mode::Lines,
            _ => Mode::Points,
        }
    }

    fn what(&self) -> &'static str {
        match self.corners {
            3 => "triangles",
            2 => "lines",
            _ => "points",
        }
    }
}

/// A scene and its buffer, while they grow.
#[derive(Default)]
struct Builder {
    root: Root,
    bytes: Vec<u8>,
}

impl Builder {
    /// Numbers into the buffer, and how they are to be read.
    fn accessor(
        &mut self,
        bytes: &[u8],
        kind: (ComponentType, Type),
        count: usize,
        target: Option<BufferTarget>,
    ) -> Index<Accessor> {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        let view = self.root.push(View {
            buffer: Index::new(0),
            byte_length: bytes.len().into(),
            byte_offset: Some(offset.into()),
            byte_stride: None,
            name: None,
            target: target.map(Valid),
            extensions: None,
            extras: None,
        });
        self.root.push(Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: count.into(),
            component_type: Valid(GenericComponentType(kind.0)),
            extensions: None,
            extras: None,
            type_: Valid(kind.1),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
        })
    }

    fn reals(
        &mut self,
        values: &[f32],
        kind: Type,
        count: usize,
        target: Option<BufferTarget>,
    ) -> Index<Accessor> {
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        self.accessor(&bytes, (ComponentType::F32, kind), count, target)
    }

    /// Vectors, with the box round them, which positions must have.
    fn vectors(&mut self, of: &[[f64; 3]]) -> Index<Accessor> {
        let values: Vec<f32> = of.iter().flatten().map(|value| *value as f32).collect();
        let index = self.reals(
            &values,
            Type::Vec3,
            of.len(),
            Some(BufferTarget::ArrayBuffer),
        );
        let most = |pick: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|a| {
                values
                    .iter()
                    .skip(a)
                    .step_by(3)
                    .copied()
                    .reduce(pick)
                    .unwrap_or(0.0)
            })
        };
        if let Some(accessor) = self.root.accessors.last_mut() {
            accessor.min = Some(json!(most(f32::min)));
            accessor.max = Some(json!(most(f32::max)));
        }
        index
    }

    fn mesh(
        &mut self,
        source: &Source,
        drawing: &Drawing,
        rest: &[[f64; 3]],
        modes: impl Iterator<Item = Vec<[f64; 3]>>,
        names: &[String],
    ) {
        let positions = self.vectors(rest);
        let bytes: Vec<u8> = drawing
            .cells
            .iter()
            .flat_map(|node| node.to_le_bytes())
            .collect();
        let indices = self.accessor(
            &bytes,
            (ComponentType::U32, Type::Scalar),
            drawing.cells.len(),
            Some(BufferTarget::ElementArrayBuffer),
        );
        let targets: Vec<MorphTarget> = modes
            .map(|mode| MorphTarget {
                positions: Some(self.vectors(&mode)),
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
            mode: Valid(drawing.mode()),
            targets: moves.then_some(targets),
        };
        let name = source.superelement().name.clone();
        let mesh = self.root.push(gltf_json::Mesh {
            extensions: None,
            extras: raw(&json!({ "targetNames": names })),
            name: Some(name.clone()),
            primitives: vec![primitive],
            weights: moves.then(|| vec![0.0; names.len()]),
        });
        let node = self.root.push(Node {
            mesh: Some(mesh),
            name: Some(name),
            ..Node::default()
        });
        let scene = self.root.push(Scene {
            extensions: None,
            extras: None,
            name: None,
            nodes: vec![node],
        });
        self.root.scene = Some(scene);
    }

    /// Each mode alone goes through a cycle.
    fn animations(&mut self, names: &[String]) {
        if names.is_empty() {
            return;
        }
        let input = self.reals(&TIMES, Type::Scalar, TIMES.len(), None);
        if let Some(accessor) = self.root.accessors.last_mut() {
            accessor.min = Some(json!([TIMES[0]]));
            accessor.max = Some(json!([TIMES[TIMES.len() - 1]]));
        }
        for (mode, name) in names.iter().enumerate() {
            let weights = WEIGHTS.iter();
            let weights: Vec<f32> = weights
                .flat_map(|weight| {
                    (0..names.len()).map(move |k| if k == mode { *weight } else { 0.0 })
                })
                .collect();
            let output = self.reals(&weights, Type::Scalar, weights.len(), None);
            self.root.animations.push(Animation {
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

    /// Header, scene, buffer.
    fn finish(mut self, source: &Source) -> Result<Vec<u8>, String> {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.root.push(gltf_json::Buffer {
            byte_length: self.bytes.len().into(),
            name: None,
            uri: None,
            extensions: None,
            extras: None,
        });
        self.root.asset.generator = Some("dual Craig-Bampton, reduce export".to_owned());
        self.root.asset.extras = raw(&json!({ "source": source.origin_line() }));
        let mut text = serde_json::to_vec(&self.root)
            .map_err(|error| format!("can't be written as JSON: {error}"))?;
        text.resize(text.len().next_multiple_of(4), b' ');
        let sizes = [
            28 + text.len() + self.bytes.len(),
            text.len(),
            self.bytes.len(),
        ];
        let sizes = sizes.map(u32::try_from);
        let [Ok(all), Ok(of_text), Ok(of_bytes)] = sizes else {
            return Err(
                "is too large for one glTF file (4 GiB); reduce it with fewer modes".to_owned(),
            );
        };
        let mut file = Vec::with_capacity(all as usize);
        file.extend(b"glTF");
        file.extend(2_u32.to_le_bytes());
        file.extend(all.to_le_bytes());
        for (size, kind, chunk) in [(of_text, b"JSON", text), (of_bytes, b"BIN\0", self.bytes)] {
            file.extend(size.to_le_bytes());
            file.extend(kind);
            file.extend(chunk);
        }
        Ok(file)
    }
}

fn raw(value: &serde_json::Value) -> gltf_json::Extras {
    serde_json::value::RawValue::from_string(value.to_string()).ok()
}
