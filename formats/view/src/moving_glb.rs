//! A page's motion as binary glTF 2.0, for slides and viewers: one node a body that moves and turns, its mesh with the same patterns as morph targets, and their amplitudes
//! as weights over time.
//!
//! Lengths are metres, times seconds, y is up, as glTF wants them. Numbers are single precision: pictures, not data.

use std::collections::BTreeMap;

use dcb_formats::units::si_factor;
use gltf_json::accessor::Type;
use gltf_json::animation::{Animation, Channel, Interpolation, Property, Sampler, Target};
use gltf_json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use gltf_json::scene::UnitQuaternion as Turn;
use gltf_json::validation::Checked::Valid;
use gltf_json::{Accessor, Index, Material, Mesh, Node, Scene};
use nalgebra::{UnitQuaternion, Vector3};
use serde_json::json;

use crate::arrays::Arrays;
use crate::description::{Body, Description};
use crate::glb::{Glb, extras};
use crate::page::MovingPage;
use crate::shape::Shape;
use crate::solid_triangles::triangles_of;

/// Colours of bodies in their order.
const COLOURS: [&str; 6] = [
    "#4f86c6", "#d98c3f", "#5ba56b", "#a56bb5", "#c6645c", "#7b8794",
];

impl MovingPage {
    /// The motion as a `.glb` file.
    ///
    /// # Errors
    /// A sentence about what can't be written.
    pub fn glb(&self) -> Result<Vec<u8>, String> {
        let page = &self.description;
        let mut film = Film::of(page, &self.arrays);
        let shapes = page.shapes.iter();
        let shapes: Vec<MorphedMesh> = shapes.map(|shape| film.shape(shape)).collect();
        let mut nodes = Vec::new();
        for (index, body) in page.bodies.iter().enumerate() {
            nodes.push(film.body(index, body, &shapes));
        }
        film.scene(nodes);
        film.glb.finish(
            "dual Craig-Bampton, simulate animate",
            &format!("a run of {}", page.title),
        )
    }
}

/// A mesh's numbers in the file; each body has them with a material of its own.
struct MorphedMesh {
    name: String,
    primitive: Option<Primitive>,
    targets: usize,
    names: Vec<String>,
}

/// The file while it grows.
struct Film<'a> {
    page: &'a Description,
    arrays: &'a Arrays,
    glb: Glb,
    metre: f64,
    /// Times that are later than those before, by their numbers.
    frames: Vec<usize>,
    input: Option<Index<Accessor>>,
    animation: Animation,
}

impl<'a> Film<'a> {
    fn of(page: &'a Description, arrays: &'a Arrays) -> Self {
        let unit = |key: &str| page.units[key].as_str().and_then(si_factor).unwrap_or(1.0);
        let (metre, second) = (unit("length"), unit("time"));
        let times = arrays.reals_of(page.times);
        let first = times.first().copied().unwrap_or_default();
        let times = times.iter().map(|time| ((time - first) * second) as f32);
        let times: Vec<f32> = times.collect();
        let mut frames: Vec<usize> = Vec::new();
        for (index, time) in times.iter().enumerate() {
            if frames.last().is_none_or(|last| times[*last] < *time) {
                frames.push(index);
            }
        }
        let mut glb = Glb::default();
        let kept: Vec<f32> = frames.iter().map(|frame| times[*frame]).collect();
        let input = (kept.len() > 1).then(|| glb.times(&kept));
        Self {
            page,
            arrays,
            glb,
            metre,
            frames,
            input,
            animation: Animation {
                extensions: None,
                extras: None,
                name: Some(page.title.clone()),
                channels: Vec::new(),
                samplers: Vec::new(),
            },
        }
    }

