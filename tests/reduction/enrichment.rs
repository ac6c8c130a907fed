//! Further columns of the basis against dense algebra: what they answer to, that modes and interfaces don't answer to it already, and what
//! they change at runtime.

use std::sync::Arc;

use dcb_formats::Component;
use dcb_formats::component::NamedLoad;
use dcb_formats::mesh::{Dimension, Direction};
use dcb_formats::{Function, TimeFunction};
use dcb_reducer::{EnrichmentSource, Reduced, Reduction, reduce};
use dcb_runtime::analysis::equilibrium::{EquilibriumSettings, find_equilibrium};
use dcb_runtime::joint::{Fixed, JointKind};
use dcb_runtime::system::Signal;
use dcb_runtime::system::builder::{Drawn, SystemBuilder, Turning};
use dcb_runtime::system::evaluation::Evaluation;
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::{PseudoRandom, RodSection, SolidElement, UnitScale, in_units, planar_rod};
use dcb_tests::dense::{dense, largest, relative, solve};
use dcb_tests::mechanism::method;
use dcb_tests::oracle::{Oracle, centre_of_mass};
use dcb_tests::parts::{skew_beam, steel_box};
use dcb_tests::rod::deflection::{apart, history};
use dcb_tests::rod::reduced::{Benchmark, ReducedRod};
use dcb_tests::{assert_says, with};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

fn enriched(modes: usize, sources: &[EnrichmentSource]) -> Reduction {
    Reduction {
        enrichment: sources.to_vec(),
        ..Reduction::lowest(modes)
    }
}

fn plate() -> Component {
    steel_box([6, 4, 1], SolidElement::Hexahedron20)
}

/// f = M (ω² r - ω (ω·r)) over the nodes of a solid.
fn centrifugal(component: &Component, spin: Vector3<f64>) -> Mat<f64> {
    let (_, centre) = centre_of_mass(component);
    let field = Mat::from_fn(component.dofs.len(), 1, |row, _| {
        let dof = component.dofs.dof(row).unwrap();
        let r = Vector3::from(component.mesh.position(dof.node)) - Vector3::from(centre);
        let pull = (Matrix3::identity() * spin.norm_squared() - spin * spin.transpose()) * r;
        pull[dof.direction.axis()]
    });
    dense(&component.mass) * field
}

/// Static deflection under the centrifugal force of a spin by the reduced basis: forces from I1, stiffness of the basis.
fn reduced_deflection(reduced: &Reduced, spin: Vector3<f64>) -> Mat<f64> {
    let element = &reduced.superelement;
    let body = FlexibleBody::from_superelement(element, Compatibility::Strong).unwrap();
    let mut original = vec![0.0; body.original_coordinate_count()];
    let n = body.coordinate_count();
    let mut terms = dcb_runtime::InertiaTerms::for_coordinates(n);
    let zeros = vec![0.0; n];
    body.inertia.evaluate(&zeros, &spin, &zeros, &mut terms);
    let y: Vec<f64> = terms
        .force
        .iter()
        .zip(&body.stiffness)
        .map(|(force, stiffness)| force / stiffness)
        .collect();
    body.original_coordinates(&y, &mut original);
    let recovery = &reduced.recovery;
    let blocks = [
        Some(&recovery.modes),
        Some(&recovery.residual),
        recovery.enrichment.as_ref(),
    ];
    let mut field = Mat::zeros(recovery.modes.nrows(), 1);
    let mut amplitudes = original.iter();
    for block in blocks.into_iter().flatten() {
        for column in block.col_iter() {
            let amplitude = amplitudes.next().unwrap();
            for (i, shape) in column.iter().enumerate() {
                field[(i, 0)] += amplitude * shape;
            }
        }
    }
    field
}

/// A body that spins steadily deflects as the whole part does, at every node; without the columns, twice the modes don't help.
#[test]
fn a_steady_spin_is_exact_with_the_columns_and_not_without() {
    let part = plate();
    let oracle = Oracle::of(&part);
    for spin in [
        Vector3::new(0.0, 0.0, 300.0),
        Vector3::new(120.0, -200.0, 150.0),
    ] {
        let exact = &oracle.inverse * centrifugal(&part, spin);
        let error = |options: &Reduction| {
            let found = reduced_deflection(&with(&part, options), spin);
            largest((&found - &exact).as_ref()) / largest(exact.as_ref())
        };
        let (few, many) = (error(&enriched(20, &[])), error(&enriched(40, &[])));
        let columns = error(&enriched(16, &[EnrichmentSource::Spin]));
        println!("20 modes {few:.1e}, 40 modes {many:.1e}, 16 modes and the columns {columns:.1e}");
        assert!(columns < 1e-9);
        assert!(few > 1e-3 && many > 1e-4);
    }
}

