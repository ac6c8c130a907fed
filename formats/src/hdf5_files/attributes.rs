//! Attributes: a string, a real or an integer, or a list of them.

use std::collections::{BTreeMap, HashMap};
use std::fmt;

use hdf5::Location;
use hdf5::types::VarLenUnicode;
use hdf5_pure::{AttrValue, Datatype};

use crate::terminal::shortened;

/// Value of an attribute.
#[derive(Clone, PartialEq)]
pub(crate) enum Value {
    /// One string.
    Text(String),
    /// A list of strings.
    Texts(Vec<String>),
    /// One real.
    Real(f64),
    /// A list of reals.
    Reals(Vec<f64>),
    /// One integer.
    Integer(i64),
    /// A list of integers.
    Integers(Vec<i64>),
}

/// As messages show it: shortened.
impl fmt::Debug for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => write!(f, "{:?}", shortened(text)),
            Self::Texts(texts) => write!(f, "a list of {} strings", texts.len()),
            Self::Real(real) => write!(f, "{real:?}"),
            Self::Reals(reals) => write!(f, "a list of {} reals", reals.len()),
            Self::Integer(integer) => write!(f, "{integer}"),
            Self::Integers(integers) => write!(f, "a list of {} integers", integers.len()),
        }
    }
}

impl Value {
    /// As the digest writes it: reals as the hexadecimal digits of their bits, so that no language rounds them.
    pub(crate) fn canonical(&self) -> serde_json::Value {
        let bits = |real: &f64| format!("{:016x}", real.to_bits());
        match self {
            Self::Text(text) => text.as_str().into(),
            Self::Texts(texts) => texts.as_slice().into(),
            Self::Real(real) => bits(real).into(),
            Self::Reals(reals) => reals.iter().map(bits).collect(),
            Self::Integer(integer) => (*integer).into(),
            Self::Integers(integers) => integers.as_slice().into(),
        }
    }

    /// From the file, however wide its numbers and however long its strings are stored.
    fn read(value: &AttrValue) -> Option<Self> {
        use AttrValue as A;
        if let Some(texts) = value.as_strings() {
            return match value {
                A::String(text)
                | A::AsciiString(text)
                | A::VarLenString(text)
                | A::VarLenAsciiString(text)
                | A::StringSized { value: text, .. }
                | A::AsciiStringSized { value: text, .. } => Some(Self::Text(text.clone())),
                _ => Some(Self::Texts(texts.to_vec())),
            };
        }
        match value {
            A::F32(real) => Some(Self::Real(f64::from(*real))),
            A::F64(real) => Some(Self::Real(*real)),
            A::F32Array(reals) => Some(Self::Reals(reals.iter().map(|&r| f64::from(r)).collect())),
            A::F64Array(reals) => Some(Self::Reals(reals.clone())),
            A::I8(_) | A::I16(_) | A::I32(_) | A::I64(_) => value.as_i64().map(Self::Integer),
            A::U8(_) | A::U16(_) | A::U32(_) | A::U64(_) => value.as_i64().map(Self::Integer),
            _ => value.to_i64s().map(Self::Integers),
        }
    }

    fn has_zero_byte(&self) -> bool {
        match self {
            Self::Text(text) => text.contains('\0'),
            Self::Texts(texts) => texts.iter().any(|text| text.contains('\0')),
            _ => false,
        }
    }
}

/// The attributes of a group or a dataset, from what the library says of their values and types: it leaves out
/// values that it can't read, but not their types.
///
/// # Errors
/// One can't be read, or is of another kind.
pub(crate) fn read(
    values: Result<HashMap<String, AttrValue>, hdf5_pure::Error>,
    types: Result<HashMap<String, Datatype>, hdf5_pure::Error>,
) -> Result<BTreeMap<String, Value>, String> {
    let told = |error: hdf5_pure::Error| format!("has attributes that can't be read: {error}");
    let (values, types) = (values.map_err(told)?, types.map_err(told)?);
    let value = |name: String| match values.get(&name).and_then(Value::read) {
        Some(value) if value.has_zero_byte() => {
            Err(format!("attribute {name} has a string with a zero byte"))
        }
        Some(value) => Ok((name, value)),
        None => Err(format!(
            "attribute {name} can't be read; it must be a string, a real or an integer, or a list of them"
        )),
    };
    types.into_keys().map(value).collect()
}

/// The same without the references between datasets and their dimension scales, which nothing here follows.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_but_references(
    values: Result<HashMap<String, AttrValue>, hdf5_pure::Error>,
    types: Result<HashMap<String, Datatype>, hdf5_pure::Error>,
) -> Result<BTreeMap<String, Value>, String> {
    let types = types.map(|mut types| {
        types.retain(|name, _| !["DIMENSION_LIST", "REFERENCE_LIST"].contains(&name.as_str()));
        types
    });
    read(values, types)
}

/// An HDF5 string; HDF5 ends strings at a zero byte, so one inside is refused.
pub(crate) fn hdf5_text(text: &str) -> hdf5::Result<VarLenUnicode> {
    text.parse()
        .map_err(|_| hdf5::Error::from(format!("{text:?} contains a zero byte")))
}

/// Writes an attribute.
pub(crate) fn write(object: &Location, name: &str, value: &Value) -> hdf5::Result<()> {
    fn list<T: hdf5::H5Type>(object: &Location, name: &str, values: &[T]) -> hdf5::Result<()> {
        object
            .new_attr::<T>()
            .shape(values.len())
            .create(name)?
            .write_raw(values)
    }
    match value {
        Value::Text(text) => object
            .new_attr::<VarLenUnicode>()
            .create(name)?
            .write_scalar(&hdf5_text(text)?),
        Value::Texts(texts) => {
            let texts = texts.iter().map(|text| hdf5_text(text));
            list(object, name, &texts.collect::<hdf5::Result<Vec<_>>>()?)
        }
        Value::Real(real) => object.new_attr::<f64>().create(name)?.write_scalar(real),
        Value::Reals(reals) => list(object, name, reals),
        Value::Integer(integer) => object.new_attr::<i64>().create(name)?.write_scalar(integer),
        Value::Integers(integers) => list(object, name, integers),
    }
}