    fn shape(&mut self, shape: &Shape) -> MorphedMesh {
        let scaled = |at: [f64; 3], scale: f64| at.map(|value| scale * value);
        let places = self.arrays.vectors_of(shape.positions);
        let places: Vec<[f64; 3]> = places.iter().map(|at| scaled(*at, self.metre)).collect();
        let cells = self.arrays.indices_of(shape.cells);
        let mut targets = Vec::new();
        if !cells.is_empty() {
            for column in &shape.columns {
                let moved = self.arrays.vectors_of(column.values);
                let scale = column.scale * self.metre;
                let moved: Vec<[f64; 3]> = moved.iter().map(|at| scaled(*at, scale)).collect();
                targets.push(MorphTarget {
                    positions: Some(self.glb.vectors(&moved)),
                    normals: None,
                    tangents: None,
                });
            }
        }
        let mode = match shape.corners {
            3 => Mode::Triangles,
            2 => Mode::Lines,
            _ => Mode::Points,
        };
        let count = targets.len();
        MorphedMesh {
            name: shape.name.clone(),
            primitive: (!cells.is_empty()).then(|| self.primitive(&places, &cells, mode, targets)),
            targets: count,
            names: shape
                .columns
                .iter()
                .map(|column| column.name.clone())
                .collect(),
        }
    }

    fn primitive(
        &mut self,
        places: &[[f64; 3]],
        cells: &[u32],
        mode: Mode,
        targets: Vec<MorphTarget>,
    ) -> Primitive {
        let positions = self.glb.vectors(places);
        Primitive {
            attributes: BTreeMap::from([(Valid(Semantic::Positions), positions)]),
            extensions: None,
            extras: None,
            indices: Some(self.glb.places(cells)),
            material: None,
            mode: Valid(mode),
            targets: (!targets.is_empty()).then_some(targets),
        }
    }

    fn body(&mut self, index: usize, body: &Body, shapes: &[MorphedMesh]) -> Index<Node> {
        let colour = COLOURS[index % COLOURS.len()];
        let own = self.material(colour);
        let mut children = Vec::new();
        for solid in &body.solids {
            let triangles = triangles_of(&solid.form, self.page.size, self.arrays);
            let places = triangles.positions.iter();
            let places: Vec<[f64; 3]> = places
                .map(|at| at.map(|value| self.metre * value))
                .collect();
            let mut primitive =
                self.primitive(&places, &triangles.cells, Mode::Triangles, Vec::new());
            primitive.material = Some(match &solid.color {
                Some(color) => self.material(color),
                None => own,
            });
            let mesh = self.mesh(&body.name, primitive, 0, &[]);
            let [w, i, j, k] = solid.turn;
            children.push(self.glb.root.push(Node {
                mesh: Some(mesh),
                translation: Some(solid.position.map(|value| (self.metre * value) as f32)),
                rotation: Some(turn([w, i, j, k])),
                ..Node::default()
            }));
        }
        let mut node = Node {
            name: Some(body.name.clone()),
            children: (!children.is_empty()).then_some(children),
            translation: Some([0, 1, 2].map(|axis| (self.metre * body.rest[axis]) as f32)),
            rotation: Some(turn([3, 4, 5, 6].map(|index| body.rest[index]))),
            ..Node::default()
        };
        let shape = body.shape.map(|shape| &shapes[shape]);
        let mut targets = 0;
        if let Some((shape, primitive)) = shape.and_then(|one| Some((one, one.primitive.clone()?)))
        {
            let primitive = Primitive {
                material: Some(own),
                ..primitive
            };
            targets = shape.targets;
            node.mesh = Some(self.mesh(&shape.name, primitive, targets, &shape.names));
        }
        let node = self.glb.root.push(node);
        self.motion(node, body, targets);
        node
    }

    fn mesh(
        &mut self,
        name: &str,
        primitive: Primitive,
        targets: usize,
        names: &[String],
    ) -> Index<Mesh> {
        self.glb.root.push(Mesh {
            extensions: None,
            extras: match targets {
                0 => None,
                _ => extras(&json!({ "targetNames": names })),
            },
            name: Some(name.to_owned()),
            primitives: vec![primitive],
            weights: (targets > 0).then(|| vec![0.0; targets]),
        })
    }

