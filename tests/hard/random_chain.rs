//! Chains of rigid and flexible bodies made from a few numbers, and what they conserve, summed over the nodes of each body: the mass matrix
//! of the finite elements times the velocity of each node, with nothing of the reduced inertia.

use std::sync::Arc;

use dcb_formats::Component;
use dcb_formats::mesh::Dimension;
use dcb_runtime::force_law::{Characteristic, Law};
use dcb_runtime::integrator::Method;
use dcb_runtime::joint::{Cylindrical, Fixed, JointKind, Spherical};
use dcb_runtime::measure::{Elongation, Measure};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::Drawn;
use dcb_runtime::system::{State, System};
use dcb_runtime::{Compatibility, FlexibleBody};
use faer::Mat;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use dcb_tests::dense::dense;
use dcb_tests::lowest;
use dcb_tests::mechanism::{Scene, revolute, rigid};
use dcb_tests::nodal;

/// The softest coordinate of a flexible link, (rad/s)²: slow enough for every motion to be resolved by the steps.
const SOFTEST: f64 = 3600.0;

/// A chain, free or hung from the ground by a ball.
#[derive(Clone, Debug)]
pub struct Chain {
    /// A planar chain has rigid links only.
    pub dimension: Dimension,
    /// At least one.
    pub links: Vec<Link>,
    /// Stiffness of a spring between the ends of two links or more, and its free length as a share of the distance drawn.
    pub spring: Option<(f64, f64)>,
    /// m/s²; with gravity it hangs.
    pub gravity: Option<f64>,
}

/// A body and the joint to the one before.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its body.
    pub body: LinkBody,
    /// Rotation vector of its axes as drawn.
    pub turn: [f64; 3],
    /// Angular velocity as drawn, before the start makes it consistent.
    pub spin: [f64; 3],
    /// Joint at its first end.
    pub joint: LinkJoint,
    /// The joint's axis.
    pub axis: [f64; 3],
}

/// What a link is.
#[derive(Clone, Debug)]
pub enum LinkBody {
    /// A bar of 1 m with this mass, kg, and radii of gyration, m.
    Rigid(f64, [f64; 3]),
    /// A box of tetrahedra with this many modes beside its attachments.
    Flexible(usize),
}

/// How a link hangs on the one before.
#[derive(Clone, Copy, Debug)]
pub enum LinkJoint {
    /// All rotations free.
    Ball,
    /// One.
    Hinge,
    /// One and a translation along it.
    Sleeve,
    /// None.
    Weld,
}

/// The finite elements behind a body.
struct Nodes {
    component: Component,
    mass: Mat<f64>,
    /// From the centre of mass.
    positions: Vec<Vector3<f64>>,
    /// [Φ, G_res L_bᵀ T_r], (n_e, n_r).
    shapes: Mat<f64>,
}

/// What a body is for the sums.
enum Matter {
    Rigid { mass: f64, tensor: Matrix3<f64> },
    Flexible(Box<Nodes>),
}

/// A body, and its interfaces' places from the centre of mass.
struct Made {
    body: Arc<FlexibleBody>,
    matter: Matter,
    ends: [Vector3<f64>; 2],
}

impl LinkBody {
    fn make(&self, dimension: Dimension) -> Made {
        let (body, matter) = match self {
            Self::Rigid(mass, radii) => {
                // Moments of inertia of three lines of points: they satisfy the triangle inequality.
                let [x, y, z] = radii.map(|r| mass * r * r);
                let tensor = Matrix3::from_diagonal(&Vector3::new(y + z, x + z, x + y));
                let body = rigid(
                    dimension,
                    *mass,
                    tensor,
                    &[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]],
                );
                (
                    body,
                    Matter::Rigid {
                        mass: *mass,
                        tensor,
                    },
                )
            }
            Self::Flexible(modes) => flexible(*modes),
        };
        let ends = [0, 1].map(|end| body.attachment(end).expect("a frame").position);
        Made { body, matter, ends }
    }
}

