//! Rows that belong to no node: superelements of parts from CalculiX, Abaqus and Nastran against dense references, and what must not
//! depend on where such rows stand or which units they have.

use dcb_dense::symmetrized;
use dcb_formats::component::{ComponentDraft, ComponentMasses, InterfaceKind, NamedLoad};
use dcb_formats::identities;
use dcb_formats::mesh::{DofMap, MatrixRow};
use dcb_formats::superelement::CouplingSource;
use dcb_formats::{Component, SparseMatrix};
use dcb_reducer::model::rigid_body::component_columns;
use dcb_reducer::{
    EnrichmentSource, InterfaceModes, ModeSelection, Reduced, Reduction, reduce_whole,
};
use dcb_samples::{PseudoRandom, SolidElement};
use dcb_tests::dense::{dense, diagonal_roots, relative, scaled_difference, sparse};
use dcb_tests::oracle::Oracle;
use dcb_tests::parts::{interface, steel_box, with_interfaces, with_internal_rows, with_rows};
use dcb_tests::reference::{matrix, numbers};
use dcb_tests::{assert_says, lowest, refusal, with};
use faer::Mat;
use serde_json::Value;

use crate::samples::HEXAHEDRON_EDGES;

const PARTS: [&str; 3] = ["plate", "beam", "outboard"];

fn reference(part: &str) -> Value {
    let path = format!(
        "{}/data/internal_rows/reference.json",
        env!("CARGO_MANIFEST_DIR")
    );
    let text = std::fs::read_to_string(path).unwrap();
    serde_json::from_str::<Value>(&text).unwrap()[part].clone()
}

/// The whole response of each row to each force that elastic motion gives: F_res with no mode kept, diagonal roots.
fn flexibility_roots(expected: &Value) -> (usize, Vec<f64>) {
    let rows = expected["flexibility"]["0"].as_array().unwrap().len();
    let whole = matrix(&expected["flexibility"]["0"], rows);
    (rows, diagonal_roots(&whole))
}

#[test]
fn superelements_of_other_programs_parts_are_those_of_the_dense_references() {
    for part in PARTS {
        let (component, expected) = (with_internal_rows(part), reference(part));
        let internal = expected["internal_rows"].as_u64().unwrap() as usize;
        assert_eq!(component.dofs.internal_count(), internal);
        let (rows, roots) = flexibility_roots(&expected);
        let omega2 = numbers(&expected["omega2"]);
        for (kept, flexibility) in expected["flexibility"].as_object().unwrap() {
            let kept: usize = kept.parse().unwrap();
            let reduced = lowest(&component, kept);
            let element = &reduced.superelement;
            // A multiple root isn't cut, and counts whole in the reference then: those asked for here end at a gap.
            assert_eq!(element.mode_count(), kept, "{part}");
            let found = &element.modes.eigenvalues;
            assert!(relative(found, &omega2[..kept]) < 1e-10, "{part}, {kept}");
            let expected = matrix(flexibility, rows);
            let off = scaled_difference(&element.residual.flexibility, &expected, &roots);
            assert!(off < 1e-9, "F_res of {part} with {kept} modes: {off:e}");
            assert_eq!(reduced.recovery.dofs, component.dofs.nodal_dofs());
            assert_eq!(element.derivation.as_ref().unwrap().internal_rows, internal);
        }
        let element = lowest(&component, 0).superelement;
        // Directions of Nastran's mass differ by 4e-11 of it; the reference takes the first, the superelement the mean.
        let digits = if part == "outboard" { 1e-9 } else { 1e-13 };
        let mass = expected["mass"].as_f64().unwrap();
        let off = (element.inertia.mass / mass - 1.0).abs();
        assert!(off < digits, "mass of {part}: {off:e}");
        let centre = numbers(&expected["centre"]);
        let size = centre.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (found, centre) in element.origin.iter().zip(&centre) {
            let off = (found - centre).abs();
            assert!(off < digits * size, "centre of {part}: {off:e}");
        }
        let tensor = matrix(&expected["inertia"], 3);
        let largest = (0..3).map(|i| tensor[(i, i)]).fold(0.0, f64::max);
        for i in 0..3 {
            for j in 0..3 {
                let off = (element.inertia.tensor[i][j] - tensor[(i, j)]).abs();
                assert!(
                    off < 10.0 * digits * largest,
                    "{part}: J({i}, {j}) off by {off:e}"
                );
            }
        }
    }
}