    /// Where the body is and how it deflects, frame after frame.
    fn motion(&mut self, node: Index<Node>, body: &Body, targets: usize) {
        let (Some(frames), Some(input)) = (body.frames, self.input) else {
            return;
        };
        let frames = self.arrays.reals_of(frames);
        let count = self.frames.len();
        let kept = self
            .frames
            .iter()
            .filter_map(|k| frames.get(7 * k..7 * k + 7));
        let mut places = Vec::with_capacity(3 * count);
        let mut turns = Vec::with_capacity(4 * count);
        for frame in kept {
            places.extend([0, 1, 2].map(|axis| (self.metre * frame[axis]) as f32));
            turns.extend(turn([3, 4, 5, 6].map(|index| frame[index])).0);
        }
        let places = self.glb.reals(&places, Type::Vec3, count);
        self.channel(node, input, places, Property::Translation);
        let turns = self.glb.reals(&turns, Type::Vec4, count);
        self.channel(node, input, turns, Property::Rotation);
        let Some(amplitudes) = body.amplitudes.filter(|_| targets > 0) else {
            return;
        };
        let amplitudes = self.arrays.reals_of(amplitudes);
        let kept = self.frames.iter();
        let kept = kept.filter_map(|k| amplitudes.get(targets * k..targets * (k + 1)));
        let weights: Vec<f32> = kept.flatten().map(|value| *value as f32).collect();
        let weights = self.glb.reals(&weights, Type::Scalar, targets * count);
        self.channel(node, input, weights, Property::MorphTargetWeights);
    }

    fn channel(
        &mut self,
        node: Index<Node>,
        input: Index<Accessor>,
        output: Index<Accessor>,
        path: Property,
    ) {
        let sampler = Index::new(self.animation.samplers.len() as u32);
        self.animation.samplers.push(Sampler {
            extensions: None,
            extras: None,
            input,
            interpolation: Valid(Interpolation::Linear),
            output,
        });
        self.animation.channels.push(Channel {
            sampler,
            target: Target {
                extensions: None,
                extras: None,
                node,
                path: Valid(path),
            },
            extensions: None,
            extras: None,
        });
    }

    fn material(&mut self, colour: &str) -> Index<Material> {
        self.glb.root.push(Material {
            double_sided: true,
            name: Some(colour.to_owned()),
            pbr_metallic_roughness: PbrMetallicRoughness {
                base_color_factor: PbrBaseColorFactor(linear(colour)),
                metallic_factor: StrengthFactor(0.1),
                roughness_factor: StrengthFactor(0.7),
                ..PbrMetallicRoughness::default()
            },
            ..Material::default()
        })
    }

    /// All bodies under a node that turns what is up into y.
    fn scene(&mut self, bodies: Vec<Index<Node>>) {
        let up = Vector3::from(self.page.up);
        let upright = UnitQuaternion::rotation_between(&up, &Vector3::y());
        let upright = upright.unwrap_or_else(|| {
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
        });
        let root = self.glb.root.push(Node {
            name: Some(self.page.title.clone()),
            children: (!bodies.is_empty()).then_some(bodies),
            rotation: Some(turn([upright.w, upright.i, upright.j, upright.k])),
            ..Node::default()
        });
        let scene = self.glb.root.push(Scene {
            extensions: None,
            extras: None,
            name: None,
            nodes: vec![root],
        });
        self.glb.root.scene = Some(scene);
        let animation = &mut self.animation;
        if !animation.channels.is_empty() {
            let whole = Animation {
                extensions: None,
                extras: None,
                name: animation.name.take(),
                channels: std::mem::take(&mut animation.channels),
                samplers: std::mem::take(&mut animation.samplers),
            };
            self.glb.root.animations.push(whole);
        }
    }
}

/// `[w, x, y, z]` as glTF wants it, of length 1 in single precision.
fn turn([w, x, y, z]: [f64; 4]) -> Turn {
    let length = (w * w + x * x + y * y + z * z).sqrt();
    match length > 0.0 {
        true => Turn([x, y, z, w].map(|value| (value / length) as f32)),
        false => Turn([0.0, 0.0, 0.0, 1.0]),
    }
}

/// A colour `#rrggbb` in linear shares, opaque.
fn linear(colour: &str) -> [f32; 4] {
    let share = |from: usize| {
        let digits = colour.get(from..from + 2).unwrap_or("80");
        let value = f32::from(u8::from_str_radix(digits, 16).unwrap_or(128)) / 255.0;
        match value <= 0.04045 {
            true => value / 12.92,
            false => ((value + 0.055) / 1.055).powf(2.4),
        }
    };
    [share(1), share(3), share(5), 1.0]
}