fn flexible(modes: usize) -> (Arc<FlexibleBody>, Matter) {
    let component = dcb_samples::reference_tetrahedra();
    let reduced = lowest(&component, modes);
    let element = &reduced.superelement;
    let mut body = FlexibleBody::from_superelement(element, Compatibility::Strong)
        .expect("a superelement without stiffening");
    let count = body.stiffness.len() as f64;
    for (k, stiffness) in body.stiffness.iter_mut().enumerate() {
        *stiffness = SOFTEST * (1.0 + k as f64 / count);
    }
    let attached = &reduced.recovery.residual * &element.residual.transform;
    let phi = &reduced.recovery.modes;
    let n_k = phi.ncols();
    let nodes = Nodes {
        mass: dense(&component.mass),
        positions: nodal::positions(&component, element.origin),
        shapes: Mat::from_fn(phi.nrows(), n_k + attached.ncols(), |i, j| {
            if j < n_k {
                phi[(i, j)]
            } else {
                attached[(i, j - n_k)]
            }
        }),
        component,
    };
    (Arc::new(body), Matter::Flexible(Box::new(nodes)))
}

/// A chain in motion.
pub struct MovingChain {
    /// The run.
    pub simulation: Simulation,
    made: Vec<Made>,
    /// Stiffness and free length.
    spring: Option<(f64, f64)>,
    gravity: Vector3<f64>,
}

/// What a chain has at one time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// Linear momentum.
    pub linear: Vector3<f64>,
    /// Angular momentum about the world's origin, where a hung chain hangs.
    pub angular: Vector3<f64>,
    /// Kinetic energy.
    pub kinetic: f64,
    /// Of deflections, the spring and gravity.
    pub potential: f64,
}

impl Chain {
    /// Starts it as drawn, from the world's origin on.
    pub fn start(&self, method: Method) -> MovingChain {
        let gravity = Vector3::new(0.0, -self.gravity.unwrap_or(0.0), 0.0);
        let mut scene = Scene::new(self.dimension, gravity);
        let made: Vec<Made> = self
            .links
            .iter()
            .map(|link| link.body.make(self.dimension))
            .collect();
        let mut at = Vector3::zeros();
        let mut last = self.gravity.map(|_| scene.ground([0.0; 3]));
        let mut first = None;
        for (index, (link, made)) in self.links.iter().zip(&made).enumerate() {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::from(link.turn));
            // Drawn is the component's frame, from which the centre of mass is at the body's origin.
            let centre = at - turn * made.ends[0];
            let body = scene.body(
                &made.body,
                &Drawn {
                    position: centre - turn * Vector3::from(made.body.origin),
                    orientation: turn,
                    velocity: Vector3::zeros(),
                    angular_velocity: Vector3::from(link.spin),
                },
            );
            let start = scene.on(body, 0);
            first.get_or_insert(start);
            if let Some(before) = last {
                let kind = match (index, self.gravity) {
                    (0, Some(_)) => JointKind::Spherical(Spherical),
                    _ => link.joint.kind(self.dimension, link.axis),
                };
                scene.join(&kind, before, start);
            }
            last = Some(scene.on(body, 1));
            at = centre + turn * made.ends[1];
        }
        let (first, last) = (first.expect("a link"), last.expect("a link"));
        let springs = self.spring.filter(|_| self.links.len() > 1);
        let spring = springs.map(|(stiffness, share)| {
            let apart =
                scene.builder().frame(last).position - scene.builder().frame(first).position;
            let free = share * apart.norm();
            let law = Law::new(
                free,
                Characteristic::Linear { slope: stiffness },
                Characteristic::Linear { slope: 0.0 },
            );
            let measure = Measure::Elongation(Elongation { length: 1.0 });
            let laws = [(measure, law.expect("a finite law"))];
            scene.builder().spring("spring", first, last, laws);
            (stiffness, free)
        });
        let (simulation, _) = scene.start(method);
        MovingChain {
            simulation,
            made,
            spring,
            gravity,
        }
    }
}

impl LinkJoint {
    fn kind(self, dimension: Dimension, axis: [f64; 3]) -> JointKind {
        let axis = Vector3::from(axis);
        match (dimension, self) {
            (_, Self::Weld) => JointKind::Fixed(Fixed),
            (Dimension::Planar, _) => revolute(Vector3::z()),
            (_, Self::Ball) => JointKind::Spherical(Spherical),
            (_, Self::Hinge) => revolute(axis),
            (_, Self::Sleeve) => JointKind::Cylindrical(Cylindrical { axis, axis_b: None }),
        }
    }
}

