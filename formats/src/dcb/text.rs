//! Variable-length strings: a length and a place in a "global heap", a block that starts with `GCOL` and lists
//! objects (III.E of the HDF5 File Format Specification).

use std::collections::HashMap;
use std::ops::Range;

use super::bytes::{Cursor, FileBytes};

/// Bytes of what stands for a string: its length (4), the address of the heap block (8), the object's index (4).
pub(super) const DESCRIPTOR_BYTES: u64 = 16;
const HEAP_HEADER_BYTES: usize = 16;
const OBJECT_HEADER_BYTES: usize = 16;

/// Reader of strings. No honest file refers to a string twice, so all strings together, and all heap blocks
/// together, are at most as long as the file.
pub(super) struct Texts<'f> {
    file: &'f FileBytes,
    heaps: HashMap<u64, Heap>,
    heap_bytes_left: u64,
    text_bytes_left: u64,
}

impl<'f> Texts<'f> {
    /// Nothing read yet.
    pub(super) fn new(file: &'f FileBytes) -> Self {
        Self {
            file,
            heaps: HashMap::new(),
            heap_bytes_left: file.length(),
            text_bytes_left: file.length(),
        }
    }

    /// The string that the next bytes stand for.
    ///
    /// # Errors
    /// What was found and what would be right.
    pub(super) fn next(&mut self, at: &mut Cursor) -> Result<String, String> {
        let (length, address, index) = (at.number(4)?, at.number(8)?, at.number(4)?);
        if length == 0 {
            return Ok(String::new());
        }
        self.text_bytes_left = self
            .text_bytes_left
            .checked_sub(length)
            .ok_or("refers to more strings than the file can hold")?;
        if !self.heaps.contains_key(&address) {
            let heap = Heap::read(self.file, address, &mut self.heap_bytes_left)?;
            self.heaps.insert(address, heap);
        }
        let bytes = self.heaps.get(&address).and_then(|heap| heap.object(index));
        let bytes = bytes.filter(|bytes| bytes.len() as u64 == length).ok_or_else(|| {
            format!("has a string of {length} bytes that isn't where it should be (heap block at byte {address}, object {index})")
        })?;
        let text =
            std::str::from_utf8(bytes).map_err(|_| "has a string that isn't UTF-8".to_owned())?;
        if text.contains('\0') {
            return Err("has a string with a zero byte".to_owned());
        }
        Ok(text.to_owned())
    }
}

/// One heap block: its bytes, and where each object's lie.
struct Heap {
    bytes: Vec<u8>,
    objects: HashMap<u64, Range<usize>>,
}

impl Heap {
    fn read(file: &FileBytes, address: u64, bytes_left: &mut u64) -> Result<Self, String> {
        let header = file.read(address, HEAP_HEADER_BYTES as u64)?;
        if &header[..5] != b"GCOL\x01" {
            return Err(format!(
                "has a string that should be at byte {address}, but no heap block of version 1 is there"
            ));
        }
        let size = Cursor::new(&header[8..]).number(8)?;
        *bytes_left = bytes_left
            .checked_sub(size)
            .ok_or("refers to more heap blocks than the file can hold")?;
        let bytes = file.read(address, size)?;
        let mut objects = HashMap::new();
        let mut start = HEAP_HEADER_BYTES;
        while let Some(header) = bytes.get(start..start + OBJECT_HEADER_BYTES) {
            let mut at = Cursor::new(header);
            let index = at.number(2)?;
            at.take(6)?;
            let size = usize::try_from(at.number(8)?).ok();
            if index == 0 {
                break; // free space up to the end
            }
            start += OBJECT_HEADER_BYTES;
            let end = size
                .and_then(|size| start.checked_add(size))
                .filter(|end| *end <= bytes.len());
            let end = end.ok_or_else(|| format!("has a string in the heap block at byte {address}, whose object {index} ends beyond it"))?;
            objects.insert(index, start..end);
            start = end.next_multiple_of(8);
        }
        Ok(Self { bytes, objects })
    }

    fn object(&self, index: u64) -> Option<&[u8]> {
        self.bytes.get(self.objects.get(&index)?.clone())
    }
}
