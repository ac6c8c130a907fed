//! Types of the elements of datasets.

/// The three element types.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Element {
    /// IEEE double, little-endian.
    Real,
    /// Two's complement, 64 bits, little-endian.
    Integer,
    /// UTF-8.
    Text,
}

impl Element {
    /// Name in the digest.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Real => "<f8",
            Self::Integer => "<i8",
            Self::Text => "str",
        }
    }
}
