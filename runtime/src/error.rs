//! Why a body can't be used, or a motion can't be continued.

/// What went wrong, and what would be right.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The superelement's file can't be used.
    #[error(transparent)]
    File(#[from] dcb_formats::Error),
    /// The superelement has something that the dynamics doesn't handle.
    #[error("body {body:?}: {what}; {remedy}")]
    NotHandled {
        /// Name of the body.
        body: String,
        /// What was found.
        what: &'static str,
        /// What to do instead.
        remedy: &'static str,
    },
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
        /// What would be right.
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
}
