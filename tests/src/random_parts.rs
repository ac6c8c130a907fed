//! Parts made from a few numbers, for property tests: networks of springs, rods, beams and boxes.

use std::collections::BTreeMap;

use dcb_formats::Component;
use dcb_formats::component::{ComponentDraft, InterfaceKind};
use dcb_formats::mesh::{CellBlock, Dimension, Direction, DofMap, Mesh};
use dcb_samples::{
    Material, PseudoRandom, RodSection, SolidElement, SpatialBeam, box_block, planar_rod,
    spatial_beam,
};
use faer::Mat;
use nalgebra::Vector3;

use crate::dense::sparse;
use crate::mechanism::si;
use crate::parts::interface;

/// What a part is made from; small, so that a failure can be read.
#[derive(Clone, Debug)]
pub enum Recipe {
    /// Points joined each to each.
    Springs(Springs),
    /// A planar rod with this many elements.
    Rod(usize, RodSection),
    /// A spatial beam.
    Beam(SpatialBeam),
    /// A box of solid elements.
    Box {
        /// Along each axis.
        cells: [usize; 3],
        /// Sides, m.
        size: [f64; 3],
        /// Of which kind.
        element: SolidElement,
        /// Material.
        material: Material,
    },
}

/// Points joined by springs along their connecting lines, each to each: rigid motions cost exactly nothing.
#[derive(Clone, Debug)]
pub struct Springs {
    /// Planar: z is left out.
    pub dimension: Dimension,
    /// Positions, m.
    pub points: Vec<[f64; 3]>,
    /// N/m, one for each pair in the order (0, 1), (0, 2) …; as many as there are pairs, or more.
    pub stiffness: Vec<f64>,
    /// kg: of the points, or of bars in place of the springs.
    pub mass: SpringMass,
}

/// Where the mass of a network is.
#[derive(Clone, Debug)]
pub enum SpringMass {
    /// At the points.
    Lumped(Vec<f64>),
    /// Along each spring, displaced linearly.
    Consistent(Vec<f64>),
}

impl Recipe {
    /// The part.
    pub fn component(&self) -> Component {
        match self {
            Self::Springs(springs) => springs.component(),
            Self::Rod(elements, section) => planar_rod(*elements, section),
            Self::Beam(beam) => spatial_beam(beam),
            Self::Box {
                cells,
                size,
                element,
                material,
            } => box_block(*cells, *size, *element, material),
        }
    }
}

impl Springs {
    /// The part, with its first and last point as interfaces.
    fn component(&self) -> Component {
        let (count, d) = (self.points.len(), self.dimension.coordinate_count());
        let size = d * count;
        let (mut k, mut m) = (Mat::zeros(size, size), Mat::zeros(size, size));
        let at = |point: usize| {
            let mut x = Vector3::from(self.points[point]);
            x.iter_mut().skip(d).for_each(|z| *z = 0.0);
            x
        };
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b)));
        for (index, (a, b)) in pairs.enumerate() {
            let along = (at(b) - at(a)).normalize();
            let ends = [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)];
            for (p, q, sign) in ends {
                for (i, j) in (0..d).flat_map(|i| (0..d).map(move |j| (i, j))) {
                    // Commutes, so that K is exactly symmetric.
                    k[(d * p + i, d * q + j)] +=
                        sign * self.stiffness[index] * (along[i] * along[j]);
                }
                if let SpringMass::Consistent(masses) = &self.mass {
                    let share = if p == q { 3.0 } else { 6.0 };
                    for i in 0..d {
                        m[(d * p + i, d * q + i)] += masses[index] / share;
                    }
                }
            }
        }
        if let SpringMass::Lumped(masses) = &self.mass {
            for row in 0..size {
                m[(row, row)] = masses[row / d];
            }
        }
        let last = count as u32 - 1;
        let mesh = Mesh {
            dimension: self.dimension,
            coordinates: (0..count)
                .flat_map(|point| self.points[point][..d].to_vec())
                .collect(),
            cells: vec![CellBlock {
                cell_type: "line".into(),
                nodes_per_cell: 2,
                nodes: (0..=last)
                    .flat_map(|a| (a + 1..=last).flat_map(move |b| [a, b]))
                    .collect(),
            }],
            point_sets: BTreeMap::new(),
        };
        let dofs = DofMap::uniform(count, &Direction::ALL[..d]).expect("a dof table");
        Component::checked(ComponentDraft {
            interfaces: vec![
                interface("first", InterfaceKind::Nodes, vec![0]),
                interface("last", InterfaceKind::Nodes, vec![last]),
            ],
            ..ComponentDraft::new("springs", si(), (mesh, dofs), sparse(&k), sparse(&m))
        })
        .expect("a component")
    }
}

/// The numbers below `count` in an order that depends on the seed.
pub fn shuffled(count: usize, seed: u64) -> Vec<u32> {
    let mut random = PseudoRandom::new(seed);
    let mut keys: Vec<(f64, u32)> = (0..count as u32).map(|i| (random.number(), i)).collect();
    keys.sort_by(|a, b| a.0.total_cmp(&b.0));
    keys.into_iter().map(|(_, i)| i).collect()
}
