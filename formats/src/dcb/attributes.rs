//! Attributes: four kinds of value.

use hdf5::Location;
use hdf5::types::VarLenUnicode;

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
    text.parse()
        .map_err(|_| hdf5::Error::from(format!("{text:?} contains a zero byte")))
}

/// Writes an attribute.
pub(super) fn write(object: &Location, name: &str, value: &Value) -> hdf5::Result<()> {
    match value {
        Value::Text(text) => object
            .new_attr::<VarLenUnicode>()
            .create(name)?
            .write_scalar(&hdf5_text(text)?),
        Value::Texts(texts) => {
            let texts = texts
                .iter()
                .map(|text| hdf5_text(text))
                .collect::<hdf5::Result<Vec<_>>>()?;
            object
                .new_attr::<VarLenUnicode>()
                .shape(texts.len())
                .create(name)?
                .write_raw(&texts)
        }
        Value::Real(real) => object.new_attr::<f64>().create(name)?.write_scalar(real),
        Value::Integer(integer) => object.new_attr::<i64>().create(name)?.write_scalar(integer),
    }
}
