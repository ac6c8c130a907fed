//! Whether two superelements are the same, to rounding.

use dcb_formats::superelement::{Inertia, RecoveryBasis, Superelement};
use faer::Mat;

use dcb_tests::dense::{difference, identity, largest, relative, scaled_difference};

/// What may differ by rounding: eigenvectors by the rounding of their eigenvalues over the gaps between these.
pub const ROUNDING: f64 = 1e-7;

/// Everything of a superelement but its interfaces.
pub fn compare(name: &str, found: &Superelement, expected: &Superelement) {
    let close = |quantity: &str, error: f64| {
        assert!(
            error < ROUNDING,
            "{name}: {quantity} differs by {error:.1e}"
        );
    };
    let (modes, all) = (&found.modes, &expected.modes);
    let elastic = all
        .eigenvalues
        .iter()
        .take_while(|value| **value <= 0.0)
        .count();
    close(
        "ω²",
        relative(&modes.eigenvalues[elastic..], &all.eigenvalues[elastic..]),
    );
    close(
        "the first ω² left out",
        (modes.first_omitted_eigenvalue / all.first_omitted_eigenvalue - 1.0).abs(),
    );
    assert_eq!(modes.damping, all.damping, "{name}");
    close(
        "L_b Φ",
        difference(&modes.interface_shapes, &all.interface_shapes),
    );
    // Rows of one unit each: by what they are with no mode kept.
    let (residual, all) = (&found.residual, &expected.residual);
    let masses: Vec<f64> = all.mass_diagonal0.iter().map(|mass| mass.sqrt()).collect();
    let flexibilities = flexibilities0(expected);
    close(
        "diag(M_res) with no mode kept",
        relative(
            &nonzero(&residual.mass_diagonal0),
            &nonzero(&all.mass_diagonal0),
        ),
    );
    close(
        "M_res",
        scaled_difference(&residual.mass, &all.mass, &masses),
    );
    close(
        "F_res",
        scaled_difference(&residual.flexibility, &all.flexibility, &flexibilities),
    );
    close("σ²", relative(&residual.sigma_squared, &all.sigma_squared));
    let t = &residual.transform;
    close(
        "T_rᵀ M_res T_r",
        largest((t.transpose() * &all.mass * t - identity(t.ncols())).as_ref()),
    );
    let stiffness = t.transpose() * &all.flexibility * t;
    let roots: Vec<f64> = all
        .sigma_squared
        .iter()
        .map(|square| square.sqrt())
        .collect();
    let squares = Mat::from_fn(t.ncols(), t.ncols(), |i, j| {
        if i == j { all.sigma_squared[i] } else { 0.0 }
    });
    close(
        "T_rᵀ F_res T_r",
        scaled_difference(&stiffness, &squares, &roots),
    );
    assert_eq!(
        residual.output_shapes.is_some(),
        all.output_shapes.is_some(),
        "{name}"
    );
    if let (Some(found), Some(all)) = (&residual.output_shapes, &all.output_shapes) {
        // Observed rows have no flexibility of their own: against the largest entry of each column.
        for column in 0..all.ncols() {
            let of =
                |matrix: &Mat<f64>| Mat::from_fn(matrix.nrows(), 1, |i, _| matrix[(i, column)]);
            close("L_b G_res L_bᵀ", difference(&of(found), &of(all)));
        }
    }
    let mut columns = vec![1.0; expected.mode_count()];
    columns.extend(&masses);
    columns.resize(expected.basis_count(), 1.0);
    compare_inertia(name, &found.inertia, &expected.inertia, &columns);
    for (load, all) in found.loads.iter().zip(&expected.loads) {
        assert_eq!((&load.name, load.force), (&all.name, all.force), "{name}");
        let over = |work: &[f64]| Mat::from_fn(work.len(), 1, |i, _| work[i]);
        let scale = |work: &Mat<f64>| {
            Mat::from_fn(work.nrows(), 1, |i, _| {
                work[(i, 0)] * columns[i].max(f64::MIN_POSITIVE).recip()
            })
        };
        let (load, all) = (scale(&over(&load.work)), scale(&over(&all.work)));
        close("the work of a load", difference(&load, &all));
    }
    assert_eq!(
        found.enrichment.is_some(),
        expected.enrichment.is_some(),
        "{name}"
    );
    let Some((found, all)) = found.enrichment.as_ref().zip(expected.enrichment.as_ref()) else {
        return;
    };
    assert_eq!(found.names, all.names, "{name}");
    close(
        "L_b X",
        difference(&found.interface_shapes, &all.interface_shapes),
    );
    close(
        "ΨᵀMΨ",
        scaled_difference(&found.reduced_mass, &all.reduced_mass, &columns),
    );
    let mut stiffnesses: Vec<f64> = expected
        .modes
        .eigenvalues
        .iter()
        .map(|square| square.sqrt())
        .collect();
    stiffnesses.extend(&flexibilities);
    let further = stiffnesses.len()..expected.basis_count();
    stiffnesses.extend(further.map(|j| all.reduced_stiffness[(j, j)].sqrt()));
    close(
        "ΨᵀKΨ",
        scaled_difference(
            &found.reduced_stiffness,
            &all.reduced_stiffness,
            &stiffnesses,
        ),
    );
}