/// K X = s P' f with f by loops over the nodes, in the complement of the modes; the first invariants of the columns are their work.
#[test]
fn columns_answer_to_centrifugal_forces() {
    let part = plate();
    let oracle = Oracle::of(&part);
    let reduced = with(&part, &enriched(6, &[EnrichmentSource::Spin]));
    let fields = reduced.recovery.enrichment.as_ref().unwrap();
    let names = &reduced.superelement.enrichment.as_ref().unwrap().names;
    assert_eq!(names.len(), 6);
    let (mass, stiffness) = (dense(&part.mass), dense(&part.stiffness));
    let kept = oracle.shapes.as_ref().subcols(0, 6).to_owned();
    for (j, name) in names.iter().enumerate() {
        let axis = |at: usize| "xyz".find(name.as_bytes()[5 + at] as char).unwrap();
        let (a, b) = (axis(0), axis(1));
        let (_, centre) = centre_of_mass(&part);
        let field = Mat::from_fn(part.dofs.len(), 1, |row, _| {
            let dof = part.dofs.dof(row).unwrap();
            let r = part.mesh.position(dof.node);
            let of = |c: usize, d: usize| match dof.direction.axis() == c {
                true => r[d] - centre[d],
                false => 0.0,
            };
            if a == b {
                of(a, a)
            } else {
                of(a, b) + of(b, a)
            }
        });
        let whole = &oracle.inverse * (&mass * field);
        // Without the kept modes' part.
        let expected = &whole - &kept * (kept.transpose() * (&mass * &whole));
        let norm = (whole.transpose() * &mass * &whole)[(0, 0)].sqrt();
        let found = fields.as_ref().subcols(j, 1);
        let difference = found - faer::Scale(1.0 / norm) * &expected;
        assert!(
            largest(difference.as_ref()) < 1e-9 * largest(found),
            "{name}: {:e}",
            largest(difference.as_ref()) / largest(found)
        );
        let balance = kept.transpose() * (&stiffness * found);
        let size = largest((&stiffness * found).as_ref()) * largest(kept.as_ref());
        assert!(largest(balance.as_ref()) < 1e-9 * size);
    }
    let element = &reduced.superelement;
    let further = element.enrichment.as_ref().unwrap();
    // Ψᵀ M Ψ and Ψᵀ K Ψ over everything, dense.
    let basis = {
        let (phi, x) = (&reduced.recovery.modes, &reduced.recovery.residual);
        Mat::from_fn(phi.nrows(), element.basis_count(), |i, j| match j {
            _ if j < phi.ncols() => phi[(i, j)],
            _ if j < phi.ncols() + x.ncols() => x[(i, j - phi.ncols())],
            _ => fields[(i, j - phi.ncols() - x.ncols())],
        })
    };
    for (what, found, expected) in [
        (
            "mass",
            &further.reduced_mass,
            basis.transpose() * &mass * &basis,
        ),
        (
            "stiffness",
            &further.reduced_stiffness,
            basis.transpose() * &stiffness * &basis,
        ),
    ] {
        for j in 0..expected.ncols() {
            for i in 0..expected.nrows() {
                let size = (expected[(i, i)] * expected[(j, j)]).sqrt();
                let difference = (found[(i, j)] - expected[(i, j)]).abs();
                assert!(
                    difference <= 1e-8 * size,
                    "{what} {i} {j}: {difference:e} of {size:e}"
                );
            }
        }
    }
}

/// The part with one load.
fn in_the_wind(part: Component, forces: Vec<f64>) -> Component {
    let name = "wind".into();
    part.changed(|draft| draft.loads = vec![NamedLoad { name, forces }])
        .unwrap()
}

