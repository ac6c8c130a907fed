//! What `Component::checked` refuses, by the place of the fault, and what it puts in order.

use dcb_formats::SparseMatrix;
use dcb_formats::component::{
    Component, ComponentDraft, ComponentFault, ComponentMasses, Damping, GeometricStiffness,
    InterfaceKind, NamedLoad, Place, Role, RowStiffness, Weights,
};
use dcb_formats::mesh::{Dimension, Direction, DofMap};
use dcb_samples::{Material, RodSection, SolidElement, box_block, planar_rod};
use dcb_tests::dense::{dense, sparse};
use faer::sparse::{SymbolicSparseColMat, Triplet};

/// Three cells with an averaged frame at each end.
fn block() -> ComponentDraft {
    let sides = [0.3, 0.1, 0.1];
    box_block([3, 1, 1], sides, SolidElement::Hexahedron, &Material::STEEL).into_draft()
}

/// Five nodes with rotations, and component masses.
fn rod() -> ComponentDraft {
    planar_rod(4, &RodSection::default()).into_draft()
}

type Change = fn(&mut ComponentDraft);

#[track_caller]
fn refused(of: ComponentDraft, change: Change, place: &str, words: &[&str]) {
    let mut draft = of;
    change(&mut draft);
    let fault = Component::checked(draft).expect_err(place);
    assert_eq!(fault.place.to_string(), place, "{fault}");
    for word in words {
        assert!(fault.message.contains(word), "{word:?} isn't in: {fault}");
    }
}

fn scaled(matrix: &SparseMatrix, row: usize, column: usize, factor: f64) -> SparseMatrix {
    let mut entries = dense(matrix);
    entries[(row, column)] *= factor;
    sparse(&entries)
}

#[test]
fn names_units_and_damping() {
    let cases: [(Change, &str, &str); 7] = [
        (|of| of.name = " ".into(), "component.name", "is empty"),
        (
            |of| of.units.mass = "k\u{7}g".into(),
            "component.units.mass",
            "control character",
        ),
        (
            |of| of.damping = Damping::Uniform(-0.01),
            "component.damping.modal",
            "-0.01",
        ),
        (
            |of| of.damping = Damping::PerMode(Vec::new()),
            "component.damping.modal",
            "empty list",
        ),
        (
            |of| of.damping = Damping::PerMode(vec![0.01, f64::NAN]),
            "component.damping.modal[1]",
            "NaN",
        ),
        (
            |of| {
                of.damping = Damping::Rayleigh {
                    alpha: 0.0,
                    beta: -1.0,
                }
            },
            "component.damping.rayleigh[1]",
            "-1",
        ),
        (
            |of| {
                of.damping = Damping::Rayleigh {
                    alpha: f64::INFINITY,
                    beta: 0.0,
                }
            },
            "component.damping.rayleigh[0]",
            "inf",
        ),
    ];
    for (change, place, word) in cases {
        refused(block(), change, place, &[word]);
    }
}

#[test]
fn geometry_and_dofs() {
    let cases: [(Change, &str, &str); 9] = [
        (|of| of.mesh.coordinates.clear(), "points", "is empty"),
        (
            |of| of.mesh.coordinates.truncate(46),
            "points",
            "46 coordinates, expected 3",
        ),
        (
            |of| of.mesh.coordinates[7] = f64::NAN,
            "points[2][1]",
            "NaN",
        ),
        (
            |of| of.mesh.cells[0].nodes[9] = 16,
            "cells[0].data[1][1]",
            "1-based",
        ),
        (
            |of| of.mesh.cells[0].nodes_per_cell = 0,
            "cells[0].data",
            "0 nodes per cell",
        ),
        (
            |of| {
                of.mesh.cells[0].cell_type = "polyhedron".into();
                of.mesh.cells[0].nodes.truncate(7);
            },
            "cells[0].data",
            "has 7 nodes, expected 8",
        ),
        (
            |of| of.mesh.point_sets.get_mut("x_min").unwrap()[1] = 99,
            "point_sets.x_min[1]",
            "node 99",
        ),
        (
            |of| of.dofs = DofMap::uniform(15, &Direction::ALL[..3]).unwrap(),
            "component.dofs",
            "of 15 nodes",
        ),
        (
            |of| of.dofs = DofMap::uniform(16, &Direction::ALL[..2]).unwrap(),
            "component.dofs",
            "32 dofs",
        ),
    ];
    for (change, place, word) in cases {
        refused(block(), change, place, &[word]);
    }
    let out_of_plane: Change = |of| {
        let directions = [Direction::Ux, Direction::Uz, Direction::Rz];
        of.dofs = DofMap::uniform(5, &directions).unwrap();
    };
    refused(rod(), out_of_plane, "component.dofs[1]", &["uz", "planar"]);
    let without_one: Change = |of| {
        of.dofs = DofMap::uniform(16, &[Direction::Ux, Direction::Uy, Direction::Rz]).unwrap();
    };
    refused(block(), without_one, "component.dofs", &["no uz"]);
}

