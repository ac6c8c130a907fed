//! Rectangular blocks of solid elements.

use dcb_formats::Component;
use dcb_formats::component::Interface;
use dcb_formats::mesh::Mesh;

use super::assemble::assemble_solid;
use super::element::{HEXAHEDRON_EDGES, SolidElement, TETRAHEDRON_EDGES};
use crate::component::{
    TRANSLATIONS, average_interface, checked, draft, nodes_interface, nodes_on_plane, uniform_dofs,
};
use crate::material::Material;
use crate::solid::lattice::mesh_of_used_points;

/// Corners of a cell in half-steps of the lattice, in meshio's hexahedron order.
const CORNERS: [[usize; 3]; 8] = [
    [0, 0, 0],
    [2, 0, 0],
    [2, 2, 0],
    [0, 2, 0],
    [0, 0, 2],
    [2, 0, 2],
    [2, 2, 2],
    [0, 2, 2],
];

/// Six tetrahedra around the diagonal from corner 0 to corner 6; the same in every cell, so faces match.
const TETRAHEDRA: [[usize; 4]; 6] = [
    [0, 1, 2, 6],
    [0, 2, 3, 6],
    [0, 3, 7, 6],
    [0, 7, 4, 6],
    [0, 4, 5, 6],
    [0, 5, 1, 6],
];

/// A block from the origin to `size` with `cells` hexahedra along each axis (tetrahedra: six to each). Interfaces
/// `left` and `right` average the faces at both ends of x; all six faces are point sets.
pub fn box_block(
    cells: [usize; 3],
    size: [f64; 3],
    element: SolidElement,
    material: &Material,
) -> Component {
    let mesh = box_mesh(cells, size, element);
    let middle = |x: f64| [x, size[1] / 2.0, size[2] / 2.0];
    let interfaces = vec![
        average_interface("left", mesh.point_sets["x_min"].clone(), middle(0.0)),
        average_interface("right", mesh.point_sets["x_max"].clone(), middle(size[0])),
    ];
    solid_component("box-block", mesh, material, interfaces)
}

/// The component of a solid mesh: assembled matrices and `ux uy uz` at every node.
pub fn solid_component(
    name: &str,
    mesh: Mesh,
    material: &Material,
    interfaces: Vec<Interface>,
) -> Component {
    let matrices = assemble_solid(&mesh, material);
    let dofs = uniform_dofs(mesh.node_count(), &TRANSLATIONS);
    checked(draft(
        name,
        mesh,
        dofs,
        matrices.stiffness,
        matrices.mass,
        interfaces,
    ))
}

/// 30 nodes: 4 × 2 × 1 hexahedra, 1 m × 0.2 m × 0.1 m, with its first and last node as interfaces.
pub fn reference_hexahedra() -> Component {
    reference_box("reference-hexahedra", [4, 2, 1], SolidElement::Hexahedron)
}

/// 16 nodes: 3 × 1 × 1 cells of six tetrahedra, 1 m × 0.2 m × 0.1 m, with its first and last node as interfaces.
pub fn reference_tetrahedra() -> Component {
    reference_box("reference-tetrahedra", [3, 1, 1], SolidElement::Tetra)
}

fn reference_box(name: &str, cells: [usize; 3], element: SolidElement) -> Component {
    let mesh = box_mesh(cells, [1.0, 0.2, 0.1], element);
    let last = mesh.node_count() as u32 - 1;
    let interfaces = vec![
        nodes_interface("first", vec![0], &TRANSLATIONS),
        nodes_interface("last", vec![last], &TRANSLATIONS),
    ];
    solid_component(name, mesh, &Material::SOFT, interfaces)
}

/// Mesh of a block; nodes are numbered along z first and along x last.
pub(crate) fn box_mesh(cells: [usize; 3], size: [f64; 3], element: SolidElement) -> Mesh {
    let cells = cells.map(|count| count.max(1));
    let [px, py, pz] = cells.map(|count| 2 * count + 1);
    let index = |p: [usize; 3]| (p[0] * py + p[1]) * pz + p[2];
    let mut cell_points = Vec::new();
    for i in 0..cells[0] {
        for j in 0..cells[1] {
            for k in 0..cells[2] {
                let corners = CORNERS.map(|c| [2 * i + c[0], 2 * j + c[1], 2 * k + c[2]]);
                push_cell(&mut cell_points, &corners, element, index);
            }
        }
    }
    let position = |point: usize| {
        let at = [point / (py * pz), point / pz % py, point % pz];
        [0, 1, 2].map(|axis| size[axis] * at[axis] as f64 / (2 * cells[axis]) as f64)
    };
    let (mut mesh, _) = mesh_of_used_points(element, &cell_points, px * py * pz, position);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (low, high) = (
            nodes_on_plane(&mesh, axis, 0.0),
            nodes_on_plane(&mesh, axis, size[axis]),
        );
        mesh.point_sets.insert(format!("{name}_min"), low);
        mesh.point_sets.insert(format!("{name}_max"), high);
    }
    mesh
}

/// Adds the lattice points of one cell, as one hexahedron or six tetrahedra.
fn push_cell(
    points: &mut Vec<usize>,
    corners: &[[usize; 3]; 8],
    element: SolidElement,
    index: impl Fn([usize; 3]) -> usize,
) {
    let middle = |a: usize, b: usize| {
        index(std::array::from_fn(|axis| {
            (corners[a][axis] + corners[b][axis]) / 2
        }))
    };
    match element {
        SolidElement::Hexahedron | SolidElement::Hexahedron20 => {
            points.extend(corners.map(&index));
            if element == SolidElement::Hexahedron20 {
                points.extend(HEXAHEDRON_EDGES.map(|[a, b]| middle(a, b)));
            }
        }
        SolidElement::Tetra | SolidElement::Tetra10 => {
            for tetrahedron in TETRAHEDRA {
                points.extend(tetrahedron.map(|corner| index(corners[corner])));
                if element == SolidElement::Tetra10 {
                    points.extend(
                        TETRAHEDRON_EDGES.map(|[a, b]| middle(tetrahedron[a], tetrahedron[b])),
                    );
                }
            }
        }
    }
}
