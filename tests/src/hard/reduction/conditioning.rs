//! Hard cases of conditioning: slender, thin, soft between stiff, other units, far from the origin.

use dcb_formats::Component;
use dcb_formats::component::ComponentDraft;
use dcb_formats::mesh::{CellBlock, Mesh};
use dcb_samples::spatial_beam::{BeamSection, SpatialBeam, spatial_beam};
use dcb_samples::{Material, SolidElement, UnitScale, assemble_solid, box_block, in_units};
use faer::Mat;

use crate::dense::{dense, diagonal_roots, relative, scaled_difference, solve, sparse};
use crate::hard::case::{Bounded, HardCase};
use crate::hard::reduction::GROUP;
use crate::hard::reduction::plain_methods::{eigenpairs, rank_by_own_largest};
use crate::oracle::{Oracle, rigid_motions};
use crate::{lowest, parts};

fn roots(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| value.sqrt()).collect()
}

/// A round steel wire of 10 m and 1 mm against cos β cosh β = 1, four pairs of frequencies.
pub fn slenderness_1e4() -> HardCase {
    let (length, elements) = (10.0, 100);
    let wire = spatial_beam(&SpatialBeam {
        elements,
        end: [length, 0.0, 0.0],
        section: BeamSection::round(length * 1e-4),
        ..SpatialBeam::default()
    });
    let (e, rho) = (Material::STEEL.youngs_modulus, Material::STEEL.density);
    let gyration = length * 1e-4 / 4.0;
    let bending = |root: f64| (root / length).powi(2) * gyration * (e / rho).sqrt();
    let expected: Vec<f64> = [4.730_040_745, 7.853_204_624, 10.995_607_84, 14.137_165_49]
        .into_iter()
        .flat_map(|root| [bending(root), bending(root)])
        .collect();
    let (values, _) = eigenpairs(&dense(&wire.stiffness), &dense(&wire.mass)).expect("a mass");
    let largest = values[values.len() - 1];
    let rigid = values
        .iter()
        .filter(|value| **value < 1e-9 * largest)
        .count();
    assert!(rigid > 8, "{rigid}");

    let element = lowest(&wire, 8).superelement;
    HardCase {
        group: GROUP,
        name: "slenderness_1e4",
        naive_method: "dense eigenvalues of L⁻¹ K L⁻ᵀ with M = L Lᵀ, those below 1e-9 of the largest taken as rigid",
        naive: format!(
            "{rigid} rigid motions: the {} lowest bending modes are lost",
            rigid - 6
        ),
        ours: "four pairs of bending frequencies of the closed form".into(),
        error: Some(Bounded {
            found: relative(&roots(&element.modes.eigenvalues), &expected),
            bound: 1e-6,
        }),
    }
}

/// A plate of 0.2 m × 0.12 m × 0.2 mm, one quadratic hexahedron through the thickness.
pub fn thin_plate_1e3() -> HardCase {
    let plate = box_block(
        [6, 4, 1],
        [0.2, 0.12, 0.0002],
        SolidElement::Hexahedron20,
        &Material::STEEL,
    );
    let oracle = Oracle::of(&plate);
    // Opposite unit moments at both ends: self-equilibrated, so that a shift adds no rigid motion.
    let n = plate.dofs.len();
    let load = Mat::from_fn(n, 1, |i, _| {
        oracle.localization[(4, i)] - oracle.localization[(10, i)]
    });
    let bent = |response: &Mat<f64>| (load.transpose() * response)[(0, 0)];
    let exact = bent(&(&oracle.inverse * &load));
    let stiffest = (0..n)
        .map(|i| oracle.stiffness[(i, i)] / oracle.mass[(i, i)])
        .fold(0.0, f64::max);
    let shifted = &oracle.stiffness + &oracle.mass * faer::Scale(1e-8 * stiffest);
    let wrong = (bent(&solve(&shifted, &load)) / exact - 1.0).abs();
    assert!(wrong > 0.1, "{wrong}");

    let element = lowest(&plate, 4).superelement;
    let kept = element.mode_count();
    let frequencies = relative(
        &roots(&element.modes.eigenvalues),
        &roots(&oracle.eigenvalues[..kept]),
    );
    let scale = diagonal_roots(&oracle.residual_flexibility(0));
    let f = oracle.residual_flexibility(kept);
    let flexibility = scaled_difference(&element.residual.flexibility, &f, &scale);
    HardCase {
        group: GROUP,
        name: "thin_plate_1e3",
        naive_method: "K⁻¹ by a tiny shift: (K + 1e-8 max(K_ii/M_ii) M)⁻¹",
        naive: format!("{:.0} % of the bending is missing", 100.0 * wrong),
        ours: "frequencies and F_res of dense algebra".into(),
        error: Some(Bounded {
            found: frequencies.max(flexibility),
            bound: 1e-5,
        }),
    }
}

