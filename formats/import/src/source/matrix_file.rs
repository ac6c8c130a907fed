//! Files with matrices, told by their content.

use std::path::{Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::matrix::blocks::{CR_ALONE, TextBlocks};

use crate::binary::file::is_gzipped;
use crate::matrix::abaqus::{coordinate, matrix_input, substructure};
use crate::matrix::matlab::{version5, version73};
use crate::matrix::nastran::{dmig, op4};
use crate::matrix::{harwell_boeing, matrix_market, numpy, petsc};
use crate::source::closed_formats::explanation;
use crate::stored::{Listed, Reading};
use crate::text::line_blocks::BYTE_ORDER_MARK;

/// A format of matrices.
struct Format {
    /// For people.
    name: &'static str,
    /// Endings of names that promise this format, or one of several; in lower case.
    endings: &'static [&'static str],
    recognises: fn(&[u8]) -> bool,
    list: fn(&Path) -> Result<Vec<Listed>, Error>,
    read: fn(&Path, &[usize]) -> Result<Reading, Error>,
}

/// All of them. The first that recognises a file reads it.
const FORMATS: [Format; 12] = [
    Format {
        name: "Matrix Market",
        endings: &["mm", "mtx"],
        recognises: matrix_market::recognises,
        list: matrix_market::list,
        read: matrix_market::read,
    },
    Format {
        name: "NumPy",
        endings: &["npz", "npy"],
        recognises: numpy::recognises,
        list: numpy::list,
        read: numpy::read,
    },
    Format {
        name: "MATLAB 5",
        endings: &["mat"],
        recognises: version5::recognises,
        list: version5::list,
        read: version5::read,
    },
    Format {
        name: "MATLAB 7.3 or HDF5",
        endings: &["mat", "h5", "hdf5"],
        recognises: version73::recognises,
        list: version73::list,
        read: version73::read,
    },
    Format {
        name: "PETSc binary",
        endings: &["petsc"],
        recognises: petsc::recognises,
        list: petsc::list,
        read: petsc::read,
    },
    Format {
        name: "Nastran OUTPUT4, binary",
        endings: &["op4"],
        recognises: op4::binary::recognises,
        list: op4::binary::list,
        read: op4::binary::read,
    },
    Format {
        name: "Nastran OUTPUT4, ASCII",
        endings: &["op4"],
        recognises: op4::text::recognises,
        list: op4::text::list,
        read: op4::text::read,
    },
    Format {
        name: "Nastran DMIG",
        endings: &["pch", "bdf", "nas"],
        recognises: dmig::recognises,
        list: dmig::list,
        read: dmig::read,
    },
    Format {
        name: "Abaqus substructure",
        endings: &["mtx"],
        recognises: substructure::recognises,
        list: substructure::list,
        read: substructure::read,
    },
    Format {
        name: "Abaqus MATRIX INPUT",
        endings: &["mtx"],
        recognises: matrix_input::recognises,
        list: matrix_input::list,
        read: matrix_input::read,
    },
    Format {
        name: "Harwell-Boeing",
        endings: &["hb", "rsa", "rua"],
        recognises: harwell_boeing::recognises,
        list: harwell_boeing::list,
        read: harwell_boeing::read,
    },
    Format {
        name: "CalculiX or Abaqus COORDINATE",
        endings: &["sti", "mas", "mtx"],
        recognises: coordinate::recognises,
        list: coordinate::list,
        read: coordinate::read,
    },
];

/// Bytes at the beginning of a file by which it is recognised.
const LOOKED_AT: usize = 1 << 20;

/// A file with matrices.
pub struct MatrixFile {
    path: PathBuf,
    format: &'static Format,
    listed: Vec<Listed>,
}

impl MatrixFile {
    /// Recognises a file and lists its matrices.
    ///
    /// # Errors
    /// [`Error::File`] for content that isn't known, and what is wrong with content that is.
    pub fn open(path: &Path) -> Result<Self, Error> {
        match Self::recognised(path)? {
            Some(file) => Ok(file),
            None => Err(unknown(path, &beginning(path)?)),
        }
    }

