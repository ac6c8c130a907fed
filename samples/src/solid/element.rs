//! Shape functions of the solid elements, in meshio's node order.
//!
//! Hexahedra live on (-1, 1)³, tetrahedra on x, y, z ≥ 0, x + y + z ≤ 1.

use super::quadrature::{self, QuadraturePoint};

/// Isoparametric solid elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SolidElement {
    /// Eight nodes, trilinear.
    Hexahedron,
    /// Twenty nodes, serendipity.
    Hexahedron20,
    /// Four nodes, linear.
    Tetra,
    /// Ten nodes, quadratic.
    Tetra10,
}

/// Corners of the reference hexahedron; the first eight nodes.
const HEXAHEDRON_CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Edges of the hexahedron in the order of the mid-side nodes 8..20.
pub(crate) const HEXAHEDRON_EDGES: [[usize; 2]; 12] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 0],
    [4, 5],
    [5, 6],
    [6, 7],
    [7, 4],
    [0, 4],
    [1, 5],
    [2, 6],
    [3, 7],
];

/// Corners of the reference tetrahedron.
const TETRAHEDRON_CORNERS: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];

/// Edges of the tetrahedron in the order of the mid-side nodes 4..10.
pub(crate) const TETRAHEDRON_EDGES: [[usize; 2]; 6] =
    [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Gradients of the barycentric coordinates of the reference tetrahedron.
const BARYCENTRIC_GRADIENTS: [[f64; 3]; 4] = [
    [-1.0, -1.0, -1.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];

/// One node's shape function at a point: value and gradient in reference coordinates.
#[derive(Clone, Copy, Debug)]
pub struct ShapeFunction {
    /// Value.
    pub value: f64,
    /// Derivatives along the three reference coordinates.
    pub gradient: [f64; 3],
}

impl SolidElement {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Hexahedron,
        Self::Hexahedron20,
        Self::Tetra,
        Self::Tetra10,
    ];

    /// meshio's cell name.
    pub fn cell_type(self) -> &'static str {
        match self {
            Self::Hexahedron => "hexahedron",
            Self::Hexahedron20 => "hexahedron20",
            Self::Tetra => "tetra",
            Self::Tetra10 => "tetra10",
        }
    }

    /// The element with this meshio name, if it is one of these.
    pub fn from_cell_type(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|element| element.cell_type() == name)
    }

    /// Nodes per element.
    pub fn node_count(self) -> usize {
        match self {
            Self::Hexahedron => 8,
            Self::Hexahedron20 => 20,
            Self::Tetra => 4,
            Self::Tetra10 => 10,
        }
    }

    /// Where the nodes are in the reference element.
    pub fn node_positions(self) -> Vec<[f64; 3]> {
        let middle = |corners: &[[f64; 3]], [a, b]: [usize; 2]| -> [f64; 3] {
            std::array::from_fn(|axis| 0.5 * (corners[a][axis] + corners[b][axis]))
        };
        let (corners, edges): (&[[f64; 3]], &[[usize; 2]]) = match self {
            Self::Hexahedron => (&HEXAHEDRON_CORNERS, &[]),
            Self::Hexahedron20 => (&HEXAHEDRON_CORNERS, &HEXAHEDRON_EDGES),
            Self::Tetra => (&TETRAHEDRON_CORNERS, &[]),
            Self::Tetra10 => (&TETRAHEDRON_CORNERS, &TETRAHEDRON_EDGES),
        };
        let middles = edges.iter().map(|edge| middle(corners, *edge));
        corners.iter().copied().chain(middles).collect()
    }

    /// Full quadrature: exact stiffness and consistent mass for undistorted elements.
    pub fn quadrature(self) -> Vec<QuadraturePoint> {
        match self {
            Self::Hexahedron => quadrature::hexahedron_8(),
            Self::Hexahedron20 => quadrature::hexahedron_27(),
            Self::Tetra => quadrature::tetrahedron_4(),
            Self::Tetra10 => quadrature::tetrahedron_14(),
        }
    }

    /// The shape functions at a point of the reference element, node after node.
    pub fn shape_functions(self, point: [f64; 3]) -> Vec<ShapeFunction> {
        match self {
            Self::Hexahedron => HEXAHEDRON_CORNERS
                .iter()
                .map(|&corner| trilinear(corner, point))
                .collect(),
            Self::Hexahedron20 => serendipity(point),
            Self::Tetra => barycentric(point)
                .into_iter()
                .zip(BARYCENTRIC_GRADIENTS)
                .map(|(value, gradient)| ShapeFunction { value, gradient })
                .collect(),
            Self::Tetra10 => quadratic_tetrahedron(point),
        }
    }
}

