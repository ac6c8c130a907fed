//! Does the project stand where plain methods fall?
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use dcb_tests::hard::case::HardCase;

/// One test for each case, by its name.
macro_rules! tests {
    ($($module:ident::$case:ident),+ $(,)?) => {
        $(
            #[test]
            fn $case() {
                $crate::held(&$module::$case(), GROUP, stringify!($case));
            }
        )+
    };
}

mod dynamics;
mod identity_defects;
mod mechanism_properties;
mod random_chain;
mod reduction;
mod reduction_properties;

fn held(case: &HardCase, group: &str, name: &str) {
    println!("{}", case.line());
    assert_eq!((case.group, case.name), (group, name));
    case.assert_held();
}
