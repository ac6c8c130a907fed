//! Do interfaces do what their kinds say?
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::needless_range_loop
)]

mod dense_reduction;
mod modes;

use dcb_formats::Component;
use dcb_formats::component::{ComponentDraft, Interface, InterfaceKind, Role, Weights};
use dcb_formats::mesh::Direction;
use dcb_reducer::model::condensation::Model;
use dcb_reducer::model::localization::Localization;
use dcb_samples::spatial_beam::{BeamMass, BeamTheory};
use dcb_samples::{SolidElement, reference_hexahedra};
use dcb_tests::dense::{
    dense, diagonal_roots, difference, largest, relative, scaled_difference, sparse,
};
use dcb_tests::localization::average_rows;
use dcb_tests::oracle::{Oracle, centre_of_mass, rigid_motions};
use dcb_tests::{assert_says, lowest, parts, refusal};
use faer::Mat;

/// L_b of a part without rigid interfaces, as the reducer builds it.
fn built_rows(component: &Component) -> Mat<f64> {
    let model = Model::of(component).unwrap();
    let localization = Localization::of(component, &model).unwrap();
    let mut rows = Mat::zeros(localization.len(), component.dofs.len());
    for (i, row) in localization.rows.iter().enumerate() {
        row.coefficients
            .iter()
            .for_each(|(dof, value)| rows[(i, *dof as usize)] = *value);
    }
    rows
}

fn average(nodes: Vec<u32>, position: Option<[f64; 3]>, weights: Weights) -> Interface {
    Interface {
        position,
        weights,
        ..parts::interface("face", InterfaceKind::Average, nodes)
    }
}

fn block() -> Component {
    parts::steel_box([3, 2, 2], SolidElement::Hexahedron)
}

#[test]
fn an_averaged_frame_follows_rigid_motions_exactly() {
    let part = block();
    let face = part.mesh.point_sets["x_max"].clone();
    for position in [None, Some([0.4, 0.0, 0.0]), Some([1.3, -0.4, 0.2])] {
        let uneven = Weights::Given((0..face.len()).map(|i| 1.0 + i as f64).collect());
        for weights in [Weights::Uniform, uneven] {
            let component =
                parts::with_interfaces(&part, vec![average(face.clone(), position, weights)]);
            let rows = built_rows(&component);
            let placed = lowest(&component, 0).superelement;
            let (_, centre) = centre_of_mass(&component);
            let reference = std::array::from_fn(|i| placed.interfaces[0].position[i] + centre[i]);
            // Row i of the frame sees motion i about its reference as one, and no other.
            let seen = &rows * rigid_motions(&component, reference);
            assert!(
                largest((seen - dcb_tests::dense::identity(6)).as_ref()) < 1e-12,
                "{position:?}"
            );
        }
    }
}

#[test]
fn an_averaged_frame_is_the_weighted_least_squares_fit() {
    let part = block();
    let face = part.mesh.point_sets["x_max"].clone();
    let given: Vec<f64> = (0..face.len())
        .map(|i| 0.5 + (i as f64 * 1.7).sin().abs())
        .collect();
    let mass = dense(&part.mass);
    let of_mass: Vec<f64> = face
        .iter()
        .map(|node| {
            (0..3)
                .map(|a| mass[(3 * *node as usize + a, 3 * *node as usize + a)])
                .sum()
        })
        .collect();
    // A 2 x 2 face of linear quadrilaterals: each shares its area equally among its four corners.
    let of_area: Vec<f64> = face
        .iter()
        .map(|node| {
            let [_, y, z] = part.mesh.position(*node);
            let inside = |x: f64, width: f64| {
                if x < 1e-9 || x > width - 1e-9 {
                    1.0
                } else {
                    2.0
                }
            };
            0.1 * 0.06 / 16.0 * inside(y, 0.1) * inside(z, 0.06)
        })
        .collect();
    let cases = [
        (Weights::Uniform, vec![1.0; face.len()]),
        (Weights::Given(given.clone()), given),
        (Weights::Mass, of_mass),
        (Weights::Area, of_area),
    ];
    for (weights, numbers) in cases {
        let interface = average(face.clone(), Some([0.41, 0.02, -0.03]), weights.clone());
        let component = parts::with_interfaces(&part, vec![interface.clone()]);
        let expected = average_rows(&component, &interface, &numbers);
        let expected = Mat::from_fn(6, component.dofs.len(), |i, j| expected[i][j]);
        assert!(
            difference(&built_rows(&component), &expected) < 1e-12,
            "{weights:?}"
        );
        // Without a position the frame stands at the weighted centroid.
        let free =
            parts::with_interfaces(&part, vec![average(face.clone(), None, weights.clone())]);
        let (_, centre) = centre_of_mass(&free);
        let placed = lowest(&free, 0).superelement.interfaces[0].position;
        let total: f64 = numbers.iter().sum();
        for axis in 0..3 {
            let mean: f64 = face
                .iter()
                .zip(&numbers)
                .map(|(n, w)| w * free.mesh.position(*n)[axis])
                .sum::<f64>()
                / total;
            assert!(
                (placed[axis] + centre[axis] - mean).abs() < 1e-13,
                "{weights:?}"
            );
        }
    }
}

