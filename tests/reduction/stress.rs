//! Stress rows through a reduction: against dense algebra over all degrees of freedom, other units, fewer modes, and wrong matrices.

use dcb_formats::component::{NamedStress, StressComponent, StressQuantity, von_mises};
use dcb_formats::dcb::{SuperelementFile, read_superelement};
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::Compatibility;
use dcb_formats::{Component, SparseMatrix, Superelement};
use dcb_reducer::{EnrichmentSource, Reduced, Reduction};
use dcb_samples::{UnitScale, bracket, in_units};
use dcb_superelement::selection::{InPlane, Normal, SYMMETRIC, Selection};
use dcb_superelement::{ErrorBounds, stress_errors};
use dcb_tests::dense::{dense, difference, largest};
use dcb_tests::oracle::Oracle;
use dcb_tests::{assert_says, lowest, refusal, with};
use faer::Mat;
use faer::sparse::Triplet;

const KEPT: usize = 8;

/// S Ψ from the nodal fields that the reduction gives.
fn from_fields(component: &Component, reduced: &Reduced) -> Mat<f64> {
    let fields = &reduced.recovery;
    let blocks = [
        Some(&fields.modes),
        Some(&fields.residual),
        fields.enrichment.as_ref(),
    ];
    let columns: Vec<Mat<f64>> = (blocks.into_iter().flatten())
        .map(|block| dense(&component.stresses[0].matrix) * block)
        .collect();
    let n = columns.iter().map(Mat::ncols).sum();
    let mut all = Mat::zeros(columns[0].nrows(), n);
    let mut first = 0;
    for block in columns {
        all.as_mut()
            .subcols_mut(first, block.ncols())
            .copy_from(&block);
        first += block.ncols();
    }
    all
}

#[test]
fn rows_are_those_of_the_fields_and_of_dense_algebra() {
    let component = bracket(1);
    let options = Reduction {
        enrichment: vec![EnrichmentSource::Spin],
        ..Reduction::lowest(KEPT)
    };
    let reduced = with(&component, &options);
    let element = &reduced.superelement;
    let field = &element.stresses[0];
    assert_eq!(field.name, "fillet");
    assert_eq!(field.shapes.nrows(), 6 * field.points.len());
    assert_eq!(field.shapes.ncols(), element.basis_count());
    assert!(difference(&field.shapes, &from_fields(&component, &reduced)) < 1e-12);
    // Places are in the body frame.
    let node = field.points[0].node.unwrap();
    let place = component.mesh.position(node);
    for (axis, place) in place.iter().enumerate() {
        let found = field.points[0].position[axis] + element.origin[axis];
        assert!((found - place).abs() < 1e-15);
    }

    // The attachments' stress, and what the modes leave out, from a dense inverse and from all modes.
    let oracle = Oracle::of(&component);
    let rows = dense(&component.stresses[0].matrix);
    let attached = &rows * oracle.residual_shapes(KEPT);
    let found = field.shapes.subcols(KEPT, attached.ncols()).to_owned();
    let off = difference(&found, &attached);
    assert!(off < 1e-8, "{off:e}");
    let response = oracle.residual_response(KEPT, &rows.transpose().to_owned());
    let omitted = field.omitted.as_ref().unwrap();
    let mut largest_row = 0.0_f64;
    for (row, found) in omitted.iter().enumerate() {
        let square: f64 = (0..rows.ncols())
            .map(|i| rows[(row, i)] * response[(i, row)])
            .sum();
        largest_row = largest_row.max(square.sqrt());
        assert!(
            (found / square.sqrt() - 1.0).abs() < 1e-7,
            "row {row}: {found:e} and {:e}",
            square.sqrt()
        );
    }
    assert!(largest_row > 0.0);
}

/// A static load: modes and attachments give the whole part's stress; the same number of modes alone is far off.
#[test]
fn a_static_load_makes_the_stress_of_the_whole_part() {
    let component = bracket(1);
    let reduced = lowest(&component, KEPT);
    let element = &reduced.superelement;
    let oracle = Oracle::of(&component);
    let rows = dense(&component.stresses[0].matrix);
    let field = &element.stresses[0];
    let n_b = element.boundary_row_count();
    // u = G L_bᵀ of the free part, its inertia relieved.
    let whole = &rows * oracle.residual_response(0, &oracle.localization.transpose().to_owned());
    let of_modes = |count: usize| {
        let modes = lowest(&component, count).superelement;
        Mat::from_fn(rows.nrows(), n_b, |i, b| {
            (0..count)
                .map(|k| {
                    let shape = modes.modes.interface_shapes[(b, k)];
                    modes.stresses[0].shapes[(i, k)] * shape / modes.modes.eigenvalues[k]
                })
                .sum::<f64>()
        })
    };
    let attached = field.shapes.subcols(KEPT, n_b).to_owned();
    let off = difference(&(of_modes(KEPT) + attached), &whole);
    assert!(off < 1e-8, "{off:e}");
    let alone = difference(&of_modes(KEPT + n_b), &whole);
    assert!(alone > 1e-2, "{alone:e}");
}