/// Columns are scaled to unit mass with no mode kept.
fn compare_inertia(name: &str, found: &Inertia, expected: &Inertia, columns: &[f64]) {
    let scaled = |matrix: &Mat<f64>| {
        Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| match columns[j] {
            0.0 => 0.0,
            scale => matrix[(i, j)] / scale,
        })
    };
    let largest_moment = (0..3).map(|a| expected.tensor[a][a]).fold(0.0, f64::max);
    for (quantity, found, all, size) in [
        ("L1", &found.l1, &expected.l1, expected.mass.sqrt()),
        ("I3", &found.i3, &expected.i3, largest_moment.sqrt()),
    ] {
        let error = largest((scaled(found) - scaled(all)).as_ref()) / size;
        assert!(
            error < ROUNDING,
            "{name}: {quantity} differs by {error:.1e}"
        );
    }
    let blocks = |inertia: &Inertia| {
        Mat::from_fn(9, inertia.i1.len(), |entry, column| {
            inertia.i1[column][entry / 3][entry % 3]
        })
    };
    let (i1, all) = (scaled(&blocks(found)), scaled(&blocks(expected)));
    let error = largest((i1 - all).as_ref()) / largest_moment.sqrt();
    assert!(error < ROUNDING, "{name}: I1 differs by {error:.1e}");
    let lists = [
        ("L3", &found.l3, &expected.l3),
        ("J2", &found.i2, &expected.i2),
    ];
    for (quantity, found, all) in lists {
        assert_eq!(found.len(), all.len(), "{name}: {quantity}");
        for (found, all) in found.iter().zip(all) {
            // The entries are cosines, so to say: at most one in size.
            let error = scaled_difference(found, all, columns);
            assert!(
                error < ROUNDING,
                "{name}: {quantity} differs by {error:.1e}"
            );
        }
    }
}

/// Nodal fields.
pub fn compare_fields(name: &str, found: &RecoveryBasis, all: &RecoveryBasis) {
    assert_eq!(found.dofs, all.dofs, "{name}");
    let error = difference(&found.modes, &all.modes);
    assert!(error < ROUNDING, "{name}: Φ differs by {error:.1e}");
    assert_eq!(
        found.enrichment.is_some(),
        all.enrichment.is_some(),
        "{name}"
    );
    if let Some((found, all)) = found.enrichment.as_ref().zip(all.enrichment.as_ref()) {
        let error = difference(found, all);
        assert!(error < ROUNDING, "{name}: X differs by {error:.1e}");
    }
    // Against the whole static response of each row.
    for column in 0..all.residual.ncols() {
        let of = |matrix: &Mat<f64>| Mat::from_fn(matrix.nrows(), 1, |i, _| matrix[(i, column)]);
        let apart = largest((of(&found.residual) - of(&all.residual)).as_ref());
        let response =
            largest(of(&found.residual).as_ref()).max(largest(of(&all.residual).as_ref()));
        assert!(
            apart <= ROUNDING * response.max(f64::MIN_POSITIVE),
            "{name}: column {column} of G_res L_bᵀ differs by {apart:.1e} of {response:.1e}"
        );
    }
}

/// √diag(F_res) with no mode kept.
fn flexibilities0(superelement: &Superelement) -> Vec<f64> {
    let (modes, residual) = (&superelement.modes, &superelement.residual);
    (0..superelement.boundary_row_count())
        .map(|row| {
            if residual.mass_diagonal0[row] == 0.0 {
                return 0.0;
            }
            let elastic = modes
                .eigenvalues
                .iter()
                .enumerate()
                .filter(|(_, value)| **value > 0.0);
            let modal = elastic.map(|(k, value)| modes.interface_shapes[(row, k)].powi(2) / value);
            (residual.flexibility[(row, row)] + modal.sum::<f64>()).sqrt()
        })
        .collect()
}

fn nonzero(values: &[f64]) -> Vec<f64> {
    values
        .iter()
        .copied()
        .filter(|value| *value > 0.0)
        .collect()
}
