//! Dense algebra and rigid-body motions shared by the tests.

mod beams;
mod connecting_rod;
mod files;
mod hard_cases;
mod solids;

use dcb_formats::mesh::Direction;
use dcb_formats::{Component, SparseMatrix};
use dcb_tests::dense::dense;
use dcb_tests::reference::{numbers, reference};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side};

/// Corners of a hexahedron's edges.
pub(crate) const HEXAHEDRON_EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 0],
    [4, 5],
    [5, 6],
    [6, 7],
    [7, 4],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

/// Ascending eigenvalues of `K x = ω² M x`, dense.
pub fn omega_squared(stiffness: &Mat<f64>, mass: &Mat<f64>) -> Vec<f64> {
    let factor = mass.llt(Side::Lower).expect("the mass is positive");
    // L⁻¹ K L⁻ᵀ
    let mut half = stiffness.to_owned();
    solve_lower_triangular_in_place(factor.L(), half.as_mut(), Par::Seq);
    let mut reduced = half.transpose().to_owned();
    solve_lower_triangular_in_place(factor.L(), reduced.as_mut(), Par::Seq);
    reduced
        .self_adjoint_eigenvalues(Side::Lower)
        .expect("eigenvalues")
}

/// Circular frequencies of a component.
pub fn omegas(component: &Component) -> Vec<f64> {
    omega_squared(&dense(&component.stiffness), &dense(&component.mass))
        .into_iter()
        .map(|value| value.max(0.0).sqrt())
        .collect()
}

/// Elastic circular frequencies: those after the rigid ones.
pub fn elastic_omegas(component: &Component) -> Vec<f64> {
    omegas(component).split_off(component.dimension().rigid_mode_count())
}

/// Rigid-body motions about the origin, one a column: translations, then rotations.
pub fn rigid_motions(component: &Component) -> Vec<Vec<f64>> {
    component
        .dimension()
        .frame_directions()
        .iter()
        .map(|motion| {
            component
                .dofs
                .nodal_dofs()
                .iter()
                .map(|dof| {
                    if !motion.is_rotation() {
                        return f64::from(dof.direction == *motion);
                    }
                    if dof.direction.is_rotation() {
                        return f64::from(dof.direction == *motion);
                    }
                    let x = component.mesh.position(dof.node);
                    // e × x
                    let (a, c) = (motion.axis(), dof.direction.axis());
                    if c == (a + 1) % 3 {
                        -x[(a + 2) % 3]
                    } else if c == (a + 2) % 3 {
                        x[(a + 1) % 3]
                    } else {
                        0.0
                    }
                })
                .collect()
        })
        .collect()
}

/// Matrix times vector.
pub fn product(matrix: &SparseMatrix, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; matrix.nrows()];
    for (column, factor) in x.iter().enumerate() {
        for at in matrix.col_ptr()[column] as usize..matrix.col_ptr()[column + 1] as usize {
            y[matrix.row_idx()[at] as usize] += matrix.val()[at] * factor;
        }
    }
    y
}

/// `xᵀ A y`.
pub fn form(matrix: &SparseMatrix, x: &[f64], y: &[f64]) -> f64 {
    product(matrix, y).iter().zip(x).map(|(a, b)| a * b).sum()
}

/// `max |K R| / max(|K| |R|)` over the rigid-body motions: row sums against the sums of absolute values.
pub fn rigid_defect(component: &Component) -> f64 {
    let mut absolute = component.stiffness.clone();
    absolute
        .val_mut()
        .iter_mut()
        .for_each(|value| *value = value.abs());
    let mut worst = 0.0_f64;
    for motion in rigid_motions(component) {
        let forces = product(&component.stiffness, &motion);
        let size: Vec<f64> = product(
            &absolute,
            &motion.iter().map(|x| x.abs()).collect::<Vec<_>>(),
        );
        let largest = size.iter().fold(0.0_f64, |most, x| most.max(*x));
        worst = worst.max(forces.iter().fold(0.0_f64, |most, x| most.max(x.abs())) / largest);
    }
    worst
}

/// Whether every entry equals its transpose, bit for bit, and rows ascend in every column.
pub fn exactly_symmetric(matrix: &SparseMatrix) -> bool {
    let (starts, rows, values) = (matrix.col_ptr(), matrix.row_idx(), matrix.val());
    (0..matrix.ncols()).all(|column| {
        let range = starts[column] as usize..starts[column + 1] as usize;
        rows[range.clone()].is_sorted_by(|a, b| a < b)
            && range.into_iter().all(|at| {
                let row = rows[at] as usize;
                let mirrored = &rows[starts[row] as usize..starts[row + 1] as usize];
                mirrored.binary_search(&(column as u32)).is_ok_and(|there| {
                    values[starts[row] as usize + there].to_bits() == values[at].to_bits()
                })
            })
    })
}

/// Rows of the matrices that don't move when some dofs are held.
pub fn held(component: &Component, hold: impl Fn(u32, Direction) -> bool) -> (Mat<f64>, Mat<f64>) {
    let kept: Vec<usize> = (0..component.dofs.len())
        .filter(|&row| {
            let dof = component.dofs.dof(row).unwrap();
            !hold(dof.node, dof.direction)
        })
        .collect();
    let cut = |matrix: &SparseMatrix| {
        let full = dense(matrix);
        Mat::from_fn(kept.len(), kept.len(), |i, j| full[(kept[i], kept[j])])
    };
    (cut(&component.stiffness), cut(&component.mass))
}

/// `|a - b| / |b|`.
pub fn relative(a: f64, b: f64) -> f64 {
    (a - b).abs() / b.abs()
}

/// The value nearest to `target`.
pub fn nearest(values: &[f64], target: f64) -> f64 {
    *values
        .iter()
        .min_by(|a, b| (*a - target).abs().total_cmp(&(*b - target).abs()))
        .unwrap()
}