fn trilinear(corner: [f64; 3], point: [f64; 3]) -> ShapeFunction {
    let [a, b, c] = std::array::from_fn(|i| 1.0 + corner[i] * point[i]);
    ShapeFunction {
        value: a * b * c / 8.0,
        gradient: [
            corner[0] * b * c / 8.0,
            a * corner[1] * c / 8.0,
            a * b * corner[2] / 8.0,
        ],
    }
}

fn serendipity(point: [f64; 3]) -> Vec<ShapeFunction> {
    let corners = HEXAHEDRON_CORNERS.iter().map(|&corner| {
        let [a, b, c] = std::array::from_fn(|i| 1.0 + corner[i] * point[i]);
        let s = a + b + c - 5.0;
        ShapeFunction {
            value: a * b * c * s / 8.0,
            gradient: [
                corner[0] * b * c * (s + a) / 8.0,
                corner[1] * a * c * (s + b) / 8.0,
                corner[2] * a * b * (s + c) / 8.0,
            ],
        }
    });
    let middles = HEXAHEDRON_EDGES.iter().map(|&[from, to]| {
        let middle: [f64; 3] = std::array::from_fn(|i| {
            0.5 * (HEXAHEDRON_CORNERS[from][i] + HEXAHEDRON_CORNERS[to][i])
        });
        // Along the edge 1 - x²; across it 1 ± x.
        let factor: [f64; 3] = std::array::from_fn(|i| match middle[i] {
            0.0 => 1.0 - point[i] * point[i],
            side => 1.0 + side * point[i],
        });
        let slope: [f64; 3] = std::array::from_fn(|i| {
            if middle[i] == 0.0 {
                -2.0 * point[i]
            } else {
                middle[i]
            }
        });
        ShapeFunction {
            value: factor[0] * factor[1] * factor[2] / 4.0,
            gradient: [
                slope[0] * factor[1] * factor[2] / 4.0,
                factor[0] * slope[1] * factor[2] / 4.0,
                factor[0] * factor[1] * slope[2] / 4.0,
            ],
        }
    });
    corners.chain(middles).collect()
}

fn barycentric(point: [f64; 3]) -> [f64; 4] {
    [
        1.0 - point[0] - point[1] - point[2],
        point[0],
        point[1],
        point[2],
    ]
}

fn quadratic_tetrahedron(point: [f64; 3]) -> Vec<ShapeFunction> {
    let l = barycentric(point);
    let corners = (0..4).map(|i| ShapeFunction {
        value: l[i] * (2.0 * l[i] - 1.0),
        gradient: BARYCENTRIC_GRADIENTS[i].map(|g| (4.0 * l[i] - 1.0) * g),
    });
    let middles = TETRAHEDRON_EDGES.iter().map(|&[i, j]| ShapeFunction {
        value: 4.0 * l[i] * l[j],
        gradient: std::array::from_fn(|axis| {
            4.0 * (l[i] * BARYCENTRIC_GRADIENTS[j][axis] + l[j] * BARYCENTRIC_GRADIENTS[i][axis])
        }),
    });
    corners.chain(middles).collect()
}
