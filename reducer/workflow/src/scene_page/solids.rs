//! What the scene says that bodies and the ground look like.

use std::collections::HashMap;
use std::path::PathBuf;

use dcb_formats::scene::{Geometry, GeometryKind, Scene};
use dcb_runtime::error::Error;
use dcb_view::{Array, Arrays, Form, Solid, Triangles};
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

/// Solids of all bodies; files are read once.
pub struct Solids<'a> {
    scene: &'a Scene,
    files: HashMap<(PathBuf, u64), Drawn>,
}

/// Triangles in the page, and the box around them.
#[derive(Clone, Copy)]
struct Drawn {
    positions: Array,
    cells: Array,
    limits: [Vector3<f64>; 2],
}

/// Solids of one body, and corners of the boxes around them.
#[derive(Default)]
pub struct SolidsOfBody {
    pub solids: Vec<Solid>,
    pub corners: Vec<Vector3<f64>>,
}

impl<'a> Solids<'a> {
    pub fn of(scene: &'a Scene) -> Self {
        Self {
            scene,
            files: HashMap::new(),
        }
    }

    /// The solids of a geometry. `origin` is that of the body's frame in its component.
    pub fn of_body(
        &mut self,
        geometry: &[Geometry],
        origin: Vector3<f64>,
        arrays: &mut Arrays,
    ) -> Result<SolidsOfBody, Error> {
        let mut found = SolidsOfBody::default();
        for one in geometry {
            let placement = one.placement();
            let (mut position, mut turn) = (placement.position, placement.orientation);
            let (form, limits) = match &one.kind {
                GeometryKind::Box(sides) => {
                    let half = 0.5 * Vector3::from(*sides);
                    (Form::Box { sides: *sides }, [-half, half])
                }
                GeometryKind::Cylinder(cylinder) => {
                    let mut length = cylinder.length.unwrap_or_default();
                    if let Some([from, to]) = cylinder.ends() {
                        length = (to - from).norm();
                        position += turn * (0.5 * (from + to));
                        turn *= onto(to - from);
                    }
                    let radius = cylinder.radius;
                    let half = Vector3::new(radius, radius, 0.5 * length);
                    (Form::Cylinder { radius, length }, [-half, half])
                }
                GeometryKind::Sphere(sphere) => {
                    let half = Vector3::repeat(sphere.radius);
                    let form = Form::Sphere {
                        radius: sphere.radius,
                    };
                    (form, [-half, half])
                }
                GeometryKind::File { file, scale } => {
                    let drawn = self.file(self.scene.resolve(file), *scale, arrays)?;
                    let form = Form::Mesh {
                        positions: drawn.positions,
                        cells: drawn.cells,
                    };
                    (form, drawn.limits)
                }
            };
            position -= origin;
            found.corners.extend((0..8_usize).map(|corner| {
                position + turn * Vector3::from_fn(|axis, _| limits[(corner >> axis) & 1][axis])
            }));
            found.solids.push(Solid {
                form,
                position: position.into(),
                turn: [turn.w, turn.i, turn.j, turn.k],
                color: one.color.clone(),
            });
        }
        Ok(found)
    }

    fn file(&mut self, path: PathBuf, scale: f64, arrays: &mut Arrays) -> Result<Drawn, Error> {
        let key = (path, scale.to_bits());
        if let Some(known) = self.files.get(&key) {
            return Ok(*known);
        }
        if !key.0.exists() {
            return Err(Error::from(dcb_formats::Error::File {
                path: key.0,
                message: "is not there, and a `geometry` of the scene draws it; put it there, or correct the path in the scene".into(),
            }));
        }
        let triangles = Triangles::read(&key.0)?;
        let places = triangles.positions.iter();
        let places: Vec<Vector3<f64>> = places.map(|at| scale * Vector3::from(*at)).collect();
        let start = [Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN)];
        let drawn = Drawn {
            positions: arrays.reals(places.iter().flat_map(|at| [at.x, at.y, at.z])),
            cells: arrays.indices(triangles.cells.iter().copied()),
            limits: places
                .iter()
                .fold(start, |[low, high], at| [low.inf(at), high.sup(at)]),
        };
        self.files.insert(key, drawn);
        Ok(drawn)
    }
}

/// The shortest turn of z onto a direction.
fn onto(direction: Vector3<f64>) -> UnitQuaternion<f64> {
    let half_turn = UnitQuaternion::from_quaternion(Quaternion::new(0.0, 1.0, 0.0, 0.0));
    let z = Vector3::z_axis();
    UnitQuaternion::rotation_between_axis(&z, &Unit::new_normalize(direction)).unwrap_or(half_turn)
}