#[test]
fn megapascals_are_pascals() {
    let component = bracket(1);
    let si = lowest(&component, KEPT).superelement;
    let mm = lowest(&in_units(&component, &UnitScale::mm_t_s()), KEPT).superelement;
    // A mode's amplitude counts √mass·length, an attachment's a force or a moment.
    let (mode, force, moment) = (1e-3_f64.sqrt() * 1e3, 1.0, 1e3);
    let amplitude = |k: usize| match k.checked_sub(KEPT) {
        None => mode,
        Some(row) if si.rows[row].direction < 3 => force,
        Some(_) => moment,
    };
    let (si, mm) = (&si.stresses[0], &mm.stresses[0]);
    let scaled = Mat::from_fn(si.shapes.nrows(), si.shapes.ncols(), |i, k| {
        1e-6 * si.shapes[(i, k)] / amplitude(k)
    });
    // Modes have a sign of their own.
    for k in 0..scaled.ncols() {
        let (a, b) = (scaled.col(k).to_owned(), mm.shapes.col(k).to_owned());
        let size = a.norm_max();
        let off = (&a - &b).norm_max().min((&a + &b).norm_max());
        assert!(off < 1e-7 * size, "column {k}: {:e}", off / size);
    }
    let [a, b] = [si, mm].map(|field| field.omitted.as_ref().unwrap());
    for (a, b) in a.iter().zip(b) {
        assert!((1e-6 * a / mode - b).abs() < 1e-7 * b);
    }
}

#[test]
fn fewer_modes_are_the_reduction_with_fewer() {
    let component = bracket(1);
    let whole = lowest(&component, KEPT + 6).superelement;
    let fewer = Selection::lowest_modes(&whole, KEPT).unwrap();
    let found = &fewer.superelement(&whole).unwrap().stresses[0];
    let expected = &lowest(&component, KEPT).superelement.stresses[0];
    for k in 0..expected.shapes.ncols() {
        let (a, b) = (
            found.shapes.col(k).to_owned(),
            expected.shapes.col(k).to_owned(),
        );
        let off = (&a - &b).norm_max().min((&a + &b).norm_max());
        assert!(off < 1e-7 * b.norm_max(), "column {k}: {off:e}");
    }
    for (a, b) in found
        .omitted
        .iter()
        .flatten()
        .zip(expected.omitted.iter().flatten())
    {
        assert!((a / b - 1.0).abs() < 1e-7, "{a:e} {b:e}");
    }
}

#[test]
fn the_plane_of_symmetry_keeps_the_stress_of_motions_in_it() {
    let component = bracket(1);
    let whole = lowest(&component, KEPT).superelement;
    let in_plane = InPlane::of(&whole, Normal::Z, SYMMETRIC).unwrap();
    let planar = in_plane.superelement(&whole).unwrap();
    assert_eq!(planar.dimension, Dimension::Planar);
    let (field, all) = (&planar.stresses[0], &whole.stresses[0]);
    assert_eq!(field.components, all.components);
    // Bending in the plane: the stress per unit of the first kept mode is that of one of the whole's.
    let first = planar.modes.eigenvalues[0];
    let k = whole
        .modes
        .eigenvalues
        .iter()
        .position(|own| (own / first - 1.0).abs() < 1e-9)
        .unwrap();
    let (a, b) = (field.shapes.col(0).to_owned(), all.shapes.col(k).to_owned());
    let off = (&a - &b).norm_max().min((&a + &b).norm_max());
    assert!(off < 1e-6 * b.norm_max(), "{off:e}");
}

#[test]
fn a_file_keeps_the_stress() {
    let component = bracket(1);
    let element = lowest(&component, KEPT).superelement;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bracket.dcb.h5");
    dcb_tests::write_bare(&path, &element);
    let read = read_superelement(&path).unwrap();
    assert_eq!(read.stresses, element.stresses);
    let file = SuperelementFile::open(&path).unwrap();
    assert_eq!(file.format_version().to_string(), "1.6");
}

fn refused(change: impl FnOnce(&mut NamedStress)) -> String {
    let component = bracket(1);
    let changed = component.changed(|draft| change(&mut draft.stresses[0]));
    match changed {
        Err(fault) => fault.to_string(),
        Ok(component) => refusal(&component),
    }
}

