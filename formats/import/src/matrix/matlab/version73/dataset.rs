//! A dataset of numbers, read window by window.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::hdf5_files::container::Container;
use dcb_formats::hdf5_files::storage::Storage;
use hdf5_pure::{Dataset, Datatype, DatatypeByteOrder, FixedPointLayout, FloatingPointLayout};

use crate::binary::file::ByteOrder;
use crate::matrix::storage::number::{Kind, Number};
use crate::matrix::storage::stream::Stream;

/// A dataset whose claims fit the file.
#[derive(Debug)]
pub(super) struct Numbers {
    /// Where it is in the file.
    pub(super) place: String,
    pub(super) number: Number,
    storage: Storage,
}

impl Numbers {
    /// Looks at a dataset.
    ///
    /// # Errors
    /// What its elements are instead of numbers, or what the file can't hold.
    pub(super) fn of(dataset: Dataset, place: String, file: &Container) -> Result<Self, String> {
        let datatype = dataset
            .datatype()
            .map_err(|error| format!("of a type that can't be read: {error}"))?;
        let number = number(&datatype)?;
        let storage = Storage::of(dataset, file.length())?;
        Ok(Self {
            place,
            number,
            storage,
        })
    }

    /// Size of each axis.
    pub(super) fn shape(&self) -> &[usize] {
        self.storage.shape()
    }

    /// Number of elements.
    pub(super) fn count(&self) -> u64 {
        self.shape().iter().map(|size| *size as u64).product()
    }

    /// Its data, from the beginning.
    pub(super) fn stream<'a>(&'a self, path: &'a Path, file: &'a Container) -> Window<'a> {
        Window {
            path,
            file,
            numbers: self,
            next_row: 0,
            bytes: Vec::new(),
            at: 0,
        }
    }
}

/// Type of numbers.
///
/// # Errors
/// What they are instead.
fn number(datatype: &Datatype) -> Result<Number, String> {
    let order_of = |order: &DatatypeByteOrder| match order {
        DatatypeByteOrder::LittleEndian => Ok(ByteOrder::Little),
        DatatypeByteOrder::BigEndian => Ok(ByteOrder::Big),
        _ => Err("of numbers in an order of bytes that isn't supported".to_owned()),
    };
    let (kind, order) = match datatype {
        Datatype::FixedPoint {
            size,
            byte_order,
            layout,
        } => {
            let whole = |signed| FixedPointLayout {
                signed,
                bit_offset: 0,
                bit_precision: (8 * *size).try_into().unwrap_or(u16::MAX),
            };
            let kind = match (size, *layout == whole(true), *layout == whole(false)) {
                (1, true, _) => Kind::I8,
                (2, true, _) => Kind::I16,
                (4, true, _) => Kind::I32,
                (8, true, _) => Kind::I64,
                (1, _, true) => Kind::U8,
                (2, _, true) => Kind::U16,
                (4, _, true) => Kind::U32,
                (8, _, true) => Kind::U64,
                _ => return Err(format!("of integers of {size} bytes, or with spare bits")),
            };
            (kind, order_of(byte_order)?)
        }
        Datatype::FloatingPoint {
            size: 8,
            byte_order,
            layout,
        } if *layout == FloatingPointLayout::IEEE754_BINARY64 => (Kind::F64, order_of(byte_order)?),
        Datatype::FloatingPoint {
            size: 4,
            byte_order,
            layout,
        } if *layout == FloatingPointLayout::IEEE754_BINARY32 => (Kind::F32, order_of(byte_order)?),
        Datatype::Compound { .. } => return Err("complex".into()),
        Datatype::Reference { .. } => return Err("of references, a cell array".into()),
        _ => return Err("not of numbers".into()),
    };
    Ok(Number { kind, order })
}

/// The data of a dataset, of which a window is in memory.
pub(super) struct Window<'a> {
    path: &'a Path,
    file: &'a Container,
    numbers: &'a Numbers,
    next_row: usize,
    bytes: Vec<u8>,
    at: usize,
}

impl Window<'_> {
    /// Reads the next window.
    fn next(&mut self) -> Result<(), Error> {
        let storage = &self.numbers.storage;
        let rows = storage.shape().first().copied().unwrap_or(1);
        let across: usize = storage.shape().iter().skip(1).product();
        let count = storage
            .window_rows(rows, across)
            .min(rows.saturating_sub(self.next_row));
        if count == 0 || across == 0 {
            return Err(self.refused("ends too early; the file is damaged".into()));
        }
        let data = storage
            .data(self.file)
            .map_err(|message| self.refused(message))?;
        self.file.allow_reading();
        let read = data.read_raw_rows(self.next_row as u64, count as u64);
        let bytes = read.map_err(|error| self.refused(format!("can't be read: {error}")))?;
        if bytes.len() != count * across * self.numbers.number.size() {
            return Err(self.refused(format!(
                "has {} bytes in {count} rows; the file is damaged",
                bytes.len()
            )));
        }
        self.next_row += count;
        (self.bytes, self.at) = (bytes, 0);
        Ok(())
    }
}

impl Stream for Window<'_> {
    fn fill(&mut self, buffer: &mut [u8]) -> Result<(), Error> {
        let mut buffer = buffer;
        while !buffer.is_empty() {
            if self.at == self.bytes.len() {
                self.next()?;
            }
            let rest = &self.bytes[self.at..];
            let count = rest.len().min(buffer.len());
            let (now, later) = buffer.split_at_mut(count);
            now.copy_from_slice(&rest[..count]);
            (self.at, buffer) = (self.at + count, later);
        }
        Ok(())
    }

    fn held(&self) -> u64 {
        self.numbers.storage.needed()
    }

    fn refused(&self, message: String) -> Error {
        Error::Location {
            path: self.path.into(),
            location: self.numbers.place.clone(),
            message,
        }
    }
}
