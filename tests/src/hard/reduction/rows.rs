//! Hard cases of what is kept: all modes, one, no interface, every dof an interface, rows that repeat.

use std::panic::catch_unwind;

use dcb_formats::component::InterfaceKind;
use dcb_samples::spatial_beam::{BeamMass, BeamTheory};
use dcb_samples::{SolidElement, reference_hexahedra};
use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use nalgebra::DMatrix;

use crate::dense::{diagonal_roots, relative, scaled_difference};
use crate::hard::case::{Bounded, HardCase};
use crate::hard::reduction::GROUP;
use crate::hard::reduction::massless::Massless;
use crate::hard::reduction::plain_methods::{
    cholesky_defect, modal_flexibility, rank_by_own_largest,
};
use crate::oracle::Oracle;
use crate::{lowest, parts};

/// Twelve modes of a rod with four elements: nothing is left for the attachments.
pub fn every_mode_kept() -> HardCase {
    let rod = parts::rod(4);
    let oracle = Oracle::of(&rod);
    let all = oracle.eigenvalues.len();
    let whole = oracle.residual_flexibility(0);
    let of_modes = modal_flexibility(
        &oracle.localization,
        oracle.shapes.as_ref(),
        &oracle.eigenvalues,
    );
    let left = &whole - &of_modes;
    let rank = rank_by_own_largest(&left, 1e-10);
    assert!(rank > 0);
    let size = scaled_difference(&of_modes, &whole, &diagonal_roots(&whole));

    let reduced = lowest(&rod, all);
    let residual = &reduced.superelement.residual;
    assert_eq!(
        (
            residual.sigma_squared.len(),
            reduced.quality.static_directions
        ),
        (0, 0)
    );
    let zero = Mat::zeros(whole.nrows(), whole.nrows());
    let flexibility = scaled_difference(&residual.flexibility, &zero, &diagonal_roots(&whole));
    let mass_scale = diagonal_roots(&oracle.residual_mass(0));
    let mass = scaled_difference(&residual.mass, &zero, &mass_scale);
    HardCase {
        group: GROUP,
        name: "every_mode_kept",
        naive_method: "F_res as the whole flexibility minus the modal sum, its directions counted above 1e-10 of its own largest",
        naive: format!("{rank} of 4 directions kept, made of rounding ({size:.0e} of the whole)"),
        ours: "no direction kept; F_res and M_res are rounding".into(),
        error: Some(Bounded {
            found: flexibility.max(mass),
            bound: 1e-10,
        }),
    }
}

/// A beam with massless rotations: with all finite modes kept, their flexibility is left, L_s K_ss⁻¹ L_sᵀ.
pub fn every_mode_kept_of_a_semidefinite_mass() -> HardCase {
    let beam = parts::beam(4, BeamTheory::EulerBernoulli, BeamMass::LumpedWithRoll);
    let oracle = Oracle::of(&beam);
    let whole = oracle.residual_flexibility(0);
    let scale = diagonal_roots(&whole);
    let of_modes = modal_flexibility(
        &oracle.localization,
        oracle.shapes.as_ref(),
        &oracle.eigenvalues,
    );
    let missing = scaled_difference(&of_modes, &whole, &scale);
    assert!(missing > 0.02, "{missing}");

    let expected = Massless::of(&beam).flexibility(&oracle.localization);
    let reduced = lowest(&beam, beam.dofs.len());
    let element = &reduced.superelement;
    assert_eq!(element.mode_count(), oracle.eigenvalues.len());
    assert!(element.residual.sigma_squared.is_empty() && reduced.quality.static_directions > 0);
    HardCase {
        group: GROUP,
        name: "every_mode_kept_of_a_semidefinite_mass",
        naive_method: "all modes kept, so no residual flexibility",
        naive: format!(
            "{:.0} % of the rotation under an end moment is missing",
            100.0 * missing
        ),
        ours: "F_res is the flexibility of the massless rotations, kept statically".into(),
        error: Some(Bounded {
            found: scaled_difference(&element.residual.flexibility, &expected, &scale),
            bound: 1e-10,
        }),
    }
}

/// One mode beside the attachments.
pub fn one_mode() -> HardCase {
    let block = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    let oracle = Oracle::of(&block);
    let whole = oracle.residual_flexibility(0);
    let scale = diagonal_roots(&whole);
    let shape = oracle.kept(1);
    let alone = modal_flexibility(
        &oracle.localization,
        shape.as_ref(),
        &oracle.eigenvalues[..1],
    );
    let missing = scaled_difference(&alone, &whole, &scale);
    assert!(missing > 0.5, "{missing}");

    let element = lowest(&block, 1).superelement;
    assert_eq!(element.mode_count(), 1);
    let seen = &element.modes.interface_shapes;
    let sum = seen * seen.transpose() * faer::Scale(1.0 / element.modes.eigenvalues[0])
        + &element.residual.flexibility;
    HardCase {
        group: GROUP,
        name: "one_mode",
        naive_method: "the lowest free mode alone",
        naive: format!("{:.0} % of a static deflection is missing", 100.0 * missing),
        ours: "one mode and F_res: the whole static flexibility".into(),
        error: Some(Bounded {
            found: scaled_difference(&sum, &whole, &scale),
            bound: 1e-10,
        }),
    }
}

