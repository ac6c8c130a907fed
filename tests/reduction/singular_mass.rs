//! Mass matrices without full rank whose null directions lie along no axis, printed with few digits, and indefinite ones.

use std::path::Path;

use dcb_formats::component::ComponentDraft;
use dcb_formats::component_files::{ComponentFiles, Overrides, read_component};
use dcb_formats::{Component, SparseMatrix};
use dcb_reducer::error::{Error, MatrixRefusal};
use dcb_reducer::{Reduction, reduce, reduce_whole};
use dcb_samples::{Material, SolidElement, box_block};
use dcb_tests::dense::{dense, diagonal_roots, eigen, relative, scaled_difference, sparse};
use dcb_tests::oracle::Oracle;
use dcb_tests::parts::with_internal_rows;
use dcb_tests::{assert_says, lowest, refusal};
use faer::Mat;

/// A block of linear hexahedra whose mass is integrated at one point of each: in each direction M has as many columns as there are elements,
/// each of a density of its own. Stiffness with full integration.
fn one_point_block() -> Component {
    let block = box_block(
        [4, 2, 2],
        [0.3, 0.1, 0.08],
        SolidElement::Hexahedron,
        &Material::STEEL,
    );
    let n = block.dofs.len();
    let mut mass = Mat::zeros(n, n);
    let cells = &block.mesh.cells[0];
    let of_cell = Material::STEEL.density * 0.3 * 0.1 * 0.08 / cells.cell_count() as f64;
    for (index, cell) in cells.cells().enumerate() {
        let of_cell = of_cell * (1.0 + 0.3 * (index as f64).sin());
        for direction in &dcb_formats::mesh::Direction::ALL[..3] {
            let rows: Vec<usize> = (cell.iter())
                .map(|node| block.dofs.row(*node, *direction).unwrap())
                .collect();
            for i in &rows {
                for j in &rows {
                    mass[(*i, *j)] += of_cell / 64.0;
                }
            }
        }
    }
    block.changed(|draft| draft.mass = sparse(&mass)).unwrap()
}

/// A block of distorted ten-node tetrahedra by CalculiX, whose M has rank 657 of 675.
fn real_block() -> Component {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/exchange/calculix");
    let stiffness = folder.join("block_c3d10.mtx.gz");
    let files = ComponentFiles::beside(&stiffness, &Overrides::default()).unwrap();
    read_component(&files, None).unwrap()
}

/// A block of ten-node tetrahedra, 675 rows, whose M has full rank.
fn tetrahedra() -> Component {
    box_block(
        [4, 2, 2],
        [0.3, 0.1, 0.08],
        SolidElement::Tetra10,
        &Material::STEEL,
    )
}

/// Reduces with nearly all modes, and compares ω², G_res L_bᵀ, F_res and M_res with dense algebra, the last three beside those with
/// no mode kept.
fn nearly_all_modes_are_those_of_dense_algebra(component: &Component, asked: &[usize]) {
    let oracle = Oracle::of(component);
    let available = oracle.eigenvalues.len();
    let (flexibility0, mass0) = (oracle.residual_flexibility(0), oracle.residual_mass(0));
    let (of_flexibility, of_mass) = (diagonal_roots(&flexibility0), diagonal_roots(&mass0));
    let static_shapes = oracle.residual_shapes(0);
    for asked in asked {
        let whole = reduce_whole(component, &Reduction::lowest(*asked), &mut ());
        let whole = whole.unwrap_or_else(|error| panic!("{asked} modes: {error}"));
        let shapes = whole.shapes().residual.to_owned();
        let (element, quality) = (&whole.reduced.superelement, &whole.reduced.quality);
        let kept = element.mode_count();
        assert!(kept >= *asked.min(&available) && kept <= available);
        assert!(quality.broken_limits().is_empty(), "{asked}");
        assert_eq!(
            (quality.mode_count.counted, quality.mode_count.found),
            (6 + kept, 6 + kept)
        );
        let off = relative(&element.modes.eigenvalues, &oracle.eigenvalues[..kept]);
        assert!(off < 1e-9, "ω² of {asked}: {off:e}");
        let expected = oracle.residual_shapes(kept);
        for column in 0..expected.ncols() {
            let size = static_shapes.col(column).norm_max();
            let off = (shapes.col(column) - expected.col(column)).norm_max();
            assert!(off < 1e-9 * size, "column {column} of {asked}: {off:e}");
        }
        let found = &element.residual;
        let expected = oracle.residual_flexibility(kept);
        let off = scaled_difference(&found.flexibility, &expected, &of_flexibility);
        assert!(off < 1e-9, "F_res of {asked}: {off:e}");
        let off = scaled_difference(&found.mass, &oracle.residual_mass(kept), &of_mass);
        assert!(off < 1e-9, "M_res of {asked}: {off:e}");
        if kept == available {
            assert_eq!(element.modes.first_omitted_eigenvalue, f64::INFINITY);
            // Nothing with mass is left: F_res is that of the motions without mass alone.
            assert!(found.sigma_squared.is_empty());
        }
        let warnings = element.provenance.warnings.iter();
        let told = warnings.filter(|said| said.contains("asked for")).count();
        let is_singular = available + 6 < component.dofs.len();
        assert_eq!(told, usize::from(*asked > available && is_singular));
    }
}

