//! Strings of a dataset, read from the file's bytes.
//!
//! A variable-length string is stored as its length and a place in a "global heap": a block that starts with
//! `GCOL` and lists objects. libhdf5 before 1.14 copies whatever size the heap claims into a buffer made for the
//! length that the dataset claims; here both are read and must agree, so a hostile file can't make use of that.

use std::collections::HashMap;
use std::fs::File;

use super::storage::read_bytes;

/// Bytes of one string in a dataset: length (4), address of the heap block (8), index in it (4).
pub(super) const DESCRIPTOR_BYTES: u64 = 16;
const HEAP_HEADER_BYTES: usize = 16;
const OBJECT_HEADER_BYTES: usize = 16;
/// Blocks are 4096 bytes unless a single string is longer.
const LONGEST_HEAP: u64 = 1 << 26;

/// The strings whose descriptors stand at `offset`.
///
/// # Errors
/// What was found and what would be right.
pub(super) fn read_texts(file: &File, file_bytes: u64, offset: u64, count: usize) -> Result<Vec<String>, String> {
    let descriptors = read_bytes(file, file_bytes, offset, count as u64 * DESCRIPTOR_BYTES)?;
    let mut heaps = HashMap::new();
    let mut texts = Vec::with_capacity(count);
    for descriptor in descriptors.chunks_exact(DESCRIPTOR_BYTES as usize) {
        let length = number(&descriptor[0..4]) as usize;
        let address = number(&descriptor[4..12]);
        let index = number(&descriptor[12..16]);
        if length == 0 {
            texts.push(String::new());
            continue;
        }
        if let std::collections::hash_map::Entry::Vacant(entry) = heaps.entry(address) {
            entry.insert(Heap::read(file, file_bytes, address)?);
        }
        let bytes = heaps.get(&address).and_then(|heap| heap.object(index));
        let bytes = bytes.filter(|bytes| bytes.len() == length).ok_or_else(|| {
            format!("a string of {length} bytes isn't where it should be (heap block at byte {address}, object {index})")
        })?;
        let text = std::str::from_utf8(bytes).map_err(|_| "a string isn't UTF-8".to_owned())?;
        texts.push(text.to_owned());
    }
    Ok(texts)
}

/// One heap block: its bytes, and where each object's lie.
struct Heap {
    bytes: Vec<u8>,
    objects: HashMap<u64, std::ops::Range<usize>>,
}

impl Heap {
    fn read(file: &File, file_bytes: u64, address: u64) -> Result<Self, String> {
        let header = read_bytes(file, file_bytes, address, HEAP_HEADER_BYTES as u64)?;
        if &header[0..5] != b"GCOL\x01" {
            return Err(format!("no heap block of version 1 at byte {address}, where a string should be"));
        }
        let size = number(&header[8..16]);
        if size > LONGEST_HEAP {
            return Err(format!("the heap block at byte {address} claims {size} bytes"));
        }
        let bytes = read_bytes(file, file_bytes, address, size)?;
        let mut objects = HashMap::new();
        let mut at = HEAP_HEADER_BYTES;
        while let Some(object) = bytes.get(at..at + OBJECT_HEADER_BYTES) {
            let index = number(&object[0..2]);
            if index == 0 {
                break; // free space up to the end
            }
            let size = usize::try_from(number(&object[8..16])).ok();
            let start = at + OBJECT_HEADER_BYTES;
            let end = size.and_then(|size| start.checked_add(size)).filter(|end| *end <= bytes.len());
            let end = end.ok_or_else(|| format!("object {index} of the heap block at byte {address} ends beyond it"))?;
            objects.insert(index, start..end);
            at = end.next_multiple_of(8);
        }
        Ok(Self { bytes, objects })
    }

    fn object(&self, index: u64) -> Option<&[u8]> {
        self.bytes.get(self.objects.get(&index)?.clone())
    }
}

/// Little-endian, up to eight bytes.
fn number(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |number, &byte| (number << 8) | u64::from(byte))
}
