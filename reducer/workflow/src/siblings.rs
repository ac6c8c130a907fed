//! The files of a part.

use std::path::PathBuf;

use clap::Args;
use dcb_formats::component_files::Overrides;
use schemars::JsonSchema;
use serde::Deserialize;

/// The files that stand beside a stiffness matrix unless they are named.
#[derive(Clone, Debug, Default, PartialEq, Args, Deserialize, JsonSchema)]
pub struct SiblingArguments {
    /// Mass matrix [default: PART.mass.mtx].
    #[arg(long, value_name = "FILE")]
    pub mass: Option<PathBuf>,
    /// Component description [default: PART.json].
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Rows of the boundary by those of K, n_b x n_e [default: PART.boundary.mtx if there].
    #[arg(long, value_name = "FILE")]
    pub boundary: Option<PathBuf>,
}

impl SiblingArguments {
    /// Names in place of those beside the stiffness matrix.
    pub fn overrides(&self) -> Overrides {
        Overrides {
            mass: self.mass.clone(),
            description: self.mesh.clone(),
            boundary: self.boundary.clone(),
        }
    }
}
