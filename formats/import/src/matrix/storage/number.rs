//! Numbers as binary files store them: integers and reals of several widths, in both byte orders.

use crate::binary::file::ByteOrder;

/// Integers below this magnitude, 2^53, are reals without rounding; the next one above it would be rounded to it.
const BEYOND_EXACT: f64 = 9_007_199_254_740_992.0;

/// Significant digits of a real of four bytes.
pub(crate) const SINGLE_DIGITS: u32 = 7;

/// A type of number in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Number {
    pub(crate) kind: Kind,
    pub(crate) order: ByteOrder,
}

/// Kind and width of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
    F32,
    F64,
}

/// A number that can't be had as it is wanted, by its place among those of a batch.
#[derive(Debug, PartialEq)]
pub(crate) struct Unusable {
    pub(crate) at: usize,
    pub(crate) message: String,
}

/// Adds numbers of a type from bytes, one after the other, each as something else.
macro_rules! numbers {
    ($type:ty, $bytes:expr, $order:expr, $into:expr, $as:expr) => {{
        let (chunks, _) = $bytes.as_chunks::<{ size_of::<$type>() }>();
        let chunks = chunks.iter();
        match $order {
            ByteOrder::Little => $into.extend(chunks.map(|c| ($as)(<$type>::from_le_bytes(*c)))),
            ByteOrder::Big => $into.extend(chunks.map(|c| ($as)(<$type>::from_be_bytes(*c)))),
        }
    }};
}

impl Number {
    /// Of a kind with the highest byte first.
    pub(crate) fn big(kind: Kind) -> Self {
        Self {
            kind,
            order: ByteOrder::Big,
        }
    }

    /// Bytes of one.
    pub(crate) fn size(self) -> usize {
        match self.kind {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::I64 | Kind::U64 | Kind::F64 => 8,
        }
    }

    /// Significant digits of one, where there are fewer than a result needs.
    pub(crate) fn digits(self) -> Option<u32> {
        (self.kind == Kind::F32).then_some(SINGLE_DIGITS)
    }

    /// Adds numbers as reals.
    ///
    /// # Errors
    /// An integer that a real can't hold exactly.
    pub(crate) fn reals(self, bytes: &[u8], into: &mut Vec<f64>) -> Result<(), Unusable> {
        into.reserve(bytes.len() / self.size());
        let order = self.order;
        let start = into.len();
        match self.kind {
            Kind::I8 => numbers!(i8, bytes, order, into, f64::from),
            Kind::I16 => numbers!(i16, bytes, order, into, f64::from),
            Kind::I32 => numbers!(i32, bytes, order, into, f64::from),
            Kind::U8 => numbers!(u8, bytes, order, into, f64::from),
            Kind::U16 => numbers!(u16, bytes, order, into, f64::from),
            Kind::U32 => numbers!(u32, bytes, order, into, f64::from),
            Kind::F32 => numbers!(f32, bytes, order, into, f64::from),
            Kind::F64 => numbers!(f64, bytes, order, into, |v: f64| v),
            Kind::I64 => numbers!(i64, bytes, order, into, |v: i64| v as f64),
            Kind::U64 => numbers!(u64, bytes, order, into, |v: u64| v as f64),
        }
        if matches!(self.kind, Kind::I64 | Kind::U64)
            && let Some(at) = into[start..]
                .iter()
                .position(|value| value.abs() >= BEYOND_EXACT)
        {
            let value = into[start + at];
            return Err(Unusable {
                at,
                message: format!(
                    "the integer {value} is 2^53 or beyond, where real numbers have gaps; save reals (float64)"
                ),
            });
        }
        Ok(())
    }

    /// Adds numbers as indices; what can't be one becomes the largest.
    pub(crate) fn indices(self, bytes: &[u8], into: &mut Vec<u32>) {
        into.reserve(bytes.len() / self.size());
        let order = self.order;
        let index = |v: i64| u32::try_from(v).unwrap_or(u32::MAX);
        match self.kind {
            Kind::I8 => numbers!(i8, bytes, order, into, |v: i8| index(i64::from(v))),
            Kind::I16 => numbers!(i16, bytes, order, into, |v: i16| index(i64::from(v))),
            // A negative one becomes larger than any index.
            Kind::I32 => numbers!(i32, bytes, order, into, |v: i32| v as u32),
            Kind::I64 => numbers!(i64, bytes, order, into, index),
            Kind::U8 => numbers!(u8, bytes, order, into, u32::from),
            Kind::U16 => numbers!(u16, bytes, order, into, u32::from),
            Kind::U32 => numbers!(u32, bytes, order, into, |v: u32| v),
            Kind::U64 => numbers!(u64, bytes, order, into, |v: u64| u32::try_from(v)
                .unwrap_or(u32::MAX)),
            Kind::F32 => numbers!(f32, bytes, order, into, |v: f32| whole(f64::from(v))),
            Kind::F64 => numbers!(f64, bytes, order, into, |v: f64| whole(v)),
        }
    }

