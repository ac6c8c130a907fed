//! Pictures of mode shapes: the surface of the deformed mesh as SVG, coloured by how far its points move.
//!
//! Planar meshes are drawn as they lie. Spatial ones are drawn with their longest side to the right and their shortest towards the
//! viewer, turned a little; faces that look away are left out and the others drawn from back to front.

use std::collections::HashMap;
use std::fmt::Write as _;

use dcb_formats::mesh::{Dimension, Dof, Mesh};
use faer::{Mat, MatRef};

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
fn displacements(mesh: &Mesh, dofs: &[Dof], shape: MatRef<'_, f64>) -> Vec<[f64; 3]> {
    let mut moved = vec![[0.0; 3]; mesh.node_count()];
    for (row, dof) in dofs.iter().enumerate() {
        if !dof.direction.is_rotation() {
            moved[dof.node as usize][dof.direction.axis()] = shape[(row, 0)];
        }
    }
    let largest = moved.iter().map(|u| length(*u)).fold(0.0, f64::max);
    if largest > 0.0 {
        for u in &mut moved {
            *u = u.map(|x| x / largest);
        }
    }
    moved
}

fn length(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// From component axes to right, up and towards the viewer.
struct View {
    /// Rows: right, up, towards.
    axes: Mat<f64>,
    /// Diagonal of the box around the part.
    size: f64,
}

impl View {
    fn of(mesh: &Mesh) -> Self {
        let (mut least, mut most) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for node in 0..mesh.node_count() as u32 {
            for (axis, x) in mesh.position(node).into_iter().enumerate() {
                least[axis] = least[axis].min(x);
                most[axis] = most[axis].max(x);
            }
        }
        let sides: Vec<f64> = least.iter().zip(&most).map(|(a, b)| b - a).collect();
        let size = length([sides[0], sides[1], sides[2]]);
        if mesh.dimension == Dimension::Planar {
            let axes = Mat::identity(3, 3);
            return Self { axes, size };
        }
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| sides[*b].total_cmp(&sides[*a]));
        let unit = |axis: usize, sign: f64| {
            let mut unit = [0.0; 3];
            unit[axis] = sign;
            unit
        };
        // Right-handed, so that nothing is seen in a mirror.
        let is_even = matches!(order, [0, 1, 2] | [1, 2, 0] | [2, 0, 1]);
        let sign = if is_even { 1.0 } else { -1.0 };
        let (right, up, towards) = (
            unit(order[0], 1.0),
            unit(order[1], 1.0),
            unit(order[2], sign),
        );
        let base = Mat::from_fn(3, 3, |i, j| [right, up, towards][i][j]);
        let (s, c) = TURN.sin_cos();
        let turn = Mat::from_fn(3, 3, |i, j| {
            [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]][i][j]
        });
        let (s, c) = TILT.sin_cos();
        let tilt = Mat::from_fn(3, 3, |i, j| {
            [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]][i][j]
        });
        Self {
            axes: tilt * turn * base,
            size,
        }
    }

    fn project(&self, x: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| (0..3).map(|j| self.axes[(i, j)] * x[j]).sum())
    }
}

fn draw(mesh: &Mesh, faces: &[Face], moved: &[[f64; 3]], view: &View) -> String {
    let places: Vec<[f64; 3]> = (0..mesh.node_count() as u32)
        .map(|node| {
            let (x, u) = (mesh.position(node), moved[node as usize]);
            view.project([0, 1, 2].map(|axis| x[axis] + AMPLITUDE * view.size * u[axis]))
        })
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
        let [x, y, _] = places[node as usize];
        [
            beside + scale * (x - left),
            HEIGHT - below - scale * (y - bottom),
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
            .map(|node| length(moved[*node as usize]))
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
fn faces_viewer(face: &Face, places: &[[f64; 3]]) -> bool {
    let Some(behind) = &face.behind else {
        return true;
    };
    let corner = |index: usize| places[face.corners[index] as usize];
    let side = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|axis| b[axis] - a[axis]);
    let (a, b) = (side(corner(0), corner(1)), side(corner(0), corner(2)));
    let normal = [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ];
    let middle = [0, 1, 2].map(|axis| {
        let sum: f64 = behind.iter().map(|node| places[*node as usize][axis]).sum();
        sum / behind.len() as f64
    });
    let out = side(middle, corner(0));
    let outward: f64 = normal.iter().zip(&out).map(|(n, x)| n * x).sum();
    normal[2] * outward >= 0.0
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
