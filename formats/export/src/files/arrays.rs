//! NumPy arrays in a zip, without pickled objects.

use std::io::{Cursor, Write as _};

use faer::Mat;
use npyz::{DType, WriteOptions, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

/// A zip that is being filled.
pub(crate) struct Arrays {
    zip: ZipWriter<Cursor<Vec<u8>>>,
}

impl Arrays {
    pub(crate) fn new() -> Self {
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

    /// An array of reals, row-major.
    pub(crate) fn reals(
        &mut self,
        name: &str,
        shape: &[usize],
        values: &[f64],
    ) -> std::io::Result<()> {
        self.start(name, "<f8", shape)?;
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        self.zip.write_all(&bytes)
    }

    /// A list of complex numbers.
    pub(crate) fn complex(&mut self, name: &str, values: &[[f64; 2]]) -> std::io::Result<()> {
        self.start(name, "<c16", &[values.len()])?;
        let bytes: Vec<u8> = values
            .iter()
            .flatten()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        self.zip.write_all(&bytes)
    }

    /// A matrix.
    pub(crate) fn matrix(&mut self, name: &str, of: &Mat<f64>) -> std::io::Result<()> {
        let values = (0..of.nrows()).flat_map(|i| (0..of.ncols()).map(move |j| of[(i, j)]));
        self.reals(name, &[of.nrows(), of.ncols()], &values.collect::<Vec<_>>())
    }

    /// An array of integers, row-major.
    pub(crate) fn integers(
        &mut self,
        name: &str,
        shape: &[usize],
        values: &[i64],
    ) -> std::io::Result<()> {
        self.start(name, "<i8", shape)?;
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        self.zip.write_all(&bytes)
    }

    /// Texts of one length, filled up with zeros, as NumPy has them.
    pub(crate) fn texts(
        &mut self,
        name: &str,
        shape: &[usize],
        values: &[&str],
    ) -> std::io::Result<()> {
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

    /// The zip.
    pub(crate) fn finish(self) -> std::io::Result<Vec<u8>> {
        Ok(self.zip.finish()?.into_inner())
    }
}
