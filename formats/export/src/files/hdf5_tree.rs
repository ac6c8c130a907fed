//! Small HDF5 files: datasets at the root, each with attributes of text.

use std::path::Path;

use dcb_formats::output::Replace;
use dcb_formats::{Error, write_hdf5};
use faer::Mat;
use hdf5::types::VarLenUnicode;
use hdf5::{File, Location};

/// What one name of the root leads to.
pub(crate) enum Node {
    /// An array, row-major.
    Reals(Vec<usize>, Vec<f64>),
    /// An array, row-major.
    Integers(Vec<usize>, Vec<i64>),
    Real(f64),
    Integer(i64),
    Text(String),
    /// A group with nothing in it.
    Empty,
}

impl Node {
    /// A matrix.
    pub(crate) fn matrix(of: &Mat<f64>) -> Self {
        let rows = (0..of.nrows()).flat_map(|i| (0..of.ncols()).map(move |j| of[(i, j)]));
        Self::Reals(vec![of.nrows(), of.ncols()], rows.collect())
    }

    fn bytes(&self) -> u64 {
        match self {
            Self::Reals(_, values) => 8 * values.len() as u64,
            Self::Integers(_, values) => 8 * values.len() as u64,
            _ => 1 << 10,
        }
    }
}

/// Nodes with their names and the value of their attribute `datatype`, and attributes of the root.
pub(crate) struct Hdf5Tree {
    pub nodes: Vec<(&'static str, &'static str, Node)>,
    pub attributes: Vec<(&'static str, String)>,
}

impl Hdf5Tree {
    /// Writes it, whole or not at all.
    pub(crate) fn write(&self, output: &Path, replace: Replace) -> Result<(), Error> {
        let needed = self.nodes.iter().map(|(.., node)| node.bytes()).sum();
        write_hdf5(output, replace, needed, |file| self.fill(file))
    }

    fn fill(&self, file: &File) -> hdf5::Result<()> {
        for (name, value) in &self.attributes {
            attribute(file, name, value)?;
        }
        for (name, datatype, node) in &self.nodes {
            match node {
                Node::Empty => {
                    let group = file.create_group(name)?;
                    attribute(&group, "datatype", datatype)?;
                }
                node => {
                    let dataset = dataset(file, name, node)?;
                    attribute(&dataset, "datatype", datatype)?;
                }
            }
        }
        Ok(())
    }
}

fn dataset(file: &File, name: &str, node: &Node) -> hdf5::Result<hdf5::Dataset> {
    fn array<T: hdf5::H5Type>(
        file: &File,
        name: &str,
        shape: &[usize],
        values: &[T],
    ) -> hdf5::Result<hdf5::Dataset> {
        let builder = file.new_dataset::<T>().no_chunk();
        let dataset = builder.shape(shape.to_vec()).create(name)?;
        if !values.is_empty() {
            dataset.write_raw(values)?;
        }
        Ok(dataset)
    }
    fn scalar<T: hdf5::H5Type>(file: &File, name: &str, value: &T) -> hdf5::Result<hdf5::Dataset> {
        let dataset = file.new_dataset::<T>().create(name)?;
        dataset.write_scalar(value)?;
        Ok(dataset)
    }
    match node {
        Node::Reals(shape, values) => array(file, name, shape, values),
        Node::Integers(shape, values) => array(file, name, shape, values),
        Node::Real(value) => scalar(file, name, value),
        Node::Integer(value) => scalar(file, name, value),
        Node::Text(value) => scalar(file, name, &text(value)?),
        Node::Empty => Err(hdf5::Error::from("a group isn't a dataset")),
    }
}

fn attribute(object: &Location, name: &str, value: &str) -> hdf5::Result<()> {
    let attribute = object.new_attr::<VarLenUnicode>().create(name)?;
    attribute.write_scalar(&text(value)?)
}

fn text(value: &str) -> hdf5::Result<VarLenUnicode> {
    value
        .parse()
        .map_err(|_| hdf5::Error::from(format!("{value:?} has a zero byte")))
}
