//! A connecting rod of steel: two bearing rings and a shank thinner and narrower than they are, in quadratic
//! hexahedra. Structured blocks, conforming, no tolerance anywhere: the rings share their points with the shank.

use std::f64::consts::PI;

use dcb_formats::Component;

use crate::component::average_interface;
use crate::material::Material;
use crate::planform::{Annulus, Planform, Ring, half_steps, on_circle};
use crate::solid::{SolidElement, solid_component};

/// Dimensions of the rod, m. The bores are along z, the rod is along x with the big end's centre at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RodShape {
    /// Distance of the bore centres.
    pub length: f64,
    /// Bore and outer radius of the big end.
    pub big_end: [f64; 2],
    /// Bore and outer radius of the small end.
    pub small_end: [f64; 2],
    /// Thickness of the rings.
    pub thickness: f64,
    /// Width (y) and thickness (z) of the shank.
    pub shank: [f64; 2],
    /// Element size aimed at.
    pub element_size: f64,
}

impl Default for RodShape {
    fn default() -> Self {
        Self {
            length: 0.180,
            big_end: [0.022, 0.032],
            small_end: [0.011, 0.018],
            thickness: 0.020,
            shank: [0.020, 0.012],
            element_size: 0.0036,
        }
    }
}

impl RodShape {
    /// Half the angle under which the shank meets the big and the small ring.
    fn half_angles(&self) -> [f64; 2] {
        let half_width = self.shank[0] / 2.0;
        [
            (half_width / self.big_end[1]).asin(),
            (half_width / self.small_end[1]).asin(),
        ]
    }

    /// Exact volume of the shape the mesh approximates, m³.
    pub fn volume(&self) -> f64 {
        let [alpha, beta] = self.half_angles();
        let ring = |radii: [f64; 2]| PI * (radii[1] * radii[1] - radii[0] * radii[0]);
        let segment = |radius: f64, half: f64| radius * radius * (half - half.sin() * half.cos());
        let (big, small) = (self.big_end[1], self.small_end[1]);
        let chord_to_chord = self.length - small * beta.cos() - big * alpha.cos();
        let shank = self.shank[0] * chord_to_chord - segment(big, alpha) - segment(small, beta);
        (ring(self.big_end) + ring(self.small_end)) * self.thickness + shank * self.shank[1]
    }
}

/// The default rod. Refinement 0 has 9 918 dofs, 1 (the usual one) 28 176, 2 98 388, 3 372 738.
pub fn connecting_rod(refinement: u32) -> Component {
    let shape = RodShape::default();
    let element_size = shape.element_size * 4.0_f64.powf((1.0 - f64::from(refinement)) / 3.0);
    connecting_rod_of(
        &RodShape {
            element_size,
            ..shape
        },
        &Material::STEEL,
    )
}

/// A rod of any dimensions, with averaged interfaces `big-end` and `small-end` at the bore centres over the point sets
/// `big_end` and `small_end` (all nodes of the bores). The shank must be narrower than both rings.
pub fn connecting_rod_of(shape: &RodShape, material: &Material) -> Component {
    let cells = |length: f64| (length / shape.element_size).round().max(1.0) as usize;
    let width_cells = cells(shape.shank[0]).max(2);
    let shank_layers = cells(shape.shank[1]);
    let outer_layers = cells((shape.thickness - shape.shank[1]) / 2.0);
    let heights = heights(shape, outer_layers, shank_layers);
    let all_layers = 0..heights.len() - 1;
    let [alpha, beta] = shape.half_angles();

    let mut planform = Planform::default();
    let add_ring =
        |planform: &mut Planform, center: f64, radii: [f64; 2], facing: f64, half: f64| {
            // The first cells around lie under the shank, the rest fill the circle.
            let rest = cells((2.0 * PI - 2.0 * half) * (radii[0] + radii[1]) / 2.0).max(6);
            let angles: Vec<f64> = half_steps(facing - half, facing + half, width_cells)
                .chain(half_steps(facing + half, facing - half + 2.0 * PI, rest))
                .collect();
            let annulus = Annulus {
                center: [center, 0.0],
                inner: radii[0],
                outer: radii[1],
            };
            planform.add_ring(
                annulus,
                &angles,
                cells(radii[1] - radii[0]).max(2),
                all_layers.clone(),
            )
        };
    let big = add_ring(&mut planform, 0.0, shape.big_end, 0.0, alpha);
    let small = add_ring(&mut planform, shape.length, shape.small_end, PI, beta);
    let length_cells = cells(shape.length - shape.big_end[1] - shape.small_end[1]);
    let shank_range = outer_layers..outer_layers + shank_layers;
    add_shank(
        &mut planform,
        shape,
        [length_cells, width_cells],
        [&big, &small],
        shank_range,
    );

    let extrusion = planform.extrude(&heights, SolidElement::Hexahedron20);
    let big_end = extrusion.nodes_over(&big.inner());
    let small_end = extrusion.nodes_over(&small.inner());
    let mut mesh = extrusion.mesh;
    mesh.point_sets.insert("big_end".into(), big_end.clone());
    mesh.point_sets
        .insert("small_end".into(), small_end.clone());
    let interfaces = vec![
        average_interface("big-end", big_end, [0.0; 3]),
        average_interface("small-end", small_end, [shape.length, 0.0, 0.0]),
    ];
    solid_component("connecting-rod", mesh, material, interfaces)
}

/// Planes between the layers: the shank's layers in the middle, the rings' own above and below.
fn heights(shape: &RodShape, outer_layers: usize, shank_layers: usize) -> Vec<f64> {
    let (outer, inner) = (shape.thickness / 2.0, shape.shank[1] / 2.0);
    let spans = [
        (-outer, -inner, outer_layers),
        (-inner, inner, shank_layers),
        (inner, outer, outer_layers),
    ];
    let between = |from: f64, to: f64, cells: usize| {
        (0..cells).map(move |step| from + (to - from) * step as f64 / cells as f64)
    };
    spans
        .into_iter()
        .flat_map(|(from, to, cells)| between(from, to, cells))
        .chain([outer])
        .collect()
}

/// Straight rows from the big ring's arc to the small ring's.
fn add_shank(
    planform: &mut Planform,
    shape: &RodShape,
    cells: [usize; 2],
    rings: [&Ring; 2],
    layers: std::ops::Range<usize>,
) {
    let [alpha, beta] = shape.half_angles();
    let [along, across] = cells.map(|count| 2 * count);
    let first: Vec<u32> = (1..along)
        .map(|i| {
            let share = i as f64 / along as f64;
            let mut first_of_column = 0;
            for j in 0..=across {
                let turn = 2.0 * j as f64 / across as f64 - 1.0;
                let from = on_circle([0.0, 0.0], shape.big_end[1], turn * alpha);
                let to = on_circle([shape.length, 0.0], shape.small_end[1], PI - turn * beta);
                let point =
                    std::array::from_fn(|axis| (1.0 - share) * from[axis] + share * to[axis]);
                let id = planform.add_point(point);
                if j == 0 {
                    first_of_column = id;
                }
            }
            first_of_column
        })
        .collect();
    let [big, small] = rings;
    planform.add_grid(cells, layers, |i, j| {
        if i == 0 {
            big.point(j, big.outer_step())
        } else if i == along {
            // The small ring counts its arc from the shank's upper side down.
            small.point(across - j, small.outer_step())
        } else {
            first[i - 1] + j as u32
        }
    });
}