impl MovingChain {
    /// Sums over everything that has mass, and the spring.
    pub fn sums(&self) -> Sums {
        let mut sums = Sums::default();
        let (system, state) = (self.simulation.system(), self.simulation.state());
        let mut ends = Vec::new();
        for (index, made) in self.made.iter().enumerate() {
            let body = &system.bodies[index];
            let y = &state.coordinates[body.coordinates.clone()];
            let motion = Motion::of(system, state, index);
            match &made.matter {
                Matter::Rigid { mass, tensor } => {
                    motion.add_rigid(*mass, tensor, &self.gravity, &mut sums);
                    ends.extend(made.ends.map(|end| motion.place(&end)));
                }
                Matter::Flexible(nodes) => {
                    let rates = &state.velocities[body.velocities.clone()][6..];
                    let strain = y.iter().zip(&made.body.stiffness);
                    sums.potential += strain.map(|(y, k)| 0.5 * k * y * y).sum::<f64>();
                    let deflected = nodes.add(&motion, y, rates, &self.gravity, &mut sums);
                    let interfaces = &nodes.component.interfaces;
                    let node = |end: usize| interfaces[end].nodes[0] as usize;
                    ends.extend([0, 1].map(|end| motion.place(&deflected[node(end)])));
                }
            }
        }
        if let Some((stiffness, free)) = self.spring {
            let length = (ends[ends.len() - 1] - ends[0]).norm();
            sums.potential += 0.5 * stiffness * (length - free).powi(2);
        }
        sums
    }

    /// Mass of all bodies.
    pub fn mass(&self) -> f64 {
        self.made.iter().map(|made| made.body.inertia.mass()).sum()
    }
}

/// Where a body's frame is, and how it moves; spin in body axes.
struct Motion {
    origin: Vector3<f64>,
    turn: UnitQuaternion<f64>,
    velocity: Vector3<f64>,
    spin: Vector3<f64>,
}

impl Motion {
    fn of(system: &System, state: &State, body: usize) -> Self {
        let rates = &state.velocities[system.bodies[body].velocities.clone()];
        Self {
            origin: state.origins[body],
            turn: state.orientations[body],
            velocity: Vector3::from_column_slice(&rates[..3]),
            spin: Vector3::from_column_slice(&rates[3..6]),
        }
    }

    /// A point of the body in the world.
    fn place(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.origin + self.turn * point
    }

    fn add_rigid(&self, mass: f64, tensor: &Matrix3<f64>, gravity: &Vector3<f64>, sums: &mut Sums) {
        let momentum = self.velocity * mass;
        sums.linear += momentum;
        sums.angular += self.origin.cross(&momentum) + self.turn * (tensor * self.spin);
        sums.kinetic +=
            0.5 * mass * self.velocity.norm_squared() + 0.5 * self.spin.dot(&(tensor * self.spin));
        sums.potential -= mass * gravity.dot(&self.origin);
    }
}

impl Nodes {
    /// Adds what the nodes have, and gives their places in the body frame.
    fn add(
        &self,
        motion: &Motion,
        y: &[f64],
        rates: &[f64],
        gravity: &Vector3<f64>,
        sums: &mut Sums,
    ) -> Vec<Vector3<f64>> {
        let field = |q: &[f64]| {
            let amounts = Mat::from_fn(q.len(), 1, |i, _| q[i]);
            nodal::vectors(&self.component, (&self.shapes * amounts).as_ref())
        };
        let times_mass = |field: &[Vector3<f64>]| {
            let product = &self.mass * nodal::column(&self.component, field);
            nodal::vectors(&self.component, product.as_ref())
        };
        let (u, u_rate) = (field(y), field(rates));
        let places: Vec<_> = self.positions.iter().zip(&u).map(|(x, u)| x + u).collect();
        let velocity = motion.turn.inverse() * motion.velocity;
        let velocities: Vec<_> = places
            .iter()
            .zip(&u_rate)
            .map(|(x, u_rate)| velocity + motion.spin.cross(x) + u_rate)
            .collect();
        let momenta = times_mass(&velocities);
        let worlds: Vec<_> = places.iter().map(|x| motion.place(x)).collect();
        for ((momentum, velocity), world) in momenta.iter().zip(&velocities).zip(&worlds) {
            let turned = motion.turn * momentum;
            sums.linear += turned;
            sums.angular += world.cross(&turned);
            sums.kinetic += 0.5 * velocity.dot(momentum);
        }
        let weights = times_mass(&worlds);
        sums.potential -= weights
            .iter()
            .map(|moment| gravity.dot(moment))
            .sum::<f64>();
        places
    }
}