/// Modes and inertia only.
pub fn no_interface() -> HardCase {
    let block = parts::with_interfaces(
        &parts::steel_box([3, 1, 1], SolidElement::Hexahedron),
        Vec::new(),
    );
    let crash = catch_unwind(|| {
        DMatrix::<f64>::zeros(0, 0)
            .symmetric_eigen()
            .eigenvalues
            .max()
    });
    let message = crash.expect_err("no eigenvalues of an empty matrix");
    let message = message
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| message.downcast_ref::<&str>().copied())
        .expect("a message");
    assert!(message.contains("empty matrix"), "{message}");

    let oracle = Oracle::of(&block);
    let element = lowest(&block, 4).superelement;
    assert_eq!((element.rows.len(), element.basis_count()), (0, 4));
    HardCase {
        group: GROUP,
        name: "no_interface",
        naive_method: "eigenvalues of F_res from a library",
        naive: format!("crash: {}", message.trim_end_matches('.')),
        ours: "four modes, no rows".into(),
        error: Some(Bounded {
            found: relative(&element.modes.eigenvalues, &oracle.eigenvalues[..4]),
            bound: 1e-10,
        }),
    }
}

/// 216 rows over 200 elastic motions that the modes leave.
pub fn every_dof_an_interface_row() -> HardCase {
    let block = parts::steel_box([5, 3, 2], SolidElement::Hexahedron);
    let nodes: Vec<u32> = (0..block.mesh.node_count() as u32).collect();
    let patch = parts::interface("all", InterfaceKind::Nodes, nodes);
    let component = parts::with_interfaces(&block, vec![patch]);
    let oracle = Oracle::of(&component);
    let (kept, rows) = (10, component.dofs.len());
    let (f, m) = (
        oracle.residual_flexibility(kept),
        oracle.residual_mass(kept),
    );
    let defect = cholesky_defect(&m);
    assert!(defect > 1e-3, "{defect:e}");

    let reduced = lowest(&component, kept);
    let (residual, quality) = (&reduced.superelement.residual, &reduced.quality);
    assert_eq!(residual.flexibility.nrows(), rows);
    let left = rows - 6 - kept;
    assert_eq!(quality.flexibility_rank, left);
    assert_eq!(quality.residual_rank + quality.static_directions, left);
    assert_eq!(quality.dependent_rows.len(), 6);
    let flexibility = scaled_difference(&residual.flexibility, &f, &diagonal_roots(&f));
    let mass = scaled_difference(&residual.mass, &m, &diagonal_roots(&m));
    HardCase {
        group: GROUP,
        name: "every_dof_an_interface_row",
        naive_method: "attachments made orthonormal by Cholesky of M_res",
        naive: match defect.is_finite() {
            true => format!("TᵀM_resT - I is {defect:.0e}"),
            false => "no factor".into(),
        },
        ours: format!(
            "{} of {rows} directions dynamic, {} static, the 6 dependent rows named",
            quality.residual_rank, quality.static_directions
        ),
        error: Some(Bounded {
            found: flexibility.max(mass),
            bound: 1e-9,
        }),
    }
}

/// One node in two interfaces.
pub fn dependent_interface_rows() -> HardCase {
    let part = reference_hexahedra();
    let mut again = part.interfaces[1].clone();
    again.name = "again".into();
    let interfaces = part.interfaces.iter().cloned().chain([again]).collect();
    let component = parts::with_interfaces(&part, interfaces);
    let f = Oracle::of(&component).residual_flexibility(2);
    let inverse = f.partial_piv_lu().inverse();
    let defect = (&f * &inverse - crate::dense::identity(9)).norm_l2();
    // NaN where a pivot is exactly zero.
    assert!(defect.is_nan() || defect > 0.1, "{defect:e}");

    let (single, double) = (lowest(&part, 2), lowest(&component, 2));
    let (single, double) = (&single.superelement, &double.superelement);
    assert_eq!(
        (double.rows.len(), double.residual.transform.ncols()),
        (9, 6)
    );
    let named = |direction: &str| {
        double.provenance.warnings.iter().any(|warning| {
            warning.contains(&format!("last/{direction} at node 29"))
                && warning.contains(&format!("again/{direction} at node 29"))
        })
    };
    assert!(["ux", "uy", "uz"].into_iter().all(named));
    HardCase {
        group: GROUP,
        name: "dependent_interface_rows",
        naive_method: "interface stiffness as the inverse of F_res",
        naive: match defect.is_finite() {
            true => format!("|F F⁻¹ - I| is {defect:.0e}"),
            false => "no inverse: a pivot is zero".into(),
        },
        ours: "6 of 9 directions kept, σ² as without the repetition, rows named".into(),
        error: Some(Bounded {
            found: relative(
                &double.residual.sigma_squared,
                &single.residual.sigma_squared,
            ),
            bound: 1e-8,
        }),
    }
}
