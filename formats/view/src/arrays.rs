//! Numbers of a page: one block of bytes, compressed, as text.

use std::io::{self, Write as _};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;

/// Where an array is in the block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Array {
    /// Bytes before it, a multiple of 4.
    pub offset: usize,
    /// Number of values.
    pub length: usize,
    /// What its values are.
    #[serde(rename = "type")]
    pub element: &'static str,
}

/// The block, while it grows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Arrays {
    bytes: Vec<u8>,
}

impl Arrays {
    /// Reals in single precision. Values that aren't finite become zero: a picture has no place for them.
    pub fn reals(&mut self, values: impl IntoIterator<Item = f64>) -> Array {
        let values = values.into_iter().map(|value| {
            let single = value as f32;
            if single.is_finite() { single } else { 0.0 }
        });
        self.append("f32", values.map(f32::to_le_bytes))
    }

    /// Numbers of nodes and cells.
    pub fn indices(&mut self, values: impl IntoIterator<Item = u32>) -> Array {
        self.append("u32", values.into_iter().map(u32::to_le_bytes))
    }

    /// Small integers.
    pub fn shorts(&mut self, values: impl IntoIterator<Item = i16>) -> Array {
        self.append("i16", values.into_iter().map(i16::to_le_bytes))
    }

    /// Bytes so far, before they are compressed.
    pub fn byte_count(&self) -> usize {
        self.bytes.len()
    }

    /// The reals, or small integers, of an array.
    pub(crate) fn reals_of(&self, array: Array) -> Vec<f64> {
        match array.element {
            "i16" => {
                let shorts = self.chunks(array).map(i16::from_le_bytes);
                shorts.map(f64::from).collect()
            }
            _ => {
                let singles = self.chunks(array).map(f32::from_le_bytes);
                singles.map(f64::from).collect()
            }
        }
    }

    /// The same, three by three.
    pub(crate) fn vectors_of(&self, array: Array) -> Vec<[f64; 3]> {
        let all = self.reals_of(array);
        all.chunks_exact(3)
            .map(|at| [at[0], at[1], at[2]])
            .collect()
    }

    /// The numbers of nodes and cells of an array.
    pub(crate) fn indices_of(&self, array: Array) -> Vec<u32> {
        self.chunks(array).map(u32::from_le_bytes).collect()
    }

    fn chunks<const N: usize>(&self, array: Array) -> impl Iterator<Item = [u8; N]> + '_ {
        let bytes = self.bytes.get(array.offset..).unwrap_or_default();
        let chunks = bytes.chunks_exact(N).take(array.length);
        chunks.map(|chunk| std::array::from_fn(|byte| chunk[byte]))
    }

    fn append<const N: usize>(
        &mut self,
        element: &'static str,
        values: impl Iterator<Item = [u8; N]>,
    ) -> Array {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend(values.flatten());
        Array {
            offset,
            length: (self.bytes.len() - offset) / N,
            element,
        }
    }

    /// The block as a zlib stream in base64.
    ///
    /// # Errors
    /// Of the compression.
    pub fn encoded(&self) -> io::Result<String> {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&self.bytes)?;
        Ok(STANDARD.encode(encoder.finish()?))
    }
}

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests {
    use super::*;
    use flate2::read::ZlibDecoder;
    use std::io::Read as _;

    #[test]
    fn arrays_are_found_again_where_the_description_says() {
        let mut arrays = Arrays::default();
        let shorts = arrays.shorts([-3, 7, 32767]);
        let reals = arrays.reals([1.5, f64::NAN, -2.0]);
        let indices = arrays.indices([9, 1 << 30]);
        assert_eq!((shorts.offset, reals.offset, indices.offset), (0, 8, 20));
        let encoded = arrays.encoded().expect("memory takes all bytes");
        let stream = STANDARD.decode(encoded).expect("base64");
        let mut bytes = Vec::new();
        ZlibDecoder::new(&stream[..])
            .read_to_end(&mut bytes)
            .expect("a zlib stream");
        let four = |at: usize| [0, 1, 2, 3].map(|byte| bytes[at + byte]);
        assert_eq!(i16::from_le_bytes([bytes[0], bytes[1]]), -3);
        assert_eq!(
            [8, 12, 16].map(|at| f32::from_le_bytes(four(at))),
            [1.5, 0.0, -2.0]
        );
        assert_eq!(u32::from_le_bytes(four(24)), 1 << 30);
    }
}
