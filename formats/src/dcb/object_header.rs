//! The HDF5 container, as much of it as the format allows: superblock of version 2 or 3, object headers of
//! version 2, everything in them "compact".
//!
//! Files from strangers are read by this module and not by libhdf5, whose older versions trust what a file says
//! about its own strings. Section numbers are those of the HDF5 File Format Specification, version 3.

use super::bytes::{Cursor, FileBytes};

const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
/// The address that means "nowhere".
pub(super) const UNDEFINED: u64 = u64::MAX;
/// Blocks of one object header, at most.
const MOST_BLOCKS: usize = 65_536;

/// Address of the root group's header (II.A).
///
/// # Errors
/// It isn't HDF5, of another kind, or truncated.
pub(super) fn root(file: &FileBytes) -> Result<u64, String> {
    let is_hdf5 = file.read(0, 8).is_ok_and(|bytes| bytes == SIGNATURE);
    if !is_hdf5 {
        return Err("isn't an HDF5 file; a superelement is what `reduce` writes".to_owned());
    }
    let bytes = file
        .read(8, 40)
        .map_err(|_| "is an HDF5 file of which only the beginning is there".to_owned())?;
    let mut at = Cursor::new(&bytes);
    let version = at.byte()?;
    if !(2..=3).contains(&version) {
        return Err(format!(
            "is an HDF5 file with superblock version {version}; superelements have version 2 or 3"
        ));
    }
    let (offset_size, length_size) = (at.byte()?, at.byte()?);
    let _flags = at.byte()?;
    let base = at.number(8)?;
    let _extension = at.number(8)?;
    let end = at.number(8)?;
    if (offset_size, length_size, base) != (8, 8, 0) {
        return Err(
            "is an HDF5 file with short or shifted addresses, which superelements don't have"
                .to_owned(),
        );
    }
    if end != file.length() {
        return Err(format!(
            "has {} bytes, but was written with {end}: it is truncated or damaged",
            file.length()
        ));
    }
    at.number(8)
}

/// One message of an object header (IV.A.2).
#[derive(Debug)]
pub(super) struct Message {
    pub(super) kind: u64,
    pub(super) body: Vec<u8>,
}

/// Kinds of messages.
pub(super) mod kind {
    pub(in crate::dcb) const DATASPACE: u64 = 0x01;
    pub(in crate::dcb) const LINK_INFO: u64 = 0x02;
    pub(in crate::dcb) const DATATYPE: u64 = 0x03;
    pub(in crate::dcb) const LINK: u64 = 0x06;
    pub(in crate::dcb) const EXTERNAL: u64 = 0x07;
    pub(in crate::dcb) const LAYOUT: u64 = 0x08;
    pub(in crate::dcb) const FILTERS: u64 = 0x0b;
    pub(in crate::dcb) const ATTRIBUTE: u64 = 0x0c;
    pub(in crate::dcb) const CONTINUATION: u64 = 0x10;
    pub(in crate::dcb) const ATTRIBUTE_INFO: u64 = 0x15;
}

/// The messages of the object at `address` (IV.A.1.b).
///
/// # Errors
/// There is no header of version 2, or it isn't whole.
pub(super) fn messages(file: &FileBytes, address: u64) -> Result<Vec<Message>, String> {
    let no_header = |_| format!("no object header of version 2 at byte {address}");
    let prefix = file.read(address, 6).map_err(no_header)?;
    if &prefix[..5] != b"OHDR\x02" {
        return Err(no_header(String::new()));
    }
    let flags = prefix[5];
    let times = if flags & 0x20 != 0 { 16 } else { 0 };
    let phases = if flags & 0x10 != 0 { 4 } else { 0 };
    let size_bytes = 1_u64 << (flags & 3);
    let size_at = address + 6 + times + phases;
    let size = Cursor::new(&file.read(size_at, size_bytes)?).number(size_bytes as usize)?;
    let ordered = flags & 0x04 != 0;

    let mut messages = Vec::new();
    let mut blocks = vec![(size_at + size_bytes, size)];
    let mut bytes_left = file.length();
    let mut next = 0;
    while let Some(&(offset, size)) = blocks.get(next) {
        next += 1;
        bytes_left = bytes_left
            .checked_sub(size)
            .filter(|_| next <= MOST_BLOCKS)
            .ok_or("its header goes round in circles")?;
        let block = file.read(offset, size)?;
        for message in block_messages(&block, ordered)? {
            if message.kind == kind::CONTINUATION {
                let mut at = Cursor::new(&message.body);
                let (offset, length) = (at.number(8)?, at.number(8)?);
                if !file
                    .read(offset, 4)
                    .is_ok_and(|signature| signature == b"OCHK")
                    || length < 8
                {
                    return Err(format!(
                        "its header should go on at byte {offset}, but doesn't"
                    ));
                }
                blocks.push((offset + 4, length - 8)); // without signature and checksum
            } else {
                messages.push(message);
            }
        }
    }
    Ok(messages)
}

fn block_messages(block: &[u8], ordered: bool) -> Result<Vec<Message>, String> {
    let prefix = if ordered { 6 } else { 4 };
    let mut messages = Vec::new();
    let mut at = Cursor::new(block);
    while at.left() >= prefix {
        let kind = at.number(1)?;
        let size = at.number(2)? as usize;
        let flags = at.byte()?;
        if ordered {
            at.number(2)?;
        }
        let body = at.take(size)?;
        match kind {
            0 => continue, // a gap
            _ if flags & 0x02 != 0 => {
                return Err("its header shares parts with others, which isn't allowed".to_owned());
            }
            _ => messages.push(Message {
                kind,
                body: body.to_vec(),
            }),
        }
    }
    Ok(messages)
}