/// Two steel blocks on a layer 1e8 times softer, and the layer's share of K.
fn soft_layer() -> (Component, Mat<f64>) {
    let block = box_block(
        [6, 2, 2],
        [0.3, 0.1, 0.1],
        SolidElement::Hexahedron,
        &Material::STEEL,
    );
    let soft = Material {
        youngs_modulus: 1e-8 * Material::STEEL.youngs_modulus,
        ..Material::STEEL
    };
    let cells = &block.mesh.cells[0];
    let in_layer = |cell: &&[u32]| {
        let mean: f64 = cell
            .iter()
            .map(|node| block.mesh.position(*node)[0])
            .sum::<f64>()
            / cell.len() as f64;
        (0.1..0.2).contains(&mean)
    };
    let only = |wanted: bool| Mesh {
        cells: vec![CellBlock {
            nodes: cells
                .cells()
                .filter(|cell| in_layer(cell) == wanted)
                .flatten()
                .copied()
                .collect(),
            ..cells.clone()
        }],
        ..block.mesh.clone()
    };
    let layer = dense(&assemble_solid(&only(true), &soft).stiffness);
    let ends = dense(&assemble_solid(&only(false), &Material::STEEL).stiffness);
    let component = Component::checked(ComponentDraft {
        stiffness: sparse(&(&layer + ends)),
        ..block.into_draft()
    })
    .expect("a component");
    (component, layer)
}

/// The first six elastic motions are those of two rigid bodies on the layer, to 1e-8 times a number of the geometry.
pub fn stiffness_contrast_1e8() -> HardCase {
    let (component, layer) = soft_layer();
    let (values, _) = crate::dense::eigen(&dense(&component.stiffness));
    let largest = values[values.len() - 1];
    let null = values
        .iter()
        .filter(|value| **value < 1e-9 * largest)
        .count();
    assert!(null > 6, "{null}");

    // T: six motions of each end, and the layer's inner nodes one by one.
    let x = |row: usize| {
        component
            .mesh
            .position(component.dofs.dof(row).expect("a row of a node").node)[0]
    };
    let n = component.dofs.len();
    let inner: Vec<usize> = (0..n)
        .filter(|row| x(*row) > 0.101 && x(*row) < 0.199)
        .collect();
    let rigid = rigid_motions(&component, [0.15, 0.05, 0.05]);
    let t = Mat::from_fn(n, 12 + inner.len(), |row, column| match column {
        c if c < 6 && x(row) < 0.101 => rigid[(row, c)],
        c if (6..12).contains(&c) && x(row) > 0.199 => rigid[(row, c - 6)],
        c if c >= 12 && inner[c - 12] == row => 1.0,
        _ => 0.0,
    });
    let mass = t.transpose() * dense(&component.mass) * &t;
    let (expected, _) = eigenpairs(&(t.transpose() * &layer * &t), &mass).expect("a mass");

    let element = lowest(&component, 6).superelement;
    HardCase {
        group: GROUP,
        name: "stiffness_contrast_1e8",
        naive_method: "rigid motions as eigenvectors of K below 1e-9 of its largest eigenvalue",
        naive: format!("{null} rigid motions of one body"),
        ours: "six from geometry; the ends' motions on the soft layer".into(),
        error: Some(Bounded {
            found: relative(
                &roots(&element.modes.eigenvalues[..6]),
                &roots(&expected[6..12]),
            ),
            bound: 1e-6,
        }),
    }
}