#[test]
fn interfaces() {
    let cases: [(Change, &str, &str); 14] = [
        (|of| of.interfaces[1].name.clear(), "[1].name", "is empty"),
        (
            |of| of.interfaces[1].name = "left".into(),
            "[1].name",
            "already",
        ),
        (|of| of.interfaces[0].name = "a/b".into(), "[0].name", "`/`"),
        (|of| of.interfaces[0].nodes.clear(), "[0].nodes", "is empty"),
        (
            |of| of.interfaces[0].nodes[2] = 16,
            "[0].nodes[2]",
            "16 nodes",
        ),
        (
            |of| of.interfaces[0].nodes[1] = of.interfaces[0].nodes[0],
            "[0].nodes[1]",
            "again",
        ),
        (
            |of| of.interfaces[0].kind = InterfaceKind::Nodes,
            "[0].position",
            "where its nodes are",
        ),
        (
            |of| of.interfaces[0].position = Some([0.0, f64::NAN, 0.0]),
            "[0].position",
            "finite",
        ),
        (
            |of| of.interfaces[0].weights = Weights::Given(vec![1.0; 3]),
            "[0].weights",
            "3 numbers",
        ),
        (
            |of| of.interfaces[0].weights = Weights::Given(vec![1.0, 1.0, -1.0, 1.0]),
            "[0].weights[2]",
            "> 0",
        ),
        (
            |of| {
                of.interfaces[0].kind = InterfaceKind::Rigid;
                of.interfaces[0].weights = Weights::Area;
            },
            "[0].weights",
            "`rigid`",
        ),
        (
            |of| of.interfaces[0].axes = Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]),
            "[0].axes",
            "left-handed",
        ),
        (
            |of| of.interfaces[0].axes = Some([[f64::NAN; 3]; 3]),
            "[0].axes[0]",
            "unit vector",
        ),
        (
            |of| of.interfaces[0].directions = Some(Vec::new()),
            "[0].dofs",
            "is empty",
        ),
    ];
    for (change, place, word) in cases {
        let place = format!("component.interfaces{place}");
        refused(block(), change, &place, &[word]);
    }
    let absent: Change = |of| of.interfaces[0].directions = Some(vec![Direction::Uz]);
    let place = "component.interfaces[0].dofs[0]";
    refused(
        rod(),
        absent,
        place,
        &["uz", "the nodes have only ux uy rz"],
    );
    let off_plane: Change = |of| {
        of.interfaces[0].kind = InterfaceKind::Rigid;
        of.interfaces[0].position = Some([0.0, 0.0, 1.0]);
    };
    let place = "component.interfaces[0].position";
    refused(rod(), off_plane, place, &["z = 1", "planar"]);
    let welded: Change = |of| {
        let shared = of.interfaces[0].nodes[0];
        for interface in &mut of.interfaces {
            interface.kind = InterfaceKind::Rigid;
        }
        of.interfaces[1].nodes.push(shared);
    };
    refused(block(), welded, "component.interfaces[1]", &["weld"]);
}

