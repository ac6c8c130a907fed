//! Pictures of mode shapes: the surface of the deformed mesh as SVG, coloured by how far its points move.
//!
//! Planar meshes are drawn as they lie. Spatial ones are drawn with their longest side to the right and their shortest towards the
//! viewer, turned a little; faces that look away are left out and the others drawn from back to front.

use std::collections::HashMap;
use std::fmt::Write as _;

use dcb_formats::mesh::{Dimension, Dof, Mesh};
use faer::MatRef;
use nalgebra::{Matrix3, Rotation3, Vector3};

use dcb_reducer::model::surface::{faces_of, is_skin};

/// Size of a picture, dots.
const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 300.0;
const MARGIN: f64 = 8.0;
/// Largest displacement over the size of the part.
const AMPLITUDE: f64 = 0.08;
/// Turn about the vertical and then about the horizontal of the picture, rad.
const TURN: f64 = 0.55;
const TILT: f64 = 0.40;
/// Colours from no motion to the largest.
const COLOURS: [[f64; 3]; 4] = [
    [226.0, 232.0, 240.0],
    [120.0, 170.0, 210.0],
    [240.0, 190.0, 80.0],
    [200.0, 60.0, 40.0],
];
/// Faces and lines that all pictures of a part have together, at most.
const MOST_FACES: usize = 60_000;
/// Pictures at most.
const MOST_PICTURES: usize = 6;

/// A face or a line of the mesh, by its corners.
#[derive(Clone, Debug, PartialEq)]
struct Face {
    corners: Vec<u32>,
    /// Nodes of the volume behind it; `None` for what is seen from both sides.
    behind: Option<Vec<u32>>,
}

/// Pictures of the lowest modes, at most six, fewer for large meshes, none without cells. `shapes` are over `dofs`.
pub fn mode_pictures(mesh: &Mesh, dofs: &[Dof], shapes: MatRef<'_, f64>) -> Vec<String> {
    let faces = faces(mesh);
    if faces.is_empty() {
        return Vec::new();
    }
    let count = (MOST_FACES / faces.len())
        .min(MOST_PICTURES)
        .min(shapes.ncols());
    let view = View::of(mesh);
    (0..count)
        .map(|mode| {
            let moved = displacements(mesh, dofs, shapes.subcols(mode, 1));
            draw(mesh, &faces, &moved, &view)
        })
        .collect()
}

/// Faces on the outside, and lines.
fn faces(mesh: &Mesh) -> Vec<Face> {
    let mut found: HashMap<Vec<u32>, (usize, Face)> = HashMap::new();
    let mut order = Vec::new();
    let (skins, volumes): (Vec<_>, Vec<_>) = mesh
        .cells
        .iter()
        .partition(|block| is_skin(&block.cell_type, Dimension::Spatial));
    for (block, of_skin) in
        (volumes.iter().map(|block| (block, false))).chain(skins.iter().map(|block| (block, true)))
    {
        let is_line = block.cell_type.starts_with("line");
        for cell in block.cells() {
            if is_line && cell.len() >= 2 {
                let key = vec![cell[0].min(cell[1]), cell[0].max(cell[1])];
                order.push(key.clone());
                let corners = vec![cell[0], cell[1]];
                found.insert(
                    key,
                    (
                        1,
                        Face {
                            corners,
                            behind: None,
                        },
                    ),
                );
            }
            for local in faces_of(&block.cell_type, Dimension::Spatial) {
                let corners: Vec<u32> = local[..corner_count(local.len())]
                    .iter()
                    .map(|index| cell[*index])
                    .collect();
                let mut key = corners.clone();
                key.sort_unstable();
                match found.get_mut(&key) {
                    Some(known) if !of_skin => known.0 += 1,
                    Some(_) => {}
                    None => {
                        let behind = (!of_skin).then(|| cell.to_vec());
                        order.push(key.clone());
                        found.insert(key, (1, Face { corners, behind }));
                    }
                }
            }
        }
    }
    order
        .iter()
        .filter_map(|key| found.remove(key))
        .filter(|(count, _)| *count == 1)
        .map(|(_, face)| face)
        .collect()
}

