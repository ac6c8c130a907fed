//! What of a scene can be changed before the motion starts.

use dcb_formats::scene::{BodyKind, DampingOverride, ModalRatios, Scene};

/// A number of the scene that an importer may set before the start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// A component of gravity, world axes.
    Gravity(usize),
    /// The damping ratio of a body whose modes have one in common.
    DampingRatio(String),
    /// A constant of the scene's formulas.
    Constant(String),
    /// The inner step; of adaptive integration the first one.
    Step,
    /// Tolerance of the iteration.
    Tolerance,
    /// Tolerance of adaptive integration.
    AdaptiveTolerance,
}

/// First value references of parameters, of damping ratios and of constants.
const FIRST: [u32; 3] = [1_000, 2_000, 10_000];

impl Parameter {
    /// Those of a scene, in their order.
    pub fn of(scene: &Scene) -> Vec<Self> {
        let mut found: Vec<Self> = (0..scene.dimension.coordinate_count())
            .map(Self::Gravity)
            .collect();
        for (name, body) in scene.superelements() {
            if let Some(DampingOverride::Modal(ModalRatios::Uniform(_))) = body.damping {
                found.push(Self::DampingRatio(name.to_owned()));
            }
        }
        found.extend(scene.constants.keys().cloned().map(Self::Constant));
        found.extend([Self::Step, Self::Tolerance]);
        if scene.integrator.is_some_and(|used| used.adaptive.is_some()) {
            found.push(Self::AdaptiveTolerance);
        }
        found
    }

    /// Value references of parameters: each kind counts from a number of its own.
    pub(crate) fn references(parameters: &[Self]) -> Vec<u32> {
        let [fixed, mut ratio, mut constant] = FIRST;
        let next = |counter: &mut u32| {
            *counter += 1;
            *counter - 1
        };
        let reference = |parameter: &Self| match parameter {
            Self::Gravity(axis) => fixed + *axis as u32,
            Self::Step => fixed + 10,
            Self::Tolerance => fixed + 11,
            Self::AdaptiveTolerance => fixed + 12,
            Self::DampingRatio(_) => next(&mut ratio),
            Self::Constant(_) => next(&mut constant),
        };
        parameters.iter().map(reference).collect()
    }

    /// Name among the variables.
    pub fn name(&self) -> String {
        match self {
            Self::Gravity(axis) => format!("gravity.{}", ["x", "y", "z"][*axis]),
            Self::DampingRatio(body) => format!("damping.{body}"),
            Self::Constant(name) => format!("constants.{name}"),
            Self::Step => "integrator.step".into(),
            Self::Tolerance => "integrator.tolerance".into(),
            Self::AdaptiveTolerance => "integrator.adaptive_tolerance".into(),
        }
    }

    /// Unit; `1` where it has none.
    pub fn unit(&self, scene: &Scene) -> String {
        let (length, time) = (&scene.units.length, &scene.units.time);
        match self {
            Self::Gravity(_) => format!("{length}/{time}^2"),
            Self::Step => time.clone(),
            Self::DampingRatio(_)
            | Self::Constant(_)
            | Self::Tolerance
            | Self::AdaptiveTolerance => "1".into(),
        }
    }

    /// One sentence for people.
    pub fn description(&self) -> String {
        match self {
            Self::Gravity(_) => "acceleration of free fall, world axes".into(),
            Self::DampingRatio(body) => {
                format!("damping ratio of all modes of body {body:?} by itself")
            }
            Self::Constant(name) => format!("constant {name:?} of the formulas"),
            Self::Step => "inner step of the integrator; the first one if it is adaptive, the longest one of radau".into(),
            Self::Tolerance => {
                "error of the accelerations that the iteration may leave, relative; of radau the error of the motion".into()
            }
            Self::AdaptiveTolerance => {
                "error that an adaptive step may add to a position, relative to the bodies' size"
                    .into()
            }
        }
    }

    /// Its value in a scene.
    pub fn value(&self, scene: &Scene) -> f64 {
        let of_integrator = |value: fn(&dcb_formats::scene::Integrator) -> f64| {
            scene.integrator.as_ref().map_or(0.0, value)
        };
        match self {
            Self::Gravity(axis) => {
                let gravity = scene.gravity.as_deref().unwrap_or_default();
                gravity.get(*axis).copied().unwrap_or(0.0)
            }
            Self::DampingRatio(body) => match uniform_ratio(scene, body) {
                Some(ratio) => *ratio,
                None => 0.0,
            },
            Self::Constant(name) => scene.constants.get(name).copied().unwrap_or(0.0),
            Self::Step => of_integrator(|used| used.step),
            Self::Tolerance => of_integrator(|used| used.tolerance),
            Self::AdaptiveTolerance => {
                of_integrator(|used| used.adaptive.map_or(0.0, |adaptive| adaptive.tolerance))
            }
        }
    }

    /// Changes a scene; whether it can be used then, its own check says.
    pub fn set(&self, scene: &mut Scene, value: f64) {
        // What the file leaves out stays out.
        if self.value(scene) == value {
            return;
        }
        match self {
            Self::Gravity(axis) => {
                let count = scene.dimension.coordinate_count();
                let gravity = scene.gravity.get_or_insert_with(|| vec![0.0; count]);
                gravity[*axis] = value;
            }
            Self::DampingRatio(body) => {
                if let Some(BodyKind::Superelement(of)) =
                    scene.bodies.get_mut(body).map(|body| &mut body.kind)
                {
                    of.damping = Some(DampingOverride::Modal(ModalRatios::Uniform(value)));
                }
            }
            Self::Constant(name) => {
                scene.constants.insert(name.clone(), value);
                scene.name_constants();
            }
            Self::Step | Self::Tolerance | Self::AdaptiveTolerance => {
                let Some(used) = &mut scene.integrator else {
                    return;
                };
                match (self, &mut used.adaptive) {
                    (Self::Step, _) => used.step = value,
                    (Self::AdaptiveTolerance, Some(adaptive)) => adaptive.tolerance = value,
                    _ => used.tolerance = value,
                }
            }
        }
    }
}

fn uniform_ratio<'a>(scene: &'a Scene, body: &str) -> Option<&'a f64> {
    match &scene.bodies.get(body)?.kind {
        BodyKind::Superelement(of) => match &of.damping {
            Some(DampingOverride::Modal(ModalRatios::Uniform(ratio))) => Some(ratio),
            _ => None,
        },
        BodyKind::Rigid(_) => None,
    }
}
