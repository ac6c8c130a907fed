//! A straight spatial beam: `ux uy uz rx ry rz` at every node, any direction in space.
//!
//! A point of the section moves with `u + θ × (0, y, z)`. Mass and component masses integrate that displacement over
//! the section exactly, so `mass = xx + yy + zz` always holds.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use dcb_formats::component::{ComponentDraft, ComponentMasses};
use dcb_formats::mesh::{CellBlock, Dimension, Direction, Mesh};
use dcb_formats::{Component, SparseMatrix};
use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};

use crate::component::{checked, draft, nodes_interface, uniform_dofs};
use crate::material::Material;
use crate::planar_rod::GAUSS_4;
use crate::sparse::Assembly;

/// Section properties about the local y and z axes, which are principal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamSection {
    /// Area, m².
    pub area: f64,
    /// `∫ z² dA`, bending in the local x–z plane, m⁴.
    pub second_moment_y: f64,
    /// `∫ y² dA`, bending in the local x–y plane, m⁴.
    pub second_moment_z: f64,
    /// Saint-Venant torsion constant, m⁴.
    pub torsion_constant: f64,
    /// Shear correction factor of both directions; used by [`BeamTheory::Timoshenko`] only.
    pub shear_factor: f64,
}

impl BeamSection {
    /// Solid circle.
    pub fn round(diameter: f64) -> Self {
        let second_moment = PI * diameter.powi(4) / 64.0;
        Self {
            area: PI * diameter.powi(2) / 4.0,
            second_moment_y: second_moment,
            second_moment_z: second_moment,
            torsion_constant: 2.0 * second_moment,
            shear_factor: 0.9,
        }
    }

    /// Solid rectangle, `width` along the local y and `height` along the local z axis; torsion constant by the usual
    /// closed approximation (error below 0.5 %).
    pub fn rectangle(width: f64, height: f64) -> Self {
        let (long, short) = (width.max(height), width.min(height));
        let ratio = short / long;
        let torsion =
            long * short.powi(3) * (1.0 / 3.0 - 0.21 * ratio * (1.0 - ratio.powi(4) / 12.0));
        Self {
            area: width * height,
            second_moment_y: width * height.powi(3) / 12.0,
            second_moment_z: height * width.powi(3) / 12.0,
            torsion_constant: torsion,
            shear_factor: 5.0 / 6.0,
        }
    }
}

/// Kinematics of the beam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeamTheory {
    /// No shear deformation, no rotary inertia of bending.
    EulerBernoulli,
    /// Shear deformation and rotary inertia.
    Timoshenko,
}

/// How the mass is distributed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeamMass {
    /// From the same shape functions as the stiffness.
    Consistent,
    /// Half of each element at its nodes, translations only: rotations are massless and M is semi-definite.
    LumpedTranslations,
    /// The same with the inertia about the beam's axis, also at the nodes: only the rotations of bending are massless.
    LumpedWithRoll,
}

/// A straight beam of equal elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpatialBeam {
    /// Number of elements; at least one is made.
    pub elements: usize,
    /// Position of the first node, m.
    pub start: [f64; 3],
    /// Position of the last node, m.
    pub end: [f64; 3],
    /// Rotation of the section about the axis from its default position, rad. By default the local z axis lies in the
    /// plane of the beam and the global z axis (global y for a beam along z).
    pub roll: f64,
    /// Section.
    pub section: BeamSection,
    /// Material.
    pub material: Material,
    /// Kinematics.
    pub theory: BeamTheory,
    /// Mass distribution.
    pub mass: BeamMass,
}

impl Default for SpatialBeam {
    /// A steel Euler–Bernoulli beam along x: 1 m, 20 mm × 30 mm, 8 elements, consistent mass.
    fn default() -> Self {
        Self {
            elements: 8,
            start: [0.0; 3],
            end: [1.0, 0.0, 0.0],
            roll: 0.0,
            section: BeamSection::rectangle(0.02, 0.03),
            material: Material::STEEL,
            theory: BeamTheory::EulerBernoulli,
            mass: BeamMass::Consistent,
        }
    }
}

type Element = SMatrix<f64, 12, 12>;
type Rows = SMatrix<f64, 3, 12>;

