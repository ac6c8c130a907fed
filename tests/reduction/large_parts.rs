//! Hard cases of large parts that a fast factorization must not break: dense rows, double roots, shifts at an eigenvalue, almost all modes
//! kept, bad conditioning. What is found is held against the component's own matrices, closed forms or dense algebra.

use dcb_formats::Component;
use dcb_formats::component::InterfaceKind;
use dcb_reducer::forecast;
use dcb_reducer::model::condensation::Model;
use dcb_reducer::resources::basis_size::BasisSize;
use dcb_reducer::resources::forecast::Forecast;
use dcb_reducer::resources::memory_limit::{FactorChoice, MemoryLimit};
use dcb_reducer::{Reduced, Reduction};
use dcb_samples::spatial_beam::{BeamSection, SpatialBeam, spatial_beam};
use dcb_samples::{Material, SolidElement, box_block};
use dcb_sparse::factor_store::{FactorStorage, Place};
use dcb_sparse::factorization::SymmetricFactor;
use dcb_tests::dense::{diagonal_roots, relative, scaled_difference, times};
use dcb_tests::oracle::Oracle;
use dcb_tests::{lowest, parts, with};
use faer::{Mat, MatRef};

fn modes(reduced: &Reduced) -> (&[f64], MatRef<'_, f64>) {
    (
        &reduced.superelement.modes.eigenvalues,
        reduced.recovery.modes.as_ref(),
    )
}

/// A block with a fine grid of nodes on each end.
fn finely_meshed_block() -> Component {
    let size = [0.06, 0.1, 0.1];
    box_block(
        [4, 34, 34],
        size,
        SolidElement::Hexahedron,
        &Material::STEEL,
    )
}

#[test]
fn a_rigid_interface_of_a_thousand_nodes_does_not_fill_the_factor() {
    let block = finely_meshed_block();
    let face = block.mesh.point_sets["x_max"].clone();
    assert!(face.len() > 1200);
    let free = lowest(&block, 6);
    let component = parts::with_interfaces(
        &block,
        vec![parts::interface("hub", InterfaceKind::Rigid, face.clone())],
    );
    let reduced = lowest(&component, 6);
    // Six rows that couple to a whole layer of nodes: no more than the rows themselves is added.
    let rows = 6 * reduced.work.dofs;
    assert!(
        reduced.work.factor_entries < free.work.factor_entries + rows,
        "{} entries with the interface, {} without",
        reduced.work.factor_entries,
        free.work.factor_entries
    );
    // K φ - ω² M φ has entries at the face alone, where the constraint's forces act, and those have no resultant.
    let (eigenvalues, shapes) = modes(&reduced);
    let (k, m) = (
        times(&component.stiffness, shapes),
        times(&component.mass, shapes),
    );
    let at_face = |row: usize| face.contains(&component.dofs.dof(row).unwrap().node);
    for (j, eigenvalue) in eigenvalues.iter().enumerate() {
        let (mut inside, mut force, mut resultant) = (0.0_f64, 0.0_f64, [0.0; 3]);
        for row in 0..shapes.nrows() {
            let left = k[(row, j)] - eigenvalue * m[(row, j)];
            force += k[(row, j)].powi(2);
            if at_face(row) {
                resultant[component.dofs.dof(row).unwrap().direction.axis()] += left;
            } else {
                inside += left * left;
            }
        }
        let size = force.sqrt();
        assert!(inside.sqrt() < 1e-8 * size, "mode {j}: {inside:e}");
        for sum in resultant {
            assert!(sum.abs() < 1e-7 * size, "mode {j}: {sum:e} of {size:e}");
        }
    }
    // The face moves as one.
    let u = |node: u32, axis: usize, j: usize| shapes[(3 * node as usize + axis, j)];
    for j in 0..eigenvalues.len() {
        for pair in face.windows(2) {
            let (a, b) = (
                component.mesh.position(pair[0]),
                component.mesh.position(pair[1]),
            );
            let stretch: f64 = (0..3)
                .map(|i| (a[i] - b[i]) * (u(pair[0], i, j) - u(pair[1], i, j)))
                .sum();
            assert!(stretch.abs() < 1e-12 * shapes.norm_max(), "{stretch:e}");
        }
    }
}

/// A bar of 1 m and square section, with 10 000 dofs.
fn square_bar() -> Component {
    let size = [1.0, 0.05, 0.05];
    box_block(
        [40, 4, 4],
        size,
        SolidElement::Hexahedron20,
        &Material::STEEL,
    )
}

