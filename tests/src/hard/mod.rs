//! Hard cases: each runs a plain method, which fails, beside this project's.

/// The cases of a group as a list.
macro_rules! list {
    ($($module:ident::$case:ident),+ $(,)?) => {
        /// The cases, in the order of the page.
        pub fn cases() -> Vec<fn() -> $crate::hard::case::HardCase> {
            vec![$($module::$case),+]
        }
    };
}

pub mod case;
pub mod dynamics;
pub mod reduction;
