//! A part described in other axes: turned about the coordinate origin, then moved.

use dcb_formats::Component;
use dcb_formats::component::ComponentMasses;
use dcb_formats::mesh::Dof;
use dcb_formats::superelement::Superelement;
use faer::Mat;
use nalgebra::{Rotation3, Vector3};

use crate::dense::{dense, sparse, symmetric};
use crate::nodal::PAIRS;

/// Pairs of a planar part's component masses.
const PLANAR_PAIRS: [(usize, usize); 3] = [(0, 0), (1, 1), (0, 1)];

/// Q: each node's translations, and its rotations, turned.
fn turned_dofs(dofs: &[Dof], turn: &Rotation3<f64>) -> Mat<f64> {
    Mat::from_fn(dofs.len(), dofs.len(), |i, j| {
        let (a, b) = (dofs[i], dofs[j]);
        let together = a.node == b.node && a.direction.is_rotation() == b.direction.is_rotation();
        match together {
            true => turn[(a.direction.axis(), b.direction.axis())],
            false => 0.0,
        }
    })
}

/// B: the rows of each interface turned, in threes; u_Γ' = B u_Γ.
pub fn turned_rows(element: &Superelement, turn: &Rotation3<f64>) -> Mat<f64> {
    let rows = &element.rows;
    Mat::from_fn(rows.len(), rows.len(), |i, j| {
        let (a, b) = (&rows[i], &rows[j]);
        let together =
            (a.interface, a.node, a.direction >= 3) == (b.interface, b.node, b.direction >= 3);
        match together {
            true => turn[((a.direction % 3) as usize, (b.direction % 3) as usize)],
            false => 0.0,
        }
    })
}

/// The part turned and then moved; a planar one about z.
pub fn turned(component: &Component, turn: &Rotation3<f64>, by: [f64; 3]) -> Component {
    let d = component.dimension().coordinate_count();
    let place = |x: [f64; 3]| -> [f64; 3] { (turn * Vector3::from(x) + Vector3::from(by)).into() };
    let mut result = component.clone().into_draft();
    result.mesh.coordinates = (0..component.mesh.node_count() as u32)
        .flat_map(|node| place(component.mesh.position(node))[..d].to_vec())
        .collect();
    for interface in &mut result.interfaces {
        interface.position = interface.position.map(place);
    }
    let q = turned_dofs(&component.dofs.nodal_dofs(), turn);
    let in_new_axes = |matrix: &Mat<f64>| &q * matrix * q.transpose();
    result.stiffness = sparse(&symmetric(&in_new_axes(&dense(&component.stiffness))));
    result.mass = sparse(&symmetric(&in_new_axes(&dense(&component.mass))));
    result.component_masses = component.component_masses.as_ref().map(|masses| {
        let pairs = if d == 2 {
            &PLANAR_PAIRS[..]
        } else {
            &PAIRS[..]
        };
        let old: Vec<Mat<f64>> = masses
            .matrices
            .iter()
            .map(|matrix| in_new_axes(&dense(matrix)))
            .collect();
        let of = |a: usize, b: usize| match pairs.iter().position(|pair| *pair == (a, b)) {
            Some(at) => old[at].clone(),
            None => {
                let at = pairs.iter().position(|pair| *pair == (b, a));
                old[at.expect("every pair")].transpose().to_owned()
            }
        };
        // M'_cd = Σ R_ca R_db Q M_ab Qᵀ
        let new = |(c, e): (usize, usize)| {
            let mut sum = Mat::<f64>::zeros(q.nrows(), q.nrows());
            for a in 0..d {
                for b in 0..d {
                    sum += of(a, b) * faer::Scale(turn[(c, a)] * turn[(e, b)]);
                }
            }
            sparse(&if c == e { symmetric(&sum) } else { sum })
        };
        ComponentMasses {
            matrices: pairs.iter().copied().map(new).collect(),
        }
    });
    Component::checked(result).expect("a component")
}
