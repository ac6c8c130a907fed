//! How joints, springs, loads and outputs say where they are.

/// A place: `ground`, `ground/point`, `body/interface` or `body/point`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attachment<'a> {
    /// The origin of the world.
    Ground,
    /// A named point of the ground.
    GroundPoint(&'a str),
    /// An interface of a superelement, or a point of a rigid body.
    Body {
        /// Name of the body.
        body: &'a str,
        /// Name of the interface or point.
        point: &'a str,
    },
}

impl<'a> Attachment<'a> {
    /// Takes a reference apart; `None` where it has not the form of one.
    pub fn parse(reference: &'a str) -> Option<Self> {
        match reference.split_once('/') {
            None if reference == "ground" => Some(Self::Ground),
            None => None,
            Some((body, point)) if body.is_empty() || point.is_empty() || point.contains('/') => {
                None
            }
            Some(("ground", point)) => Some(Self::GroundPoint(point)),
            Some((body, point)) => Some(Self::Body { body, point }),
        }
    }

    /// The body; `None` for the ground.
    pub fn body(&self) -> Option<&'a str> {
        match self {
            Self::Ground | Self::GroundPoint(_) => None,
            Self::Body { body, .. } => Some(body),
        }
    }
}
