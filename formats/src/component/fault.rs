//! A fault of a component, by its place.

use std::fmt;

/// The place of a component that a fault is in: a member of [`ComponentDraft`](super::ComponentDraft), in the words of its file where it is
/// one of the description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A key of the component file, such as `component.interfaces[1].nodes`.
    Description(String),
    /// The stiffness matrix.
    Stiffness,
    /// The mass matrix.
    Mass,
    /// One of the component masses.
    ComponentMass(usize),
    /// The rows of L_b that are given as a matrix.
    Boundary,
    /// One of the loads.
    Load(usize),
    /// One of the stress matrices.
    Stress(usize),
    /// The geometric stiffness of a product of spins.
    SpinStiffness(usize),
    /// The geometric stiffness of a unit force on a row of an interface.
    RowStiffness(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Description(location) => f.write_str(location),
            Self::Stiffness => f.write_str("stiffness"),
            Self::Mass => f.write_str("mass"),
            Self::ComponentMass(index) => write!(f, "component_masses[{index}]"),
            Self::Boundary => f.write_str("explicit_boundary"),
            Self::Load(index) => write!(f, "loads[{index}]"),
            Self::Stress(index) => write!(f, "stresses[{index}]"),
            Self::SpinStiffness(index) => write!(f, "geometric_stiffness.spins[{index}]"),
            Self::RowStiffness(index) => write!(f, "geometric_stiffness.rows[{index}]"),
        }
    }
}

/// Something of a component that is wrong in itself, or doesn't fit the rest.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {message}")]
pub struct ComponentFault {
    /// Where.
    pub place: Place,
    /// Found and expected.
    pub message: String,
}

impl ComponentFault {
    pub(super) fn at(place: Place, message: impl Into<String>) -> Self {
        Self {
            place,
            message: message.into(),
        }
    }
}

/// A fault at a key of the component file.
pub(crate) fn fault(location: impl Into<String>, message: impl Into<String>) -> ComponentFault {
    ComponentFault::at(Place::Description(location.into()), message)
}
