//! Beam samples against closed forms and the planar reference values.

use std::f64::consts::PI;

use super::*;
use dcb_formats::mesh::Direction;
use dcb_samples::spatial_beam::{BeamMass, BeamSection, BeamTheory};
use dcb_samples::{Material, RodSection, SpatialBeam, planar_rod, spatial_beam};

#[test]
fn planar_rod_has_the_reference_frequencies() {
    let reference = reference("ref_planar.json");
    for (elements, values) in reference["invariants"].as_object().unwrap() {
        let expected = numbers(&values["omega"]);
        let computed = elastic_omegas(&planar_rod(
            elements.parse().unwrap(),
            &RodSection::default(),
        ));
        assert!(expected.len() <= computed.len());
        for (a, b) in computed.iter().zip(&expected) {
            assert!(
                relative(*a, *b) < 1e-9,
                "{elements} elements: {a} against {b}"
            );
        }
    }
}

#[test]
fn planar_rod_at_an_angle_is_the_same_rod() {
    let along = elastic_omegas(&planar_rod(4, &RodSection::default()));
    let turned = planar_rod(
        4,
        &RodSection {
            angle: 0.7,
            ..RodSection::default()
        },
    );
    for (a, b) in elastic_omegas(&turned).iter().zip(&along) {
        assert!(relative(*a, *b) < 1e-10);
    }
    assert!(rigid_defect(&turned) < 1e-15, "{:e}", rigid_defect(&turned));
    assert!(exactly_symmetric(&turned.stiffness) && exactly_symmetric(&turned.mass));
}

#[test]
fn planar_component_masses_sum_to_the_mass_and_give_the_rigid_inertia() {
    let section = RodSection {
        angle: 0.4,
        ..RodSection::default()
    };
    let rod = planar_rod(3, &section);
    let [xx, yy, xy] = rod.component_masses.as_ref().unwrap().matrices.as_slice() else {
        panic!("three")
    };
    let difference = dense(&rod.mass) - dense(xx) - dense(yy);
    assert!(
        difference.norm_max() < 1e-15 * dense(&rod.mass).norm_max(),
        "{:e}",
        difference.norm_max()
    );
    let motions = rigid_motions(&rod);
    let mass = section.density * section.area * section.length;
    let (ct, st) = (section.angle.cos(), section.angle.sin());
    let about_end = mass * section.length.powi(2) / 3.0;
    let spin = &motions[2];
    assert!(relative(form(xx, spin, spin), about_end * st * st) < 1e-13);
    assert!(relative(form(yy, spin, spin), about_end * ct * ct) < 1e-13);
    // ∫ρ (-y)(x)
    assert!(relative(form(xy, spin, spin), -about_end * st * ct) < 1e-13);
    assert!(relative(form(xy, &motions[0], &motions[1]), mass) < 1e-13);
    assert!(form(xy, &motions[1], &motions[0]).abs() < 1e-13 * mass);
}

#[test]
fn planar_rod_converges_to_bar_and_beam_theory() {
    let rod = RodSection::default();
    let bar = PI / rod.length * (rod.youngs_modulus / rod.density).sqrt();
    let line_mass = rod.density * rod.area;
    // First root of cosh(x) cos(x) = 1.
    let beam = (4.730_040_744_862_704 / rod.length).powi(2)
        * (rod.youngs_modulus * rod.second_moment / line_mass).sqrt();
    let errors = [8, 16].map(|elements| {
        let omega = elastic_omegas(&planar_rod(elements, &rod));
        (
            relative(nearest(&omega, bar), bar),
            relative(omega[0], beam),
        )
    });
    for pair in errors.windows(2) {
        let (bar_order, beam_order) = (
            (pair[0].0 / pair[1].0).log2(),
            (pair[0].1 / pair[1].1).log2(),
        );
        assert!((bar_order - 2.0).abs() < 0.1, "axial order {bar_order}");
        assert!((beam_order - 4.0).abs() < 0.2, "bending order {beam_order}");
    }
    assert!(errors[1].1 < 1e-5);
}

