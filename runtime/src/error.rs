//! Why a body can't be used, or a motion can't be continued.

use std::path::{Path, PathBuf};

/// Errors: the finding, and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The superelement's file can't be used.
    #[error(transparent)]
    File(dcb_formats::Error),
    /// A file can't be written.
    #[error("{}: cannot write: {source}", path.display())]
    CannotWrite {
        /// File or folder.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// Nodal fields, mesh and body don't belong together, or a picture of them isn't possible.
    #[error("body {body:?}: {message}")]
    Field {
        /// Name of the body.
        body: String,
        /// Found and expected.
        message: String,
    },
    /// There is nothing to show.
    #[error("{}: {message}", path.display())]
    NothingToShow {
        /// The file that would have shown it.
        path: PathBuf,
        /// Missing part.
        message: String,
    },
    /// The superelement has something that the dynamics doesn't handle.
    #[error("body {body:?}: {what}; {remedy}")]
    NotHandled {
        /// Name of the body.
        body: String,
        /// Value found.
        what: &'static str,
        /// Remedy.
        remedy: &'static str,
    },
    /// Nothing of the kind follows from the superelement.
    #[error(transparent)]
    Superelement(#[from] dcb_superelement::Error),
    /// The frame is called mean-axis, but the basis has momentum in it.
    #[error(
        "body {body:?}: {quantity} of the basis is {found:.1e} of a rigid motion's, but a mean-axis frame allows {limit:.0e}; reduce the component again"
    )]
    NotMeanAxis {
        /// Name of the body.
        body: String,
        /// `L1` or `I3`.
        quantity: &'static str,
        /// The largest cosine between a rigid motion and a column of the basis.
        found: f64,
        /// The largest allowed.
        limit: f64,
    },
    /// The mass matrix is not positive definite at this deflection.
    #[error(
        "the rotary inertia left after eliminating the deflection is not positive ({inertia:.3e}): the deflection is far beyond what linear elasticity describes"
    )]
    InertiaNotPositive {
        /// The smallest diagonal entry of `J - L Lᵀ`.
        inertia: f64,
    },
    /// Accelerations were asked for in a closed form that the body doesn't have.
    #[error("no closed form for the accelerations of this body: {what}")]
    NoClosedForm {
        /// Property of the body beyond it.
        what: &'static str,
    },
    /// A quantity of a body made in memory has to be positive and isn't.
    #[error("body {body:?}: {quantity} has to be {required}, but {found:.3e} was found in it")]
    NotPositive {
        /// Name of the body.
        body: String,
        /// Kind.
        quantity: &'static str,
        /// `positive`, or a weaker demand.
        required: &'static str,
        /// The offending value: an eigenvalue of a matrix.
        found: f64,
    },
    /// Arrays of a body made in memory don't fit each other.
    #[error(
        "body {body:?}: {quantity} has {found:?} rows and columns, but {expected:?} are needed"
    )]
    Shape {
        /// Name of the body.
        body: String,
        /// Which array.
        quantity: &'static str,
        /// Rows and columns found.
        found: (usize, usize),
        /// Rows and columns needed.
        expected: (usize, usize),
    },
    /// An interface doesn't say how a frame moves.
    #[error(
        "body {body:?}: interface {interface:?} is of kind `{kind}` and has no frame that a joint or a load could act on; make it `average` or `rigid`"
    )]
    NoFrame {
        /// Name of the body.
        body: String,
        /// Name of the interface.
        interface: String,
        /// Its kind.
        kind: &'static str,
    },
    /// Memory is short.
    #[error("out of memory while setting up the system; use fewer bodies or modes")]
    OutOfMemory,
    /// A body's part of the equations is singular.
    #[error(
        "t = {time:.6e}: the equations of body {body:?} are singular; check its mass and inertia, and take a smaller step"
    )]
    SingularBody {
        /// When.
        time: f64,
        /// Which.
        body: String,
    },
    /// The joints' equations are singular.
    #[error(
        "t = {time:.6e}: the joints' equations are singular; constraints contradict or repeat each other, or the mechanism is at a dead centre"
    )]
    SingularJoints {
        /// When.
        time: f64,
    },
    /// A motion became infinite or undefined.
    #[error("t = {time:.6e}: the motion of body {body:?} is not finite; take a smaller step")]
    NotFinite {
        /// When.
        time: f64,
        /// Where it was largest.
        body: String,
    },
    /// A function of time has no value.
    #[error("t = {time:.6e}: the function of {name:?} is {found}; it must be finite until the end")]
    FunctionNotFinite {
        /// When.
        time: f64,
        /// The drive or load that follows it.
        name: String,
        /// Kind there.
        found: f64,
    },
    /// Newton's iteration did not converge.
    #[error(
        "t = {time:.6e}: no convergence in {iterations} iterations; the last correction was {residual:.2e}, allowed is {tolerance:.2e}, largest at body {worst:?}; take a smaller step"
    )]
    NotConverged {
        /// When.
        time: f64,
        /// Iterations made.
        iterations: usize,
        /// Size of the last correction, a length.
        residual: f64,
        /// Tolerance.
        tolerance: f64,
        /// The body with the largest correction.
        worst: String,
    },
    /// An eigenvalue or singular value computation did not converge.
    #[error(
        "no eigenvalues or free directions: the mechanism's matrices are not finite or too badly scaled; check masses, stiffnesses and units"
    )]
    NoEigenvalues,
    /// A frequency response at an undamped resonance.
    #[error(
        "the response at the frequency {frequency:.9} isn't finite: an undamped resonance lies there; give damping (\"damping\": {{\"structural\": 0.01}}), or another frequency"
    )]
    Resonant {
        /// Cycles per time.
        frequency: f64,
    },
    /// No static equilibrium was found.
    #[error(
        "t = {time:.6e}: no static equilibrium in {iterations} iterations; the last correction was {residual:.2e}, allowed is {tolerance:.2e}, largest at body {body:?}; joint or spring {connection:?} carries most; hold bodies that can drift away (\"analysis\": \"inertia_relief\" lets loads accelerate them), or start nearer to the rest"
    )]
    NoEquilibrium {
        /// When.
        time: f64,
        /// Iterations made.
        iterations: usize,
        /// Size of the last correction, a length.
        residual: f64,
        /// Tolerance.
        tolerance: f64,
        /// The body with the largest correction.
        body: String,
        /// The joint or spring with the largest force.
        connection: String,
    },
    /// A mechanism isn't moved by its drives alone.
    #[error(
        "{count} degrees of freedom are left to dynamics beside the drives; drive as many joint coordinates more, or run the dynamics"
    )]
    NotDriven {
        /// Degrees of freedom left.
        count: usize,
    },
    /// Steps had to become too small.
    #[error(
        "t = {time:.6e}: the error of a step is {error:.2e} times the allowed one even at the smallest step, {smallest:.2e}; look for a jump in a drive or load, raise the tolerance, or lower `minimum_step`"
    )]
    StepTooSmall {
        /// When.
        time: f64,
        /// The smallest step allowed.
        smallest: f64,
        /// Estimated error of the last attempt, relative to the tolerance; infinite if it failed altogether.
        error: f64,
    },
    /// A step beyond the next sample.
    #[error(
        "t = {time:.6e}: a step of {step:.6e} would pass the sample of a controller or servo at {sample:.6e}; steps must end there"
    )]
    PassesSample {
        /// When.
        time: f64,
        /// The step.
        step: f64,
        /// Time of the sample.
        sample: f64,
    },
    /// Steps that follow nothing of a motion.
    #[error(
        "t = {time:.6e}: steps of {step:.2e} are too long: a period of the motion of body {body:?} takes only {steps_per_period:.1} of them; take steps below {advised:.1e}"
    )]
    StepTooLong {
        /// When.
        time: f64,
        /// Which body.
        body: String,
        /// Steps in a period of its motion.
        steps_per_period: f64,
        /// The step.
        step: f64,
        /// A step that would follow the motion.
        advised: f64,
    },
    /// A joint whose angle is counted turns too far in one step.
    #[error(
        "t = {time:.6e}: {b:?} turns by {turn:.2} rad against {a:?} in one step; the angle between them is counted, which needs less than half a turn (3.14 rad) in a step; take a smaller step"
    )]
    LongTurn {
        /// When.
        time: f64,
        /// First body.
        a: String,
        /// Second body.
        b: String,
        /// Turn in the step, rad.
        turn: f64,
    },
    /// The joints can't be closed.
    #[error(
        "joint {joint:?} can't be closed: it stays open by {misfit:.3e} (allowed {allowed:.1e}); check the positions, lengths and drives"
    )]
    CannotAssemble {
        /// The joint or drive that is furthest from closed.
        joint: String,
        /// By how much, length or rad.
        misfit: f64,
        /// Allowed.
        allowed: f64,
    },
    /// Redundant constraints where they are refused.
    #[error(
        "constraints are redundant: {}; free a direction, or allow it with \"redundant_constraints\": \"minimum-norm\"",
        joints.join(", ")
    )]
    Redundant {
        /// Joints and drives that repeat what others hold.
        joints: Vec<String>,
    },
    /// Weak compatibility with a step at which the integrator follows its growing motions.
    #[error(
        "body {body:?}: weak compatibility has motions that grow at a rate of {sigma_min:.3e} or faster, and a step of {step:.3e} lets them grow (in the scene's unit of time); take steps above {smallest_step:.3e}, or strong or static compatibility"
    )]
    WeakUnstable {
        /// Name of the body.
        body: String,
        /// The slowest growth, 1/time.
        sigma_min: f64,
        /// The step asked for.
        step: f64,
        /// The smallest step at which the growth is damped.
        smallest_step: f64,
    },
    /// A constraint is violated although the iteration converged: redundant constraints that contradict each other.
    #[error(
        "t = {time:.6e}: {joint:?} is violated by {misfit:.3e} {unit}: it contradicts the other constraints; remove one of them"
    )]
    Contradiction {
        /// When.
        time: f64,
        /// The joint or drive.
        joint: String,
        /// By how much.
        misfit: f64,
        /// `rad`, or the unit of length.
        unit: String,
    },
    /// Drives that together ask for what the joints don't allow, so that flexible bodies deflect beyond the theory.
    #[error(
        "t = {time:.6e}: drives {} contradict each other: the joints don't allow what they ask for together, and {what} to follow them; give functions that fit each other, or leave one drive out",
        drives.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ")
    )]
    DrivesContradict {
        /// When.
        time: f64,
        /// The drives.
        drives: Vec<String>,
        /// Which body gives way, by how much, and how much the theory allows.
        what: String,
    },
    /// A number from the calling program can't be used.
    #[error("{quantity} is {found}; give {expected}")]
    BadNumber {
        /// Purpose.
        quantity: String,
        /// As given.
        found: f64,
        /// Expected value.
        expected: &'static str,
    },
    /// A saved state has other sizes than the mechanism that is to go on from it.
    #[error("the saved state is of another mechanism; restore it where the same scene was started")]
    ForeignSnapshot,
    /// Nothing that is recorded has this name.
    #[error("nothing recorded is called {name:?}{hint}")]
    UnknownOutput {
        /// As given.
        name: String,
        /// The nearest name, or those that there are.
        hint: String,
    },
    /// The output would overwrite an input.
    #[error("{}: is {role}, which writing there would destroy; name another file", path.display())]
    WouldDestroyInput {
        /// The file.
        path: PathBuf,
        /// Its role in this run.
        role: &'static str,
    },
    /// No input has this name.
    #[error("there is no input {name:?}; {}", if known.is_empty() { "the scene has none".to_owned() } else { format!("known are {}", known.join(", ")) })]
    UnknownInput {
        /// As given.
        name: String,
        /// Inputs of the scene.
        known: Vec<String>,
    },
    /// A direction of a joint is zero or not finite.
    #[error(
        "{joint} joint: `{quantity}` = {found:?} is no direction; give a finite vector that isn't zero"
    )]
    NoDirection {
        /// Kind of the joint.
        joint: &'static str,
        /// Which direction.
        quantity: &'static str,
        /// As given.
        found: [f64; 3],
    },
    /// A direction of a joint doesn't fit a planar scene.
    #[error("{joint} joint: `{quantity}` = {found:?}, but in a planar scene it must be {expected}")]
    DirectionNotInPlane {
        /// Kind of the joint.
        joint: &'static str,
        /// Which direction.
        quantity: &'static str,
        /// As given.
        found: [f64; 3],
        /// Expected value.
        expected: &'static str,
    },
    /// Axes that must be perpendicular are not.
    #[error(
        "{joint} joint: `axis_a` and `axis_b` must be perpendicular as drawn, but the cosine between them is {cosine:.1e} (limit {limit:.0e}); correct the axes or the placement"
    )]
    AxesNotPerpendicular {
        /// Kind of the joint.
        joint: &'static str,
        /// Cosine between the axes as drawn.
        cosine: f64,
        /// Largest allowed.
        limit: f64,
    },
    /// Axes that must be parallel are far from it.
    #[error(
        "{joint} joint: `{quantity}` is drawn {degrees:.0}° away from the axis of the first frame that it is to be parallel to; correct it or the placement, or leave it out"
    )]
    AxesApart {
        /// Kind of the joint.
        joint: &'static str,
        /// The direction given for the second frame.
        quantity: &'static str,
        /// Angle between the axes as drawn.
        degrees: f64,
    },
    /// A length of a joint is not one.
    #[error("{joint} joint: `{quantity}` = {found}; give a finite length above zero")]
    LengthNotPositive {
        /// Kind of the joint.
        joint: &'static str,
        /// Which length.
        quantity: &'static str,
        /// As given.
        found: f64,
    },
    /// The joint has no meaning in a planar scene.
    #[error(
        "a {joint} joint has no meaning in a planar scene; use fixed, revolute, prismatic, spherical, point-on-line or distance"
    )]
    NotInPlane {
        /// Kind of the joint.
        joint: &'static str,
    },
    /// A number of a force law is not finite.
    #[error("force law: {quantity} is {found}; give a finite number")]
    LawNotFinite {
        /// Which number.
        quantity: &'static str,
        /// As given.
        found: f64,
    },
    /// A tabulated law has too few points for a line.
    #[error("force law: a table of {count} points; give two or more")]
    TableTooShort {
        /// Number of points.
        count: usize,
    },
    /// The abscissae of a table don't increase.
    #[error(
        "force law: point {index} of the table, counted from 0, is at {found}, not beyond the one before at {previous}; put the points in order, each once"
    )]
    TableNotIncreasing {
        /// Position of the point.
        index: usize,
        /// Its abscissa.
        found: f64,
        /// That of the point before.
        previous: f64,
    },
    /// A damping law feeds energy in.
    #[error("force law: the damping must oppose the motion, but {found}")]
    DampingNotPassive {
        /// Where it doesn't.
        found: String,
    },
    /// `reduce` did not make a superelement; it has said why itself.
    #[error("{}: not reduced ({status})", part.display())]
    Reduction {
        /// Stiffness matrix of the part.
        part: PathBuf,
        /// How the program ended.
        status: String,
        /// Whether it found its input unusable.
        is_unusable_input: bool,
    },
    /// A body that would have to go far to close its joints.
    #[error(
        "bodies.{body}.position: is {distance:.3e} {unit} away from where the joints can be closed (the sizes of all bodies together are {extent:.3e} {unit}); correct the position or the joints, or allow it with \"initial\": {{\"allow_gap\": {:.1e}}}",
        2.0 * distance
    )]
    FarFromJoints {
        /// Which body.
        body: String,
        /// How far.
        distance: f64,
        /// Size of all bodies together.
        extent: f64,
        /// Unit of length.
        unit: String,
    },
    /// What stops a scene, with its file.
    #[error("{}: {error}", path.display())]
    InScene {
        /// File of the scene.
        path: PathBuf,
        /// Finding.
        error: Box<Error>,
    },
    /// A scene, or a function of time, says something that can't be used.
    #[error("{location}: {message}")]
    Description {
        /// Where: a path of keys such as `joints.axle.revolute.a`.
        location: String,
        /// Finding and expectation.
        message: String,
    },
}