/// A rod with rotation rows in both unit systems.
pub fn millimetre_tonne_second() -> HardCase {
    let mut rod = parts::rod(4).into_draft();
    for interface in &mut rod.interfaces {
        interface.directions = None;
    }
    let rod = Component::checked(rod).expect("a component");
    let scale = UnitScale::mm_t_s();
    let fine = in_units(&rod, &scale);
    let [coarse_rank, fine_rank] =
        [&rod, &fine].map(|part| rank_by_own_largest(&Oracle::of(part).residual_mass(0), 1e-9));
    assert_ne!(coarse_rank, fine_rank);

    let (a, b) = (lowest(&rod, 3), lowest(&fine, 3));
    let rank = |r: &dcb_reducer::Reduced| (r.quality.residual_rank, r.quality.static_directions);
    assert_eq!(rank(&a), rank(&b));
    let frequencies = relative(
        &roots(&b.superelement.modes.eigenvalues),
        &roots(&a.superelement.modes.eigenvalues),
    );
    // mm/N, rad/N, rad/(N mm)
    let power: Vec<i32> = a
        .superelement
        .rows
        .iter()
        .map(|row| i32::from(row.direction >= 3))
        .collect();
    let f = &a.superelement.residual.flexibility;
    let expected = Mat::from_fn(f.nrows(), f.ncols(), |i, j| {
        f[(i, j)] * scale.time.powi(2) / scale.mass / scale.length.powi(power[i] + power[j])
    });
    let found = &b.superelement.residual.flexibility;
    let flexibility = scaled_difference(found, &expected, &diagonal_roots(&expected));
    HardCase {
        group: GROUP,
        name: "millimetre_tonne_second",
        naive_method: "directions of M_res above 1e-9 of its largest eigenvalue, rows as they come",
        naive: format!("{coarse_rank} of 6 directions in metres, {fine_rank} in millimetres"),
        ours: format!("{} of 6 in both; same frequencies, same F_res", rank(&a).0),
        error: Some(Bounded {
            found: frequencies.max(flexibility),
            bound: 1e-9,
        }),
    }
}

/// The same box at the origin and far from it.
pub fn a_million_metres_from_the_origin() -> HardCase {
    let box_here = parts::steel_box([4, 2, 1], SolidElement::Hexahedron);
    // A power of two near a million keeps coordinates of the part to 1e-10 m.
    let box_there = parts::moved(&box_here, [1_048_576.0, -1_048_576.0, 524_288.0]);
    let near = lowest(&box_here, 6).superelement;
    let largest = (0..3)
        .map(|a| near.inertia.tensor[a][a])
        .fold(0.0, f64::max);
    let off = |tensor: &dyn Fn(usize, usize) -> f64| {
        (0..9)
            .map(|at| (tensor(at / 3, at % 3) - near.inertia.tensor[at / 3][at % 3]).abs())
            .fold(0.0, f64::max)
            / largest
    };
    // XᵀMX about the coordinate origin, then Steiner's theorem.
    let x = rigid_motions(&box_there, [0.0; 3]);
    let about_origin = x.transpose() * dense(&box_there.mass) * &x;
    let mass = about_origin[(0, 0)];
    // Rows of Tᵀ M X_r: m (e_a × c).
    let centre = [
        about_origin[(1, 5)] / mass,
        about_origin[(2, 3)] / mass,
        about_origin[(0, 4)] / mass,
    ];
    let squared: f64 = centre.iter().map(|c| c * c).sum();
    let wrong = off(&|i, j| {
        let identity = if i == j { squared } else { 0.0 };
        about_origin[(3 + i, 3 + j)] - mass * (identity - centre[i] * centre[j])
    });
    assert!(wrong > 0.01, "{wrong:e}");

    let far = lowest(&box_there, 6).superelement;
    let f = &near.residual.flexibility;
    let flexibility = scaled_difference(&far.residual.flexibility, f, &diagonal_roots(f));
    let frequencies = relative(
        &roots(&far.modes.eigenvalues),
        &roots(&near.modes.eigenvalues),
    );
    let tensor = off(&|i, j| far.inertia.tensor[i][j]);
    HardCase {
        group: GROUP,
        name: "a_million_metres_from_the_origin",
        naive_method: "moments about the coordinate origin, then Steiner's theorem",
        naive: format!("moments of inertia wrong by {:.0} %", 100.0 * wrong),
        ours: "frequencies, F_res and inertia tensor of the part at the origin".into(),
        error: Some(Bounded {
            found: flexibility.max(frequencies).max(tensor),
            bound: 3e-8,
        }),
    }
}
