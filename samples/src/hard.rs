//! Components that try a reducer: clustered and double roots, bad aspect ratios, and defects it has to name.

use dcb_formats::component::{Component, ComponentDraft};
use dcb_formats::mesh::{CellBlock, Direction, Dof, Mesh};

use crate::component::{average_interface, changed, checked, dof_table, nodes_on_plane};
use crate::material::Material;
use crate::planform::{Annulus, Planform, full_circle};
use crate::solid::{SolidElement, box_block, box_mesh, solid_component};
use crate::sparse::principal_submatrix;

/// A plate of 0.2 m × 0.12 m × 1 mm, one quadratic hexahedron through the thickness: bending frequencies far below
/// the in-plane ones.
pub fn thin_plate() -> Component {
    let plate = box_block(
        [20, 12, 1],
        [0.2, 0.12, 0.001],
        SolidElement::Hexahedron20,
        &Material::STEEL,
    );
    changed(plate, |draft| draft.name = "thin-plate".into())
}

/// A bar of 2 m × 12 mm × 8 mm: stiffness along and across differ by the square of 250.
pub fn slender_block() -> Component {
    let bar = box_block(
        [60, 1, 1],
        [2.0, 0.012, 0.008],
        SolidElement::Hexahedron20,
        &Material::STEEL,
    );
    changed(bar, |draft| draft.name = "slender-block".into())
}

/// A bar of square section, 0.4 m × 0.1 m × 0.1 m: every bending mode is an exact double root.
pub fn square_block() -> Component {
    let bar = box_block(
        [8, 2, 2],
        [0.4, 0.1, 0.1],
        SolidElement::Hexahedron20,
        &Material::STEEL,
    );
    changed(bar, |draft| draft.name = "square-block".into())
}

/// A flat ring, radii 50 mm and 100 mm, 10 mm thick, whose mesh repeats `fold` times around (at least three): modes
/// with one and more nodal diameters come as double roots wherever the symmetry allows. Interface `bore`.
pub fn symmetric_ring(fold: usize) -> Component {
    let fold = fold.max(3);
    let cells_around = fold * 16_usize.div_ceil(fold);
    let mut planform = Planform::default();
    let annulus = Annulus {
        center: [0.0, 0.0],
        inner: 0.05,
        outer: 0.1,
    };
    let ring = planform.add_ring(annulus, &full_circle(cells_around), 2, 0..1);
    let extrusion = planform.extrude(&[-0.005, 0.005], SolidElement::Hexahedron20);
    let bore = extrusion.nodes_over(&ring.inner());
    let mut mesh = extrusion.mesh;
    mesh.point_sets.insert("bore".into(), bore.clone());
    let interfaces = vec![average_interface("bore", bore, [0.0; 3])];
    solid_component("symmetric-ring", mesh, &Material::STEEL, interfaces)
}

/// Two blocks that don't touch: twelve zero frequencies in one component.
pub fn two_loose_blocks() -> Component {
    pair_of_blocks("two-loose-blocks", [0.05, 0.0, 0.0])
}

/// Connection of two blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hinge {
    /// One edge: seven zero frequencies, the seventh is rotation about the edge.
    Edge,
    /// One node: nine zero frequencies.
    Node,
}

/// Two blocks joined by less than a face: a mechanism.
pub fn hinged_blocks(hinge: Hinge) -> Component {
    match hinge {
        Hinge::Edge => pair_of_blocks("edge-hinge", [0.0, BLOCK[1], 0.0]),
        Hinge::Node => pair_of_blocks("node-hinge", [0.0, BLOCK[1], BLOCK[2]]),
    }
}

const BLOCK: [f64; 3] = [0.1, 0.04, 0.04];
const BLOCK_CELLS: [usize; 3] = [4, 2, 2];

