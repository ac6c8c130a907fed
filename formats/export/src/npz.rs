//! NumPy: K, M and C of the primal form in a zip of arrays, without pickled objects.
//!
//! | array | shape | holds |
//! | --- | --- | --- |
//! | `K`, `M`, `C` | (N, N) | stiffness, mass, damping (`C` only where something is damped); coordinates: frames, then inertia relief and modes |
//! | `boundary` | (n_b, 2) | interface and direction (0 to 5: ux uy uz rx ry rz) of the first n_b coordinates |
//! | `names` | (n_i) | of the interfaces |
//! | `positions`, `orientations` | (n_i, 3), (n_i, 3, 3) | of the interfaces at rest; columns of a matrix are the frame's axes |
//! | `n_modes` | () | coordinates behind those of the frames |
//! | `rigid` | (n_b, 6) | rigid motions of the frames about the centre of mass |
//! | `mass`, `centre_of_mass`, `inertia` | (), (3), (3, 3) | of the whole part; `inertia` about the centre of mass |
//! | `units`, `source` | () | texts |

use std::io::{Cursor, Write as _};

use dcb_formats::Error;
use faer::Mat;
use npyz::{DType, WriteOptions, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

use crate::Request;
use crate::files::product::{Content, Product};
use crate::part::left_out::{Holds, left_out, unit_note};
use crate::part::primal::{Primal, boundary};
use crate::part::{Part, Source};

/// A part's primal form as NumPy arrays.
pub(crate) fn product(source: &Source, request: &Request<'_>) -> Result<Product, Error> {
    let part = Part::spatial(source, request)?;
    let primal = Primal::of(&part)?;
    let bytes = archive(&part, &primal)
        .map_err(|error| part.refused(format!("can't be written as npz: {error}")))?;
    let mut product = Product::new(Content::Bytes(bytes), primal.summary());
    product.notes.push(primal.rigid_note());
    product.notes.extend(unit_note(&part));
    product.left_out = left_out(
        &part,
        Holds {
            damping: true,
            axes: true,
            ..Holds::default()
        },
    )?;
    Ok(product)
}

fn archive(part: &Part<'_>, primal: &Primal) -> std::io::Result<Vec<u8>> {
    let frames = &primal.frames;
    let mut arrays = Arrays::new();
    arrays.matrix("K", &primal.stiffness)?;
    arrays.matrix("M", &primal.mass)?;
    if let Some(damping) = &primal.damping {
        arrays.matrix("C", damping)?;
    }
    let rows = boundary(frames).into_iter();
    let rows = rows.flat_map(|(frame, direction)| [frame as i64, direction.index() as i64]);
    arrays.integers(
        "boundary",
        &[6 * frames.len(), 2],
        &rows.collect::<Vec<_>>(),
    )?;
    let names: Vec<&str> = frames.iter().map(|frame| frame.name.as_str()).collect();
    arrays.texts("names", &[names.len()], &names)?;
    let positions = frames
        .iter()
        .flat_map(|frame| frame.position.iter().copied());
    arrays.reals(
        "positions",
        &[frames.len(), 3],
        &positions.collect::<Vec<_>>(),
    )?;
    let axes = frames.iter().flat_map(|frame| {
        frame
            .orientation
            .transpose()
            .iter()
            .copied()
            .collect::<Vec<_>>()
    });
    arrays.reals(
        "orientations",
        &[frames.len(), 3, 3],
        &axes.collect::<Vec<_>>(),
    )?;
    arrays.integers("n_modes", &[], &[primal.modal_count as i64])?;
    arrays.matrix("rigid", &primal.rigid)?;
    let basis = &part.basis;
    arrays.reals("mass", &[], &[basis.mass])?;
    arrays.reals("centre_of_mass", &[3], basis.centre.as_slice())?;
    arrays.reals("inertia", &[3, 3], basis.tensor.as_slice())?;
    let units = &part.superelement.units;
    arrays.texts("units", &[3], &[&units.length, &units.mass, &units.time])?;
    arrays.texts("source", &[], &[&part.source.origin_line()])?;
    arrays.finish()
}

/// A zip that is being filled.
struct Arrays {
    zip: ZipWriter<Cursor<Vec<u8>>>,
}

impl Arrays {
    fn new() -> Self {
        Self {
            zip: ZipWriter::new(Cursor::new(Vec::new())),
        }
    }

    /// Starts a member; the same contents give the same bytes at any time of day.
    fn start(&mut self, name: &str, element: &str, shape: &[usize]) -> std::io::Result<()> {
        let options = SimpleFileOptions::default().last_modified_time(DateTime::default());
        self.zip.start_file(format!("{name}.npy"), options)?;
        let element = element.parse().map_err(std::io::Error::other)?;
        let shape: Vec<u64> = shape.iter().map(|size| *size as u64).collect();
        WriteOptions::new_header_only()
            .dtype(DType::Plain(element))
            .shape(&shape)
            .writer(&mut self.zip)
            .write_header_only()?;
        Ok(())
    }

    fn reals(&mut self, name: &str, shape: &[usize], values: &[f64]) -> std::io::Result<()> {
        self.start(name, "<f8", shape)?;
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        self.zip.write_all(&bytes)
    }

    fn matrix(&mut self, name: &str, of: &Mat<f64>) -> std::io::Result<()> {
        let values = (0..of.nrows()).flat_map(|i| (0..of.ncols()).map(move |j| of[(i, j)]));
        self.reals(name, &[of.nrows(), of.ncols()], &values.collect::<Vec<_>>())
    }

    fn integers(&mut self, name: &str, shape: &[usize], values: &[i64]) -> std::io::Result<()> {
        self.start(name, "<i8", shape)?;
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        self.zip.write_all(&bytes)
    }

    /// Texts of one length, filled up with zeros, as NumPy has them.
    fn texts(&mut self, name: &str, shape: &[usize], values: &[&str]) -> std::io::Result<()> {
        let longest = values.iter().map(|text| text.chars().count()).max();
        let length = longest.unwrap_or(0).max(1);
        self.start(name, &format!("<U{length}"), shape)?;
        for text in values {
            let characters = text.chars().map(u32::from).chain(std::iter::repeat(0));
            let bytes: Vec<u8> = characters.take(length).flat_map(u32::to_le_bytes).collect();
            self.zip.write_all(&bytes)?;
        }
        Ok(())
    }

    fn finish(self) -> std::io::Result<Vec<u8>> {
        Ok(self.zip.finish()?.into_inner())
    }
}
