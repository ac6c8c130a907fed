//! Parts that several tests ask about, small enough for dense algebra.

use std::path::PathBuf;

use dcb_formats::component::{ComponentDraft, Interface, InterfaceKind, Role, Weights};
use dcb_formats::component_files::{ComponentFiles, Overrides, read_component};
use dcb_formats::mesh::{Direction, Dof, DofMap, Mesh};
use dcb_formats::{Component, SparseMatrix};
use dcb_samples::spatial_beam::{BeamMass, BeamTheory, SpatialBeam};
use dcb_samples::{Material, RodSection, SolidElement, box_block, planar_rod, spatial_beam};
use faer::Mat;

use crate::dense::{dense, sparse};

/// The planar rod of the slider-crank benchmark.
pub fn rod(elements: usize) -> Component {
    planar_rod(elements, &RodSection::default())
}

/// A tilted planar rod.
pub fn tilted_rod(elements: usize) -> Component {
    planar_rod(
        elements,
        &RodSection {
            angle: 0.7,
            ..RodSection::default()
        },
    )
}

/// The spatial beam with these kinematics and masses.
pub fn beam(elements: usize, theory: BeamTheory, mass: BeamMass) -> Component {
    spatial_beam(&SpatialBeam {
        elements,
        theory,
        mass,
        ..SpatialBeam::default()
    })
}

/// A skew Timoshenko beam.
pub fn skew_beam() -> Component {
    let theory = BeamTheory::Timoshenko;
    spatial_beam(&SpatialBeam {
        elements: 6,
        theory,
        start: [0.1, -0.2, 0.3],
        end: [0.7, 0.4, 0.9],
        roll: 0.4,
        ..SpatialBeam::default()
    })
}

/// A steel box 0.4 m x 0.1 m x 0.06 m with averaged interfaces at both ends.
pub fn steel_box(cells: [usize; 3], element: SolidElement) -> Component {
    box_block(cells, [0.4, 0.1, 0.06], element, &Material::STEEL)
}

/// An interface with everything at its default.
pub fn interface(name: &str, kind: InterfaceKind, nodes: Vec<u32>) -> Interface {
    Interface {
        name: name.into(),
        kind,
        nodes,
        position: None,
        weights: Weights::Uniform,
        axes: None,
        directions: None,
        role: Role::Attachment,
    }
}

/// The part with other interfaces.
pub fn with_interfaces(component: &Component, interfaces: Vec<Interface>) -> Component {
    Component::checked(ComponentDraft {
        interfaces,
        ..component.clone().into_draft()
    })
    .expect("a component")
}

/// The published rotor: matrices and mesh as the sample files hold them.
pub fn rotor() -> Component {
    let folder: PathBuf = [env!("CARGO_MANIFEST_DIR"), "..", "samples", "data", "rotor"]
        .iter()
        .collect();
    let description =
        dcb_formats::read_description(&folder.join("rotor.json")).expect("the description");
    let read = |name: &str| {
        dcb_formats::matrix::read_symmetric_operator(&folder.join(name))
            .expect("the matrix")
            .0
    };
    let (stiffness, mass) = (read("rotor.mtx"), read("rotor.mass.mtx"));
    let path = folder.join("rotor.json");
    let dofs = description
        .dof_map(stiffness.nrows(), &path)
        .expect("the dof table");
    Component::checked(ComponentDraft {
        interfaces: description.interfaces,
        ..ComponentDraft::new(
            "rotor",
            description.units,
            (description.mesh, dofs),
            stiffness,
            mass,
        )
    })
    .expect("a component")
}

/// A part with internal rows that another program made: `plate`, `beam` or `outboard` of `tests/data/internal_rows`.
pub fn with_internal_rows(name: &str) -> Component {
    let folder: PathBuf = [env!("CARGO_MANIFEST_DIR"), "data", "internal_rows"]
        .iter()
        .collect();
    let files = ComponentFiles::beside(
        &folder.join(format!("{name}.mtx.gz")),
        &Overrides::default(),
    )
    .expect("the files");
    read_component(&files, None).expect("a component")
}

/// Parts of the same kind of nodes as one component, 10 m from each other, with no connection.
pub fn side_by_side(pieces: &[Component]) -> Component {
    let mut whole = pieces[0].clone().into_draft();
    let size = pieces.iter().map(|piece| piece.dofs.len()).sum();
    let (mut k, mut m) = (Mat::zeros(size, size), Mat::zeros(size, size));
    whole.mesh.coordinates.clear();
    whole.mesh.cells.clear();
    whole.interfaces.clear();
    let (mut dofs, mut nodes) = (0, 0);
    for (index, piece) in pieces.iter().enumerate() {
        let count = piece.dofs.len();
        k.submatrix_mut(dofs, dofs, count, count)
            .copy_from(dense(&piece.stiffness));
        m.submatrix_mut(dofs, dofs, count, count)
            .copy_from(dense(&piece.mass));
        let d = piece.dimension().coordinate_count();
        let moved = piece.mesh.coordinates.iter().enumerate();
        let offset = |place: usize| {
            if place.is_multiple_of(d) {
                10.0 * index as f64
            } else {
                0.0
            }
        };
        whole
            .mesh
            .coordinates
            .extend(moved.map(|(place, x)| x + offset(place)));
        whole
            .interfaces
            .extend(piece.interfaces.iter().map(|interface| Interface {
                name: format!("{} {index}", interface.name),
                nodes: interface.nodes.iter().map(|node| node + nodes).collect(),
                ..interface.clone()
            }));
        dofs += count;
        nodes += piece.mesh.node_count() as u32;
    }
    let directions = &Direction::ALL[..whole.dimension().coordinate_count()];
    whole.dofs = DofMap::uniform(nodes as usize, directions).expect("a dof table");
    (whole.stiffness, whole.mass) = (sparse(&k), sparse(&m));
    Component::checked(whole).expect("a component")
}

