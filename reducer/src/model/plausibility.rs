//! Warnings for numbers that hint at mixed units. Nothing here refuses anything: exotic parts exist.

use dcb_formats::component::{Component, Units};
use dcb_formats::mesh::Dimension;
use dcb_formats::units::si_factor;
use dcb_sparse::block_algebra::symmetric_product;
use faer::Mat;

use crate::model::frame::{box_sides, part_size};
use crate::model::rigid_body::MassProperties;

/// Densities of what parts are made of lie in here, kg/m³ (foams to osmium), over the part's bounding box.
const DENSITY: (f64, f64) = (0.05, 23_000.0);
/// Twice the first frequency times the part's length is a wave speed: below that of sound in diamond, m/s.
const FASTEST_WAVE: f64 = 20_000.0;
/// And above that of the most slender structures, m/s.
const SLOWEST_WAVE: f64 = 1e-3;
/// Materials carry pressure waves at 500 m/s (soft plastics) to 18 000 m/s (diamond); steel at 6000 m/s. A
/// factor of 1000 in stiffness or mass, which is one of 32 in speed, must leave the band: hence not lower.
const SLOWEST_MATERIAL: f64 = 300.0;
/// Nodal rotations that stay zero stiffen beams with elements shorter than their sections are high.
const FASTEST_WITH_ROTATIONS: f64 = 40_000.0;
/// Sides of the box shorter than this fraction of the longest say little: curved shells and frames hardly strain there.
const SHORT_SIDE: f64 = 0.1;

/// Implausible combinations of mass, size, stiffness and first frequency.
pub fn unit_warnings(
    component: &Component,
    properties: &MassProperties,
    first_eigenvalue: Option<f64>,
) -> Vec<String> {
    let Units { length, mass, time } = &component.units;
    let (Some(metre), Some(kilogram), Some(second)) =
        (si_factor(length), si_factor(mass), si_factor(time))
    else {
        return vec![format!(
            "units {length}, {mass}, {time} are not all known by name, so they were not checked for plausibility"
        )];
    };
    let mut warnings = Vec::new();
    if component.dimension() == Dimension::Spatial {
        let volume = bounding_volume(component) * metre.powi(3);
        let density = properties.mass * kilogram / volume;
        // Parts without thickness (beams, flat shells) have no box to compare with.
        if volume > 0.0 && density > DENSITY.1 {
            warnings.push(format!(
                "a mass of {:.4e} {mass} in a box of {volume:.3e} m³ is {density:.1e} kg/m³, denser than any material: mixed units?",
                properties.mass
            ));
        } else if volume > 0.0 && density < DENSITY.0 {
            warnings.push(format!(
                "a mass of {:.4e} {mass} in a box of {volume:.3e} m³ is {density:.1e} kg/m³, lighter than a foam: mixed units?",
                properties.mass
            ));
        }
    }
    // One mix-up, one message.
    if !warnings.is_empty() {
        return warnings;
    }
    if let Some((slowest, fastest)) = material_speeds(component, properties) {
        let (slowest, fastest) = (slowest * metre / second, fastest * metre / second);
        let limit = match component.dofs.has_rotations() {
            true => FASTEST_WITH_ROTATIONS,
            false => FASTEST_WAVE,
        };
        let outside = if fastest < SLOWEST_MATERIAL {
            Some((fastest, "slower"))
        } else if slowest > limit {
            Some((slowest, "faster"))
        } else {
            None
        };
        if let Some((speed, than)) = outside {
            warnings.push(format!(
                "stiffness, mass and coordinates make a material with a wave speed of {speed:.1e} m/s, {than} than what parts are made of (steel: 6e3 m/s): mixed units?"
            ));
            return warnings;
        }
    }
    if let Some(eigenvalue) = first_eigenvalue.filter(|value| *value > 0.0) {
        let hertz = eigenvalue.sqrt() / (2.0 * std::f64::consts::PI * second);
        let wave = 2.0 * hertz * part_size(component) * metre;
        if !(SLOWEST_WAVE..=FASTEST_WAVE).contains(&wave) {
            warnings.push(format!(
                "a first frequency of {hertz:.3e} Hz for a part of {:.3e} m is a wave speed of {wave:.1e} m/s, which no material has: mixed units?",
                part_size(component) * metre
            ));
        }
    }
    warnings
}

/// Lowest and highest pressure wave speed over the axes, in the component's units, from unit strain along each of them:
/// u = x - x₀ stores uᵀKu = ∫ C dV, and the mass is ∫ ρ dV. Exact for homogeneous solids of any shape. A free part does
/// not see x₀; for a held one it is where the energy is least.
fn material_speeds(component: &Component, properties: &MassProperties) -> Option<(f64, f64)> {
    let sides = box_sides(component);
    let longest = sides.iter().copied().fold(0.0, f64::max);
    let axes = component.dimension().coordinate_count();
    let mut fields = Mat::zeros(component.dofs.len(), 2 * axes);
    for (row, dof) in component.dofs.nodal() {
        if !dof.direction.is_rotation() {
            let axis = dof.direction.axis();
            fields[(row, axis)] = 1.0;
            fields[(row, axes + axis)] =
                component.mesh.position(dof.node)[axis] - properties.centre[axis];
        }
    }
    let forces = symmetric_product(&component.stiffness, fields.as_ref());
    let energy = |i: usize, j: usize| -> f64 {
        (0..fields.nrows())
            .map(|row| fields[(row, i)] * forces[(row, j)])
            .sum()
    };
    let mut range: Option<(f64, f64)> = None;
    for axis in (0..axes).filter(|axis| sides[*axis] > SHORT_SIDE * longest) {
        let mut strained = energy(axes + axis, axes + axis);
        let moved = energy(axis, axis);
        if moved * longest.powi(2) > 1e-9 * strained {
            strained -= energy(axis, axes + axis).powi(2) / moved;
        }
        let speed = (strained / properties.mass).sqrt();
        if speed > 0.0 && speed.is_finite() {
            let (low, high) = range.unwrap_or((speed, speed));
            range = Some((low.min(speed), high.max(speed)));
        }
    }
    range
}

fn bounding_volume(component: &Component) -> f64 {
    let sides = box_sides(component);
    let longest = sides.iter().copied().fold(0.0, f64::max);
    if sides.iter().any(|side| *side < 1e-6 * longest) {
        0.0
    } else {
        sides.iter().product()
    }
}