fn corner_count(nodes: usize) -> usize {
    if nodes == 3 || nodes == 6 { 3 } else { 4 }
}

/// Translations of each node, the largest one with length 1.
fn displacements(mesh: &Mesh, dofs: &[Dof], shape: MatRef<'_, f64>) -> Vec<Vector3<f64>> {
    let mut moved = vec![Vector3::zeros(); mesh.node_count()];
    for (row, dof) in dofs.iter().enumerate() {
        if !dof.direction.is_rotation() {
            moved[dof.node as usize][dof.direction.axis()] = shape[(row, 0)];
        }
    }
    let largest = moved.iter().map(Vector3::norm).fold(0.0, f64::max);
    if largest > 0.0 {
        moved.iter_mut().for_each(|u| *u /= largest);
    }
    moved
}

/// From component axes to right, up and towards the viewer.
struct View {
    /// Rows: right, up, towards.
    axes: Matrix3<f64>,
    /// Diagonal of the box around the part.
    size: f64,
}

impl View {
    fn of(mesh: &Mesh) -> Self {
        let positions = (0..mesh.node_count() as u32).map(|node| position(mesh, node));
        let (least, most) = positions.fold(
            (
                Vector3::repeat(f64::INFINITY),
                Vector3::repeat(f64::NEG_INFINITY),
            ),
            |(least, most), x| (least.inf(&x), most.sup(&x)),
        );
        let sides = most - least;
        let size = sides.norm();
        if mesh.dimension == Dimension::Planar {
            let axes = Matrix3::identity();
            return Self { axes, size };
        }
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| sides[*b].total_cmp(&sides[*a]));
        // Right-handed, so that nothing is seen in a mirror.
        let is_even = matches!(order, [0, 1, 2] | [1, 2, 0] | [2, 0, 1]);
        let mut base = Matrix3::zeros();
        for (row, axis) in order.into_iter().enumerate() {
            base[(row, axis)] = if row == 2 && !is_even { -1.0 } else { 1.0 };
        }
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), TURN);
        let tilt = Rotation3::from_axis_angle(&Vector3::x_axis(), TILT);
        let axes = (tilt * turn).matrix() * base;
        Self { axes, size }
    }
}

fn position(mesh: &Mesh, node: u32) -> Vector3<f64> {
    mesh.position(node).into()
}

fn draw(mesh: &Mesh, faces: &[Face], moved: &[Vector3<f64>], view: &View) -> String {
    let places: Vec<Vector3<f64>> = (moved.iter().zip(0..))
        .map(|(u, node)| view.axes * (position(mesh, node) + AMPLITUDE * view.size * u))
        .collect();
    let drawn = || faces.iter().flat_map(|face| &face.corners);
    let range = |axis: usize| {
        let values = drawn().map(|node| places[*node as usize][axis]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| {
            (least.min(x), most.max(x))
        })
    };
    let ((left, right), (bottom, top)) = (range(0), range(1));
    let scale = ((WIDTH - 2.0 * MARGIN) / (right - left).max(f64::MIN_POSITIVE))
        .min((HEIGHT - 2.0 * MARGIN) / (top - bottom).max(f64::MIN_POSITIVE));
    let (beside, below) = (
        0.5 * (WIDTH - scale * (right - left)),
        0.5 * (HEIGHT - scale * (top - bottom)),
    );
    let dot = |node: u32| {
        let place = places[node as usize];
        [
            beside + scale * (place.x - left),
            HEIGHT - below - scale * (place.y - bottom),
        ]
    };
    let depth = |face: &Face| -> f64 {
        let sum: f64 = face
            .corners
            .iter()
            .map(|node| places[*node as usize][2])
            .sum();
        sum / face.corners.len() as f64
    };
    let mut visible: Vec<(f64, &Face)> = faces
        .iter()
        .filter(|face| faces_viewer(face, &places))
        .map(|face| (depth(face), face))
        .collect();
    visible.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\"><g stroke=\"#445\" stroke-width=\".3\" stroke-linejoin=\"round\">\n"
    );
    for (_, face) in visible {
        let amount: f64 = (face.corners.iter())
            .map(|node| moved[*node as usize].norm())
            .sum();
        let colour = colour(amount / face.corners.len() as f64);
        let mut path = String::new();
        for (index, node) in face.corners.iter().enumerate() {
            let [x, y] = dot(*node);
            let _ = write!(path, "{}{x:.1} {y:.1}", if index == 0 { 'M' } else { 'L' });
        }
        let _ = match face.corners.len() {
            2 => writeln!(
                svg,
                "<path d=\"{path}\" style=\"stroke:{colour};stroke-width:4;stroke-linecap:round\"/>"
            ),
            _ => writeln!(svg, "<path fill=\"{colour}\" d=\"{path}z\"/>"),
        };
    }
    svg + "</g></svg>\n"
}

