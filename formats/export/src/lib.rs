//! Other tools' files out: a superelement as other programs read it.
//!
//! Each target is one file over the same integrals (`part/basis.rs`), and one entry of [`TARGETS`]. What a target can't hold of a superelement is said, as found in this one.
//!
//! ```
//! use std::path::Path;
//! use dcb_export::{Export, Source, Target};
//!
//! // The rod of the slider-crank is planar: most programs have no place for it, and it is refused by name.
//! let rod = Source::open(Path::new("../../samples/slider-crank/rod.dcb.h5"))?;
//! let target = Target::named("mbdyn").ok_or("no such target")?;
//! let folder = tempfile::tempdir()?;
//! let output = folder.path().join("rod.fem");
//! let refused = Export::to(target).write(&rod, &output).map(|_| ());
//! assert!(refused.is_err_and(|error| error.to_string().contains("planar")));
//! assert!(!output.exists());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod exudyn;
mod files;
mod gltf;
pub mod linear_system;
mod mbdyn;
mod mesh;
mod nastran;
mod npz;
mod part;
mod sid;
mod simscape;
mod vtu;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::output::{Replace, check_output, is_same_file};

use files::product::Product;
pub use part::Source;

/// Where the origin of positions is. The axes are the component's in both cases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axes {
    /// In the centre of mass.
    #[default]
    Body,
    /// In the component's origin.
    Component,
}

/// A program, or a format, that superelements can be written for.
pub struct Target {
    /// Name on the command line.
    pub name: &'static str,
    /// What it writes, in a few words.
    pub about: &'static str,
    /// Ending of its files, with the dot.
    pub ending: &'static str,
    /// Dialects, the usual one first; empty where there is one form only.
    pub dialects: &'static [&'static str],
    make: fn(&Source, &Request<'_>) -> Result<Product, Error>,
}

/// All targets.
pub static TARGETS: [Target; 8] = [
    Target {
        name: "npz",
        about: "K, M and C of frames and modes as NumPy arrays",
        ending: ".npz",
        dialects: &[],
        make: npz::product,
    },
    Target {
        name: "simscape",
        about: "the same as a MATLAB file, for Simscape's Reduced Order Flexible Solid",
        ending: ".mat",
        dialects: &[],
        make: simscape::product,
    },
    Target {
        name: "nastran",
        about: "the same as bulk data with DMIG, or with an OUTPUT4 file",
        ending: ".bdf",
        dialects: &["dmig", "op4"],
        make: nastran::product,
    },
    Target {
        name: "exudyn",
        about: "an ObjectFFRFreducedOrderInterface of Exudyn, HDF5",
        ending: ".hdf5",
        dialects: &[],
        make: exudyn::product,
    },
    Target {
        name: "mbdyn",
        about: "the file of a modal joint of MBDyn",
        ending: ".fem",
        dialects: &[],
        make: mbdyn::product,
    },
    Target {
        name: "sid",
        about: "standard input data (SID_FEM)",
        ending: ".SID_FEM",
        dialects: &["vector", "matrix"],
        make: sid::product,
    },
    Target {
        name: "gltf",
        about: "the surface with moving modes, binary glTF",
        ending: ".glb",
        dialects: &[],
        make: gltf::product,
    },
    Target {
        name: "vtu",
        about: "the mesh with modes and attachments as fields, for ParaView",
        ending: ".vtu",
        dialects: &[],
        make: vtu::product,
    },
];

impl Target {
    /// The one with this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        TARGETS.iter().find(|target| target.name == name)
    }
}

/// What an exporter is asked for.
pub(crate) struct Request<'a> {
    pub target: &'static Target,
    /// One of the target's, empty where it has none.
    pub dialect: &'static str,
    pub axes: Axes,
    /// Name of the file that is written, without folder.
    pub file_name: &'a str,
}

/// One export.
#[derive(Clone, Copy)]
pub struct Export {
    target: &'static Target,
    dialect: &'static str,
    axes: Axes,
    replace: Replace,
}

/// What was written.
#[derive(Clone, Debug)]
pub struct Written {
    /// Files.
    pub files: Vec<PathBuf>,
    /// What they hold, what they can't, and how they are used; for people.
    pub text: String,
}

impl Export {
    /// To this target: its usual dialect, body axes, no file is replaced.
    pub fn to(target: &'static Target) -> Self {
        Self {
            target,
            dialect: target.dialects.first().copied().unwrap_or_default(),
            axes: Axes::Body,
            replace: Replace::Refuse,
        }
    }

    /// In this dialect.
    ///
    /// # Errors
    /// [`Error::Description`] if the target has no such.
    pub fn in_dialect(self, dialect: &str) -> Result<Self, Error> {
        let (name, dialects) = (self.target.name, self.target.dialects);
        let known = dialects.iter().find(|known| **known == dialect);
        known
            .map(|dialect| Self { dialect, ..self })
            .ok_or_else(|| {
                let wanted = match dialects {
                    [] => "has one form only; leave the option out".to_owned(),
                    dialects => format!("has {}", dialects.join(" and ")),
                };
                Error::described(
                    "--dialect",
                    format!("{dialect:?} is no form of `{name}`, which {wanted}"),
                )
            })
    }

    /// With this origin.
    pub fn about(self, axes: Axes) -> Self {
        Self { axes, ..self }
    }

    /// With this treatment of files that are there.
    pub fn replacing(self, replace: Replace) -> Self {
        Self { replace, ..self }
    }

    /// The usual name: that of the superelement, less `.dcb.h5`, with the target's ending.
    pub fn usual_output(&self, superelement: &Path) -> PathBuf {
        let name = superelement.file_name().unwrap_or_default();
        let name = name.to_string_lossy();
        let endings = [".dcb.h5", ".h5", ".hdf5"];
        let stem = endings.iter().find_map(|ending| name.strip_suffix(ending));
        let mut output = OsString::from(stem.unwrap_or(&name));
        output.push(self.target.ending);
        superelement.with_file_name(output)
    }

    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// [`Error::File`] for a superelement that the target can't hold at all, saying what it lacks; those of [`dcb_formats::output`] where nothing can be written.
    pub fn write(&self, source: &Source, output: &Path) -> Result<Written, Error> {
        if is_same_file(source.path(), output) {
            return Err(source
                .refused("is the superelement that is exported; name another output".to_owned()));
        }
        check_output(output, self.replace)?;
        let request = Request {
            target: self.target,
            dialect: self.dialect,
            axes: self.axes,
            file_name: &output.file_name().unwrap_or_default().to_string_lossy(),
        };
        let product = (self.target.make)(source, &request)?;
        let files = product.write(output, self.replace)?;
        let text = product.text(&files);
        Ok(Written { files, text })
    }
}
