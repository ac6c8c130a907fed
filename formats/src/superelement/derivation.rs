//! How a superelement was made, as far as other programs need it: what was left out of it, and where its couplings come from.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// How a superelement was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derivation {
    /// Where L3 and I2 come from.
    pub coupling_source: CouplingSource,
    /// Directions that an interface reduction kept; `None` if nothing was left out.
    pub interface_directions: Option<InterfaceDirections>,
    /// Names of further columns that were asked for and not made: their responses have nothing beyond the kept modes.
    pub left_out_columns: Vec<String>,
    /// Rows of the component's matrices that belong to no node, and have no part in the fields.
    pub internal_rows: usize,
    /// Selections that the superelement went through, the first one first.
    pub selections: Vec<SelectionRecord>,
}

/// Where L3 and I2 come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CouplingSource {
    /// Integrals over the component: they belong to one field of displacements with the mass.
    Integrals,
    /// The mass matrix at nodes whose rotations, or internal rows beside them, move the component between them too: approximations.
    Nodal,
    /// Nobody says.
    #[default]
    Unknown,
}

/// Directions of the residual flexibility that an interface reduction kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InterfaceDirections {
    /// Directions kept.
    pub kept: usize,
    /// Directions that there were.
    pub available: usize,
}

impl InterfaceDirections {
    /// Whether a direction was left out.
    pub fn leave_out(self) -> bool {
        self.kept < self.available
    }
}

/// One selection that a superelement went through after its reduction: what it left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SelectionRecord {
    /// Places of the modes that stayed among those before it, ascending.
    pub modes: Vec<usize>,
    /// How many modes there were before it.
    pub of_modes: usize,
    /// The lowest ω² that was left out already before, 1/time²; `None` if nothing was.
    #[serde(default)]
    pub first_omitted_eigenvalue: Option<f64>,
    /// The frequency, in cycles per time, up to which the responses were to stay as they are; `None` if nobody said.
    #[serde(default)]
    pub up_to: Option<f64>,
    /// Interfaces of the superelement that are loaded along some forces only: these, each over the interface's rows as they are now.
    pub loaded_along: BTreeMap<String, Vec<Vec<f64>>>,
}
