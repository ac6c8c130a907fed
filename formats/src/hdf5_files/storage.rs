//! Storage of a dataset: the claims of its layout are compared with the file before the HDF5 library takes memory for it.
//!
//! Chunks are found through one of five indices (B-tree of version 1, single chunk, implicit, fixed array, extensible
//! array; the library can't read a B-tree of version 2). The library lists the chunks of all of them in the same way, so
//! one check of that list serves them all: place, size, and what a chunk's bytes can become.

use std::sync::OnceLock;

use hdf5_pure::{
    Chunk, DType, Dataset, Datatype, DatatypeByteOrder, FixedPointLayout, FloatingPointLayout,
    Layout,
};

use super::container::Container;
use super::element::Element;

/// Axes of a dataset, at most.
const MOST_AXES: usize = 8;
/// Deflate can't do better than 1:1032.
const LARGEST_DEFLATE_RATIO: u64 = 1032;
/// HDF5's numbers of the filters that may be used, each once.
const FILTERS: [(u16, &str); 3] = [(DEFLATE, "deflate"), (2, "shuffle"), (3, "fletcher32")];
/// The only one of them that makes data smaller.
const DEFLATE: u16 = 1;
/// The least that a chunk takes: its address in an index, or one element.
const LEAST_CHUNK_BYTES: u64 = 8;
/// Rows of a matrix are read together up to this many values: 1 MiB.
const WINDOW_VALUES: usize = 1 << 17;

/// A dataset of a file, and what is known of its place in the file.
#[derive(Debug)]
pub struct Storage {
    dataset: Dataset,
    shape: Vec<usize>,
    /// Stored bytes that the data need at least.
    needed: u64,
    /// Elements of a chunk by axis, where there are chunks.
    chunk: Option<ChunkSize>,
    /// Set once the chunks were compared with the file.
    fits: OnceLock<()>,
}

/// Size of a chunk.
#[derive(Debug)]
struct ChunkSize {
    rows: u64,
    /// Stored bytes that it needs at least.
    needed: u64,
}

impl Storage {
    /// Looks at a dataset, without its data and chunks: the file must be able to hold an array of its shape.
    ///
    /// # Errors
    /// It claims more than the file can hold, or has filters that aren't known here.
    pub fn of(dataset: Dataset, file_bytes: u64) -> Result<Self, String> {
        let shape = dataset.shape().map_err(unreadable)?;
        if shape.len() > MOST_AXES {
            return Err(format!("has {} axes", shape.len()));
        }
        let impossible = || format!("has the impossible shape {shape:?}");
        let element_bytes = dataset.element_size().map_err(unreadable)?;
        let bytes_of = |shape: &[u64]| -> Result<u64, String> {
            let product = shape
                .iter()
                .try_fold(element_bytes, |product, &size| product.checked_mul(size));
            product.ok_or_else(impossible)
        };
        let ratio = largest_ratio(&dataset.filters())?;
        let bytes = bytes_of(&shape)?;
        let needed = bytes / ratio;
        if needed > file_bytes {
            return Err(format!(
                "of shape {shape:?} needs {bytes} bytes, which a file of {file_bytes} can't hold"
            ));
        }
        let chunk = match dataset.layout().map_err(unreadable)? {
            // Where there is nothing in it no chunk is stored either.
            Layout::Chunked { chunk_shape, .. } if bytes > 0 => {
                let needed = bytes_of(&chunk_shape)? / ratio;
                let counts = shape.iter().zip(&chunk_shape);
                let count = counts.fold(1, |count: u64, (size, chunk)| {
                    count.saturating_mul(size.div_ceil((*chunk).max(1)))
                });
                if needed > file_bytes || count > file_bytes / LEAST_CHUNK_BYTES {
                    return Err(format!(
                        "of shape {shape:?} has {count} chunks of shape {chunk_shape:?}, which a file of {file_bytes} bytes can't hold"
                    ));
                }
                let rows = chunk_shape.first().copied().unwrap_or(1);
                Some(ChunkSize { rows, needed })
            }
            Layout::Virtual => {
                return Err("has its data in other files, which isn't allowed".to_owned());
            }
            _ => None,
        };
        let sizes = shape.iter().map(|&size| usize::try_from(size));
        let sizes = sizes.collect::<Result<_, _>>().map_err(|_| impossible())?;
        Ok(Self {
            dataset,
            shape: sizes,
            needed,
            chunk,
            fits: OnceLock::new(),
        })
    }

    /// Size of each axis.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Stored bytes that the data need at least.
    pub fn needed(&self) -> u64 {
        self.needed
    }

    /// Whether the strings have lengths of their own.
    pub(crate) fn has_variable_strings(&self) -> bool {
        let kind = self.dataset.dtype();
        kind.is_ok_and(|kind| kind == DType::VariableLengthString)
    }