#[test]
fn too_few_nodes_for_a_moment_are_refused_unless_they_have_rotations() {
    let part = block();
    let line: Vec<u32> = part.mesh.point_sets["x_max"]
        .iter()
        .copied()
        .filter(|n| part.mesh.position(*n)[1] < 1e-9)
        .collect();
    for nodes in [line.clone(), line[..2].to_vec(), line[..1].to_vec()] {
        let message = refusal(&parts::with_interfaces(
            &part,
            vec![average(nodes.clone(), None, Weights::Uniform)],
        ));
        let count = format!("its {} node(s)", nodes.len());
        assert_says(
            &message,
            &[
                "\"face\"",
                &count,
                "3 nodes that are not on one line",
                "\"ux\", \"uy\", \"uz\"",
            ],
        );
        let translations = Interface {
            directions: Some(vec![Direction::Ux, Direction::Uy, Direction::Uz]),
            ..average(nodes, None, Weights::Uniform)
        };
        assert_eq!(
            lowest(&parts::with_interfaces(&part, vec![translations]), 2)
                .superelement
                .rows
                .len(),
            3
        );
    }
    let beam = parts::beam(4, BeamTheory::Timoshenko, BeamMass::Consistent);
    for nodes in [vec![2, 3, 4], vec![4]] {
        let interface = average(nodes.clone(), Some([1.1, 0.05, 0.0]), Weights::Uniform);
        let component = parts::with_interfaces(&beam, vec![interface]);
        let seen = built_rows(&component) * rigid_motions(&component, [1.1, 0.05, 0.0]);
        assert!(
            largest((seen - dcb_tests::dense::identity(6)).as_ref()) < 1e-12,
            "{nodes:?}"
        );
    }
}

/// Columns of T: the frame's motions on its nodes, then every other dof, with the dofs they stand for.
fn constrained(component: &Component, nodes: &[u32], position: [f64; 3]) -> Mat<f64> {
    let motions = rigid_motions(component, position);
    let dofs = component.dofs.nodal_dofs();
    let free: Vec<usize> = (0..dofs.len())
        .filter(|row| !nodes.contains(&dofs[*row].node))
        .collect();
    Mat::from_fn(dofs.len(), 6 + free.len(), |row, column| match column {
        c if c < 6 && nodes.contains(&dofs[row].node) => motions[(row, c)],
        c if c < 6 => 0.0,
        c => f64::from(u8::from(free[c - 6] == row)),
    })
}

