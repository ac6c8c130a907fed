//! A cloud of particles on shapes: every inertia quantity as a sum over particles.

use dcb_formats::component::{InterfaceKind, Role, Units};
use dcb_formats::mesh::Dimension;
use dcb_formats::superelement::{BoundaryRow, Inertia, InterfaceFrame};
use dcb_runtime::{BodyAcceleration, BodyState, FlexibleBody, GeneralizedBody};
use faer::Mat;
use nalgebra::Vector3;

use super::numbers;

/// Particles with masses, places about their centre of mass, and shapes: particle i is displaced by Σ_k ψ_ik q_k.
pub struct Cloud {
    pub dimension: Dimension,
    pub masses: Vec<f64>,
    pub places: Vec<Vector3<f64>>,
    /// shapes[k][i].
    pub shapes: Vec<Vec<Vector3<f64>>>,
}

impl Cloud {
    /// Random particles and shapes.
    fn random(dimension: Dimension, count: usize) -> Self {
        let particles = 3 * count + 8;
        let flat = |v: Vector3<f64>| match dimension {
            Dimension::Planar => Vector3::new(v.x, v.y, 0.0),
            Dimension::Spatial => v,
        };
        let field = |seed: u64| -> Vec<Vector3<f64>> {
            numbers(3 * particles, seed)
                .chunks_exact(3)
                .map(|c| flat(Vector3::new(c[0], c[1], c[2])))
                .collect()
        };
        let masses: Vec<f64> = numbers(particles, 11).iter().map(|x| 1.2 + x).collect();
        let mut places = field(12);
        let total: f64 = masses.iter().sum();
        let center = masses
            .iter()
            .zip(&places)
            .fold(Vector3::zeros(), |sum, (m, r)| sum + *m * r)
            / total;
        places.iter_mut().for_each(|place| *place -= center);
        let shapes = (0..count).map(|k| field(20 + k as u64)).collect();
        Self {
            dimension,
            masses,
            places,
            shapes,
        }
    }

    /// Shapes with momentum: a frame that is not on mean axes.
    pub fn with_momentum(dimension: Dimension, count: usize) -> Self {
        Self::random(dimension, count)
    }

    /// Shapes orthogonal to all rigid motions.
    pub fn on_mean_axes(dimension: Dimension, count: usize) -> Self {
        let mut cloud = Self::random(dimension, count);
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let mut rigid: Vec<Vec<Vector3<f64>>> = axes[..dimension.coordinate_count()]
            .iter()
            .map(|axis| vec![*axis; cloud.masses.len()])
            .collect();
        let turns = match dimension {
            Dimension::Planar => &axes[2..],
            Dimension::Spatial => &axes[..],
        };
        rigid.extend(
            turns
                .iter()
                .map(|axis| cloud.places.iter().map(|r| axis.cross(r)).collect()),
        );
        // Gram and Schmidt, twice over for rounding.
        for end in 0..rigid.len() {
            for _ in 0..2 {
                for earlier in 0..end {
                    let (before, after) = rigid.split_at_mut(end);
                    remove(&cloud.masses, &before[earlier], &mut after[0]);
                }
            }
        }
        for shape in &mut cloud.shapes {
            for _ in 0..2 {
                rigid.iter().for_each(|r| remove(&cloud.masses, r, shape));
            }
        }
        cloud
    }

    pub fn inner(&self, f: impl Fn(usize) -> f64) -> f64 {
        (0..self.masses.len()).map(|i| self.masses[i] * f(i)).sum()
    }

    fn vector(&self, f: impl Fn(usize) -> Vector3<f64>) -> Vector3<f64> {
        (0..self.masses.len()).fold(Vector3::zeros(), |sum, i| sum + self.masses[i] * f(i))
    }

    /// The invariants over the shapes, by their definitions as sums over particles.
    pub fn inertia(&self) -> Inertia {
        let n = self.shapes.len();
        let unit = |a: usize| Vector3::from_fn(|i, _| f64::from(u8::from(i == a)));
        let (places, shapes) = (&self.places, &self.shapes);
        let l1: Vec<_> = shapes.iter().map(|s| self.vector(|i| s[i])).collect();
        let i3: Vec<_> = shapes
            .iter()
            .map(|s| self.vector(|i| places[i].cross(&s[i])))
            .collect();
        let crossed = |a: usize, field: &[Vector3<f64>], i: usize| unit(a).cross(&field[i]);
        let pair = |a: usize, b: usize, f: &[Vector3<f64>], g: &[Vector3<f64>]| {
            self.inner(|i| crossed(a, f, i).dot(&crossed(b, g, i)))
        };
        let i1 = shapes
            .iter()
            .map(|s| {
                let first = |a: usize, b: usize| pair(a, b, places, s) + pair(b, a, places, s);
                let half = match self.dimension {
                    Dimension::Planar => 0.5,
                    Dimension::Spatial => 1.0,
                };
                std::array::from_fn(|a| std::array::from_fn(|b| half * first(a, b)))
            })
            .collect();
        let l3 = |axis: usize| {
            Mat::from_fn(n, n, |k, l| {
                self.vector(|i| shapes[k][i].cross(&shapes[l][i]))[axis]
            })
        };
        let (rows, turns) = match self.dimension {
            Dimension::Planar => (2, vec![2]),
            Dimension::Spatial => (3, vec![0, 1, 2]),
        };
        let pairs: &[(usize, usize)] = match self.dimension {
            Dimension::Planar => &[],
            Dimension::Spatial => &[(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)],
        };
        Inertia {
            mass: self.masses.iter().sum(),
            tensor: std::array::from_fn(|a| std::array::from_fn(|b| pair(a, b, places, places))),
            l1: Mat::from_fn(rows, n, |a, k| l1[k][a]),
            i1,
            i3: Mat::from_fn(turns.len(), n, |a, k| i3[k][turns[a]]),
            l3: turns.iter().map(|axis| l3(*axis)).collect(),
            i2: pairs
                .iter()
                .map(|(a, b)| {
                    Mat::from_fn(n, n, |k, l| {
                        0.5 * (pair(*a, *b, &shapes[k], &shapes[l])
                            + pair(*b, *a, &shapes[k], &shapes[l]))
                    })
                })
                .collect(),
        }
    }