#[test]
fn operators() {
    let n = 48;
    let cases: [(Change, &str, &str); 6] = [
        (
            |of| of.mass = sparse(&faer::Mat::identity(47, 47)),
            "mass",
            "is 47 x 47, but the stiffness matrix is 48 x 48",
        ),
        (
            |of| of.stiffness = sparse(&faer::Mat::from_fn(48, 50, |_, _| 1.0)),
            "stiffness",
            "is 48 x 50",
        ),
        (
            |of| of.stiffness.val_mut()[3] = f64::NAN,
            "stiffness",
            "column 1 is NaN",
        ),
        (
            |of| of.stiffness = scaled(&of.stiffness, 3, 0, 1.001),
            "stiffness",
            "not symmetric: (4, 1)",
        ),
        (
            |of| of.mass = scaled(&of.mass, 0, 3, 1.001),
            "mass",
            "not symmetric: (4, 1)",
        ),
        (
            |of| of.explicit_boundary = Some(sparse(&faer::Mat::identity(3, 47))),
            "explicit_boundary",
            "47 columns, but the component has 48 dofs",
        ),
    ];
    for (change, place, word) in cases {
        refused(block(), change, place, &[word]);
    }
    let named: Change = |of| {
        of.explicit_boundary = Some(sparse(&faer::Mat::identity(3, 48)));
        of.interfaces[1].name = "boundary".into();
    };
    let place = "component.interfaces[1].name";
    refused(block(), named, place, &["--boundary", "rename"]);
    let empty: Change = |of| {
        let rows = faer::Mat::from_fn(3, 48, |i, j| if i == 1 { 0.0 } else { j as f64 });
        of.explicit_boundary = Some(sparse(&rows));
    };
    refused(block(), empty, "explicit_boundary", &["row 2 has no entry"]);
    // Rows in another order than theirs.
    let mut starts = vec![0_u32, 2];
    starts.resize(n + 1, 2);
    let unsorted = SymbolicSparseColMat::new_unsorted_checked(n, n, starts, None, vec![4, 1]);
    let mut draft = block();
    draft.mass = SparseMatrix::new(unsorted, vec![1.0, 1.0]);
    let fault = Component::checked(draft).unwrap_err();
    assert_eq!(fault.place, Place::Mass);
    assert!(fault.message.contains("row 2 after 5"), "{fault}");
}

#[test]
fn loads_and_geometric_stiffness() {
    fn with_loads(of: &mut ComponentDraft, loads: &[(&str, Vec<f64>)]) {
        of.loads = (loads.iter())
            .map(|(name, forces)| NamedLoad {
                name: (*name).to_owned(),
                forces: forces.clone(),
            })
            .collect();
    }
    fn prestressed(of: &mut ComponentDraft, spins: usize, row: usize) {
        let matrix = sparse(&faer::Mat::identity(48, 48));
        of.geometric_stiffness = Some(GeometricStiffness {
            spins: vec![Some(matrix.clone()); spins],
            rows: vec![RowStiffness {
                row: (row, Direction::Ux),
                matrix,
            }],
        });
    }
    let cases: [(Change, &str, &str); 9] = [
        (
            |of| with_loads(of, &[("wind", vec![1.0; 47])]),
            "loads[0]",
            "has 47 entries",
        ),
        (
            |of| with_loads(of, &[("wind", vec![1.0; 48]), ("wind", vec![1.0; 48])]),
            "loads[1]",
            "no other load has",
        ),
        (
            |of| with_loads(of, &[("wind", vec![f64::NAN; 48])]),
            "loads[0]",
            "entry 1 is not finite",
        ),
        (
            |of| with_loads(of, &[("wind", vec![0.0; 48])]),
            "loads[0]",
            "isn't zero",
        ),
        (
            |of| prestressed(of, 3, 0),
            "geometric_stiffness.spins[3]",
            "3 products of spins, expected 6",
        ),
        (
            |of| prestressed(of, 6, 2),
            "geometric_stiffness.rows[0]",
            "interface 2",
        ),
        (
            |of| {
                prestressed(of, 6, 1);
                of.interfaces[1].role = Role::Output;
            },
            "geometric_stiffness.rows[0]",
            "attached",
        ),
        (
            |of| {
                prestressed(of, 6, 1);
                let spins = &mut of.geometric_stiffness.as_mut().unwrap().spins;
                spins[4] = Some(sparse(&faer::Mat::identity(47, 47)));
            },
            "geometric_stiffness.spins[4]",
            "47 x 47",
        ),
        (
            |of| {
                prestressed(of, 0, 1);
                let row = &mut of.geometric_stiffness.as_mut().unwrap().rows[0];
                row.matrix = sparse(&faer::Mat::from_fn(48, 48, |i, j| (i + 2 * j) as f64));
            },
            "geometric_stiffness.rows[0]",
            "not symmetric",
        ),
    ];
    for (change, place, word) in cases {
        refused(block(), change, place, &[word]);
    }
}