#[test]
fn a_rigid_interface_is_the_constrained_part_exactly() {
    let solid = block();
    let face = solid.mesh.point_sets["x_max"].clone();
    let beam = parts::beam(5, BeamTheory::Timoshenko, BeamMass::Consistent);
    for (part, nodes, position) in [
        (solid, face, [0.42, 0.03, 0.01]),
        (beam, vec![4, 5], [0.9, 0.1, -0.05]),
    ] {
        let rigid = Interface {
            position: Some(position),
            ..parts::interface("hub", InterfaceKind::Rigid, nodes.clone())
        };
        let other = part.interfaces[0].clone();
        let component = Component::checked(ComponentDraft {
            component_masses: None,
            ..parts::with_interfaces(&part, vec![rigid, other.clone()]).into_draft()
        })
        .unwrap();
        let t = constrained(&component, &nodes, position);
        let through = |a: Mat<f64>| t.transpose() * a * &t;
        let (_, centre) = centre_of_mass(&component);
        // Rigid motions of the constrained dofs: the frame's own, the others as they are.
        let whole = rigid_motions(&component, centre);
        let arm: [f64; 3] = std::array::from_fn(|i| position[i] - centre[i]);
        let frame = Mat::from_fn(6, 6, |i, j| match (i < 3, j < 3) {
            (true, true) | (false, false) => f64::from(u8::from(i == j)),
            (true, false) => {
                nalgebra::Vector3::ith(j - 3, 1.0).cross(&nalgebra::Vector3::from(arm))[i]
            }
            (false, true) => 0.0,
        });
        let free: Vec<usize> = (0..component.dofs.len())
            .filter(|row| !nodes.contains(&component.dofs.dof(*row).unwrap().node))
            .collect();
        let motions = Mat::from_fn(6 + free.len(), 6, |i, j| {
            if i < 6 {
                frame[(i, j)]
            } else {
                whole[(free[i - 6], j)]
            }
        });
        let elsewhere =
            dcb_tests::localization::localization(&parts::with_interfaces(&component, vec![other]));
        let elsewhere = elsewhere * &t;
        let n_b = 6 + elsewhere.nrows();
        let rows = Mat::from_fn(n_b, t.ncols(), |i, j| match i {
            i if i < 6 => f64::from(u8::from(i == j)),
            i => elsewhere[(i - 6, j)],
        });
        let oracle = Oracle::from_parts(
            through(dense(&component.stiffness)),
            through(dense(&component.mass)),
            motions,
            rows,
        );
        let reduced = lowest(&component, 5);
        let element = &reduced.superelement;
        assert!(
            relative(&element.modes.eigenvalues, &oracle.eigenvalues[..5]) < 1e-9,
            "{}",
            component.name
        );
        let f = oracle.residual_flexibility(5);
        assert!(
            scaled_difference(&element.residual.flexibility, &f, &diagonal_roots(&f)) < 1e-9,
            "{}",
            component.name
        );
        let m = oracle.residual_mass(5);
        assert!(
            scaled_difference(&element.residual.mass, &m, &diagonal_roots(&m)) < 1e-9,
            "{}",
            component.name
        );
        // The recovered field moves the interface's nodes as one rigid body: the frame's own rows say how.
        let lone = rigid_motions(&component, position);
        let field = &reduced.recovery.modes;
        for k in 0..5 {
            for (row, dof) in component
                .dofs
                .nodal_dofs()
                .iter()
                .enumerate()
                .filter(|(_, dof)| nodes.contains(&dof.node))
            {
                let expected: f64 = (0..6)
                    .map(|i| lone[(row, i)] * element.modes.interface_shapes[(i, k)])
                    .sum();
                let size = (0..field.nrows())
                    .map(|i| field[(i, k)].abs())
                    .fold(0.0, f64::max);
                assert!(
                    (field[(row, k)] - expected).abs() < 1e-13 * size,
                    "node {} of mode {k}",
                    dof.node
                );
            }
        }
    }
}

#[test]
fn an_averaged_frame_takes_part_in_the_rigid_motion_of_shared_nodes() {
    let part = block();
    let (x, y) = (
        part.mesh.point_sets["x_max"].clone(),
        part.mesh.point_sets["y_max"].clone(),
    );
    assert!(x.iter().any(|node| y.contains(node)));
    let mixed = vec![
        parts::interface("end", InterfaceKind::Rigid, x),
        parts::interface("side", InterfaceKind::Average, y),
    ];
    assert_eq!(
        lowest(&parts::with_interfaces(&part, mixed), 3)
            .superelement
            .rows
            .len(),
        12
    );
}

