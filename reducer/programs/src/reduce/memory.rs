//! The options `--memory`, `--factor` and `--scratch`.

use std::path::{Path, PathBuf};

use clap::Args;

use dcb_reducer::resources::memory_limit::{FactorChoice, MemoryLimit, available, size};

/// How much memory may be taken, and where the factor is kept.
#[derive(Debug, Args)]
pub struct MemoryArguments {
    /// Memory that may be taken, for example 8G [default: what the machine has available].
    #[arg(long, value_name = "SIZE", allow_hyphen_values = true, value_parser = size)]
    pub memory: Option<u64>,
    /// Where the factor is kept.
    #[arg(long, value_name = "WHERE", value_enum, default_value_t)]
    pub factor: FactorChoice,
    /// Folder of a factor on disk [default: the output's].
    #[arg(long, value_name = "FOLDER")]
    pub scratch: Option<PathBuf>,
}

impl MemoryArguments {
    /// The limit; what the machine has available is taken now. `beside` is a file in the folder of choice.
    pub fn limit(&self, beside: &Path) -> MemoryLimit {
        let folder = || match beside.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
            _ => PathBuf::from("."),
        };
        let scratch = self.scratch.clone().unwrap_or_else(folder);
        MemoryLimit::here(self.bytes(), self.factor, scratch)
    }

    /// Memory that may be taken, as of now.
    pub fn bytes(&self) -> Option<u64> {
        self.memory.or_else(available)
    }
}