#[test]
fn component_masses() {
    fn masses(of: &mut ComponentDraft) -> &mut Vec<SparseMatrix> {
        &mut of.component_masses.as_mut().unwrap().matrices
    }
    let cases: [(Change, &str, &str); 4] = [
        (
            |of| drop(masses(of).pop()),
            "component_masses[2]",
            "2 component masses, expected 3",
        ),
        (
            |of| masses(of)[1] = sparse(&faer::Mat::identity(14, 14)),
            "component_masses[1]",
            "14 x 14",
        ),
        (
            |of| masses(of)[0].val_mut()[0] *= 1.01,
            "mass",
            "don't add up to it: at row 1, column 1",
        ),
        (
            |of| masses(of)[2].val_mut().iter_mut().for_each(|m| *m *= -1.0),
            "component_masses[2]",
            "is not the component mass xy",
        ),
    ];
    for (change, place, word) in cases {
        refused(rod(), change, place, &[word]);
    }
    assert_eq!(ComponentMasses::names(Dimension::Spatial).len(), 6);
}

/// Rounding is put in order, once, and noted; what is in order stays as it is to the last bit.
#[test]
fn rounding_is_put_in_order() {
    let before = block();
    let after = Component::checked(before.clone()).unwrap();
    assert_eq!(after.stiffness.val(), before.stiffness.val());
    assert_eq!(after.mass.val(), before.mass.val());
    assert!(after.notes.is_empty(), "{:?}", after.notes);

    let mut rough = before.clone();
    rough.stiffness = scaled(&rough.stiffness, 3, 0, 1.0 + 1e-10);
    let [c, s] = [0.8 + 3e-7, 0.6 - 2e-7];
    rough.interfaces[0].axes = Some([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]);
    rough.interfaces[0].directions = Some(vec![Direction::Rz, Direction::Ux]);
    let smooth = Component::checked(rough).unwrap();
    let entries = dense(&smooth.stiffness);
    assert_eq!(entries[(3, 0)], entries[(0, 3)]);
    let moved = entries[(3, 0)] / dense(&before.stiffness)[(3, 0)] - 1.0;
    assert!((moved - 0.5e-10).abs() < 1e-15, "{moved:e}");
    let [note] = &smooth.notes[..] else {
        panic!("{:?}", smooth.notes);
    };
    assert!(
        note.contains("stiffness") && note.contains("averaged"),
        "{note}"
    );
    let axes = smooth.interfaces[0].axes.unwrap();
    for (i, a) in axes.iter().enumerate() {
        for (j, b) in axes.iter().enumerate() {
            let product: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
            let unit = if i == j { 1.0 } else { 0.0 };
            assert!((product - unit).abs() < 4.0 * f64::EPSILON, "{i} {j}");
        }
    }
    let directions = smooth.interfaces[0].directions.as_deref();
    assert_eq!(directions, Some(&[Direction::Ux, Direction::Rz][..]));

    let again = Component::checked(smooth.clone().into_draft()).unwrap();
    assert_eq!(again.interfaces, smooth.interfaces);
    assert_eq!(again.stiffness.val(), smooth.stiffness.val());
    assert_eq!(again.notes, smooth.notes);
}

/// A place that is stored on one side of the diagonal only counts as zero on the other, and both are stored afterwards.
#[test]
fn a_place_without_mirror_image_gets_one() {
    for (row, column) in [(0, 47), (47, 0)] {
        let mut draft = block();
        let whole = dense(&draft.stiffness);
        assert_eq!(whole[(row, column)], 0.0);
        let mut entries = Vec::new();
        for j in 0..48 {
            let rows = draft.stiffness.row_idx_of_col_raw(j).iter();
            let stored = rows.zip(draft.stiffness.val_of_col(j));
            entries.extend(stored.map(|(i, value)| Triplet::new(*i, j as u32, *value)));
        }
        let tiny = 1e-12 * whole[(0, 0)];
        entries.push(Triplet::new(row as u32, column as u32, tiny));
        let stored = entries.len();
        draft.stiffness = SparseMatrix::try_new_from_triplets(48, 48, &entries).unwrap();
        let component = Component::checked(draft).unwrap();
        assert_eq!(component.stiffness.compute_nnz(), stored + 1);
        let after = dense(&component.stiffness);
        assert_eq!(after[(0, 47)], 0.5 * tiny);
        assert_eq!(after[(47, 0)], 0.5 * tiny);
    }
}

#[test]
fn a_change_is_checked_too() {
    let component = Component::checked(block()).unwrap();
    let fault = component
        .changed(|draft| draft.interfaces[0].nodes.push(1000))
        .unwrap_err();
    let expected = ComponentFault {
        place: Place::Description("component.interfaces[0].nodes[4]".into()),
        message: "is node 1000, but the mesh has 16 nodes (0-based ids, up to 15)".into(),
    };
    assert_eq!(fault, expected);
}