impl Error {
    /// Whether the input, and not the computation, is at fault.
    pub fn is_unusable_input(&self) -> bool {
        if let Self::Reduction {
            is_unusable_input, ..
        } = self
        {
            return *is_unusable_input;
        }
        if let Self::InScene { error, .. } = self {
            return error.is_unusable_input();
        }
        if let Self::File(error) = self {
            return error.is_unusable_input();
        }
        if let Self::Superelement(error) = self {
            return error.is_unusable_input();
        }
        !matches!(
            self,
            Self::OutOfMemory
                | Self::SingularBody { .. }
                | Self::SingularJoints { .. }
                | Self::NotFinite { .. }
                | Self::FunctionNotFinite { .. }
                | Self::NotConverged { .. }
                | Self::LongTurn { .. }
                | Self::StepTooSmall { .. }
                | Self::StepTooLong { .. }
                | Self::NoEquilibrium { .. }
                | Self::NoEigenvalues
                | Self::Resonant { .. }
                | Self::CannotAssemble { .. }
                | Self::FarFromJoints { .. }
                | Self::Contradiction { .. }
                | Self::DrivesContradict { .. }
                | Self::InertiaNotPositive { .. }
        )
    }

    /// A fault of a description at a path of keys.
    pub fn described(location: impl Into<String>, message: impl Into<String>) -> Self {
        Self::Description {
            location: location.into(),
            message: message.into(),
        }
    }

    /// A fault of a description, or of how it draws a mechanism, as one of the file that holds it.
    pub fn in_file(self, path: &Path) -> Self {
        match self {
            Self::Description { location, message } => Self::File(dcb_formats::Error::Location {
                path: path.to_owned(),
                location,
                message,
            }),
            error @ (Self::FarFromJoints { .. } | Self::CannotAssemble { .. }) => Self::InScene {
                path: path.to_owned(),
                error: Box::new(error),
            },
            other => other,
        }
    }
}

impl From<dcb_demand::Error> for Error {
    fn from(error: dcb_demand::Error) -> Self {
        match error {
            dcb_demand::Error::Formats(error) => error.into(),
            dcb_demand::Error::Superelement(error) => error.into(),
        }
    }
}

impl From<dcb_formats::Error> for Error {
    fn from(error: dcb_formats::Error) -> Self {
        match error {
            dcb_formats::Error::Description { location, message } => {
                Self::Description { location, message }
            }
            other => Self::File(other),
        }
    }
}
