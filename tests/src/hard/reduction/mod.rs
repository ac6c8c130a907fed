//! Hard cases of the reduction, all of them: `tests/hard/reduction.rs` asks one by one, `docs/hard-cases.md` shows them.

pub mod conditioning;
pub mod massless;
pub mod plain_methods;
pub mod refusals;
pub mod rows;
pub mod spectra;

use crate::hard::case::HardCase;

/// The group of these cases.
pub const GROUP: &str = "reduction";

/// Every case, in the order of the page.
pub fn cases() -> Vec<fn() -> HardCase> {
    vec![
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
    ]
}
