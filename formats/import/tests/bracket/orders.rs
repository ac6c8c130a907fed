//! The bracket with its rows in other orders and along other axes, its files exchanged or called by another name.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use dcb_formats::matrix::read_matrix;
use dcb_formats::mesh::Dof;
use dcb_formats::{Error, SparseMatrix};
use dcb_import::mesh::read_mesh;
use dcb_import::{Import, Imported, LostOrder, NamedFile, NodeOrder, import};
use tempfile::TempDir;

use crate::{data, request};

fn matrix(name: &str) -> SparseMatrix {
    read_matrix(&data(name)).unwrap().0
}

/// Files of a test.
struct Files(TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes the lower triangle of `new[i][j] = old[rows[i]][rows[j]]`.
    fn write(&self, name: &str, old: &SparseMatrix, rows: &[usize]) {
        let mut place = vec![0; rows.len()];
        for (new, old) in rows.iter().enumerate() {
            place[*old] = new;
        }
        let mut lines = String::new();
        let mut count = 0;
        for column in 0..old.ncols() {
            let entries = old.row_idx_of_col_raw(column).iter();
            for (row, value) in entries.zip(old.val_of_col(column)) {
                let (row, column) = (place[*row as usize] + 1, place[column] + 1);
                if row >= column {
                    writeln!(lines, "{row} {column} {value:e}").unwrap();
                    count += 1;
                }
            }
        }
        let size = rows.len();
        let head =
            format!("%%MatrixMarket matrix coordinate real symmetric\n{size} {size} {count}\n");
        std::fs::write(self.path(name), head + &lines).unwrap();
    }

    fn import(
        &self,
        stiffness: &str,
        mass: &str,
        mesh: &Path,
        lost: LostOrder,
    ) -> Result<Imported, Error> {
        import(&Import {
            stiffness: NamedFile::of(&self.path(stiffness)),
            mass: Some(NamedFile::of(&self.path(mass))),
            mesh: Some(mesh.to_path_buf()),
            node_order: NodeOrder::File,
            lost_order: lost,
            ..request("", None, "")
        })
    }
}

/// A mesh whose nodes are listed in the order of the rows.
fn mesh_in_row_order() -> PathBuf {
    data("bracket.json")
}

#[test]
fn rows_that_go_direction_after_direction_are_told_and_repaired() {
    let (stiffness, mass) = (matrix("bracket.mtx"), matrix("bracket.mass.mtx"));
    let size = stiffness.nrows();
    let by_direction: Vec<usize> = (0..3).flat_map(|axis| (axis..size).step_by(3)).collect();
    let files = Files::new();
    files.write("K.mtx", &stiffness, &by_direction);
    files.write("M.mtx", &mass, &by_direction);
    let mesh = mesh_in_row_order();
    let refused = files.import("K.mtx", "M.mtx", &mesh, LostOrder::Refuse);
    let message = refused.unwrap_err().to_string();
    assert!(
        message.contains("direction after direction") && message.contains("--repair-order"),
        "{message}"
    );
    let Imported { component, report } = files
        .import("K.mtx", "M.mtx", &mesh, LostOrder::Repair)
        .unwrap();
    assert!(report.resistance < 1e-12, "{}", report.resistance);
    let notes = component.notes.join("\n");
    assert!(notes.contains("direction after direction"), "{notes}");
    // The rows stay where they are, and the component says whose they are.
    assert_eq!(component.dofs.nodal_dofs().len(), size);
    for (found, old) in [(&component.stiffness, &stiffness), (&component.mass, &mass)] {
        let (found, old) = (found.to_dense(), old.to_dense());
        for (row, of_row) in component.dofs.nodal() {
            for (column, of_column) in component.dofs.nodal() {
                let place = |dof: Dof| 3 * dof.node as usize + dof.direction.index();
                assert_eq!(found[(row, column)], old[(place(of_row), place(of_column))]);
            }
        }
    }
}

#[test]
fn exchanged_matrices_are_told() {
    let files = Files::new();
    let rows: Vec<usize> = (0..matrix("bracket.mtx").nrows()).collect();
    files.write("K.mtx", &matrix("bracket.mtx"), &rows);
    files.write("M.mtx", &matrix("bracket.mass.mtx"), &rows);
    let exchanged = files.import("M.mtx", "K.mtx", &mesh_in_row_order(), LostOrder::Refuse);
    let message = exchanged.unwrap_err().to_string();
    assert!(
        message.contains("the stiffness, which comes first"),
        "{message}"
    );
}

#[test]
fn a_mass_that_couples_other_nodes_than_the_stiffness_is_told() {
    let (stiffness, mass) = (matrix("bracket.mtx"), matrix("bracket.mass.mtx"));
    let size = stiffness.nrows();
    let rows: Vec<usize> = (0..size).collect();
    // Node 7 k comes k-th: far from where it was, with the same directions.
    let nodes = size / 3;
    assert_ne!(nodes % 7, 0);
    let mixed: Vec<usize> = (0..size)
        .map(|row| 3 * (row / 3 * 7 % nodes) + row % 3)
        .collect();
    let files = Files::new();
    files.write("K.mtx", &stiffness, &rows);
    files.write("M.mtx", &mass, &rows);
    files.write("mixed.mtx", &mass, &mixed);
    let mesh = mesh_in_row_order();
    let warning = |mass: &str| {
        let Imported { component, .. } = files
            .import("K.mtx", mass, &mesh, LostOrder::Refuse)
            .unwrap();
        component.notes.join("\n").contains("in the same order?")
    };
    assert!(!warning("M.mtx"));
    assert!(warning("mixed.mtx"));
}

