//! A folder with a superelement, and what is exported of it.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use dcb_export::{Export, Source, Target, Written};
use dcb_formats::component::Component;
use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::output::Replace;
use dcb_formats::{Error, Superelement};
use dcb_reducer::Reduced;
use dcb_tests::{parts, python};
use serde_json::Value;
use tempfile::TempDir;

/// A file of the repository.
pub fn stored(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(path)
}

/// A folder with `part.dcb.h5`.
pub struct Folder {
    place: TempDir,
}

impl Folder {
    /// With nodal fields and mesh.
    pub fn of(component: &Component, reduced: &Reduced) -> Self {
        let folder = Self::empty();
        let contents = Contents {
            superelement: &reduced.superelement,
            recovery: Some(&reduced.recovery),
            mesh: Some(&component.mesh),
        };
        let options = WriteOptions {
            replace_existing: Replace::Overwrite,
            ..WriteOptions::default()
        };
        write_superelement(&folder.source(), &contents, &options).unwrap();
        folder
    }

    /// Without.
    pub fn bare(superelement: &Superelement) -> Self {
        let folder = Self::empty();
        dcb_tests::write_bare(&folder.source(), superelement);
        folder
    }

    /// The published rotor with twelve modes.
    pub fn rotor() -> Self {
        let rotor = parts::rotor();
        Self::of(&rotor, &dcb_tests::lowest(&rotor, 12))
    }

    pub fn empty() -> Self {
        Self {
            place: tempfile::tempdir().unwrap(),
        }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.place.path().join(name)
    }

    pub fn source(&self) -> PathBuf {
        self.path("part.dcb.h5")
    }

    /// Exports with a change of the usual request.
    pub fn export(
        &self,
        target: &str,
        output: &str,
        change: impl FnOnce(Export) -> Export,
    ) -> Result<Written, Error> {
        let export = change(Export::to(Target::named(target).unwrap()));
        export.write(&Source::open(&self.source())?, &self.path(output))
    }

    /// Exports what can be exported.
    pub fn exported(&self, target: &str, output: &str) -> String {
        match self.export(target, output, |usual| usual) {
            Ok(written) => written.text,
            Err(error) => panic!("{target}: {error}"),
        }
    }

    /// Exports what can't: the message. The folder stays as it was.
    pub fn refused(&self, target: &str) -> String {
        let before = self.names();
        let Err(error) = self.export(target, "refused", |usual| usual) else {
            panic!("{target} was written");
        };
        assert_eq!(self.names(), before);
        error.to_string()
    }

    pub fn names(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.place.path()).unwrap();
        let mut names: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        names.sort();
        names
    }

    /// What Python finds in an export, beside the superelement and perhaps another program's file.
    pub fn checked(&self, target: &str, output: &str, oracle: Option<&str>) -> Checked {
        let (source, file) = (self.source(), self.path(output));
        let oracle = oracle.map(stored);
        let mut arguments = vec![source.as_os_str(), OsStr::new(target), file.as_os_str()];
        arguments.extend(oracle.as_ref().map(|oracle| oracle.as_os_str()));
        asked(&arguments)
    }
}

/// What `tests/h5py/exports.py` prints.
pub fn asked(arguments: &[&OsStr]) -> Checked {
    let printed = python::run("exports.py", arguments);
    let printed = printed.unwrap_or_else(|error| panic!("{arguments:?}: {error}"));
    Checked(serde_json::from_str(&printed).unwrap())
}

/// Findings by name.
pub struct Checked(pub Value);

impl Checked {
    /// Every number with this start of its name is there, and none is above the limit.
    #[track_caller]
    pub fn all_below(&self, names: &[&str], limit: f64) {
        for name in names {
            let found: BTreeMap<&String, f64> = (self.0.as_object().unwrap().iter())
                .filter(|(key, _)| key.starts_with(name))
                .filter_map(|(key, value)| Some((key, value.as_f64()?)))
                .collect();
            assert!(!found.is_empty(), "{name} isn't in {}", self.0);
            for (key, value) in found {
                assert!(value.abs() <= limit, "{key}: {value:e}, allowed {limit:e}");
            }
        }
    }

    pub fn numbers(&self, name: &str) -> Vec<f64> {
        dcb_tests::reference::numbers(&self.0[name])
    }
}
