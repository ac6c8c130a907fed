//! Linear systems as files: HDF5, NumPy's npz, MATLAB's mat.

mod hdf5;
mod mat;
mod npz;

use std::ffi::OsStr;
use std::io::Write as _;
use std::path::Path;

use dcb_formats::Error;
use dcb_formats::linear_system::{LinearSystem, Variable};
use dcb_formats::output::{Replace, write_stream};

/// A kind of file, by its ending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinearFile {
    /// `.h5` or `.hdf5`.
    Hdf5,
    /// `.npz`: arrays of NumPy.
    Npz,
    /// `.mat`: MATLAB, version 5.
    Mat,
}

impl LinearFile {
    /// As the name of a file says.
    ///
    /// # Errors
    /// [`Error::File`] for another ending.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let ending = path.extension().and_then(OsStr::to_str);
        match ending.map(str::to_ascii_lowercase).as_deref() {
            Some("h5" | "hdf5") => Ok(Self::Hdf5),
            Some("npz") => Ok(Self::Npz),
            Some("mat") => Ok(Self::Mat),
            _ => Err(Error::File {
                path: path.to_owned(),
                message: "its ending says nothing about what to write; name a file that ends in .h5, .npz or .mat".into(),
            }),
        }
    }

    /// Writes a system, whole or not at all.
    ///
    /// # Errors
    /// [`Error::OutputExists`]; [`Error::NoRoom`]; [`Error::File`] and [`Error::Io`] where no file can be written, or where a file of this kind
    /// can't hold the system.
    pub fn write(self, system: &LinearSystem, path: &Path, replace: Replace) -> Result<(), Error> {
        let bytes = match self {
            Self::Hdf5 => return hdf5::write(system, path, replace),
            Self::Npz => npz::bytes(system).map_err(|error| Error::File {
                path: path.to_owned(),
                message: format!("can't be written as npz: {error}"),
            })?,
            Self::Mat => mat::bytes(system).map_err(|message| Error::File {
                path: path.to_owned(),
                message,
            })?,
        };
        write_stream(path, replace, |out| out.write_all(&bytes))
    }
}

fn names(of: &[Variable]) -> Vec<&str> {
    of.iter().map(|variable| variable.name.as_str()).collect()
}

fn units(of: &[Variable]) -> Vec<&str> {
    of.iter().map(|variable| variable.unit.as_str()).collect()
}

fn values(of: &[Variable]) -> Vec<f64> {
    of.iter().map(|variable| variable.at).collect()
}

fn poles(of: &LinearSystem) -> Vec<[f64; 2]> {
    let poles = of.poles.iter();
    poles
        .map(|pole| [pole.growth, pole.angular_frequency])
        .collect()
}
