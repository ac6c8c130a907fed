//! MATLAB files of version 5: little-endian, nothing compressed; real matrices, texts and lists of texts.
//!
//! An element is its type and its length in bytes, 32 bits each, then its data, padded to 8 bytes. A matrix is an element of elements: flags, sizes, name, data by columns.

use faer::Mat;

/// Types of data.
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
/// Classes of arrays.
const CELL: u32 = 1;
const CHAR: u32 = 4;
const REALS: u32 = 6;
/// Flag beside the class: imaginary parts follow the real ones.
const COMPLEX: u32 = 0x0800;
/// Text at the beginning, with blanks behind it.
const HEADER: usize = 116;

/// A file that is being filled.
pub(crate) struct MatFile {
    bytes: Vec<u8>,
}

impl MatFile {
    /// A file that begins with a text of at most 116 letters.
    pub(crate) fn new(text: &str) -> Self {
        let mut bytes: Vec<u8> = text.bytes().filter(u8::is_ascii).take(HEADER).collect();
        bytes.resize(HEADER, b' ');
        bytes.extend([0; 8]);
        bytes.extend(0x0100_u16.to_le_bytes());
        bytes.extend(b"IM");
        Self { bytes }
    }

    /// A matrix.
    pub(crate) fn matrix(&mut self, name: &str, of: &Mat<f64>) {
        let values = (0..of.ncols()).flat_map(|j| (0..of.nrows()).map(move |i| of[(i, j)]));
        let data: Vec<u8> = values.flat_map(f64::to_le_bytes).collect();
        let array = array(REALS, [of.nrows(), of.ncols()], name, &[(DOUBLE, data)]);
        element(&mut self.bytes, MATRIX, &array);
    }

    /// A column of complex numbers.
    pub(crate) fn complex(&mut self, name: &str, values: &[[f64; 2]]) {
        let part = |place: usize| -> (u32, Vec<u8>) {
            let numbers = values.iter().flat_map(|value| value[place].to_le_bytes());
            (DOUBLE, numbers.collect())
        };
        let class = REALS | COMPLEX;
        let array = array(class, [values.len(), 1], name, &[part(0), part(1)]);
        element(&mut self.bytes, MATRIX, &array);
    }

    /// A text.
    pub(crate) fn text(&mut self, name: &str, text: &str) {
        element(&mut self.bytes, MATRIX, &characters(name, text));
    }

    /// A list of texts, one a row.
    pub(crate) fn texts(&mut self, name: &str, texts: &[&str]) {
        let cells: Vec<(u32, Vec<u8>)> = texts
            .iter()
            .map(|text| (MATRIX, characters("", text)))
            .collect();
        let array = array(CELL, [texts.len(), 1], name, &cells);
        element(&mut self.bytes, MATRIX, &array);
    }

    /// All bytes.
    pub(crate) fn finish(self) -> Vec<u8> {
        self.bytes
    }
}

fn characters(name: &str, text: &str) -> Vec<u8> {
    let units: Vec<u16> = text.encode_utf16().collect();
    let data = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
    let size = [usize::from(!units.is_empty()), units.len()];
    array(CHAR, size, name, &[(UINT16, data)])
}

fn array(class: u32, size: [usize; 2], name: &str, data: &[(u32, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let flags: Vec<u8> = [class, 0]
        .iter()
        .flat_map(|word| word.to_le_bytes())
        .collect();
    element(&mut bytes, UINT32, &flags);
    let size = size.map(|size| i32::try_from(size).unwrap_or(i32::MAX));
    let size: Vec<u8> = size.iter().flat_map(|size| size.to_le_bytes()).collect();
    element(&mut bytes, INT32, &size);
    element(&mut bytes, INT8, name.as_bytes());
    for (kind, data) in data {
        element(&mut bytes, *kind, data);
    }
    bytes
}

fn element(bytes: &mut Vec<u8>, kind: u32, data: &[u8]) {
    bytes.extend(kind.to_le_bytes());
    bytes.extend(u32::try_from(data.len()).unwrap_or(u32::MAX).to_le_bytes());
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
}