fn tilted(theory: BeamTheory) -> SpatialBeam {
    SpatialBeam {
        start: [0.1, -0.2, 0.3],
        end: [0.7, 0.5, 0.9],
        roll: 0.6,
        theory,
        ..SpatialBeam::default()
    }
}

#[test]
fn spatial_beam_does_not_resist_rigid_motion_in_any_direction() {
    for theory in [BeamTheory::EulerBernoulli, BeamTheory::Timoshenko] {
        let beam = spatial_beam(&tilted(theory));
        assert!(rigid_defect(&beam) < 1e-14, "{:e}", rigid_defect(&beam));
        assert!(exactly_symmetric(&beam.stiffness) && exactly_symmetric(&beam.mass));
    }
}

#[test]
fn spatial_beam_frequencies_do_not_depend_on_direction() {
    let tilted = tilted(BeamTheory::Timoshenko);
    let length = (0..3)
        .map(|i| (tilted.end[i] - tilted.start[i]).powi(2))
        .sum::<f64>()
        .sqrt();
    let straight = SpatialBeam {
        start: [0.0; 3],
        end: [0.0, 0.0, length],
        roll: 0.0,
        ..tilted
    };
    let (a, b) = (
        elastic_omegas(&spatial_beam(&tilted)),
        elastic_omegas(&spatial_beam(&straight)),
    );
    for (a, b) in a.iter().zip(&b) {
        assert!(relative(*a, *b) < 1e-9, "{a} against {b}");
    }
}

#[test]
fn spatial_beam_bends_stretches_and_twists_as_theory_says() {
    let beam = SpatialBeam {
        elements: 16,
        ..SpatialBeam::default()
    };
    let omega = elastic_omegas(&spatial_beam(&beam));
    let (section, material) = (beam.section, beam.material);
    let (_, mu) = material.lame();
    let bending = |second_moment: f64| {
        4.730_040_744_862_704_f64.powi(2)
            * (material.youngs_modulus * second_moment / (material.density * section.area)).sqrt()
    };
    let polar = section.second_moment_y + section.second_moment_z;
    let twist = PI * (mu * section.torsion_constant / (material.density * polar)).sqrt();
    let stretch = PI * (material.youngs_modulus / material.density).sqrt();
    for (exact, tolerance) in [
        (bending(section.second_moment_y), 1e-5),
        (bending(section.second_moment_z), 1e-5),
        (twist, 2e-3),
        (stretch, 2e-3),
    ] {
        let found = nearest(&omega, exact);
        assert!(
            relative(found, exact) < tolerance,
            "{found} against {exact}"
        );
    }
}

#[test]
fn simply_supported_timoshenko_beam_has_the_closed_form_frequencies() {
    let section = BeamSection::rectangle(0.1, 0.2);
    let errors = [8, 16].map(|elements| {
        let beam = SpatialBeam {
            elements,
            section,
            theory: BeamTheory::Timoshenko,
            ..SpatialBeam::default()
        };
        let component = spatial_beam(&beam);
        // Bending in x–z only: uz free except at the ends, ry free.
        let end = elements as u32;
        let (k, m) = held(&component, |node, direction| match direction {
            Direction::Uz => node == 0 || node == end,
            Direction::Ry => false,
            _ => true,
        });
        let (e, rho) = (beam.material.youngs_modulus, beam.material.density);
        let (_, mu) = beam.material.lame();
        let shear = section.shear_factor * mu;
        let (area, moment, wave) = (section.area, section.second_moment_y, PI);
        // EI k⁴ - (ρA + ρI (1 + E/κG) k²) ω² + ρ²I/κG ω⁴ = 0
        let (c0, c1, c2) = (
            e * moment * wave.powi(4),
            rho * area + rho * moment * (1.0 + e / shear) * wave * wave,
            rho * rho * moment / shear,
        );
        let exact = 2.0 * c0 / (c1 + (c1 * c1 - 4.0 * c0 * c2).sqrt());
        relative(omega_squared(&k, &m)[0], exact)
    });
    assert!(
        errors[1] < 4e-4 && errors[1] < errors[0] / 3.5,
        "{errors:?}"
    );
}