/// Component masses in the order of the files: xx, yy, zz, xy, yz, zx.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// The beam with interfaces `a` (first node) and `b` (last node), all six directions each, and exact component masses.
pub fn spatial_beam(beam: &SpatialBeam) -> Component {
    let elements = beam.elements.max(1);
    let node_count = elements + 1;
    let start = Vector3::from(beam.start);
    let span = Vector3::from(beam.end) - start;
    let h = span.norm() / elements as f64;
    let axes = local_axes(&span, beam.roll);

    let mut to_local = Element::zeros();
    for block in 0..4 {
        to_local
            .fixed_view_mut::<3, 3>(3 * block, 3 * block)
            .copy_from(&axes.transpose());
    }
    let stiffness_element = to_local.transpose() * stiffness_local(h, beam) * to_local;
    let mass_elements = PAIRS.map(|(c, d)| match beam.mass {
        BeamMass::Consistent => consistent_mass(h, beam, &axes, &to_local, c, d),
        BeamMass::LumpedTranslations => lumped_mass(h, beam, c, d),
        BeamMass::LumpedWithRoll => lumped_mass(h, beam, c, d) + lumped_roll(h, beam, &axes, c, d),
    });
    let mass_element = mass_elements[0] + mass_elements[1] + mass_elements[2];

    let mesh = Mesh {
        dimension: Dimension::Spatial,
        coordinates: (0..node_count)
            .flat_map(|node| <[f64; 3]>::from(start + span * (node as f64 / elements as f64)))
            .collect(),
        cells: vec![CellBlock {
            cell_type: "line".into(),
            nodes_per_cell: 2,
            nodes: (0..elements as u32).flat_map(|e| [e, e + 1]).collect(),
        }],
        point_sets: BTreeMap::from([("a".into(), vec![0]), ("b".into(), vec![elements as u32])]),
    };
    let dofs = uniform_dofs(node_count, &Direction::ALL);
    let interfaces = vec![
        nodes_interface("a", vec![0], &Direction::ALL),
        nodes_interface("b", vec![elements as u32], &Direction::ALL),
    ];
    let stiffness = chain(elements, &symmetrised(stiffness_element));
    let mass = chain(elements, &symmetrised(mass_element));
    let masses = PAIRS.iter().zip(mass_elements).map(|(&(c, d), element)| {
        chain(
            elements,
            &if c == d {
                symmetrised(element)
            } else {
                element
            },
        )
    });
    checked(ComponentDraft {
        component_masses: Some(ComponentMasses {
            matrices: masses.collect(),
        }),
        ..draft("spatial-beam", mesh, dofs, stiffness, mass, interfaces)
    })
}

/// Columns are the local axes in global coordinates.
fn local_axes(span: &Vector3<f64>, roll: f64) -> Matrix3<f64> {
    let x = span.normalize();
    let up = if x.x.hypot(x.y) > 1e-6 {
        Vector3::z()
    } else {
        Vector3::y()
    };
    let y = up.cross(&x).normalize();
    let z = x.cross(&y);
    let axes = Matrix3::from_columns(&[x, y, z]);
    if roll == 0.0 {
        axes
    } else {
        axes * Rotation3::from_axis_angle(&Vector3::x_axis(), roll).matrix()
    }
}

/// Shear parameters `12 E I / (k G A h²)` of bending in x–y and x–z; zero without shear.
fn shear_parameters(h: f64, beam: &SpatialBeam) -> (f64, f64) {
    let section = &beam.section;
    let (_, mu) = beam.material.lame();
    let of = |second_moment: f64| match beam.theory {
        BeamTheory::EulerBernoulli => 0.0,
        BeamTheory::Timoshenko => {
            12.0 * beam.material.youngs_modulus * second_moment
                / (section.shear_factor * mu * section.area * h * h)
        }
    };
    (of(section.second_moment_z), of(section.second_moment_y))
}

fn stiffness_local(h: f64, beam: &SpatialBeam) -> Element {
    let section = &beam.section;
    let e = beam.material.youngs_modulus;
    let (_, mu) = beam.material.lame();
    let mut k = Element::zeros();
    let mut pair = |dof: usize, value: f64| {
        k[(dof, dof)] += value;
        k[(dof + 6, dof + 6)] += value;
        k[(dof, dof + 6)] -= value;
        k[(dof + 6, dof)] -= value;
    };
    pair(0, e * section.area / h);
    pair(3, mu * section.torsion_constant / h);
    let (phi_y, phi_z) = shear_parameters(h, beam);
    // Bending in x–y uses v and rz; in x–z it uses w and ry with the opposite sign of rotation.
    bending(
        &mut k,
        [1, 5, 7, 11],
        1.0,
        e * section.second_moment_z,
        phi_y,
        h,
    );
    bending(
        &mut k,
        [2, 4, 8, 10],
        -1.0,
        e * section.second_moment_y,
        phi_z,
        h,
    );
    k
}

fn bending(k: &mut Element, dofs: [usize; 4], sign: f64, rigidity: f64, phi: f64, h: f64) {
    let b = rigidity / (h.powi(3) * (1.0 + phi));
    let s = sign * h;
    let local = [
        [12.0, 6.0 * s, -12.0, 6.0 * s],
        [6.0 * s, (4.0 + phi) * h * h, -6.0 * s, (2.0 - phi) * h * h],
        [-12.0, -6.0 * s, 12.0, -6.0 * s],
        [6.0 * s, (2.0 - phi) * h * h, -6.0 * s, (4.0 + phi) * h * h],
    ];
    for (i, row) in local.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            k[(dofs[i], dofs[j])] += b * value;
        }
    }
}