    /// The layout, as the file says it.
    ///
    /// # Errors
    /// It can't be read.
    pub(crate) fn layout(&self) -> Result<Layout, String> {
        self.dataset.layout().map_err(unreadable)
    }

    /// Rows of a matrix to read together: about 1 MiB, and whole chunks, so that none is decoded twice.
    pub fn window_rows(&self, rows: usize, columns: usize) -> usize {
        let window = (WINDOW_VALUES / columns.max(1)).max(1);
        let chunk_rows = self.chunk.as_ref().map_or(1, |chunk| chunk.rows);
        let chunk_rows = usize::try_from(chunk_rows).unwrap_or(usize::MAX);
        window.next_multiple_of(chunk_rows.clamp(1, rows.max(1)))
    }

    /// The dataset, for reading its data: the only way to it, so that no chunk is read unchecked.
    ///
    /// # Errors
    /// A chunk isn't inside the file, or can't hold what it claims.
    pub fn data(&self, file: &Container) -> Result<&Dataset, String> {
        if let (Some(size), None) = (&self.chunk, self.fits.get()) {
            file.allow_reading();
            check_chunks(
                &self.dataset.chunks().map_err(unreadable)?,
                size,
                file.length(),
            )?;
            let _ = self.fits.set(());
        }
        Ok(&self.dataset)
    }
}

fn unreadable(error: hdf5_pure::Error) -> String {
    format!("can't be read: {error}")
}

/// How many times as large as stored the data can be.
fn largest_ratio(filters: &[u16]) -> Result<u64, String> {
    let known = |filter: &u16| FILTERS.iter().any(|(known, _)| known == filter);
    if let Some(unknown) = filters.iter().find(|filter| !known(filter)) {
        return Err(format!(
            "is stored with filter {unknown}; only {:?} may be used",
            FILTERS.map(|(_, name)| name)
        ));
    }
    if (1..filters.len()).any(|index| filters[..index].contains(&filters[index])) {
        return Err(format!(
            "is stored with filters {filters:?}; each may be used once"
        ));
    }
    Ok(match filters.contains(&DEFLATE) {
        true => LARGEST_DEFLATE_RATIO,
        false => 1,
    })
}

/// Every chunk lies in the file, is large enough for what it must become, and shares the file with the others.
fn check_chunks(chunks: &[Chunk], size: &ChunkSize, file_bytes: u64) -> Result<(), String> {
    let mut together = 0_u64;
    for chunk in chunks {
        let stored = chunk.storage_size;
        let end = chunk.address.checked_add(stored);
        if end.is_none_or(|end| end > file_bytes) {
            return Err(format!(
                "has a chunk of {stored} bytes from byte {} on, which a file of {file_bytes} can't hold",
                chunk.address
            ));
        }
        if stored < size.needed {
            return Err(format!(
                "has a chunk of {stored} bytes; its shape needs {} at least",
                size.needed
            ));
        }
        together = together.saturating_add(stored);
    }
    match together > file_bytes {
        true => Err(format!(
            "has chunks of {together} bytes together, which a file of {file_bytes} can't hold"
        )),
        false => Ok(()),
    }
}

/// Element type of a dataset, one of three.
///
/// # Errors
/// It is another one, or can't be read.
pub(crate) fn element_of(dataset: &Dataset) -> Result<Element, String> {
    element(&dataset.datatype().map_err(unreadable)?)
}

fn element(datatype: &Datatype) -> Result<Element, String> {
    let whole = FixedPointLayout {
        signed: true,
        bit_offset: 0,
        bit_precision: 64,
    };
    match datatype {
        Datatype::FloatingPoint {
            size: 8,
            byte_order: DatatypeByteOrder::LittleEndian,
            layout,
        } if *layout == FloatingPointLayout::IEEE754_BINARY64 => Ok(Element::Real),
        Datatype::FixedPoint {
            size: 8,
            byte_order: DatatypeByteOrder::LittleEndian,
            layout,
        } if *layout == whole => Ok(Element::Integer),
        Datatype::String { .. }
        | Datatype::VariableLength {
            is_string: true, ..
        } => Ok(Element::Text),
        _ => Err(
            "holds something else than little-endian f64, little-endian i64 or strings".to_owned(),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deflated twice, data could be a million times as large as stored.
    #[test]
    fn only_known_filters_are_used_and_each_once() {
        assert_eq!(largest_ratio(&[2, 1, 3]), Ok(1032));
        assert_eq!(largest_ratio(&[2, 3]), Ok(1));
        for refused in [[1, 1].as_slice(), &[1, 2, 1], &[4], &[1, 32015]] {
            assert!(largest_ratio(refused).is_err(), "{refused:?}");
        }
    }
}