#[test]
fn every_mode_that_the_mass_has_is_found_and_no_other() {
    for part in PARTS {
        let (component, expected) = (with_internal_rows(part), reference(part));
        let omega2 = numbers(&expected["omega2"]);
        let rank = expected["mass_rank"].as_u64().unwrap() as usize;
        assert_eq!(omega2.len() + 6, rank);
        for asked in [omega2.len() - 1, omega2.len(), omega2.len() + 1, 500] {
            let reduced = lowest(&component, asked);
            let element = &reduced.superelement;
            let kept = element.mode_count();
            assert!(kept >= asked.min(omega2.len()), "{part}, {asked}: {kept}");
            let off = relative(&element.modes.eigenvalues, &omega2[..kept]);
            assert!(off < 1e-8, "{part}, {asked}: {off:e}");
            let count = reduced.quality.mode_count;
            assert_eq!((count.counted, count.found), (6 + kept, 6 + kept));
            if kept == omega2.len() {
                assert_eq!(element.modes.first_omitted_eigenvalue, f64::INFINITY);
            }
            let fewer = element.provenance.warnings.iter();
            let said: Vec<&String> = fewer.filter(|said| said.contains("asked for")).collect();
            let expected = asked > omega2.len() && rank < component.dofs.len();
            assert_eq!(
                said.len(),
                usize::from(expected),
                "{part}, {asked}: {said:?}"
            );
            if expected {
                let rank = format!("rank {rank} of {}", component.dofs.len());
                assert_says(said[0], &[&format!("there are {}", omega2.len()), &rank]);
            }
            assert!(reduced.quality.broken_limits().is_empty(), "{part}");
        }
    }
}

#[test]
fn a_truncated_basis_with_its_attachments_is_that_of_dense_algebra_at_every_row() {
    let component = with_internal_rows("plate");
    let oracle = Oracle::of(&component);
    for kept in [0, 3, 11] {
        let whole = reduce_whole(&component, &Reduction::lowest(kept), &mut ()).unwrap();
        let shapes = whole.shapes();
        assert_eq!(shapes.modes.nrows(), component.dofs.len());
        let expected = oracle.residual_shapes(kept);
        for column in 0..expected.ncols() {
            let size = expected.col(column).norm_max();
            let off = (shapes.residual.col(column) - expected.col(column)).norm_max();
            assert!(off < 1e-9 * size, "column {column}, {kept} modes: {off:e}");
        }
        // The fields are those rows that nodes have, in the order of the matrices.
        let fields = &whole.reduced.recovery;
        for (place, (row, dof)) in component.dofs.nodal().enumerate() {
            assert_eq!(fields.dofs[place], dof);
            for column in 0..expected.ncols() {
                assert_eq!(
                    fields.residual[(place, column)],
                    shapes.residual[(row, column)]
                );
            }
        }
        let mass = dense(&component.mass);
        let gram = shapes.modes.transpose() * &mass * shapes.modes;
        for i in 0..kept {
            assert!((gram[(i, i)] - 1.0).abs() < 1e-10);
        }
        let found = &whole.reduced.superelement.residual.mass;
        let expected = oracle.residual_mass(kept);
        let off = scaled_difference(found, &expected, &diagonal_roots(&expected));
        assert!(off < 1e-8, "M_res with {kept} modes: {off:e}");
    }
}

/// The part with its rows in another order.
fn in_order(component: &Component, order: &[usize]) -> Component {
    let owners: Vec<MatrixRow> = (order.iter())
        .map(|row| component.dofs.rows()[*row])
        .collect();
    let nodes = component.mesh.node_count();
    Component::checked(ComponentDraft {
        dofs: DofMap::new(owners, nodes).unwrap(),
        stiffness: with_rows(&component.stiffness, order),
        mass: with_rows(&component.mass, order),
        ..component.clone().into_draft()
    })
    .unwrap()
}

/// The part with every internal coordinate in a unit of its own, from 1e-4 to 1e4 times the old one.
fn in_internal_units(component: &Component) -> Component {
    let exponents = PseudoRandom::new(3).numbers(component.dofs.len());
    let factor = |row: usize| match component.dofs.dof(row) {
        Some(_) => 1.0,
        None => 10_f64.powf(4.0 * exponents[row]),
    };
    let scaled = |matrix: &SparseMatrix| {
        let matrix = dense(matrix);
        sparse(&Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
            factor(i) * (matrix[(i, j)] * factor(j))
        }))
    };
    Component::checked(ComponentDraft {
        stiffness: scaled(&component.stiffness),
        mass: scaled(&component.mass),
        ..component.clone().into_draft()
    })
    .unwrap()
}

