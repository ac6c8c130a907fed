//! Exudyn: the data of an `ObjectFFRFreducedOrderInterface`, as its `SaveToFile` writes them into HDF5 (file version 1). Nothing is pickled.
//!
//! ```text
//! mPhitTPsi = L1          mXRefTildePsi     = −I3          mPsiTildePsi      = −L3_k·, block under block
//! mPhitTPsiTilde = [L1_k] mXRefTildePsiTilde = N_k         mPsiTildePsiTilde = −P_kl
//! ```
//! over the strong coordinates, with M = 1 and K = diag(ω², σ²). Nodes are those of the mesh where the file has nodal fields, and otherwise four for each frame: the
//! corners p + a of a tetrahedron round its place p, moving with u + θ × a. Their mean motion with equal weights is that of the frame, displacement and rotation,
//! so that a marker over them needs no offset: Exudyn doesn't turn a marker's offset with the nodes.

use std::fmt::Write as _;

use dcb_formats::Error;
use dcb_formats::component::{Role, Units};
use dcb_formats::mesh::Mesh;
use dcb_formats::units::si_factor;
use dcb_view::Surface;
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

use crate::files::hdf5_tree::{Hdf5Tree, Node};
use crate::files::product::{Content, Product};
use crate::mesh::node_shapes::NodeShapes;
use crate::part::basis::Basis;
use crate::part::frames::Frame;
use crate::part::left_out::{Holds, left_out, unit_note};
use crate::part::{Part, Source};
use crate::{Axes, Request};