/// A load inside the part: its static response is in the basis, and its name in the file.
#[test]
fn named_loads_are_exact_statically() {
    let mut random = PseudoRandom::new(11);
    let part = plate();
    let forces: Vec<f64> = (0..part.dofs.len()).map(|_| random.number()).collect();
    let part = in_the_wind(part, forces.clone());
    let oracle = Oracle::of(&part);
    let f = Mat::from_fn(forces.len(), 1, |i, _| forces[i]);
    let exact = &oracle.inverse * &f;
    let reduced = with(&part, &enriched(8, &[EnrichmentSource::Loads]));
    let (phi, x) = (
        &reduced.recovery.modes,
        reduced.recovery.enrichment.as_ref(),
    );
    let further = reduced.superelement.enrichment.as_ref().unwrap();
    assert_eq!(further.names, ["load wind"]);
    let x = x.unwrap();
    let last = reduced.superelement.basis_count() - 1;
    let amount = (x.transpose() * &f)[(0, 0)] / further.reduced_stiffness[(last, last)];
    let eigenvalues = &reduced.superelement.modes.eigenvalues;
    let modal = phi.transpose() * &f;
    let found = Mat::from_fn(forces.len(), 1, |i, _| {
        amount * x[(i, 0)]
            + (0..phi.ncols())
                .map(|k| phi[(i, k)] * modal[(k, 0)] / eigenvalues[k])
                .sum::<f64>()
    });
    assert!(largest((&found - &exact).as_ref()) < 1e-9 * largest(exact.as_ref()));
    // Without the file there is nothing to enrich with.
    let part = part.changed(|draft| draft.loads.clear()).unwrap();
    let message = reduce(&part, &enriched(8, &[EnrichmentSource::Loads]), &mut ())
        .unwrap_err()
        .to_string();
    assert_says(&message, &["load", "PART.load.NAME.mtx"]);
}

/// Beams: the forces come from the component masses. A straight one can't feel what pulls across it.
#[test]
fn a_beam_has_the_patterns_that_pull_along_it() {
    let reduced = with(&skew_beam(), &enriched(4, &[EnrichmentSource::Spin]));
    let further = reduced.superelement.enrichment.as_ref().unwrap();
    let body =
        FlexibleBody::from_superelement(&reduced.superelement, Compatibility::Strong).unwrap();
    let attached = reduced.superelement.residual.sigma_squared.len();
    println!(
        "{:?}: {} of {}",
        further.names,
        body.coordinate_count(),
        4 + attached
    );
    // All six pull along the axis; what tells them apart is the section's inertia. The reader keeps what is independent.
    let beside = body.coordinate_count() - 4 - attached;
    assert!((1..6).contains(&beside), "{beside}");
    let oracle_stretch = |length: f64, modulus: f64, density: f64, spin: f64| {
        density * spin * spin * length.powi(3) / (12.0 * modulus)
    };
    let section = RodSection::default();
    let rod = with(
        &planar_rod(16, &section),
        &enriched(2, &[EnrichmentSource::Spin]),
    );
    let field = reduced_deflection(&rod, Vector3::new(0.0, 0.0, 400.0));
    let along = |node: u32| {
        let dofs = rod.recovery.dofs.iter();
        let row = dofs
            .clone()
            .position(|dof| dof.node == node && dof.direction == Direction::Ux);
        field[(row.unwrap(), 0)]
    };
    let expected = oracle_stretch(0.3, section.youngs_modulus, section.density, 400.0);
    assert!(((along(16) - along(0)) / expected - 1.0).abs() < 1e-8);
}

/// The second Krylov block follows the interfaces' dynamics further: the slider-crank's rod, 2 modes and no more.
#[test]
fn the_second_krylov_block_brings_the_rod_nearer() {
    let benchmark = Benchmark::first();
    let whole = history(&ReducedRod::new(benchmark, 4, 12), method(0.0), 3600);
    let rod = planar_rod(4, &benchmark.section);
    let error = |sources: &[EnrichmentSource]| {
        let options = enriched(2, sources);
        let rod = ReducedRod::of(benchmark, &rod, &options, Compatibility::Strong);
        apart(&history(&rod, method(0.0), 3600), &whole)
    };
    let (plain, krylov) = (error(&[]), error(&[EnrichmentSource::Krylov]));
    println!("2 modes {plain:.1e}, with the second block {krylov:.1e}");
    assert!(krylov < 1e-4 && krylov < 0.2 * plain);
}

/// What the columns amount to has no unit.
#[test]
fn columns_do_not_depend_on_the_unit_system() {
    let part = plate();
    let scaled = in_units(&part, &UnitScale::mm_t_s());
    let options = enriched(5, &[EnrichmentSource::Spin, EnrichmentSource::Krylov]);
    let frequencies = |component: &Component| {
        let reduced = with(component, &options);
        let element = &reduced.superelement;
        FlexibleBody::from_superelement(element, Compatibility::Strong)
            .unwrap()
            .stiffness
    };
    let (si, other) = (frequencies(&part), frequencies(&scaled));
    assert_eq!(si.len(), other.len());
    assert!(relative(&si, &other) < 1e-8);
}

