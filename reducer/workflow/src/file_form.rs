//! How a superelement is written: what decides the file and not the result.

use clap::Args;
use dcb_formats::dcb::Compression;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Options, and keys of a manifest, of the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct FileForm {
    /// Leave out mesh and nodal shapes: nothing of the inside of the part is handed over.
    #[arg(long)]
    pub without_fields: bool,
    /// Compress the nodal shapes (slower, a little smaller).
    #[arg(long)]
    pub compress: bool,
}

impl FileForm {
    /// Writes it into the options of a file.
    pub fn say(self, options: &mut Value) {
        options["without_fields"] = self.without_fields.into();
        options["compress"] = self.compress.into();
    }

    /// How the field arrays are stored.
    pub fn compression(self) -> Compression {
        match self.compress {
            true => Compression::Deflate,
            false => Compression::None,
        }
    }
}