#[test]
fn wrong_rows_are_named() {
    // Columns moved on by one degree of freedom: another order of the matrix.
    let shifted = refused(|stress| {
        let all = dense(&stress.matrix);
        let n = all.ncols();
        let entries: Vec<Triplet<u32, u32, f64>> = (0..n)
            .flat_map(|j| (0..all.nrows()).map(move |i| (i, j)))
            .filter(|(i, j)| all[(*i, *j)] != 0.0)
            .map(|(i, j)| Triplet::new(i as u32, ((j + 1) % n) as u32, all[(i, j)]))
            .collect();
        stress.matrix = SparseMatrix::try_new_from_triplets(all.nrows(), n, &entries).unwrap();
    });
    assert_says(
        &shifted,
        &[
            "component.stresses.fillet",
            "makes stress of a rigid motion",
        ],
    );
    let fewer = refused(|stress| {
        stress.points.pop();
    });
    assert_says(&fewer, &["stresses[0]", "places with 6 components"]);
    let twice = refused(|stress| stress.components[1] = StressComponent::Xx);
    assert_says(&twice, &["components", "names xx twice"]);
    let node = refused(|stress| stress.points[0].node = Some(1_000_000));
    assert_says(&node, &["names node 1000000"]);
}

#[test]
fn strain_is_read_as_strain() {
    let component = bracket(1)
        .changed(|draft| draft.stresses[0].quantity = StressQuantity::Strain)
        .unwrap();
    let element: Superelement = lowest(&component, 4).superelement;
    assert_eq!(element.stresses[0].quantity, StressQuantity::Strain);
    let values: Vec<f64> = element.stresses[0]
        .shapes
        .col(0)
        .iter()
        .take(6)
        .copied()
        .collect();
    assert!(von_mises(&element.stresses[0].components, &values) > 0.0);
    assert!(largest(element.stresses[0].shapes.as_ref()) > 0.0);
}

/// Stress over frequency: the true error against its bound, over all rows, forces and frequencies.
#[test]
fn errors_over_frequency_are_below_their_bound() {
    let component = bracket(1);
    let element = lowest(&component, 6).superelement;
    let bounds = ErrorBounds::of(&element, Compatibility::Strong)
        .unwrap()
        .unwrap();
    let oracle = Oracle::of(&component);
    let rows = dense(&component.stresses[0].matrix);
    let of_modes = &rows * &oracle.shapes;
    let work = &oracle.localization * &oracle.shapes;
    let (n_k, n_b) = (element.mode_count(), element.boundary_row_count());
    let field = &element.stresses[0];
    let residual = &element.residual;
    let attached = field.shapes.subcols(n_k, n_b) * &residual.transform;
    let seen = &residual.flexibility * &residual.transform;
    let at_rest = Mat::from_fn(rows.nrows(), n_b, |i, b| {
        (0..oracle.eigenvalues.len())
            .map(|k| of_modes[(i, k)] * work[(b, k)] / oracle.eigenvalues[k])
            .sum::<f64>()
    });
    let stored: Vec<f64> = (0..n_b)
        .map(|b| {
            (0..oracle.eigenvalues.len())
                .map(|k| work[(b, k)].powi(2) / oracle.eigenvalues[k])
                .sum()
        })
        .collect();
    let size = (0..n_b)
        .map(|b| at_rest.col(b).norm_max() / stored[b].sqrt())
        .fold(0.0, f64::max);
    let mut ratios = Vec::new();
    for part in [0.1, 0.3, 0.5, 0.8] {
        let square = (part * part) * bounds.eigenvalue_bound();
        let told = stress_errors(&element, &bounds, square).unwrap()[0].unwrap();
        let mut worst = 0.0_f64;
        for b in 0..n_b {
            for i in 0..rows.nrows() {
                let exact: f64 = (n_k..oracle.eigenvalues.len())
                    .map(|k| of_modes[(i, k)] * work[(b, k)] / (oracle.eigenvalues[k] - square))
                    .sum();
                let reduced: f64 = (0..seen.ncols())
                    .map(|r| attached[(i, r)] * seen[(b, r)] / (residual.sigma_squared[r] - square))
                    .sum();
                worst = worst.max((exact - reduced).abs() / stored[b].sqrt() / size);
            }
        }
        assert!(
            worst <= told * (1.0 + 1e-6) + 1e-9,
            "{part}: {worst:e} above {told:e}"
        );
        ratios.push(told / worst);
    }
    // Told at most some tens of times too large.
    assert!(ratios.iter().all(|ratio| *ratio < 50.0), "{ratios:?}");
}