/// Whether the outside of a face is seen.
fn faces_viewer(face: &Face, places: &[Vector3<f64>]) -> bool {
    let Some(behind) = &face.behind else {
        return true;
    };
    let corner = |index: usize| places[face.corners[index] as usize];
    let normal = (corner(1) - corner(0)).cross(&(corner(2) - corner(0)));
    let sum: Vector3<f64> = behind.iter().map(|node| places[*node as usize]).sum();
    let out = corner(0) - sum / behind.len() as f64;
    normal.z * normal.dot(&out) >= 0.0
}

/// Of an amount between 0 and 1.
fn colour(amount: f64) -> String {
    let place = amount.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let first = (place.floor() as usize).min(COLOURS.len() - 2);
    let share = place - first as f64;
    let mixed = [0, 1, 2].map(|channel| {
        let (from, to) = (COLOURS[first][channel], COLOURS[first + 1][channel]);
        (from + share * (to - from)).round() as u8
    });
    format!("#{:02x}{:02x}{:02x}", mixed[0], mixed[1], mixed[2])
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use faer::Mat;

    use dcb_formats::mesh::{CellBlock, Direction};

    use super::*;

    /// Two hexahedra side by side: eleven faces, of which one between them, and three of a box face a viewer.
    #[test]
    fn only_what_is_seen_of_a_solid_is_drawn() {
        let points: Vec<[f64; 3]> = (0..3)
            .flat_map(|i| {
                [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].map(|[y, z]| [f64::from(i), y, z])
            })
            .collect();
        let cell = |first: u32| [0, 1, 2, 3, 4, 5, 6, 7].map(|k| first + k);
        let mesh = Mesh {
            dimension: Dimension::Spatial,
            coordinates: points.concat(),
            cells: vec![CellBlock {
                cell_type: "hexahedron".into(),
                nodes_per_cell: 8,
                nodes: [cell(0), cell(4)].concat(),
            }],
            point_sets: BTreeMap::new(),
        };
        assert_eq!(faces(&mesh).len(), 10);
        let dofs: Vec<Dof> = (0..12)
            .map(|node| Dof {
                node,
                direction: Direction::Uy,
            })
            .collect();
        let shapes = Mat::from_fn(12, 1, |i, _| if i < 4 { 2.0 } else { 0.0 });
        let pictures = mode_pictures(&mesh, &dofs, shapes.as_ref());
        assert_eq!(pictures.len(), 1);
        // Two sides of two faces each, and one end.
        assert_eq!(pictures[0].matches("<path").count(), 5, "{}", pictures[0]);
        assert!(pictures[0].contains("#c83c28") && pictures[0].contains("#e2e8f0"));
    }
}
