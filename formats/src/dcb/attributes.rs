//! Attributes: four kinds of value, written and read with every surprise refused.

use hdf5::Location;
use hdf5::types::{FloatSize, IntSize, TypeDescriptor, VarLenUnicode};

/// What an attribute may hold.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// One string.
    Text(String),
    /// A list of strings.
    Texts(Vec<String>),
    /// One real.
    Real(f64),
    /// One integer.
    Integer(i64),
}

impl Value {
    /// As the digest writes it: reals as the hexadecimal digits of their bits, so that no language rounds them.
    pub(super) fn canonical(&self) -> serde_json::Value {
        match self {
            Self::Text(text) => text.as_str().into(),
            Self::Texts(texts) => texts.as_slice().into(),
            Self::Real(real) => format!("{:016x}", real.to_bits()).into(),
            Self::Integer(integer) => (*integer).into(),
        }
    }
}

/// An HDF5 string; HDF5 ends strings at a zero byte, so one inside is refused.
pub(super) fn hdf5_text(text: &str) -> hdf5::Result<VarLenUnicode> {
    text.parse().map_err(|_| hdf5::Error::from(format!("{text:?} contains a zero byte")))
}

/// Writes an attribute.
pub(super) fn write(object: &Location, name: &str, value: &Value) -> hdf5::Result<()> {
    match value {
        Value::Text(text) => object.new_attr::<VarLenUnicode>().create(name)?.write_scalar(&hdf5_text(text)?),
        Value::Texts(texts) => {
            let texts = texts.iter().map(|text| hdf5_text(text)).collect::<hdf5::Result<Vec<_>>>()?;
            object.new_attr::<VarLenUnicode>().shape(texts.len()).create(name)?.write_raw(&texts)
        }
        Value::Real(real) => object.new_attr::<f64>().create(name)?.write_scalar(real),
        Value::Integer(integer) => object.new_attr::<i64>().create(name)?.write_scalar(integer),
    }
}

/// Reads an attribute; its list may have at most `longest` entries.
///
/// # Errors
/// What was found and what would be right.
pub(super) fn read(object: &Location, name: &str, longest: usize) -> Result<Value, String> {
    let told = |error: hdf5::Error| format!("attribute {name} is unreadable: {error}");
    let attribute = object.attr(name).map_err(told)?;
    let space = attribute.space().map_err(told)?;
    let shape = space.shape();
    let scalar = space.is_scalar();
    let descriptor = attribute.dtype().and_then(|dtype| dtype.to_descriptor()).map_err(told)?;
    match descriptor {
        TypeDescriptor::VarLenUnicode | TypeDescriptor::VarLenAscii if scalar => {
            let mut texts = attribute.read_raw::<VarLenUnicode>().map_err(told)?;
            let text = texts.pop().ok_or_else(|| format!("attribute {name} is empty"))?;
            Ok(Value::Text(utf8(name, &text)?))
        }
        TypeDescriptor::VarLenUnicode | TypeDescriptor::VarLenAscii => {
            let [length] = shape.as_slice() else {
                return Err(format!("attribute {name} has {} axes; a list of strings has one", shape.len()));
            };
            if *length > longest {
                return Err(format!("attribute {name} claims {length} strings; at most {longest} make sense here"));
            }
            let texts = attribute.read_raw::<VarLenUnicode>().map_err(told)?;
            Ok(Value::Texts(texts.iter().map(|text| utf8(name, text)).collect::<Result<_, _>>()?))
        }
        TypeDescriptor::Float(FloatSize::U8) if scalar => Ok(Value::Real(attribute.read_scalar().map_err(told)?)),
        TypeDescriptor::Integer(IntSize::U8) if scalar => Ok(Value::Integer(attribute.read_scalar().map_err(told)?)),
        other => Err(format!(
            "attribute {name} is {other:?} of shape {shape:?}; it must be a variable-length string, a list of them, \
             one 64-bit float or one 64-bit integer"
        )),
    }
}

fn utf8(name: &str, text: &VarLenUnicode) -> Result<String, String> {
    // `as_str` doesn't check, and the bytes come from the file.
    match std::str::from_utf8(text.as_bytes()) {
        Ok(text) => Ok(text.to_owned()),
        Err(_) => Err(format!("attribute {name} isn't UTF-8")),
    }
}
