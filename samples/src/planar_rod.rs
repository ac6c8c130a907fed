//! A straight planar Euler–Bernoulli rod with axial stiffness: `ux uy rz` at every node, linear axial and cubic
//! transverse shape functions, consistent mass, exact component masses. No rotary inertia, no shear.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use dcb_formats::component::{ComponentDraft, ComponentMasses};
use dcb_formats::mesh::{CellBlock, Dimension, Direction, Mesh};
use dcb_formats::{Component, SparseMatrix};

use crate::component::{checked, draft, nodes_interface, uniform_dofs};
use crate::sparse::Assembly;

/// Geometry, section and material of a uniform rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RodSection {
    /// Length, m.
    pub length: f64,
    /// Cross-section area, m².
    pub area: f64,
    /// Second moment of area about the axis of bending, m⁴.
    pub second_moment: f64,
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// Angle of the rod's axis from x, rad.
    pub angle: f64,
}

impl RodSection {
    /// A rod of round section along x.
    pub fn round(length: f64, diameter: f64, youngs_modulus: f64, density: f64) -> Self {
        let area = PI * diameter.powi(2) / 4.0;
        let second_moment = PI * diameter.powi(4) / 64.0;
        Self {
            length,
            area,
            second_moment,
            youngs_modulus,
            density,
            angle: 0.0,
        }
    }
}

impl RodSection {
    /// A rod of square section along x.
    pub fn square(length: f64, side: f64, youngs_modulus: f64, density: f64) -> Self {
        Self {
            length,
            area: side * side,
            second_moment: side.powi(4) / 12.0,
            youngs_modulus,
            density,
            angle: 0.0,
        }
    }
}

impl Default for RodSection {
    /// The connecting rod of the slider-crank benchmark: 0.3 m, round 6 mm, 0.2e12 Pa, 7870 kg/m³.
    fn default() -> Self {
        Self::round(0.3, 0.006, 0.2e12, 7870.0)
    }
}

/// Gauss points and weights on (0, 1), exact to degree 7.
pub(crate) const GAUSS_4: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// The rod as a chain of equal elements from the origin, with interfaces `a` (first node) and `b` (last node), both
/// `ux uy`. At least one element is made.
pub fn planar_rod(elements: usize, rod: &RodSection) -> Component {
    let elements = elements.max(1);
    let node_count = elements + 1;
    let (sine, cosine) = direction(rod.angle);
    let h = rod.length / elements as f64;

    let stiffness_element = rotate_pair(&stiffness_local(h, rod), sine, cosine);
    // Order xx, yy, xy.
    let mass_elements =
        [(0, 0), (1, 1), (0, 1)].map(|(c, d)| component_mass(h, rod, sine, cosine, c, d));
    let stiffness = chain(elements, &stiffness_element);
    let masses = mass_elements.map(|element| chain(elements, &element));
    let mut total = [[0.0; 6]; 6];
    for (i, row) in total.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = mass_elements[0][i][j] + mass_elements[1][i][j];
        }
    }
    let mass = chain(elements, &total);

    let along = |node: usize| rod.length * node as f64 / elements as f64;
    let mesh = Mesh {
        dimension: Dimension::Planar,
        coordinates: (0..node_count)
            .flat_map(|node| [along(node) * cosine, along(node) * sine])
            .collect(),
        cells: vec![CellBlock {
            cell_type: "line".into(),
            nodes_per_cell: 2,
            nodes: (0..elements as u32).flat_map(|e| [e, e + 1]).collect(),
        }],
        point_sets: BTreeMap::from([("a".into(), vec![0]), ("b".into(), vec![elements as u32])]),
    };
    let dofs = uniform_dofs(node_count, &[Direction::Ux, Direction::Uy, Direction::Rz]);
    let ends = [Direction::Ux, Direction::Uy];
    let interfaces = vec![
        nodes_interface("a", vec![0], &ends),
        nodes_interface("b", vec![elements as u32], &ends),
    ];
    checked(ComponentDraft {
        component_masses: Some(ComponentMasses {
            matrices: masses.into(),
        }),
        ..draft("planar-rod", mesh, dofs, stiffness, mass, interfaces)
    })
}

type Element = [[f64; 6]; 6];