    /// The same, but `None` for content that isn't known.
    ///
    /// # Errors
    /// What is wrong with content that is known; it can't be read.
    pub fn recognised(path: &Path) -> Result<Option<Self>, Error> {
        let start = beginning(path)?;
        let Some(format) = FORMATS.iter().find(|format| (format.recognises)(&start)) else {
            return Ok(None);
        };
        let refused = |message: &str| Error::File {
            path: path.to_path_buf(),
            message: message.into(),
        };
        let is_text = !start.iter().take(1024).any(|byte| *byte == 0);
        if is_text && start.contains(&b'\r') && !start.contains(&b'\n') {
            return Err(refused(CR_ALONE));
        }
        if !is_text && is_gzipped(path)? {
            return Err(refused(
                "is a gzipped binary file; unpack it first, gunzip FILE (text files are read packed)",
            ));
        }
        Ok(Some(Self {
            path: path.to_path_buf(),
            format,
            listed: (format.list)(path)?,
        }))
    }

    /// Name of the format.
    pub fn format_name(&self) -> &'static str {
        self.format.name
    }

    /// A remark where the file's name promises another format.
    pub(crate) fn misleading_name(&self) -> Option<String> {
        let name = self.file_name();
        let bare = name.strip_suffix(".gz").unwrap_or(&name);
        let (_, ending) = bare.rsplit_once('.')?;
        let ending = ending.to_ascii_lowercase();
        let promises = |format: &&Format| format.endings.contains(&ending.as_str());
        let promised: Vec<&str> = (FORMATS.iter().filter(promises))
            .map(|format| format.name)
            .collect();
        let misleads = !promised.is_empty() && !promised.contains(&self.format.name);
        misleads.then(|| {
            format!(
                "{name} is {} by its content, though its name promises {}",
                self.format.name,
                promised.join(" or ")
            )
        })
    }

    /// Its matrices.
    pub fn listed(&self) -> &[Listed] {
        &self.listed
    }

    /// Reads matrices by their numbers in the list.
    ///
    /// # Errors
    /// Whatever is wrong with them, with its place.
    pub fn read(&self, wanted: &[usize]) -> Result<Reading, Error> {
        (self.format.read)(&self.path, wanted)
    }

    /// An error of this file.
    pub(crate) fn refused(&self, message: impl Into<String>) -> Error {
        Error::File {
            path: self.path.clone(),
            message: message.into(),
        }
    }

    /// Name of the file without its folder.
    pub(crate) fn file_name(&self) -> String {
        let name = self.path.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }
}

/// Whether a file has a Matrix Market banner.
///
/// # Errors
/// It can't be read.
pub fn is_matrix_market(path: &Path) -> Result<bool, Error> {
    Ok(matrix_market::recognises(&beginning(path)?))
}

/// The first bytes of a file, unpacked where it is gzipped.
pub(crate) fn beginning(path: &Path) -> Result<Vec<u8>, Error> {
    let mut text = TextBlocks::open(path)?;
    text.fill_to(LOOKED_AT)?;
    let start = text.pending();
    Ok(start
        .strip_prefix(BYTE_ORDER_MARK)
        .unwrap_or(start)
        .to_vec())
}

fn unknown(path: &Path, start: &[u8]) -> Error {
    let names = || {
        FORMATS
            .iter()
            .map(|format| format.name)
            .collect::<Vec<_>>()
            .join(", ")
    };
    let message = match explanation(path, start) {
        Some(explanation) => explanation,
        None if start.is_empty() => "is empty; expected a matrix".to_owned(),
        None => format!(
            "holds no matrix of a format that is known here; expected one of {}",
            names()
        ),
    };
    Error::File {
        path: path.to_path_buf(),
        message,
    }
}