#[test]
fn a_name_that_promises_another_format_is_told() {
    let files = Files::new();
    std::fs::copy(data("matlab/bracket_v5.mat"), files.path("bracket.npz")).unwrap();
    std::fs::copy(data("bracket.mass.mtx"), files.path("bracket.mass.mtx")).unwrap();
    let mesh = mesh_in_row_order();
    let Imported { report, .. } = files
        .import(
            "bracket.npz#K",
            "bracket.mass.mtx",
            &mesh,
            LostOrder::Refuse,
        )
        .unwrap();
    let told: Vec<&String> = report
        .notes
        .iter()
        .filter(|note| note.contains("its name promises"))
        .collect();
    assert_eq!(
        told,
        ["bracket.npz is MATLAB 5 by its content, though its name promises NumPy"]
    );
}

/// Rows of some nodes along axes of their own, as Ansys' NROTAT makes them, and the list that NLIST prints, page after page.
#[test]
fn a_list_with_angles_turns_rows_back() {
    let (stiffness, mass) = (matrix("bracket.mtx"), matrix("bracket.mass.mtx"));
    let mesh = read_mesh(&mesh_in_row_order()).unwrap().mesh;
    let angles = |node: usize| match node % 5 {
        0 => [30.0, 0.0, 0.0],
        1 => [-110.0, 25.0, 70.0],
        _ => [0.0; 3],
    };
    let mut list = String::from(" LIST ALL SELECTED NODES.   DSYS=      0\n");
    let head = "\n   NODE        X             Y             Z           THXY    THYZ    THZX\n";
    for (node, [x, y, z]) in mesh.points.iter().enumerate() {
        if node % 20 == 0 {
            list.push_str(head);
        }
        let [about_z, about_x, about_y] = angles(node);
        writeln!(
            list,
            "{:9} {x:.17e} {y:.17e} {z:.17e} {about_z:8.2} {about_x:8.2} {about_y:8.2}",
            node + 1
        )
        .unwrap();
    }
    let files = Files::new();
    let path = files.path("nodes.lis");
    std::fs::write(&path, list).unwrap();
    // own = Rᵀ component, R = Rz Rx Ry written out.
    let turn = |node: usize| {
        let [a, b, c] = angles(node).map(f64::to_radians);
        let ((sa, ca), (sb, cb), (sc, cc)) = (a.sin_cos(), b.sin_cos(), c.sin_cos());
        [
            [ca * cc - sa * sb * sc, -sa * cb, ca * sc + sa * sb * cc],
            [sa * cc + ca * sb * sc, ca * cb, sa * sc - ca * sb * cc],
            [-cb * sc, sb, cb * cc],
        ]
    };
    for (name, matrix) in [("K.mtx", &stiffness), ("M.mtx", &mass)] {
        files.write_turned(name, matrix, &turn);
    }
    let Imported { component, report } = files
        .import("K.mtx", "M.mtx", &path, LostOrder::Refuse)
        .unwrap();
    assert!(report.resistance < 1e-12, "{}", report.resistance);
    for (found, expected) in [(&component.stiffness, &stiffness), (&component.mass, &mass)] {
        let largest = expected
            .val()
            .iter()
            .fold(0.0, |most: f64, value| most.max(value.abs()));
        let (found, expected) = (found.to_dense(), expected.to_dense());
        let error = (found - expected).norm_max() / largest;
        assert!(error < 1e-14, "{error:e}");
    }
    // Without the angles rigid motions are resisted.
    let plain = std::fs::read_to_string(&path).unwrap();
    let without: String = plain
        .lines()
        .map(|line| {
            line.split_whitespace()
                .take(4)
                .collect::<Vec<_>>()
                .join(" ")
                + "\n"
        })
        .collect();
    std::fs::write(&path, without).unwrap();
    assert!(
        files
            .import("K.mtx", "M.mtx", &path, LostOrder::Refuse)
            .is_err()
    );
}

impl Files {
    /// Writes Rᵀ A R with the blocks R of the nodes.
    fn write_turned(
        &self,
        name: &str,
        matrix: &SparseMatrix,
        turn: &dyn Fn(usize) -> [[f64; 3]; 3],
    ) {
        let dense = matrix.to_dense();
        let size = matrix.nrows();
        let mut lines = String::new();
        let mut count = 0;
        for column in 0..size {
            for row in column..size {
                let (left, right) = (turn(row / 3), turn(column / 3));
                let mut value = 0.0;
                for i in 0..3 {
                    for j in 0..3 {
                        value += left[i][row % 3]
                            * dense[(row / 3 * 3 + i, column / 3 * 3 + j)]
                            * right[j][column % 3];
                    }
                }
                if value != 0.0 {
                    writeln!(lines, "{} {} {value:e}", row + 1, column + 1).unwrap();
                    count += 1;
                }
            }
        }
        let head =
            format!("%%MatrixMarket matrix coordinate real symmetric\n{size} {size} {count}\n");
        std::fs::write(self.path(name), head + &lines).unwrap();
    }
}