    pub fn generalized(&self) -> GeneralizedBody {
        let n = self.shapes.len();
        let mass = Mat::from_fn(n, n, |k, l| {
            self.inner(|i| self.shapes[k][i].dot(&self.shapes[l][i]))
        });
        let root = numbers(n * n, 31);
        let root = Mat::from_fn(n, n, |k, l| root[k * n + l]);
        let identity: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let d = self.dimension.coordinate_count();
        GeneralizedBody {
            name: "cloud".into(),
            units: Units {
                length: "m".into(),
                mass: "kg".into(),
                time: "s".into(),
            },
            dimension: self.dimension,
            origin: [0.0; 3],
            mass,
            stiffness: root.transpose() * &root,
            damping: vec![0.01, 0.02],
            inertia: self.inertia(),
            interfaces: vec![InterfaceFrame {
                name: "first".into(),
                kind: InterfaceKind::Rigid,
                role: Role::Attachment,
                position: self.places[0].into(),
                orientation: identity,
            }],
            rows: (0..d)
                .map(|direction| BoundaryRow {
                    interface: 0,
                    direction: direction as i64,
                    node: -1,
                    position: self.places[0].into(),
                })
                .collect(),
            interface_shapes: Mat::from_fn(d, n, |a, k| self.shapes[k][0][a]),
        }
    }

    pub fn body(&self) -> FlexibleBody {
        FlexibleBody::from_generalized(&self.generalized()).unwrap()
    }

    /// Σ_k ψ_ik q_k.
    pub fn field(&self, q: &[f64]) -> Vec<Vector3<f64>> {
        (0..self.masses.len())
            .map(|i| {
                let terms = self.shapes.iter().zip(q);
                terms.fold(Vector3::zeros(), |sum, (shape, q)| sum + shape[i] * *q)
            })
            .collect()
    }

    /// The shape of dynamic coordinate `k` of `body`.
    pub fn dynamic_shape(&self, body: &FlexibleBody, k: usize) -> Vec<Vector3<f64>> {
        let mut y = vec![0.0; body.coordinate_count()];
        y[k] = 1.0;
        self.field(&original(body, &y))
    }

    /// d'Alembert's sum over the particles: force, moment about the frame's origin, and forces on y; body axes.
    pub fn inertia_forces(
        &self,
        body: &FlexibleBody,
        state: &BodyState<'_>,
        acceleration: &BodyAcceleration<'_>,
    ) -> (Vector3<f64>, Vector3<f64>, Vec<f64>) {
        let [u, du, ddu] = [state.y, state.rates, acceleration.second_rates]
            .map(|x| self.field(&original(body, x)));
        let (w, dw) = (state.spin, acceleration.spin_rate);
        let arms: Vec<_> = self.places.iter().zip(&u).map(|(r, u)| r + u).collect();
        let felt: Vec<_> = (0..arms.len())
            .map(|i| {
                acceleration.origin
                    + dw.cross(&arms[i])
                    + w.cross(&w.cross(&arms[i]))
                    + 2.0 * w.cross(&du[i])
                    + ddu[i]
            })
            .collect();
        let elastic = (0..body.coordinate_count())
            .map(|k| {
                let shape = self.dynamic_shape(body, k);
                self.inner(|i| shape[i].dot(&felt[i]))
            })
            .collect();
        (
            self.vector(|i| felt[i]),
            self.vector(|i| arms[i].cross(&felt[i])),
            elastic,
        )
    }

    /// Kinetic energy, linear momentum and angular momentum about the frame's origin, summed over the particles.
    pub fn energy_and_momenta(
        &self,
        body: &FlexibleBody,
        velocity_body: &Vector3<f64>,
        state: &BodyState<'_>,
    ) -> (f64, Vector3<f64>, Vector3<f64>) {
        let [u, du] = [state.y, state.rates].map(|x| self.field(&original(body, x)));
        let arms: Vec<_> = self.places.iter().zip(&u).map(|(r, u)| r + u).collect();
        let v: Vec<_> = (0..arms.len())
            .map(|i| velocity_body + state.spin.cross(&arms[i]) + du[i])
            .collect();
        (
            0.5 * self.inner(|i| v[i].norm_squared()),
            self.vector(|i| v[i]),
            self.vector(|i| arms[i].cross(&v[i])),
        )
    }
}

pub fn original(body: &FlexibleBody, y: &[f64]) -> Vec<f64> {
    let mut q = vec![0.0; body.original_coordinate_count()];
    body.original_coordinates(y, &mut q);
    q
}

fn remove(masses: &[f64], direction: &[Vector3<f64>], field: &mut [Vector3<f64>]) {
    let product = |a: &[Vector3<f64>], b: &[Vector3<f64>]| -> f64 {
        (0..masses.len()).map(|i| masses[i] * a[i].dot(&b[i])).sum()
    };
    let factor = product(direction, field) / product(direction, direction);
    for (field, direction) in field.iter_mut().zip(direction) {
        *field -= factor * direction;
    }
}