#[test]
fn spatial_component_masses_are_consistent() {
    for theory in [BeamTheory::EulerBernoulli, BeamTheory::Timoshenko] {
        let beam = tilted(theory);
        let component = spatial_beam(&beam);
        let masses = &component.component_masses.as_ref().unwrap().matrices;
        let sum = dense(&masses[0]) + dense(&masses[1]) + dense(&masses[2]);
        let difference = dense(&component.mass) - sum;
        assert!(difference.norm_max() < 1e-15 * dense(&component.mass).norm_max());
        // Products of inertia of a line: ∫ρ x_a x_b, from rigid rotation about z: u = (-y, x, 0).
        let motions = rigid_motions(&component);
        let total = form(&component.mass, &motions[0], &motions[0]);
        assert!(relative(form(&masses[3], &motions[0], &motions[1]), total) < 1e-13);
        assert!(relative(form(&masses[4], &motions[1], &motions[2]), total) < 1e-13);
        assert!(relative(form(&masses[5], &motions[2], &motions[0]), total) < 1e-13);
    }
}

#[test]
fn timoshenko_beam_has_the_inertia_of_a_solid_bar() {
    let (width, height) = (0.02, 0.03);
    let beam = SpatialBeam {
        section: BeamSection::rectangle(width, height),
        theory: BeamTheory::Timoshenko,
        ..SpatialBeam::default()
    };
    let component = spatial_beam(&beam);
    let motions = rigid_motions(&component);
    let mass = beam.material.density * width * height;
    let expected = [
        mass * (width * width + height * height) / 12.0,
        mass * (1.0 / 3.0 + height * height / 12.0),
        mass * (1.0 / 3.0 + width * width / 12.0),
    ];
    for (spin, expected) in motions[3..].iter().zip(expected) {
        assert!(relative(form(&component.mass, spin, spin), expected) < 1e-12);
    }
}

#[test]
fn lumped_beam_has_massless_rotations_and_the_whole_mass() {
    let beam = SpatialBeam {
        mass: BeamMass::LumpedTranslations,
        ..SpatialBeam::default()
    };
    let component = spatial_beam(&beam);
    let motions = rigid_motions(&component);
    let expected = Material::STEEL.density * beam.section.area;
    assert!(relative(form(&component.mass, &motions[2], &motions[2]), expected) < 1e-13);
    let massless = (0..component.dofs.len())
        .filter(|&row| component.mass.col_ptr()[row] == component.mass.col_ptr()[row + 1]);
    assert_eq!(massless.count(), component.dofs.len() / 2);
}

#[test]
fn lumped_beam_with_roll_has_the_inertia_about_its_axis_and_massless_bending_rotations() {
    let beam = SpatialBeam {
        mass: BeamMass::LumpedWithRoll,
        ..SpatialBeam::default()
    };
    let component = spatial_beam(&beam);
    let motions = rigid_motions(&component);
    let section = &beam.section;
    let polar = section.second_moment_y + section.second_moment_z;
    for (motion, moment) in [(2, section.area), (3, polar)] {
        let expected = Material::STEEL.density * moment;
        let found = form(&component.mass, &motions[motion], &motions[motion]);
        assert!(relative(found, expected) < 1e-13, "{motion}");
    }
    let massless = (0..component.dofs.len())
        .filter(|&row| component.mass.col_ptr()[row] == component.mass.col_ptr()[row + 1]);
    assert_eq!(massless.count(), component.dofs.len() / 3);
    // Skew: the component masses still add up to the mass.
    let skew = spatial_beam(&SpatialBeam {
        end: [0.3, 0.5, 0.7],
        roll: 0.4,
        ..beam
    });
    let masses = &skew.component_masses.as_ref().unwrap().matrices;
    for motion in rigid_motions(&skew) {
        let sum: f64 = masses[..3].iter().map(|m| form(m, &motion, &motion)).sum();
        assert!(relative(sum, form(&skew.mass, &motion, &motion)) < 1e-12);
    }
}