    /// Adds numbers as integers; reals may be stored that are whole.
    ///
    /// # Errors
    /// A real that isn't whole, an integer beyond 64 bits with sign.
    pub(crate) fn integers(self, bytes: &[u8], into: &mut Vec<i64>) -> Result<(), Unusable> {
        let unusable = |at, value: &dyn std::fmt::Display| Unusable {
            at,
            message: format!("{value} is no integer below 2^53"),
        };
        if self.kind == Kind::I64 {
            numbers!(i64, bytes, self.order, into, |v: i64| v);
            return Ok(());
        }
        let mut reals = Vec::new();
        self.reals(bytes, &mut reals)?;
        for (at, value) in reals.into_iter().enumerate() {
            if value.trunc() != value || value.abs() >= BEYOND_EXACT {
                return Err(unusable(at, &value));
            }
            into.push(value as i64);
        }
        Ok(())
    }
}

/// A real that should be an index.
fn whole(value: f64) -> u32 {
    match value >= 0.0 && value < f64::from(u32::MAX) && value.trunc() == value {
        true => value as u32,
        false => u32::MAX,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn of_little(kind: Kind) -> Number {
        Number {
            kind,
            order: ByteOrder::Little,
        }
    }

    #[test]
    fn numbers_of_every_kind_and_order_are_what_they_were() {
        macro_rules! case {
            ($type:ty, $kind:expr) => {
                let values: [$type; 3] = [1 as $type, <$type>::MAX, <$type>::MIN];
                let little = values.map(<$type>::to_le_bytes).concat();
                let big = values.map(<$type>::to_be_bytes).concat();
                for (number, bytes) in [(of_little($kind), little), (Number::big($kind), big)] {
                    let mut reals = Vec::new();
                    let read = number.reals(&bytes, &mut reals);
                    if size_of::<$type>() < 8 || $kind == Kind::F64 {
                        read.unwrap();
                        assert_eq!(reals, values.map(|v| v as f64), "{number:?}");
                    } else {
                        assert_eq!(read.unwrap_err().at, 1, "{number:?}");
                    }
                    let mut indices = Vec::new();
                    number.indices(&bytes[..number.size()], &mut indices);
                    assert_eq!(indices, [1], "{number:?}");
                    let mut integers = Vec::new();
                    number
                        .integers(&bytes[..number.size()], &mut integers)
                        .unwrap();
                    assert_eq!(integers, [1], "{number:?}");
                }
            };
        }
        case!(i8, Kind::I8);
        case!(i16, Kind::I16);
        case!(i32, Kind::I32);
        case!(i64, Kind::I64);
        case!(u8, Kind::U8);
        case!(u16, Kind::U16);
        case!(u32, Kind::U32);
        case!(u64, Kind::U64);
        case!(f32, Kind::F32);
        case!(f64, Kind::F64);
    }

    #[test]
    fn what_is_no_index_is_beyond_all_of_them() {
        for (kind, bytes) in [
            (Kind::I8, vec![0xff]),
            (Kind::I32, (-1_i32).to_le_bytes().to_vec()),
            (Kind::I64, (-1_i64).to_le_bytes().to_vec()),
            (Kind::U64, (1_u64 << 40).to_le_bytes().to_vec()),
            (Kind::F64, 1.5_f64.to_le_bytes().to_vec()),
            (Kind::F64, f64::NAN.to_le_bytes().to_vec()),
        ] {
            let mut indices = Vec::new();
            of_little(kind).indices(&bytes, &mut indices);
            assert_eq!(indices, [u32::MAX], "{kind:?}");
        }
    }

    #[test]
    fn a_table_may_be_stored_as_whole_reals() {
        let bytes = [7.0_f64.to_le_bytes(), 2.5_f64.to_le_bytes()].concat();
        let mut integers = Vec::new();
        let error = of_little(Kind::F64).integers(&bytes, &mut integers);
        assert_eq!(error.unwrap_err().at, 1);
        assert_eq!(integers, [7]);
    }
}
