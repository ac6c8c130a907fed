//! Mass matrices without full rank whose null directions lie along no axis, printed with few digits, and indefinite ones.

use dcb_formats::component::ComponentDraft;
use dcb_formats::{Component, SparseMatrix};
use dcb_reducer::error::{Error, MatrixRefusal};
use dcb_reducer::{Reduction, reduce};
use dcb_samples::{Material, SolidElement, box_block};
use dcb_tests::dense::{dense, eigen, relative, sparse};
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