/// Distance of a frame's nodes, along each axis, over the part's radius of gyration.
const REACH: f64 = 0.1;
/// A frame's nodes, seen from the frame, in units of that distance: a tetrahedron with its centre in the frame.
const CORNERS: [[f64; 3]; 4] = [
    [1.0, 1.0, 1.0],
    [1.0, -1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
];
/// Largest difference of a node set's mean motion from a frame's, relative, that counts as the same.
const SAME_MOTION: f64 = 1e-9;
/// Longest list of nodes that is printed.
const LISTED_NODES: usize = 40;

/// Points that move, triangles between them, and how interfaces are met.
struct Nodes {
    /// Reference positions from the origin.
    positions: Vec<Vector3<f64>>,
    /// (3 nodes, q).
    shapes: Mat<f64>,
    triangles: Vec<[u32; 3]>,
    notes: Vec<String>,
    /// For each frame: its name and the nodes that it is the mean of; `None` where nobody knows.
    markers: Vec<(String, Option<Vec<usize>>)>,
}

/// A part as Exudyn reads it.
pub(crate) fn product(source: &Source, request: &Request<'_>) -> Result<Product, Error> {
    let part = Part::spatial(source, request)?;
    let fields = source.fields()?;
    let nodes = match &fields {
        Some((fields, mesh)) => {
            let shapes = NodeShapes::of(fields, mesh, &part.basis.to_file);
            of_mesh(&part, shapes, mesh, request.axes)
        }
        None => of_frames(&part)?,
    };
    if nodes.positions.is_empty() {
        return Err(part.refused("has no node with displacements along x, y and z, and no frame: there is nothing to attach to; reduce it with fields, or with interfaces of kind `average` or `rigid`".to_owned()));
    }
    let q = part.basis.count();
    let summary = format!(
        "{} nodes over {q} coordinates: {}; {} triangles",
        nodes.positions.len(),
        part.coordinates(),
        nodes.triangles.len()
    );
    let paste = snippet(&nodes, request.file_name, gravity(&part.superelement.units));
    let mut product = Product::new(Content::Hdf5(tree(&part, &nodes)), summary);
    product.notes = nodes.notes;
    if !request.file_name.ends_with(".hdf5") {
        product.notes.push("Exudyn goes by the ending: give the file a name that ends in .hdf5 before it is loaded".to_owned());
    }
    product.notes.extend(unit_note(&part));
    product.left_out = left_out(
        &part,
        Holds {
            inertia_change: true,
            outputs: true,
            fields: true,
            ..Holds::default()
        },
    )?;
    product.paste = Some(("in a script of Exudyn:", paste));
    Ok(product)
}

fn tree(part: &Part<'_>, nodes: &Nodes) -> Hdf5Tree {
    let text = |text: &str| Node::Text(text.to_owned());
    let arrays = arrays(&part.basis, nodes).into_iter();
    let mut all: Vec<_> = arrays.map(|(name, node)| (name, "ndarray", node)).collect();
    let node_type = text("NodeType.RotationEulerParameters");
    all.extend([
        ("totalMass", "float", Node::Real(part.basis.mass)),
        ("fileVersion", "int", Node::Integer(1)),
        ("rigidBodyNodeType", "str", node_type),
        ("type", "str", text("ObjectFFRFreducedOrderInterface")),
        ("postProcessingModes", "dict", Node::Empty),
    ]);
    Hdf5Tree {
        nodes: all,
        attributes: vec![("source", part.source.origin_line())],
    }
}

fn arrays(basis: &Basis, nodes: &Nodes) -> [(&'static str, Node); 16] {
    let (q, count) = (basis.count(), nodes.positions.len());
    let diagonal = |of: &dyn Fn(usize) -> f64, n: usize| {
        Node::matrix(&Mat::from_fn(n, n, |i, j| if i == j { of(i) } else { 0.0 }))
    };
    let array = |of: &Mat<f64>| Node::matrix(of);
    let sizes = [q, count, 3, 4, 7, 7 + q].map(|size| size as i64);
    let positions = nodes.positions.iter().flat_map(|at| at.iter().copied());
    let triangles = nodes.triangles.iter().flatten();
    let triangles = triangles.map(|node| i64::from(*node)).collect();
    let turned = Mat::from_fn(3, q, |a, k| -basis.i3[(a, k)]);
    let coupled = Mat::from_fn(3 * q, q, |i, l| -basis.l3[i % 3][(i / 3, l)]);
    let moments = side_by_side(q, |k| basis.l1(k).cross_matrix());
    let first = side_by_side(q, |k| basis.first(k));
    [
        ("modeBasis", array(&nodes.shapes)),
        ("xRef", Node::Reals(vec![3 * count], positions.collect())),
        ("massMatrixReduced", diagonal(&|_| 1.0, q)),
        (
            "stiffnessMatrixReduced",
            diagonal(&|k| basis.stiffness[k], q),
        ),
        ("infoList", Node::Integers(vec![6], sizes.to_vec())),
        ("inertiaLocal", array(&small(&basis.tensor_about_origin()))),
        ("Mtt", diagonal(&|_| basis.mass, 3)),
        (
            "chiU",
            Node::Reals(vec![3], basis.centre.as_slice().to_vec()),
        ),
        ("chiUtilde", array(&small(&basis.centre.cross_matrix()))),
        ("mPsiTildePsi", array(&coupled)),
        ("mPsiTildePsiTilde", array(&second_order(basis))),
        ("mPhitTPsi", array(&basis.l1)),
        ("mPhitTPsiTilde", array(&moments)),
        ("mXRefTildePsi", array(&turned)),
        ("mXRefTildePsiTilde", array(&first)),
        (
            "trigList",
            Node::Integers(vec![nodes.triangles.len(), 3], triangles),
        ),
    ]
}

fn small(of: &Matrix3<f64>) -> Mat<f64> {
    Mat::from_fn(3, 3, |a, b| of[(a, b)])
}

fn side_by_side(q: usize, of: impl Fn(usize) -> Matrix3<f64>) -> Mat<f64> {
    let blocks: Vec<Matrix3<f64>> = (0..q).map(of).collect();
    Mat::from_fn(3, 3 * q, |a, j| blocks[j / 3][(a, j % 3)])
}

/// −P_kl, (3q, 3q).
fn second_order(basis: &Basis) -> Mat<f64> {
    let q = basis.count();
    let mut all = Mat::zeros(3 * q, 3 * q);
    for k in 0..q {
        for l in 0..q {
            let block = basis.second(k, l);
            for a in 0..3 {
                for b in 0..3 {
                    all[(3 * k + a, 3 * l + b)] = -block[(a, b)];
                }
            }
        }
    }
    all
}

/// The nodes of the mesh that the fields have.
fn of_mesh(part: &Part<'_>, shapes: NodeShapes, mesh: &Mesh, axes: Axes) -> Nodes {
    let offset = match axes {
        Axes::Body => Vector3::from(part.superelement.origin),
        Axes::Component => Vector3::zeros(),
    };
    let mut place = vec![None; mesh.node_count()];
    for (index, node) in shapes.nodes.iter().enumerate() {
        place[*node as usize] = Some(index as u32);
    }
    let mut notes = Vec::new();
    let missing = mesh.node_count() - shapes.nodes.len();
    if missing > 0 {
        notes.push(format!("{missing} of {} nodes have no displacements in the file: nodes are numbered without them", mesh.node_count()));
    }
    if shapes.has_rotations {
        notes.push("rotations of nodes stay out: Exudyn takes displacements alone".to_owned());
    }
    let surface = Surface::of(mesh);
    if !surface.others.is_empty() {
        notes.push(format!(
            "not drawn: cells of type {}",
            surface.others.join(", ")
        ));
    }
    let placed = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|node| place[node as usize]);
        Some([a?, b?, c?])
    };
    let markers = part.frames.iter();
    let markers = markers.map(|frame| {
        (
            frame.name.clone(),
            nodes_of(part, frame, mesh, &place, &shapes.shapes),
        )
    });
    Nodes {
        positions: shapes
            .nodes
            .iter()
            .map(|node| Vector3::from(mesh.position(*node)) - offset)
            .collect(),
        triangles: surface.triangles.iter().filter_map(placed).collect(),
        notes,
        markers: markers.collect(),
        shapes: shapes.shapes,
    }
}