#[test]
fn every_double_root_of_a_large_square_bar_is_found_twice() {
    let bar = square_bar();
    let reduced = lowest(&bar, 36);
    let (eigenvalues, _) = modes(&reduced);
    assert!(bar.dofs.len() > 10_000 && eigenvalues.len() >= 36);
    let (mut pairs, mut singles, mut at) = (0, Vec::new(), 0);
    while at < eigenvalues.len() {
        let next = eigenvalues.get(at + 1);
        match next.is_some_and(|next| next / eigenvalues[at] - 1.0 < 1e-6) {
            true => {
                // Copies of one root agree to rounding, and no third one is near.
                assert!(eigenvalues[at + 1] / eigenvalues[at] - 1.0 < 1e-9);
                let third = eigenvalues.get(at + 2);
                assert!(third.is_none_or(|third| third / eigenvalues[at] - 1.0 > 1e-6));
                (pairs, at) = (pairs + 1, at + 2);
            }
            false => {
                singles.push(eigenvalues[at].sqrt());
                at += 1;
            }
        }
    }
    assert!(pairs >= 12, "{pairs} pairs");
    // What is single is torsion and tension of a bar: multiples of the lowest of each, within the dispersion of short waves.
    let (e, nu, rho) = (
        Material::STEEL.youngs_modulus,
        Material::STEEL.poisson_ratio,
        Material::STEEL.density,
    );
    let tension = std::f64::consts::PI * (e / rho).sqrt();
    // A square's torsion constant is 0.1406 a⁴, its polar moment a⁴/6.
    let torsion = std::f64::consts::PI * (e / (2.0 * (1.0 + nu)) * 0.1406 * 6.0 / rho).sqrt();
    let multiples = |first: f64| {
        let near = |n: f64| singles.iter().any(|f| (f / (n * first) - 1.0).abs() < 0.01);
        (1..4).filter(|n| near(f64::from(*n))).count()
    };
    assert_eq!((multiples(torsion), multiples(tension)), (3, 3));
}

#[test]
fn a_basis_that_memory_cuts_short_finds_the_same_modes() {
    let bar = square_bar();
    let options = Reduction::lowest(220);
    let roomy = forecast(&bar, options.modes).unwrap();
    let short = Forecast {
        basis: BasisSize::Short,
        ..roomy
    };
    let in_memory = FactorStorage::default();
    let bytes = short.peak_bytes(&in_memory);
    assert!(bytes < roomy.peak_bytes(&in_memory));
    let memory = MemoryLimit {
        bytes: Some(bytes),
        ..MemoryLimit::default()
    };
    // The factor stays in memory for it, until not even that is enough.
    assert_eq!(memory.fitted(roomy), short);
    assert_eq!(memory.choose(&short).unwrap(), in_memory);
    let less = MemoryLimit {
        bytes: Some(bytes - 1),
        ..memory.clone()
    };
    let elsewhere = less.choose(&less.fitted(roomy)).unwrap();
    assert!(matches!(elsewhere.place, Place::Disk { .. }));
    let refused = MemoryLimit {
        factor: FactorChoice::Memory,
        ..less
    };
    let message = refused.choose(&refused.fitted(roomy)).unwrap_err();
    assert!(message.to_string().contains("--factor disk"), "{message}");
    let limited = Reduction {
        memory,
        ..options.clone()
    };
    let short = with(&bar, &limited);
    let roomy = with(&bar, &options);
    assert!(short.quality.iterations.0 > roomy.quality.iterations.0);
    assert!(relative(modes(&short).0, modes(&roomy).0) < 1e-10);
    let f = |reduced: &Reduced| reduced.superelement.residual.flexibility.clone();
    let scale = diagonal_roots(&f(&roomy));
    assert!(scaled_difference(&f(&short), &f(&roomy), &scale) < 1e-9);
}