/// Displacement `u` and rotation `θ` of the section at `s` in (0, 1), as rows over the 12 local dofs.
fn shape_rows(h: f64, s: f64, beam: &SpatialBeam) -> (Rows, Rows) {
    let (mut u, mut theta) = (Rows::zeros(), Rows::zeros());
    for (axis, target) in [&mut u, &mut theta].into_iter().enumerate() {
        // Axial displacement and twist are linear.
        target[(0, 3 * axis)] = 1.0 - s;
        target[(0, 3 * axis + 6)] = s;
    }
    let (phi_y, phi_z) = shear_parameters(h, beam);
    for (row, dofs, sign, phi) in [
        (1, [1, 5, 7, 11], 1.0, phi_y),
        (2, [2, 4, 8, 10], -1.0, phi_z),
    ] {
        let (deflection, rotation) = timoshenko_functions(h, s, phi);
        for (at, &dof) in dofs.iter().enumerate() {
            let flip = if at % 2 == 1 { sign } else { 1.0 };
            u[(row, dof)] = flip * deflection[at];
            theta[(3 - row, dof)] = sign * flip * rotation[at];
        }
    }
    (u, theta)
}

/// Deflection and section rotation for unit `v1, θ1, v2, θ2` (cubic and quadratic; Hermite when `phi` is zero).
fn timoshenko_functions(h: f64, s: f64, phi: f64) -> ([f64; 4], [f64; 4]) {
    let (s2, s3, d) = (s * s, s * s * s, 1.0 / (1.0 + phi));
    let deflection = [
        d * (1.0 - 3.0 * s2 + 2.0 * s3 + phi * (1.0 - s)),
        d * h * (s - 2.0 * s2 + s3 + phi / 2.0 * (s - s2)),
        d * (3.0 * s2 - 2.0 * s3 + phi * s),
        d * h * (-s2 + s3 + phi / 2.0 * (s2 - s)),
    ];
    let rotation = [
        d * 6.0 / h * (s2 - s),
        d * (1.0 - 4.0 * s + 3.0 * s2 + phi * (1.0 - s)),
        d * 6.0 / h * (s - s2),
        d * (3.0 * s2 - 2.0 * s + phi * s),
    ];
    (deflection, rotation)
}

/// `M_cd = ∫ ρ N_cᵀ N_d dV` in component axes.
fn consistent_mass(
    h: f64,
    beam: &SpatialBeam,
    axes: &Matrix3<f64>,
    to_local: &Element,
    c: usize,
    d: usize,
) -> Element {
    let section = &beam.section;
    let mut mass = Element::zeros();
    for (s, weight) in GAUSS_4 {
        let (u, mut theta) = shape_rows(h, s, beam);
        if beam.theory == BeamTheory::EulerBernoulli {
            theta.row_mut(1).fill(0.0);
            theta.row_mut(2).fill(0.0);
        }
        // θ × (0, y, z) = y (-θz, 0, θx) + z (θy, -θx, 0)
        let zero = SMatrix::<f64, 1, 12>::zeros();
        let per_y = Rows::from_rows(&[-theta.row(2), zero, theta.row(0).into()]);
        let per_z = Rows::from_rows(&[theta.row(1).into(), -theta.row(0), zero]);
        let factor = weight * h * beam.material.density;
        for (rows, moment) in [
            (u, section.area),
            (per_y, section.second_moment_z),
            (per_z, section.second_moment_y),
        ] {
            let global = axes * rows * to_local;
            mass += global.row(c).transpose() * global.row(d) * (factor * moment);
        }
    }
    mass
}

fn lumped_mass(h: f64, beam: &SpatialBeam, c: usize, d: usize) -> Element {
    let half = 0.5 * h * beam.section.area * beam.material.density;
    let mut mass = Element::zeros();
    mass[(c, d)] = half;
    mass[(c + 6, d + 6)] = half;
    mass
}

/// The section's points move with θ · (0, -z, y) in local axes when a node turns by θ about the beam's axis.
fn lumped_roll(h: f64, beam: &SpatialBeam, axes: &Matrix3<f64>, c: usize, d: usize) -> Element {
    let section = &beam.section;
    let inertia = 0.5
        * h
        * beam.material.density
        * (section.second_moment_y * axes[(c, 1)] * axes[(d, 1)]
            + section.second_moment_z * axes[(c, 2)] * axes[(d, 2)]);
    let about_axis = axes.column(0) * axes.column(0).transpose() * inertia;
    let mut mass = Element::zeros();
    for node in [3, 9] {
        mass.fixed_view_mut::<3, 3>(node, node)
            .copy_from(&about_axis);
    }
    mass
}

fn symmetrised(element: Element) -> Element {
    Element::from_fn(|i, j| element[(i.min(j), i.max(j))])
}

fn chain(elements: usize, element: &Element) -> SparseMatrix {
    let mut assembly = Assembly::new(6 * (elements + 1));
    for e in 0..elements {
        for i in 0..12 {
            for j in 0..12 {
                assembly.add(6 * e + i, 6 * e + j, element[(i, j)]);
            }
        }
    }
    assembly.finish()
}
