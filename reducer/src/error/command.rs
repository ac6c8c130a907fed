//! Refusals of a command before it begins: options, files and folders that don't go together.

use std::path::PathBuf;

/// A command that can't be carried out as it is given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CommandRefusal {
    /// Nothing to reduce.
    #[error("no stiffness matrix given")]
    NoPart,
    /// Hz mean nothing in the component's time unit.
    #[error("{option} is in Hz, but the time unit {unit:?} is not known; {remedy}")]
    UnknownTimeUnit {
        /// The option that is in Hz.
        option: &'static str,
        /// The unit.
        unit: String,
        /// Another option.
        remedy: &'static str,
    },
    /// Rows of L_b for matrices of another program, whose rows get another order.
    #[error(
        "{}: rows of L_b stand in the order of part.mtx, and an import may change that of another program's matrices; run `reduce import` first, and put PART.boundary.mtx beside PART.mtx",
        path.display()
    )]
    BoundaryOfImport {
        /// Rows of L_b.
        path: PathBuf,
    },
    /// An import into a file that isn't named like one.
    #[error("{}: expected PART.mtx as the output of an import; PART.mass.mtx and PART.json are written beside it", path.display())]
    NoMatrixMarketName {
        /// The output.
        path: PathBuf,
    },
    /// Rows of a table in a description that knows no matrices.
    #[error(
        "a draft takes the directions of every node, for example --dofs ux,uy,uz; `reduce import` reads tables of rows"
    )]
    TableInDraft,
    /// An output in the place of an input.
    #[error("{}: {role}", path.display())]
    WouldDestroy {
        /// The file.
        path: PathBuf,
        /// Kind.
        role: Occupied,
    },
    /// Options of ranks that don't go together.
    #[error(transparent)]
    Ranks(#[from] RanksRefusal),
    /// Further columns are asked for, and no form that has them.
    #[error(
        "--enrich adds rows in the strong form, the only one that has further columns as coordinates, and --variants leaves it out; name strong there, or leave --enrich out"
    )]
    EnrichWithoutStrong,
    /// A limit of the cache that is no size.
    #[error("the environment variable {variable} is {found:?}: {wanted}")]
    NoSize {
        /// Name of the variable.
        variable: &'static str,
        /// As given.
        found: String,
        /// Expected value.
        wanted: String,
    },
    /// No folder for a cache.
    #[error("no folder of a cache is known; name one with --cache=FOLDER or {variable}")]
    NoCacheFolder {
        /// The environment variable that names one.
        variable: &'static str,
    },
    /// No key, or several, begin as asked.
    #[error(
        "{}: {}",
        folder.display(),
        match found {
            0 => format!("no key begins with {start:?}; `reduce cache` lists them"),
            several => format!("{several} keys begin with {start:?}; give more of it"),
        }
    )]
    NotOneKey {
        /// Folder of the cache.
        folder: PathBuf,
        /// How the key should begin.
        start: String,
        /// How many do.
        found: usize,
    },
    /// A planar superelement beside a spatial one.
    #[error("{} and {}: one is planar, the other spatial", a.display(), b.display())]
    DimensionsDiffer {
        /// First superelement.
        a: PathBuf,
        /// Second superelement.
        b: PathBuf,
    },
}

/// File or folder that stands in the way of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupied {
    /// The scene.
    Scene,
    /// A file of the component.
    Component,
    /// A file that is imported.
    Import,
    /// A file of one of the parts.
    Batch,
    /// The superelement, where the timings are to go.
    Superelement,
}

impl std::fmt::Display for Occupied {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Scene => "is the scene and can't be an output; name another file",
            Self::Component => {
                "is an input of this reduction and can't be its output; name another file"
            }
            Self::Import => "is imported and can't be an output too; name another one with -o",
            Self::Batch => {
                "is an input of this batch and can't be an output; name another folder with -o"
            }
            Self::Superelement => "is the output; the timings need another file",
        })
    }
}

/// Options of ranks that don't go together, or that this program doesn't have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RanksRefusal {
    /// How to start nothing.
    #[error("--mpirun says how the processes of --ranks are started: say with --ranks how many")]
    NoRanks,
    /// The factor can be in one place only.
    #[error("--ranks keeps the factor in the memory of MPI processes: leave out --factor")]
    OtherPlace,
    /// Ranks aren't built in.
    #[cfg(not(feature = "ranks"))]
    #[error(
        "--ranks: this program was built without the feature ranks; build with --features ranks (docs/ranks.md), or keep the factor on disk with --factor disk"
    )]
    NotBuilt,
    /// A command line without a word, or with an open quote.
    #[cfg(feature = "ranks")]
    #[error(
        "--mpirun: a command is wanted, for example \"mpirun --hostfile hosts\", with every quote closed"
    )]
    NoLauncher,
}
