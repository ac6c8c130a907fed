//! tmp
mod named;
pub(crate) use named::Object;
pub use named::Named;
/// tmp
pub struct Scene;
