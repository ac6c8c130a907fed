//! Where a dataset's bytes lie in the file: established and bounded before anything is allocated for them.

use std::fs::File;
use std::os::unix::fs::FileExt;

use hdf5::dataset::Layout;
use hdf5::filters::Filter;

use super::contract::Element;
use super::text;

/// Deflate can't do better than 1:1032.
const LARGEST_DEFLATE_RATIO: u64 = 1032;
/// A larger chunk makes no sense and would be allocated whole.
const LARGEST_CHUNK_BYTES: u64 = 1 << 26;

/// How a dataset's elements are stored.
#[derive(Clone, Debug)]
pub(super) enum Storage {
    /// In one piece from this byte on; nowhere if there are no elements.
    Contiguous(u64),
    /// In chunks, to be read by HDF5.
    Compressed,
}

/// Finds and checks the storage of a dataset of this element type and shape.
///
/// # Errors
/// What was found and what would be right.
pub(super) fn locate(
    dataset: &hdf5::Dataset,
    element: Element,
    shape: &[usize],
    may_compress: bool,
    file_bytes: u64,
) -> Result<Storage, String> {
    let told = |error: hdf5::Error| format!("its storage is unreadable: {error}");
    let element_bytes = if element == Element::Text { text::DESCRIPTOR_BYTES } else { 8 };
    let count = shape.iter().try_fold(1_u64, |product, &size| product.checked_mul(size as u64));
    let bytes = count.and_then(|count| count.checked_mul(element_bytes));
    let bytes = bytes.ok_or_else(|| format!("its shape {shape:?} is impossible"))?;
    let creation = dataset.dcpl().map_err(told)?;
    let filters = creation.get_filters().map_err(told)?;
    match creation.get_layout().map_err(told)? {
        _ if bytes == 0 => Ok(Storage::Contiguous(0)),
        Layout::Contiguous => {
            if !creation.get_external().map_err(told)?.is_empty() {
                return Err("its data lie in another file, which isn't allowed".to_owned());
            }
            let offset = dataset.offset().ok_or("it has a shape but no data")?;
            let stored = dataset.storage_size();
            let fits = offset.checked_add(bytes).is_some_and(|end| end <= file_bytes);
            if stored != bytes || !fits {
                return Err(format!(
                    "its shape {shape:?} needs {bytes} bytes, but {stored} are stored from byte {offset} of a file of {file_bytes}"
                ));
            }
            Ok(Storage::Contiguous(offset))
        }
        Layout::Chunked if may_compress && element == Element::Real => {
            let known = |filter: &Filter| matches!(filter, Filter::Deflate(_) | Filter::Shuffle | Filter::Fletcher32);
            if let Some(filter) = filters.iter().find(|filter| !known(filter)) {
                return Err(format!("its filter {filter:?} isn't one of shuffle, deflate and fletcher32"));
            }
            let stored = dataset.storage_size();
            let ratio = if filters.iter().any(|filter| matches!(filter, Filter::Deflate(_))) { LARGEST_DEFLATE_RATIO } else { 1 };
            if stored > file_bytes || bytes / ratio > stored {
                return Err(format!(
                    "its shape {shape:?} needs {bytes} bytes, but {stored} compressed ones can't hold them (file of {file_bytes})"
                ));
            }
            let chunk = creation.get_chunk().map_err(told)?.unwrap_or_default();
            let chunk_bytes = chunk.iter().try_fold(8_u64, |product, &size| product.checked_mul(size as u64));
            if chunk.len() != shape.len() || chunk_bytes.is_none_or(|bytes| bytes > LARGEST_CHUNK_BYTES) {
                return Err(format!("its chunks {chunk:?} exceed {LARGEST_CHUNK_BYTES} bytes"));
            }
            Ok(Storage::Compressed)
        }
        other => Err(format!("its layout is {other:?}; it must be contiguous (field arrays may be chunked)")),
    }
}

/// Bytes of the file, if it has them.
///
/// # Errors
/// The range leaves the file, or the system's answer.
pub(super) fn read_bytes(file: &File, file_bytes: u64, offset: u64, count: u64) -> Result<Vec<u8>, String> {
    check_range(file_bytes, offset, count)?;
    let count = usize::try_from(count).map_err(|_| format!("{count} bytes don't fit in memory"))?;
    let mut bytes = vec![0; count];
    file.read_exact_at(&mut bytes, offset).map_err(|error| format!("cannot be read: {error}"))?;
    Ok(bytes)
}

/// Reals of the file; the caller has checked the range with [`locate`].
///
/// # Errors
/// The system's answer.
pub(super) fn read_reals(file: &File, offset: u64, reals: &mut [f64]) -> Result<(), String> {
    let mut block = vec![0_u8; 8 * reals.len().min(8192)];
    let mut at = offset;
    for part in reals.chunks_mut(8192) {
        let bytes = &mut block[..8 * part.len()];
        file.read_exact_at(bytes, at).map_err(|error| format!("cannot be read: {error}"))?;
        for (real, bytes) in part.iter_mut().zip(bytes.chunks_exact(8)) {
            *real = f64::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3], bytes[4], bytes[5], bytes[6], bytes[7]]);
        }
        at += bytes.len() as u64;
    }
    Ok(())
}

fn check_range(file_bytes: u64, offset: u64, count: u64) -> Result<(), String> {
    match offset.checked_add(count) {
        Some(end) if end <= file_bytes => Ok(()),
        _ => Err(format!("{count} bytes from byte {offset} on leave the file of {file_bytes} bytes")),
    }
}