/// A block and its copy, moved along x by its length and further by `offset`; coinciding nodes are one.
fn pair_of_blocks(name: &str, offset: [f64; 3]) -> Component {
    let first = box_mesh(BLOCK_CELLS, BLOCK, SolidElement::Hexahedron);
    let mut second = first.clone();
    for point in second.coordinates.chunks_exact_mut(3) {
        point[0] += BLOCK[0] + offset[0];
        point[1] += offset[1];
        point[2] += offset[2];
    }
    let end = 2.0 * BLOCK[0] + offset[0];
    let right = [end, BLOCK[1] / 2.0 + offset[1], BLOCK[2] / 2.0 + offset[2]];
    let mut mesh = welded(first, &second);
    let (left_nodes, right_nodes) = (nodes_on_plane(&mesh, 0, 0.0), nodes_on_plane(&mesh, 0, end));
    mesh.point_sets.clear();
    mesh.point_sets.insert("x_min".into(), left_nodes.clone());
    mesh.point_sets.insert("x_max".into(), right_nodes.clone());
    let interfaces = vec![
        average_interface("left", left_nodes, [0.0, BLOCK[1] / 2.0, BLOCK[2] / 2.0]),
        average_interface("right", right_nodes, right),
    ];
    solid_component(name, mesh, &Material::STEEL, interfaces)
}

/// Both meshes as one; nodes closer than a nanometre become one. For small meshes: every pair is compared.
fn welded(mut first: Mesh, second: &Mesh) -> Mesh {
    let first_count = first.node_count() as u32;
    let mut added = 0;
    let mut node_of = Vec::with_capacity(second.node_count());
    for node in 0..second.node_count() as u32 {
        let position = second.position(node);
        let near = |&other: &u32| {
            let at = first.position(other);
            (0..3).all(|axis| (at[axis] - position[axis]).abs() < 1e-9)
        };
        let same = (0..first_count).find(near);
        node_of.push(same.unwrap_or(first_count + added));
        if same.is_none() {
            first.coordinates.extend(position);
            added += 1;
        }
    }
    first.cells.extend(second.cells.iter().map(|block| {
        CellBlock {
            nodes: block
                .nodes
                .iter()
                .map(|&node| node_of[node as usize])
                .collect(),
            ..block.clone()
        }
    }));
    first
}

/// A block whose dofs on the face x = 0 were removed from the matrices: no zero frequency, and a dof table instead of
/// a pattern. Interface `right`.
pub fn grounded_block() -> Component {
    let mut free = box_block(
        [6, 2, 2],
        [0.3, 0.1, 0.08],
        SolidElement::Hexahedron,
        &Material::STEEL,
    )
    .into_draft();
    free.interfaces
        .retain(|interface| interface.name == "right");
    let held = &free.mesh.point_sets["x_min"];
    let kept: Vec<usize> = (0..free.dofs.len())
        .filter(|&row| !(free.dofs.dof(row)).is_some_and(|dof| held.contains(&dof.node)))
        .collect();
    with_rows(free, "grounded-block", &kept, &[])
}

/// A block and one more node that belongs to no element but has a dof: a row without stiffness or mass.
pub fn orphan_dof_block() -> Component {
    let mut block = box_block(
        [4, 2, 2],
        [0.2, 0.1, 0.08],
        SolidElement::Hexahedron,
        &Material::STEEL,
    )
    .into_draft();
    let orphan = block.mesh.node_count() as u32;
    block.mesh.coordinates.extend([0.1, 0.2, 0.04]);
    let rows: Vec<usize> = (0..=block.dofs.len()).collect();
    with_rows(
        block,
        "orphan-dof-block",
        &rows,
        &[Dof {
            node: orphan,
            direction: Direction::Ux,
        }],
    )
}

/// The component with the given rows, `extra` naming those beyond the present ones.
fn with_rows(component: ComponentDraft, name: &str, rows: &[usize], extra: &[Dof]) -> Component {
    let mut dofs = component.dofs.nodal_dofs();
    dofs.extend_from_slice(extra);
    let dofs = rows.iter().map(|&row| dofs[row]).collect();
    checked(ComponentDraft {
        name: name.into(),
        dofs: dof_table(dofs, component.mesh.node_count()),
        stiffness: principal_submatrix(&component.stiffness, rows),
        mass: principal_submatrix(&component.mass, rows),
        ..component
    })
}