/// Largest differences of eigenvalues, F_res and nodal fields of two reductions of one part.
fn differences(found: &Reduced, expected: &Reduced) -> [f64; 3] {
    let of = |reduced: &Reduced| reduced.superelement.residual.flexibility.clone();
    let whole = of(expected);
    let fields = |reduced: &Reduced| reduced.recovery.modes.clone();
    let places: Vec<usize> = (expected.recovery.dofs.iter())
        .map(|dof| {
            let mut dofs = found.recovery.dofs.iter();
            dofs.position(|other| other == dof).unwrap()
        })
        .collect();
    let (found_fields, expected_fields) = (fields(found), fields(expected));
    let mut off = 0.0_f64;
    for k in 0..expected_fields.ncols() {
        let size = expected_fields.col(k).norm_max();
        for (i, place) in places.iter().enumerate() {
            off = off.max((found_fields[(*place, k)] - expected_fields[(i, k)]).abs() / size);
        }
    }
    [
        relative(
            &found.superelement.modes.eigenvalues,
            &expected.superelement.modes.eigenvalues,
        ),
        scaled_difference(&of(found), &whole, &diagonal_roots(&whole)),
        off,
    ]
}

#[test]
fn neither_the_order_nor_the_units_of_internal_rows_matter() {
    // The beam has double roots, whose axes are anybody's.
    for part in ["plate", "outboard"] {
        let component = with_internal_rows(part);
        let expected = lowest(&component, 5);
        // Internal rows among those of the nodes, which keep their order: of nodes that move as much the first decides a mode's sign.
        let inner = (0..component.dofs.len()).filter(|row| component.dofs.dof(*row).is_none());
        let mut inner = inner.rev().fuse();
        let mut order: Vec<usize> = Vec::new();
        for (row, _) in component.dofs.nodal() {
            order.extend([inner.next(), Some(row)].into_iter().flatten());
        }
        assert_eq!(order.len(), component.dofs.len());
        for other in [in_order(&component, &order), in_internal_units(&component)] {
            let found = differences(&lowest(&other, 5), &expected);
            assert!(
                found[0] < 1e-10 && found[1] < 1e-10 && found[2] < 1e-6,
                "{part}: {found:?}"
            );
        }
    }
}

/// The part with the motion of mid-side nodes as what it differs from the mean of the corners: functions of higher order, which vanish in
/// rigid motions. What they share with the corners in those is nothing but rounding.
fn hierarchical(component: &Component) -> Component {
    let size = component.stiffness.nrows();
    let mut transform = Mat::<f64>::identity(size, size);
    let mut owners = component.dofs.rows().to_vec();
    for cell in component.mesh.cells[0].nodes.chunks_exact(20) {
        for (edge, ends) in HEXAHEDRON_EDGES.iter().enumerate() {
            let middle = 3 * cell[8 + edge] as usize;
            for axis in 0..3 {
                owners[middle + axis] = MatrixRow::Internal;
                for end in ends {
                    transform[(middle + axis, 3 * cell[*end] as usize + axis)] = 0.5;
                }
            }
        }
    }
    let of = |matrix: &SparseMatrix| {
        let changed = transform.transpose() * dense(matrix) * &transform;
        sparse(&symmetrized(changed.as_ref()))
    };
    let nodes = component.mesh.node_count();
    Component::checked(ComponentDraft {
        dofs: DofMap::new(owners, nodes).unwrap(),
        stiffness: of(&component.stiffness),
        mass: of(&component.mass),
        ..component.clone().into_draft()
    })
    .unwrap()
}

#[test]
fn functions_of_higher_order_are_internal_rows_and_change_nothing() {
    let part = steel_box([3, 2, 1], SolidElement::Hexahedron20);
    let is_corner = |node: u32| {
        let of_cells = part.mesh.cells[0].nodes.chunks_exact(20);
        of_cells.into_iter().any(|cell| cell[..8].contains(&node))
    };
    let end = (0..part.mesh.node_count() as u32)
        .filter(|node| is_corner(*node) && part.mesh.position(*node)[0].abs() < 1e-12)
        .collect();
    let part = with_interfaces(&part, vec![interface("end", InterfaceKind::Average, end)]);
    let (expected, found) = (lowest(&part, 8), lowest(&hierarchical(&part), 8));
    let (expected, found) = (expected.superelement, found.superelement);
    assert_eq!(found.derivation.as_ref().unwrap().internal_rows, 3 * 46);
    let off = relative(&found.modes.eigenvalues, &expected.modes.eigenvalues);
    assert!(off < 1e-10, "{off:e}");
    let roots = diagonal_roots(&expected.residual.flexibility);
    let off = scaled_difference(
        &found.residual.flexibility,
        &expected.residual.flexibility,
        &roots,
    );
    assert!(off < 1e-8, "{off:e}");
}