/// Other choices of compatibility leave the columns out and say so.
#[test]
fn static_compatibility_leaves_the_columns_out() {
    let part = plate();
    let plain = with(&part, &enriched(5, &[])).superelement;
    let with_columns = with(&part, &enriched(5, &[EnrichmentSource::Spin])).superelement;
    let body = |element| {
        Arc::new(FlexibleBody::from_superelement(element, Compatibility::Static).unwrap())
    };
    let (plain, with_columns) = (body(&plain), body(&with_columns));
    assert_eq!(plain.coordinate_count(), with_columns.coordinate_count());
    assert_eq!(plain.stiffness, with_columns.stiffness);
    assert_eq!(with_columns.further_transform.nrows(), 6);
    assert_eq!(part.dimension(), Dimension::Spatial);
}

/// A part that is clamped at one interface, under a load on its inside: displacements of the other interface against a dense solution
/// with the clamp as a constraint.
#[test]
fn a_load_inside_bends_a_clamped_part_as_the_whole_part() {
    let part = plate();
    let forces: Vec<f64> = part
        .dofs
        .nodal_dofs()
        .iter()
        .map(|dof| {
            let [x, y, _] = part.mesh.position(dof.node);
            match dof.direction {
                Direction::Uz => 1e-3 * (x + 0.3 * y),
                Direction::Uy => 2e-3 * x * x,
                _ => 0.0,
            }
        })
        .collect();
    let part = in_the_wind(part, forces.clone());
    let oracle = Oracle::of(&part);
    // [[K, Lᵀ], [L, 0]] with the rows of the left interface.
    let n = forces.len();
    let held = oracle.localization.as_ref().subrows(0, 6);
    let seen = oracle.localization.as_ref().subrows(6, 6);
    let scale = largest(oracle.stiffness.as_ref());
    let matrix = Mat::from_fn(n + 6, n + 6, |i, j| match (i < n, j < n) {
        (true, true) => oracle.stiffness[(i, j)],
        (true, false) => scale * held[(j - n, i)],
        (false, true) => scale * held[(i - n, j)],
        (false, false) => 0.0,
    });
    let right = Mat::from_fn(n + 6, 1, |i, _| if i < n { forces[i] } else { 0.0 });
    let exact = solve(&matrix, &right);
    let exact = seen * exact.as_ref().subrows(0, n);

    let found = |sources: &[EnrichmentSource]| {
        let reduced = with(&part, &enriched(4, sources));
        let body = FlexibleBody::from_superelement(&reduced.superelement, Compatibility::Strong);
        let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
        let body = builder.body("plate", Arc::new(body.unwrap()), &Drawn::default());
        let mut on = |interface| builder.marker(body, interface, Turning::Interface).unwrap();
        let (root, tip) = (on(0), on(1));
        let place = builder.system().markers[root].position;
        let origin = Vector3::from(reduced.superelement.origin);
        let ground = builder.ground(place + origin, Matrix3::identity());
        builder
            .joint("clamp", ground, root, &JointKind::Fixed(Fixed))
            .unwrap();
        let factor = builder.signal(Signal {
            function: TimeFunction::new(&Function::Constant(1.0)).unwrap(),
            input: None,
            offset: 0.0,
        });
        builder.part_load("wind", body, 0, factor);
        let (system, mut state) = builder.finish();
        let mut evaluation = Evaluation::of(&system);
        evaluation.place(&system, &state);
        let before = evaluation.motions[tip].position;
        find_equilibrium(&system, &mut state, &EquilibriumSettings::default()).unwrap();
        evaluation.place(&system, &state);
        evaluation.motions[tip].position - before
    };
    let expected = Vector3::new(exact[(0, 0)], exact[(1, 0)], exact[(2, 0)]);
    let error = |sources: &[EnrichmentSource]| (found(sources) - expected).norm() / expected.norm();
    let (plain, column) = (error(&[]), error(&[EnrichmentSource::Loads]));
    println!("clamped plate under a load inside: {plain:.1e}, with its column {column:.1e}");
    // What is left is the square of the turn, 1e-6 of it.
    assert!(column < 1e-6);
}
