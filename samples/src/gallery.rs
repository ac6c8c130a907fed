//! The solid parts of the gallery's mechanisms: bars of changing section and a plate, small enough to reduce in a second.

use std::f64::consts::PI;

use dcb_formats::Component;

use crate::component::{average_interface, nodes_on_plane};
use crate::connecting_rod::{RodShape, connecting_rod_of};
use crate::material::Material;
use crate::solid::{SolidElement, box_mesh, solid_component};

/// Glass fibre in epoxy, as if it were isotropic.
const GLASS_FIBRE: Material = Material {
    youngs_modulus: 25e9,
    poisson_ratio: 0.3,
    density: 1900.0,
};

/// Aluminium.
const ALUMINIUM: Material = Material {
    youngs_modulus: 70e9,
    poisson_ratio: 0.33,
    density: 2700.0,
};

/// A section of a bar across x.
#[derive(Clone, Copy)]
struct Section {
    /// Place along the bar, m.
    x: f64,
    /// Width along y and height along z before the twist, m.
    size: [f64; 2],
    /// Turn about x, rad.
    twist: f64,
}

impl Section {
    const fn straight(x: f64, size: [f64; 2]) -> Self {
        Self {
            x,
            size,
            twist: 0.0,
        }
    }
}

/// A bar along x from the origin; its sections change linearly between the given ones.
struct Bar {
    name: &'static str,
    cells: [usize; 3],
    sections: &'static [Section],
    /// Interfaces over all nodes of a section, at shares of the length that are planes of the mesh.
    interfaces: &'static [(&'static str, f64)],
    material: Material,
}

impl Bar {
    fn component(&self) -> Component {
        let length = self.sections.last().map_or(1.0, |section| section.x);
        let mut mesh = box_mesh(self.cells, [1.0, 2.0, 2.0], SolidElement::Hexahedron20);
        let interfaces = self
            .interfaces
            .iter()
            .map(|(name, share)| {
                let nodes = nodes_on_plane(&mesh, 0, *share);
                average_interface(name, nodes, [share * length, 0.0, 0.0])
            })
            .collect();
        for point in mesh.coordinates.chunks_exact_mut(3) {
            let section = self.section_at(point[0] * length);
            let (sine, cosine) = section.twist.sin_cos();
            let across = [
                (point[1] - 1.0) * section.size[0] / 2.0,
                (point[2] - 1.0) * section.size[1] / 2.0,
            ];
            point[0] = section.x;
            point[1] = cosine * across[0] - sine * across[1];
            point[2] = sine * across[0] + cosine * across[1];
        }
        solid_component(self.name, mesh, &self.material, interfaces)
    }

    fn section_at(&self, x: f64) -> Section {
        let pair = self
            .sections
            .windows(2)
            .find(|pair| x <= pair[1].x)
            .unwrap_or(&self.sections[self.sections.len() - 2..]);
        let share = (x - pair[0].x) / (pair[1].x - pair[0].x);
        let between = |from: f64, to: f64| from + share * (to - from);
        Section {
            x,
            size: [0, 1].map(|axis| between(pair[0].size[axis], pair[1].size[axis])),
            twist: between(pair[0].twist, pair[1].twist),
        }
    }
}

/// Upper arm of the robot, aluminium, 0.6 m, interfaces `root` and `tip`.
pub(crate) fn upper_arm() -> Component {
    Bar {
        name: "upper-arm",
        cells: [12, 2, 2],
        sections: const {
            &[
                Section::straight(0.0, [0.03, 0.05]),
                Section::straight(0.6, [0.02, 0.03]),
            ]
        },
        interfaces: &[("root", 0.0), ("tip", 1.0)],
        material: ALUMINIUM,
    }
    .component()
}

/// Forearm of the robot, aluminium, 0.5 m, interfaces `root` and `tip`.
pub(crate) fn forearm() -> Component {
    Bar {
        name: "forearm",
        cells: [10, 2, 2],
        sections: const {
            &[
                Section::straight(0.0, [0.02, 0.03]),
                Section::straight(0.5, [0.012, 0.016]),
            ]
        },
        interfaces: &[("root", 0.0), ("tip", 1.0)],
        material: ALUMINIUM,
    }
    .component()
}

/// Blade of a wind turbine, glass fibre, 20 m, twisted by 14 degrees, interfaces `root` and `tip`.
pub(crate) fn blade() -> Component {
    Bar {
        name: "blade",
        cells: [24, 4, 1],
        sections: const {
            &[
                Section {
                    x: 0.0,
                    size: [0.9, 0.7],
                    twist: 14.0 * PI / 180.0,
                },
                Section {
                    x: 4.0,
                    size: [1.8, 0.4],
                    twist: 12.0 * PI / 180.0,
                },
                Section {
                    x: 20.0,
                    size: [0.5, 0.07],
                    twist: 0.0,
                },
            ]
        },
        interfaces: &[("root", 0.0), ("tip", 1.0)],
        material: GLASS_FIBRE,
    }
    .component()
}

/// Bar of the double four-bar, aluminium, 1 m long and of 1 kg, interfaces `a` and `b`.
pub(crate) fn four_bar_link() -> Component {
    Bar {
        name: "four-bar-link",
        cells: [12, 2, 1],
        sections: const {
            &[
                Section::straight(0.0, [0.025, 1.0 / (2700.0 * 0.025)]),
                Section::straight(1.0, [0.025, 1.0 / (2700.0 * 0.025)]),
            ]
        },
        interfaces: &[("a", 0.0), ("b", 1.0)],
        material: ALUMINIUM,
    }
    .component()
}

/// Bar of the scissor lift, aluminium, 1 m, interfaces `a`, `middle` and `b`.
pub(crate) fn scissor_bar() -> Component {
    Bar {
        name: "scissor-bar",
        cells: [12, 2, 1],
        sections: const {
            &[
                Section::straight(0.0, [0.08, 0.025]),
                Section::straight(0.5, [0.1, 0.025]),
                Section::straight(1.0, [0.08, 0.025]),
            ]
        },
        interfaces: &[("a", 0.0), ("middle", 0.5), ("b", 1.0)],
        material: ALUMINIUM,
    }
    .component()
}

/// Square plate of steel about the origin, 0.4 m wide and 3 mm thick, interface `hub` over the nodes within 40 mm of its axis z.
pub(crate) fn spinning_plate() -> Component {
    const WIDTH: f64 = 0.4;
    let mut mesh = box_mesh(
        [12, 12, 1],
        [WIDTH, WIDTH, 0.003],
        SolidElement::Hexahedron20,
    );
    for point in mesh.coordinates.chunks_exact_mut(3) {
        point[0] -= WIDTH / 2.0;
        point[1] -= WIDTH / 2.0;
        point[2] -= 0.0015;
    }
    let hub = (0..mesh.node_count() as u32)
        .filter(|&node| {
            let at = mesh.position(node);
            at[0].hypot(at[1]) <= 0.04
        })
        .collect();
    solid_component(
        "plate",
        mesh,
        &Material::STEEL,
        vec![average_interface("hub", hub, [0.0; 3])],
    )
}

/// The connecting rod of the samples with larger elements, interfaces `big-end` and `small-end`.
pub(crate) fn engine_rod() -> Component {
    let shape = RodShape {
        element_size: 0.0075,
        ..RodShape::default()
    };
    connecting_rod_of(&shape, &Material::STEEL)
}
