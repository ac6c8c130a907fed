//! Does the reduction stand where a plain method falls? Each case runs both: the plain one has to fail, by number, and ours has to hold
//! its bound or be refused by name.

use dcb_tests::hard::case::HardCase;
use dcb_tests::hard::reduction;
use dcb_tests::hard::reduction::{conditioning, refusals, rows, spectra};

fn held(case: HardCase, name: &str) {
    assert_eq!((case.group, case.name), (reduction::GROUP, name));
    case.assert_held();
}

/// One test for each case, by its name.
macro_rules! tests {
    ($($module:ident::$case:ident),+ $(,)?) => {
        $(
            #[test]
            fn $case() {
                held($module::$case(), stringify!($case));
            }
        )+

        #[test]
        fn every_case_has_its_test() {
            assert_eq!(reduction::cases().len(), [$(stringify!($case)),+].len());
        }
    };
}

tests!(
    rows::every_mode_kept,
    rows::every_mode_kept_of_a_semidefinite_mass,
    rows::one_mode,
    rows::no_interface,
    rows::every_dof_an_interface_row,
    rows::dependent_interface_rows,
    conditioning::slenderness_1e4,
    conditioning::thin_plate_1e3,
    conditioning::stiffness_contrast_1e8,
    conditioning::millimetre_tonne_second,
    conditioning::a_million_metres_from_the_origin,
    spectra::massless_rotations,
    spectra::lumped_mass_with_zeros,
    spectra::double_roots,
    spectra::triple_root_at_the_cut,
    spectra::fifty_fold_root,
    spectra::cluster_at_the_cut,
    refusals::grounded,
    refusals::mechanism,
    refusals::two_pieces,
    refusals::orphan_dof,
    refusals::slightly_indefinite_stiffness,
);