/// The node of an interface, or the node set whose mean motion is that of the frame.
fn nodes_of(
    part: &Part<'_>,
    frame: &Frame,
    mesh: &Mesh,
    place: &[Option<u32>],
    shapes: &Mat<f64>,
) -> Option<Vec<usize>> {
    let placed = |node: &u32| {
        place
            .get(*node as usize)
            .copied()
            .flatten()
            .map(|node| node as usize)
    };
    if let Some(node) = frame.node {
        return placed(&node).map(|node| vec![node]);
    }
    let rows: Vec<usize> = frame.rows[..3].iter().copied().collect::<Option<_>>()?;
    let basis = &part.basis;
    let largest = rows
        .iter()
        .flat_map(|row| (0..basis.count()).map(|k| basis.rows[(*row, k)].abs()));
    let allowed = SAME_MOTION * largest.fold(0.0, f64::max);
    let moves_so = |nodes: &[usize]| {
        rows.iter().enumerate().all(|(axis, row)| {
            (0..basis.count()).all(|k| {
                let sum: f64 = nodes.iter().map(|node| shapes[(3 * node + axis, k)]).sum();
                (sum / nodes.len() as f64 - basis.rows[(*row, k)]).abs() <= allowed
            })
        })
    };
    let sets = mesh.point_sets.values();
    let mut sets = sets.filter_map(|set| set.iter().map(placed).collect::<Option<Vec<usize>>>());
    sets.find(|nodes| !nodes.is_empty() && moves_so(nodes))
}

