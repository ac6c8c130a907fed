//! Every sample by name, for the command line and for tests that want all of them.

use dcb_formats::Component;

use crate::gallery;
use crate::hard::{self, Hinge};
use crate::material::Material;
use crate::planar_rod::{RodSection, planar_rod};
use crate::solid::{SolidElement, box_block, reference_hexahedra, reference_tetrahedra};
use crate::spatial_beam::{BeamMass, BeamTheory, SpatialBeam, spatial_beam};

/// A named sample.
#[derive(Clone, Copy)]
pub struct Sample {
    /// Name on the command line.
    pub name: &'static str,
    /// One line.
    pub description: &'static str,
    /// Meaning of the refinement number and its default, if the sample has one.
    pub refinement: Option<(&'static str, u32)>,
    make: fn(u32) -> Component,
}

impl Sample {
    /// The component; `refinement` is ignored by samples that have none.
    pub fn make(&self, refinement: Option<u32>) -> Component {
        let default = self.refinement.map_or(0, |(_, default)| default);
        (self.make)(refinement.unwrap_or(default))
    }
}

/// The sample with this name.
pub fn find(name: &str) -> Option<&'static Sample> {
    CATALOGUE.iter().find(|sample| sample.name == name)
}

const fn fixed(
    name: &'static str,
    description: &'static str,
    make: fn(u32) -> Component,
) -> Sample {
    Sample {
        name,
        description,
        refinement: None,
        make,
    }
}

/// All samples.
pub const CATALOGUE: &[Sample] = &[
    Sample {
        name: "rod",
        description: "planar connecting rod of the slider-crank benchmark, with exact component masses",
        refinement: Some(("number of beam elements", 4)),
        make: |elements| planar_rod(elements as usize, &RodSection::default()),
    },
    fixed(
        "ivp-rod",
        "planar rod of the slider-crank of the IVP test set, 8 elements",
        |_| planar_rod(8, &RodSection::square(0.3, 0.008, 0.20e12, 7870.0)),
    ),
    Sample {
        name: "beam",
        description: "spatial Euler-Bernoulli beam, 1 m, 20 x 30 mm, steel, with exact component masses",
        refinement: Some(("number of beam elements", 8)),
        make: |elements| {
            spatial_beam(&SpatialBeam {
                elements: elements as usize,
                ..SpatialBeam::default()
            })
        },
    },
    Sample {
        name: "timoshenko-beam",
        description: "the same with shear and rotary inertia",
        refinement: Some(("number of beam elements", 8)),
        make: |elements| {
            let theory = BeamTheory::Timoshenko;
            spatial_beam(&SpatialBeam {
                elements: elements as usize,
                theory,
                ..SpatialBeam::default()
            })
        },
    },
    Sample {
        name: "lumped-beam",
        description: "the same with massless bending rotations: semi-definite mass",
        refinement: Some(("number of beam elements", 8)),
        make: |elements| {
            let mass = BeamMass::LumpedWithRoll;
            spatial_beam(&SpatialBeam {
                elements: elements as usize,
                mass,
                ..SpatialBeam::default()
            })
        },
    },
    Sample {
        name: "connecting-rod",
        description: "steel connecting rod with two bores, quadratic hexahedra, averaged interfaces",
        refinement: Some(("0, 1, 2, 3: 10, 28, 98, 373 thousand dofs", 1)),
        make: crate::connecting_rod,
    },
    Sample {
        name: "bracket",
        description: "steel angle bracket with the stress in its fillet, quadratic hexahedra, averaged interfaces",
        refinement: Some((
            "cells across the thickness; 2, 4, 8: 6, 37, 256 thousand dofs",
            2,
        )),
        make: |cells| crate::bracket(cells as usize),
    },
    Sample {
        name: "shaft",
        description: "round steel shaft of a rotor, 1.5 m, with places for two disks and two bearings",
        refinement: Some(("number of beam elements, a multiple of three", 12)),
        make: |elements| crate::shaft(elements as usize),
    },
    Sample {
        name: "block",
        description: "steel block 0.4 x 0.1 x 0.06 m, quadratic hexahedra",
        refinement: Some(("cells across the height", 2)),
        make: |n| block(n, SolidElement::Hexahedron20),
    },
    Sample {
        name: "block-tetra10",
        description: "the same in quadratic tetrahedra",
        refinement: Some(("cells across the height", 1)),
        make: |n| block(n, SolidElement::Tetra10),
    },
    fixed(
        "reference-hexahedra",
        "30-node box of the spatial reference values",
        |_| reference_hexahedra(),
    ),
    fixed(
        "reference-tetrahedra",
        "16-node box of linear tetrahedra",
        |_| reference_tetrahedra(),
    ),
    fixed("thin-plate", "plate 1 mm thick", |_| hard::thin_plate()),
    fixed("slender-block", "bar 2 m x 12 x 8 mm", |_| {
        hard::slender_block()
    }),
    fixed(
        "square-block",
        "square section: exact double bending modes",
        |_| hard::square_block(),
    ),
    Sample {
        name: "symmetric-ring",
        description: "flat ring with double roots",
        refinement: Some(("fold of the mesh's symmetry", 8)),
        make: |fold| hard::symmetric_ring(fold as usize),
    },
    fixed("two-loose-blocks", "two parts that don't touch", |_| {
        hard::two_loose_blocks()
    }),
    fixed(
        "edge-hinge",
        "two blocks with one edge in common: seven zero frequencies",
        |_| hard::hinged_blocks(Hinge::Edge),
    ),
    fixed(
        "node-hinge",
        "two blocks with one node in common: nine zero frequencies",
        |_| hard::hinged_blocks(Hinge::Node),
    ),
    fixed("grounded-block", "dofs of one face removed", |_| {
        hard::grounded_block()
    }),
    fixed(
        "orphan-dof-block",
        "one dof without stiffness and mass",
        |_| hard::orphan_dof_block(),
    ),
    fixed(
        "upper-arm",
        "gallery: upper arm of a robot, 0.6 m, aluminium",
        |_| gallery::upper_arm(),
    ),
    fixed(
        "forearm",
        "gallery: forearm of a robot, 0.5 m, aluminium",
        |_| gallery::forearm(),
    ),
    fixed(
        "blade",
        "gallery: blade of a wind turbine, 20 m, glass fibre",
        |_| gallery::blade(),
    ),
    fixed(
        "four-bar-link",
        "gallery: bar of 1 m and 1 kg, aluminium",
        |_| gallery::four_bar_link(),
    ),
    fixed(
        "scissor-bar",
        "gallery: bar with a middle pin, 1 m, aluminium",
        |_| gallery::scissor_bar(),
    ),
    fixed(
        "spinning-plate",
        "gallery: square plate with a hub, 0.4 m, steel",
        |_| gallery::spinning_plate(),
    ),
    fixed(
        "engine-rod",
        "gallery: connecting-rod with larger elements",
        |_| gallery::engine_rod(),
    ),
];

fn block(cells: u32, element: SolidElement) -> Component {
    let n = cells.max(1) as usize;
    box_block(
        [6 * n, 2 * n, n],
        [0.4, 0.1, 0.06],
        element,
        &Material::STEEL,
    )
}