/// Nodes in another order: node i of the result is node `order[i]` of the part, and its dofs move with it.
pub fn renumbered(component: &Component, order: &[u32]) -> Component {
    let mut new_of = vec![0_u32; order.len()];
    for (new, old) in order.iter().enumerate() {
        new_of[*old as usize] = new as u32;
    }
    let d = component.dimension().coordinate_count();
    let mut mesh = Mesh {
        coordinates: Vec::new(),
        ..component.mesh.clone()
    };
    for old in order {
        mesh.coordinates.extend(&component.mesh.position(*old)[..d]);
    }
    for block in &mut mesh.cells {
        block
            .nodes
            .iter_mut()
            .for_each(|node| *node = new_of[*node as usize]);
    }
    for set in mesh.point_sets.values_mut() {
        set.iter_mut()
            .for_each(|node| *node = new_of[*node as usize]);
    }
    // Row order follows the new node numbers.
    let mut rows: Vec<usize> = Vec::new();
    for old in order {
        rows.extend(
            Direction::ALL
                .iter()
                .filter_map(|direction| component.dofs.row(*old, *direction)),
        );
    }
    let dofs = rows
        .iter()
        .map(|row| {
            let dof = component.dofs.dof(*row).expect("a row of a node");
            Dof {
                node: new_of[dof.node as usize],
                ..dof
            }
        })
        .collect();
    let mut result = component.clone().into_draft();
    result.dofs = DofMap::new(dofs, order.len()).expect("a dof table");
    result.stiffness = with_rows(&component.stiffness, &rows);
    result.mass = with_rows(&component.mass, &rows);
    for matrix in result
        .component_masses
        .iter_mut()
        .flat_map(|masses| &mut masses.matrices)
    {
        *matrix = with_rows(matrix, &rows);
    }
    for interface in &mut result.interfaces {
        interface
            .nodes
            .iter_mut()
            .for_each(|node| *node = new_of[*node as usize]);
    }
    result.mesh = mesh;
    Component::checked(result).expect("a component")
}

/// Rows and columns of a matrix in another order, possibly fewer.
pub fn with_rows(matrix: &SparseMatrix, rows: &[usize]) -> SparseMatrix {
    let mut new_of = vec![None; matrix.nrows()];
    for (new, old) in rows.iter().enumerate() {
        new_of[*old] = Some(new as u32);
    }
    let mut entries = Vec::new();
    for (j, old) in rows.iter().enumerate() {
        for (row, value) in matrix
            .row_idx_of_col_raw(*old)
            .iter()
            .zip(matrix.val_of_col(*old))
        {
            if let Some(i) = new_of[*row as usize] {
                entries.push(faer::sparse::Triplet::new(i, j as u32, *value));
            }
        }
    }
    SparseMatrix::try_new_from_triplets(rows.len(), rows.len(), &entries)
        .expect("the entries are in range")
}

/// A stiff box with `count` equal oscillators at one of its nodes: masses on three springs each, at the node's place; and the ω² of
/// their motions against each other.
pub fn with_oscillators(count: usize) -> (Component, f64) {
    let block = box_block(
        [2, 1, 1],
        [0.2, 0.1, 0.08],
        SolidElement::Hexahedron,
        &Material::STEEL,
    );
    let (nodes, n) = (block.mesh.node_count(), block.dofs.len());
    let (stiffness, mass) = (2.0e6, 0.05);
    let host = 4_u32;
    let mut mesh = block.mesh.clone();
    let mut dofs: Vec<Dof> = block.dofs.nodal_dofs();
    let size = n + 3 * count;
    let (mut k, mut m) = (Mat::zeros(size, size), Mat::zeros(size, size));
    k.as_mut()
        .submatrix_mut(0, 0, n, n)
        .copy_from(&dense(&block.stiffness));
    m.as_mut()
        .submatrix_mut(0, 0, n, n)
        .copy_from(&dense(&block.mass));
    for oscillator in 0..count {
        mesh.coordinates.extend(block.mesh.position(host));
        for axis in 0..3 {
            let (at, base) = (n + 3 * oscillator + axis, 3 * host as usize + axis);
            dofs.push(Dof {
                node: (nodes + oscillator) as u32,
                direction: Direction::ALL[axis],
            });
            m[(at, at)] = mass;
            k[(at, at)] = stiffness;
            k[(base, base)] += stiffness;
            k[(at, base)] = -stiffness;
            k[(base, at)] = -stiffness;
        }
    }
    let component = Component::checked(ComponentDraft {
        dofs: DofMap::new(dofs, nodes + count).expect("a dof table"),
        stiffness: sparse(&k),
        mass: sparse(&m),
        mesh,
        ..block.into_draft()
    })
    .expect("a component");
    (component, stiffness / mass)
}

/// The part elsewhere: coordinates and positions of interfaces increased by `by`.
pub fn moved(component: &Component, by: [f64; 3]) -> Component {
    let mut result = component.clone().into_draft();
    let d = component.dimension().coordinate_count();
    for point in result.mesh.coordinates.chunks_exact_mut(d) {
        point.iter_mut().zip(by).for_each(|(x, b)| *x += b);
    }
    for position in result
        .interfaces
        .iter_mut()
        .filter_map(|interface| interface.position.as_mut())
    {
        position.iter_mut().zip(by).for_each(|(x, b)| *x += b);
    }
    Component::checked(result).expect("a component")
}