#[test]
fn rigid_interfaces_leave_internal_rows_as_they_are() {
    let component = with_internal_rows("plate");
    let [left, right] = ["left", "right"].map(|set| component.mesh.point_sets[set].clone());
    let component = with_interfaces(
        &component,
        vec![
            interface("left", InterfaceKind::Rigid, left.clone()),
            interface("right", InterfaceKind::Average, right),
        ],
    );
    let reduced = lowest(&component, 6);
    // K and M with the six rigid motions of the left nodes in place of their eighteen dofs.
    let motions = component_columns(&component, [0.0, 16.0, 3.0]);
    let kept: Vec<usize> = (0..component.dofs.len())
        .filter(|row| {
            let dof = component.dofs.dof(*row);
            dof.is_none_or(|dof| !left.contains(&dof.node))
        })
        .collect();
    let t = Mat::from_fn(component.dofs.len(), 6 + kept.len(), |i, j| {
        match j.checked_sub(6) {
            None if kept.contains(&i) => 0.0,
            None => motions[(i, j)],
            Some(j) => f64::from(u8::from(kept[j] == i)),
        }
    });
    let condensed = |matrix: &SparseMatrix| t.transpose() * dense(matrix) * &t;
    let rigid = Mat::from_fn(6 + kept.len(), 6, |i, j| match i.checked_sub(6) {
        None => f64::from(u8::from(i == j)),
        Some(i) => motions[(kept[i], j)],
    });
    let none = Mat::zeros(0, 6 + kept.len());
    let oracle = Oracle::from_parts(
        condensed(&component.stiffness),
        condensed(&component.mass),
        rigid,
        none,
    );
    let off = relative(
        &reduced.superelement.modes.eigenvalues,
        &oracle.eigenvalues[..6],
    );
    assert!(off < 1e-9, "{off:e}");
}

#[test]
fn a_load_on_an_internal_row_does_work_and_has_no_resultant() {
    let component = with_internal_rows("plate");
    let row = (0..component.dofs.len())
        .rfind(|row| component.dofs.dof(*row).is_none())
        .unwrap();
    let mut forces = vec![0.0; component.dofs.len()];
    forces[row] = 2.5;
    let name = "inside".to_owned();
    let component = component
        .changed(|draft| draft.loads = vec![NamedLoad { name, forces }])
        .unwrap();
    let options = Reduction {
        modes: ModeSelection::Lowest(4),
        enrichment: vec![EnrichmentSource::Loads],
        ..Reduction::lowest(4)
    };
    let whole = reduce_whole(&component, &options, &mut ()).unwrap();
    let load = &whole.reduced.superelement.loads[0];
    assert_eq!((load.force, load.moment), ([0.0; 3], [0.0; 3]));
    let shapes = whole.shapes();
    for k in 0..4 {
        assert_eq!(load.work[k], 2.5 * shapes.modes[(row, k)]);
    }
    assert!(load.work.iter().any(|work| *work != 0.0));
}

#[test]
fn multipliers_of_constraints_are_no_internal_rows() {
    // Two nodes of the plate held together by a multiplier: no mass, and nothing or little on the diagonal.
    let component = with_internal_rows("plate");
    let n = component.dofs.len();
    let [first, second] = [1, 7].map(|node| {
        let direction = dcb_formats::mesh::Direction::Ux;
        component.dofs.row(node, direction).unwrap()
    });
    for on_diagonal in [0.0, 1.0] {
        let bordered = |matrix: &SparseMatrix, coupling: f64, own: f64| {
            let matrix = dense(matrix);
            sparse(&Mat::from_fn(n + 1, n + 1, |i, j| match (i == n, j == n) {
                (false, false) => matrix[(i, j)],
                (true, true) => own,
                (true, false) if j == first => coupling,
                (true, false) if j == second => -coupling,
                (false, true) if i == first => coupling,
                (false, true) if i == second => -coupling,
                _ => 0.0,
            }))
        };
        let mut owners = component.dofs.rows().to_vec();
        owners.push(MatrixRow::Internal);
        let bordered = Component::checked(ComponentDraft {
            dofs: DofMap::new(owners, component.mesh.node_count()).unwrap(),
            stiffness: bordered(&component.stiffness, 1e6, on_diagonal),
            mass: bordered(&component.mass, 0.0, 0.0),
            ..component.clone().into_draft()
        })
        .unwrap();
        let said = refusal(&bordered);
        assert_says(
            &said,
            &[
                "stiffness matrix is indefinite",
                "Lagrange multipliers",
                "no internal rows",
                "build K and M without them",
            ],
        );
        if on_diagonal == 0.0 {
            assert_says(&said, &[&format!("internal row {n}")]);
        }
    }
}