#[test]
fn a_count_at_an_eigenvalue_is_one_of_its_neighbours_or_says_so() {
    let block = parts::steel_box([8, 4, 3], SolidElement::Hexahedron);
    let oracle = Oracle::of(&block);
    let model = Model::of(&block).unwrap();
    let factor = SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points()).unwrap();
    for (k, eigenvalue) in oracle.eigenvalues.iter().enumerate().step_by(37) {
        let count = |shift: f64| {
            let inertia = factor
                .inertia(&model.stiffness, &model.mass, shift)
                .unwrap();
            (inertia.zero == 0).then_some(inertia.negative)
        };
        // Six rigid motions are below any positive shift. Dense eigenvalues are good to about 1e-13 of the largest.
        let room = 1e-12 * oracle.eigenvalues[oracle.eigenvalues.len() - 1];
        let below = oracle
            .eigenvalues
            .partition_point(|v| *v < eigenvalue - room)
            + 6;
        let above = oracle
            .eigenvalues
            .partition_point(|v| *v <= eigenvalue + room)
            + 6;
        for nudge in [0.0, f64::EPSILON, -f64::EPSILON, 1e-14] {
            let counted = count(eigenvalue * (1.0 + nudge));
            assert!(
                counted.is_none_or(|counted| (below..=above).contains(&counted)),
                "eigenvalue {k}: {counted:?}, {below} to {above}"
            );
        }
        assert_eq!(count(eigenvalue - 2.0 * room), Some(below));
        assert_eq!(count(eigenvalue + 2.0 * room), Some(above));
    }
}

#[test]
fn a_nearly_singular_matrix_is_solved_as_well_as_it_can_be() {
    let block = parts::steel_box([8, 4, 3], SolidElement::Hexahedron);
    let model = Model::of(&block).unwrap();
    let largest = Oracle::of(&block).eigenvalues.last().copied().unwrap();
    let mut factor =
        SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points()).unwrap();
    let f = Mat::from_fn(model.len(), 16, |i, j| ((i * (j + 2)) as f64).sin());
    for share in [1e-8, 1e-10, 1e-12, 1e-14] {
        let shift = share * largest;
        // Where rounding makes the smallest pivots negative the matrix is refused; a solution that is given leaves rounding.
        let Ok(positive) = factor.factorize(&model.stiffness, &model.mass, shift) else {
            assert!(share < 1e-12, "{share:e} was refused");
            continue;
        };
        let mut x = f.clone();
        positive.solve_in_place(x.as_mut()).unwrap();
        let mut left = times(&model.stiffness, x.as_ref());
        left += faer::Scale(shift) * times(&model.mass, x.as_ref());
        left -= &f;
        let entries = model
            .stiffness
            .val()
            .iter()
            .fold(0.0_f64, |a, b| a.max(b.abs()));
        let backward = left.norm_max() / (entries * x.norm_max());
        assert!(backward < 1e-13, "{share:e}: {backward:e}");
    }
}

#[test]
fn almost_every_mode_can_be_kept() {
    let block = parts::steel_box([4, 3, 2], SolidElement::Hexahedron);
    let oracle = Oracle::of(&block);
    let all = oracle.eigenvalues.len();
    assert_eq!(all, block.dofs.len() - 6);
    let roots = |values: &[f64]| values.iter().map(|v| v.sqrt()).collect::<Vec<_>>();
    for kept in [all - 13, all - 2, all - 1] {
        let reduced = lowest(&block, kept);
        let (eigenvalues, _) = modes(&reduced);
        assert_eq!(eigenvalues.len(), kept);
        assert!(relative(&roots(eigenvalues), &roots(&oracle.eigenvalues[..kept])) < 1e-11);
        let flexibility = oracle.residual_flexibility(kept);
        let whole = diagonal_roots(&oracle.residual_flexibility(0));
        let residual = &reduced.superelement.residual.flexibility;
        assert!(scaled_difference(residual, &flexibility, &whole) < 1e-11);
    }
}

#[test]
fn a_needle_bends_at_the_frequencies_of_the_closed_form() {
    // Slenderness 1e5, condition of K beside its first elastic eigenvalue above 1e14.
    let (length, elements) = (10.0, 200);
    let beam = spatial_beam(&SpatialBeam {
        elements,
        end: [length, 0.0, 0.0],
        section: BeamSection::round(length * 1e-5),
        ..SpatialBeam::default()
    });
    let reduced = lowest(&beam, 12);
    let (eigenvalues, _) = modes(&reduced);
    let (e, rho) = (Material::STEEL.youngs_modulus, Material::STEEL.density);
    let radius = length * 1e-5 / 4.0; // of gyration
    let axial_highest = 12.0 * e / rho * (elements as f64 / length).powi(2);
    assert!(axial_highest / eigenvalues[0] > 1e14);
    for (i, root) in [4.730_040_745, 7.853_204_624, 10.995_607_84, 14.137_165_49]
        .into_iter()
        .enumerate()
    {
        let bending = (root / length).powi(2) * radius * (e / rho).sqrt();
        for found in &eigenvalues[2 * i..2 * i + 2] {
            let error = found.sqrt() / bending - 1.0;
            assert!(error.abs() < 1e-6, "bending {i}: {error:e}");
        }
    }
}