#[test]
fn nearly_all_modes_of_a_few_hundred_are_kept_with_a_singular_mass() {
    let block = real_block();
    let available = Oracle::of(&block).eigenvalues.len();
    assert_eq!(available, 651);
    nearly_all_modes_are_those_of_dense_algebra(&block, &[400, 650, 651, 5000]);
}

#[test]
fn nearly_all_modes_of_a_few_hundred_are_kept_with_a_regular_mass() {
    let block = tetrahedra();
    let available = block.dofs.len() - 6;
    let asked = [available - 250, available - 1, available, 5000];
    nearly_all_modes_are_those_of_dense_algebra(&block, &asked);
}

fn printed(matrix: &SparseMatrix, digits: usize) -> SparseMatrix {
    let matrix = dense(matrix);
    sparse(&Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        let text = format!("{:.*e}", digits - 1, matrix[(i.max(j), i.min(j))]);
        text.parse().unwrap()
    }))
}

fn with_mass(component: &Component, mass: SparseMatrix) -> Component {
    Component::checked(ComponentDraft {
        mass,
        ..component.clone().into_draft()
    })
    .unwrap()
}

fn lowest_eigenvalue(matrix: &SparseMatrix) -> f64 {
    let (values, _) = eigen(&dense(matrix));
    values[0] / values[values.len() - 1]
}

#[test]
fn a_mass_of_one_point_an_element_has_its_modes_and_no_more() {
    let block = one_point_block();
    let oracle = Oracle::of(&block);
    // Sixteen elements, three directions; the linear fields are among them.
    assert_eq!(oracle.eigenvalues.len(), 48 - 6);
    for asked in [5, 41, 42, 100] {
        let found = lowest(&block, asked);
        let kept = found.superelement.mode_count();
        assert!(kept >= asked.min(42) && kept <= 42, "{asked}: {kept}");
        let off = relative(
            &found.superelement.modes.eigenvalues,
            &oracle.eigenvalues[..kept],
        );
        assert!(off < 1e-9, "{asked}: {off:e}");
        assert!(found.quality.broken_limits().is_empty());
        let flexibility = oracle.residual_flexibility(kept);
        let (whole, mut worst) = (oracle.residual_flexibility(0), 0.0_f64);
        for i in 0..whole.nrows() {
            for j in 0..whole.nrows() {
                let off = found.superelement.residual.flexibility[(i, j)] - flexibility[(i, j)];
                worst = worst.max(off.abs() / (whole[(i, i)] * whole[(j, j)]).sqrt());
            }
        }
        assert!(worst < 1e-9, "{asked}: {worst:e}");
    }
}

#[test]
fn ten_digits_of_a_singular_mass_are_enough() {
    let component = one_point_block();
    let rounded = with_mass(&component, printed(&component.mass, 10));
    let negative = lowest_eigenvalue(&rounded.mass);
    assert!((-1e-9..-1e-12).contains(&negative), "{negative:e}");
    for asked in [8, 1000] {
        let (found, expected) = (lowest(&rounded, asked), lowest(&component, asked));
        let (found, expected) = (found.superelement, expected.superelement);
        assert_eq!(found.mode_count(), expected.mode_count());
        assert!(found.mode_count() <= 42);
        let off = relative(&found.modes.eigenvalues, &expected.modes.eigenvalues);
        assert!(off < 1e-8, "{asked}: {off:e}");
    }
    // Four digits are too few.
    let rounded = with_mass(&component, printed(&component.mass, 4));
    assert_says(
        &refusal(&rounded),
        &["mass matrix is indefinite", "export more digits"],
    );
}

#[test]
fn an_indefinite_mass_is_refused_with_how_much() {
    let component = with_internal_rows("plate");
    let mass = dense(&component.mass);
    let (values, vectors) = eigen(&mass);
    let largest = values[values.len() - 1];
    let n = values.len();
    // Along a motion without mass.
    let with_negative = |part: f64| {
        let lowered = Mat::from_fn(n, n, |i, j| {
            mass[(i, j)] - part * largest * (vectors[(i, 0)] * vectors[(j, 0)])
        });
        with_mass(&component, sparse(&lowered))
    };
    let still = lowest(&with_negative(1e-11), 6).superelement;
    let off = relative(
        &still.modes.eigenvalues,
        &lowest(&component, 6).superelement.modes.eigenvalues,
    );
    assert!(off < 1e-9, "{off:e}");
    for part in [1e-7, 1e-4, 0.5] {
        let error = reduce(&with_negative(part), &Reduction::lowest(4), &mut ()).unwrap_err();
        let said = error.to_string();
        assert_says(
            &said,
            &[
                "mass matrix is indefinite",
                "1 of its eigenvalues",
                "-1e-9",
                "more digits",
            ],
        );
        let Error::Matrix(MatrixRefusal::NegativeMass { least, most, .. }) = error else {
            panic!("{said}");
        };
        // Measured with K's diagonal scaled to one, which is not far from constant here.
        assert!(least < 30.0 * part && most > part / 30.0, "{part}: {said}");
    }
}