#[test]
fn a_row_that_is_no_internal_one_is_found_by_the_rigid_motions() {
    // The uz of a node in the middle said to be internal: rigid motions leave it behind.
    let component = with_internal_rows("plate");
    let row = component
        .dofs
        .row(13, dcb_formats::mesh::Direction::Uz)
        .unwrap();
    let mut owners = component.dofs.rows().to_vec();
    owners[row] = MatrixRow::Internal;
    let nodes = component.mesh.node_count();
    let wrong = component
        .changed(|draft| draft.dofs = DofMap::new(owners, nodes).unwrap())
        .unwrap();
    assert_says(
        &refusal(&wrong),
        &[
            "don't belong together",
            "rigid motions",
            &format!("internal row {row}"),
        ],
    );
}

#[test]
fn interface_modes_and_further_columns_go_with_internal_rows() {
    for part in PARTS {
        let component = with_internal_rows(part);
        let options = Reduction {
            interface_modes: InterfaceModes::Softest(3),
            ..Reduction::lowest(2)
        };
        let few = with(&component, &options);
        assert!(few.superelement.residual.sigma_squared.len() <= 3);
        let options = Reduction {
            enrichment: vec![EnrichmentSource::Spin, EnrichmentSource::Krylov],
            ..Reduction::lowest(2)
        };
        let more = with(&component, &options);
        assert!(more.superelement.enrichment.is_some(), "{part}");
        for reduced in [few, more] {
            assert!(reduced.quality.broken_limits().is_empty(), "{part}");
        }
    }
}

/// Component masses of the plate, whose elements have one shape function for all directions and three amplitudes to each inner one.
fn component_masses(plate: &Component) -> ComponentMasses {
    let n = plate.dofs.len();
    // Point and direction of each row; inner amplitudes come in threes.
    let mut points = Vec::with_capacity(n);
    let mut inner = 0;
    for row in plate.dofs.rows() {
        points.push(match row {
            MatrixRow::Nodal(dof) => (dof.node as usize, dof.direction.index()),
            MatrixRow::Internal => (plate.mesh.node_count() + inner / 3, inner % 3),
        });
        inner += usize::from(*row == MatrixRow::Internal);
    }
    let place = |of: (usize, usize)| points.iter().position(|point| *point == of).unwrap();
    let mass = dense(&plate.mass);
    let matrix = |c: usize, d: usize| {
        sparse(&Mat::from_fn(n, n, |i, j| {
            let ((p, a), (q, b)) = (points[i], points[j]);
            match (a, b) == (c, d) {
                true => mass[(place((p, 0)), place((q, 0)))],
                false => 0.0,
            }
        }))
    };
    let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
    ComponentMasses {
        matrices: pairs.iter().map(|(c, d)| matrix(*c, *d)).collect(),
    }
}

#[test]
fn component_masses_make_the_couplings_of_internal_rows_integrals() {
    let plate = with_internal_rows("plate");
    let said = |reduced: &Reduced| {
        let warnings = reduced.superelement.provenance.warnings.iter();
        warnings
            .filter(|said| said.contains("are internal"))
            .count()
    };
    let nodal = lowest(&plate, 10);
    assert_eq!(said(&nodal), 1);
    let masses = component_masses(&plate);
    let plate = plate
        .changed(|draft| draft.component_masses = Some(masses))
        .unwrap();
    let exact = lowest(&plate, 10);
    assert_eq!(said(&exact), 0);
    assert_eq!(
        exact.superelement.coupling_source(),
        CouplingSource::Integrals
    );
    // All identities of one field of displacements hold, with the motion inside elements in L3 and I2.
    for identity in identities::in_full(&exact.superelement) {
        assert!(
            identity.defect <= identity.limit,
            "{} {}: {:e}",
            identity.path,
            identity.what,
            identity.defect
        );
    }
    // Nodes alone come near, and not nearer.
    let (found, expected) = (&nodal.superelement.inertia, &exact.superelement.inertia);
    let off = (0..3).map(|a| (&found.l3[a] - &expected.l3[a]).norm_max());
    let size = (0..3).map(|a| expected.l3[a].norm_max());
    let off = off.fold(0.0, f64::max) / size.fold(0.0, f64::max);
    assert!((1e-9..1.0).contains(&off), "{off:e}");
}