#[test]
fn explicit_rows_are_used_as_they_are() {
    let part = reference_hexahedra();
    let mut matrix = Mat::zeros(2, part.dofs.len());
    (matrix[(0, 3)], matrix[(0, 12)], matrix[(1, 40)]) = (0.25, -1.5, 2.0);
    let component = Component::checked(ComponentDraft {
        explicit_boundary: Some(sparse(&matrix)),
        ..parts::with_interfaces(&part, Vec::new()).into_draft()
    })
    .unwrap();
    let oracle = Oracle::of(&component);
    let element = lowest(&component, 4).superelement;
    assert_eq!(element.interfaces[0].name, "boundary");
    assert!(
        element
            .rows
            .iter()
            .all(|row| row.direction == -1 && row.node == -1)
    );
    let f = oracle.residual_flexibility(4);
    assert!(scaled_difference(&element.residual.flexibility, &f, &diagonal_roots(&f)) < 1e-10);
}

#[test]
fn repeated_rows_are_named_and_kept_but_not_counted_twice() {
    let part = reference_hexahedra();
    let mut again = part.interfaces[1].clone();
    again.name = "again".into();
    let single = lowest(&part, 2);
    let mut interfaces = part.interfaces.clone();
    interfaces.push(again);
    let double = lowest(&parts::with_interfaces(&part, interfaces), 2);
    let element = &double.superelement;
    assert_eq!(
        (element.rows.len(), element.residual.flexibility.nrows()),
        (9, 9)
    );
    assert_eq!(
        (single.quality.residual_rank, double.quality.residual_rank),
        (6, 6)
    );
    assert_eq!(
        (
            element.residual.transform.nrows(),
            element.residual.transform.ncols()
        ),
        (9, 6)
    );
    for direction in ["ux", "uy", "uz"] {
        let named = element.provenance.warnings.iter().any(|w| {
            w.contains("is a combination of")
                && w.contains(&format!("last/{direction} at node 29"))
                && w.contains(&format!("again/{direction} at node 29"))
        });
        assert!(named, "{direction}: {:?}", element.provenance.warnings);
    }
    let roots = |r: &dcb_reducer::Reduced| r.superelement.residual.sigma_squared.clone();
    let softer = relative(&roots(&double), &roots(&single));
    assert!(
        softer < 1e-8,
        "σ² does not depend on repetition: {softer:e}"
    );
    let none = element
        .modes
        .interface_shapes
        .as_ref()
        .subrows(6, 3)
        .to_owned();
    assert_eq!(
        none,
        element
            .modes
            .interface_shapes
            .as_ref()
            .subrows(3, 3)
            .to_owned()
    );
}

#[test]
fn output_rows_observe_and_do_not_act() {
    let part = reference_hexahedra();
    let sensor = Interface {
        role: Role::Output,
        ..parts::interface("sensor", InterfaceKind::Nodes, vec![13])
    };
    let mut interfaces = part.interfaces.clone();
    interfaces.insert(1, sensor);
    let component = parts::with_interfaces(&part, interfaces);
    let oracle = Oracle::of(&component);
    let element = lowest(&component, 4).superelement;
    let everything = &oracle.localization * oracle.residual_shapes(4);
    let output = |row: usize| (3..6).contains(&row);
    let (f, m) = (&element.residual.flexibility, &element.residual.mass);
    let seen = element
        .residual
        .output_shapes
        .as_ref()
        .expect("output shapes");
    let scale = diagonal_roots(&everything);
    for i in 0..9 {
        for j in 0..9 {
            if output(i) || output(j) {
                assert_eq!((f[(i, j)], m[(i, j)]), (0.0, 0.0), "({i}, {j})");
            }
            // Columns of forces are zero where nothing acts, rows are what every interface sees.
            let expected = if output(j) { 0.0 } else { everything[(i, j)] };
            assert!(
                (seen[(i, j)] - expected).abs() < 1e-10 * scale[i] * scale[j],
                "L_b G_res L_bᵀ ({i}, {j})"
            );
        }
    }
    assert!((0..4).any(|k| element.modes.interface_shapes[(4, k)] != 0.0));
    let without = lowest(&part, 4).superelement;
    assert!(
        relative(
            &element.residual.sigma_squared,
            &without.residual.sigma_squared
        ) < 1e-10
    );
}