/// Sine and cosine, exact at multiples of a right angle.
fn direction(angle: f64) -> (f64, f64) {
    let quarter = angle / (PI / 2.0);
    if quarter == quarter.round() {
        match quarter.rem_euclid(4.0) as u8 {
            0 => (0.0, 1.0),
            1 => (1.0, 0.0),
            2 => (0.0, -1.0),
            _ => (-1.0, 0.0),
        }
    } else {
        angle.sin_cos()
    }
}

fn stiffness_local(h: f64, rod: &RodSection) -> Element {
    let axial = rod.youngs_modulus * rod.area / h;
    let bending = rod.youngs_modulus * rod.second_moment / h.powi(3);
    let (b1, b2, b3, b4) = (
        12.0 * bending,
        6.0 * h * bending,
        4.0 * h * h * bending,
        2.0 * h * h * bending,
    );
    [
        [axial, 0.0, 0.0, -axial, 0.0, 0.0],
        [0.0, b1, b2, 0.0, -b1, b2],
        [0.0, b2, b3, 0.0, -b2, b4],
        [-axial, 0.0, 0.0, axial, 0.0, 0.0],
        [0.0, -b1, -b2, 0.0, b1, -b2],
        [0.0, b2, b4, 0.0, -b2, b3],
    ]
}

/// `Tᵀ A T` with T the rotation of the displacements at both nodes, for symmetric A; the upper triangle is mirrored.
fn rotate_pair(local: &Element, sine: f64, cosine: f64) -> Element {
    let t = rotation(sine, cosine);
    let mut global = [[0.0; 6]; 6];
    for i in 0..6 {
        for j in i..6 {
            let mut sum = 0.0;
            for k in 0..6 {
                for l in 0..6 {
                    sum += t[k][i] * local[k][l] * t[l][j];
                }
            }
            global[i][j] = sum;
            global[j][i] = sum;
        }
    }
    global
}

/// Local displacements from global ones.
fn rotation(sine: f64, cosine: f64) -> Element {
    let mut t = [[0.0; 6]; 6];
    for node in [0, 3] {
        t[node][node] = cosine;
        t[node][node + 1] = sine;
        t[node + 1][node] = -sine;
        t[node + 1][node + 1] = cosine;
        t[node + 2][node + 2] = 1.0;
    }
    t
}

/// `M_cd = ∫ ρA N_cᵀ N_d dx` of one element in component axes; N_c is the global displacement along axis c.
fn component_mass(h: f64, rod: &RodSection, sine: f64, cosine: f64, c: usize, d: usize) -> Element {
    let t = rotation(sine, cosine);
    let to_global = [[cosine, -sine], [sine, cosine]];
    let mut mass = [[0.0; 6]; 6];
    for (s, weight) in GAUSS_4 {
        let local = shape_rows(h, s);
        let global = to_global.map(|row| {
            let mut n = [0.0; 6];
            for (j, entry) in n.iter_mut().enumerate() {
                *entry = (0..6)
                    .map(|k| (row[0] * local[0][k] + row[1] * local[1][k]) * t[k][j])
                    .sum();
            }
            n
        });
        for (i, row) in mass.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry += weight * rod.density * rod.area * h * (global[c][i] * global[d][j]);
            }
        }
    }
    mass
}

/// Local axial and transverse shape functions at `s` in (0, 1).
fn shape_rows(h: f64, s: f64) -> [[f64; 6]; 2] {
    let [h1, h2, h3, h4] = hermite(h, s);
    [[1.0 - s, 0.0, 0.0, s, 0.0, 0.0], [0.0, h1, h2, 0.0, h3, h4]]
}

/// Cubic Hermite functions on an element of length `h`.
fn hermite(h: f64, s: f64) -> [f64; 4] {
    let (s2, s3) = (s * s, s * s * s);
    [
        1.0 - 3.0 * s2 + 2.0 * s3,
        h * (s - 2.0 * s2 + s3),
        3.0 * s2 - 2.0 * s3,
        h * (s3 - s2),
    ]
}

fn chain(elements: usize, element: &Element) -> SparseMatrix {
    let mut assembly = Assembly::new(3 * (elements + 1));
    for e in 0..elements {
        for (i, row) in element.iter().enumerate() {
            for (j, &value) in row.iter().enumerate() {
                assembly.add(3 * e + i, 3 * e + j, value);
            }
        }
    }
    assembly.finish()
}