/// Four nodes for each frame; one where it has no rotations.
fn of_frames(part: &Part<'_>) -> Result<Nodes, Error> {
    let basis = &part.basis;
    let reach = REACH * (basis.tensor.trace() / (2.0 * basis.mass)).sqrt();
    let mut nodes = Nodes {
        positions: Vec::new(),
        shapes: Mat::zeros(0, 0),
        triangles: Vec::new(),
        notes: vec![format!(
            "no nodal fields: four nodes for each frame, {reach:.6} from it along x, y and z; their mean with equal weights is the frame"
        )],
        markers: Vec::new(),
    };
    let mut columns: Vec<[f64; 3]> = Vec::new();
    let q = basis.count();
    for frame in &part.frames {
        if !frame.has_translations() {
            let told = format!(
                "interface {:?} has no row for {}",
                frame.name,
                frame.missing().join(", ")
            );
            match frame.role {
                Role::Attachment => return Err(part.refused(format!("{told}, and without nodal fields Exudyn gets its frames as nodes; reduce it with fields, or that interface as `average` or `rigid`"))),
                Role::Output => nodes.notes.push(format!("{told}: it stays out")),
            }
            continue;
        }
        let first = nodes.positions.len();
        let centre = [Vector3::zeros()];
        let corners = CORNERS.map(|corner| Vector3::from(corner) * reach);
        let arms: &[Vector3<f64>] = if frame.has_rotations() {
            &corners
        } else {
            &centre
        };
        for arm in arms {
            nodes.positions.push(frame.position + arm);
            columns.extend((0..q).map(|k| {
                let [x, y, z, a, b, c] = frame.motion(|row| basis.rows[(row, k)]);
                <[f64; 3]>::from(Vector3::new(x, y, z) + Vector3::new(a, b, c).cross(arm))
            }));
        }
        if arms.len() == 4 {
            let at = |node: usize| (first + node) as u32;
            nodes.triangles.extend(
                [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]].map(|face: [usize; 3]| face.map(at)),
            );
        }
        nodes.markers.push((
            frame.name.clone(),
            Some((first..nodes.positions.len()).collect()),
        ));
    }
    nodes.shapes = Mat::from_fn(3 * nodes.positions.len(), q, |i, k| {
        columns[i / 3 * q + k][i % 3]
    });
    Ok(nodes)
}

/// 9.81 m/s² in the part's units; `None` where these aren't known.
fn gravity(units: &Units) -> Option<f64> {
    let (length, time) = (si_factor(&units.length)?, si_factor(&units.time)?);
    let exact = 9.81 * time * time / length;
    // Without the rounding of the units' factors.
    format!("{exact:.9e}").parse().ok()
}

/// How the file is loaded, and how its interfaces are met.
fn snippet(nodes: &Nodes, file_name: &str, gravity: Option<f64>) -> String {
    let gravity = gravity.map_or("-GRAVITY".to_owned(), |gravity| format!("-{gravity}"));
    let mut text = format!(
        "from exudyn.FEM import ObjectFFRFreducedOrderInterface\n\
         part = ObjectFFRFreducedOrderInterface()\n\
         part.LoadFromFile({file_name:?})\n\
         body = part.AddObjectFFRFreducedOrder(mbs, positionRef=[0, 0, 0], initialVelocity=[0, 0, 0], rotationMatrixRef=np.eye(3),\n    \
         initialAngularVelocity=[0, 0, 0], gravity=[0, 0, {gravity}])['oFFRFreducedOrder']\n"
    );
    for (name, of) in &nodes.markers {
        let nodes = match of {
            Some(nodes) if nodes.len() <= LISTED_NODES => nodes,
            Some(nodes) => {
                let _ = writeln!(
                    text,
                    "# interface {name:?}: the mean of {} nodes, all of one set of the mesh",
                    nodes.len()
                );
                continue;
            }
            None => {
                let _ = writeln!(
                    text,
                    "# interface {name:?}: no node set of the mesh moves so with equal weights; weights are those of the component file"
                );
                continue;
            }
        };
        let weights = match nodes.as_slice() {
            [_] => "[1]".to_owned(),
            nodes => format!("[1 / {0}] * {0}", nodes.len()),
        };
        let _ = writeln!(
            text,
            "# interface {name:?}\nmbs.AddMarker(MarkerSuperElementRigid(bodyNumber=body, meshNodeNumbers={nodes:?}, weightingFactors={weights}))"
        );
    }
    text
}
