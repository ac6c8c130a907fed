//! The parts that are measured against dense algebra.

use dcb_formats::Component;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Par, Side};

use crate::accuracy::{BOUND, Exact, Measurement, measure};
use crate::dense::{dense, relative, symmetric};
use crate::oracle::Oracle;

/// A measured part: its name, the component, the numbers of modes, and its exact fields where it has rotations.
pub struct Case {
    /// Name in the table.
    pub name: String,
    /// The part.
    pub component: Component,
    /// Numbers of modes asked for.
    pub counts: Vec<usize>,
    /// Exact invariants.
    pub exact: Option<Box<Exact>>,
}

impl Case {
    /// All measurements.
    pub fn measure(&self) -> Vec<Measurement> {
        let oracle = Oracle::of(&self.component);
        let one = |count| {
            measure(
                &self.component,
                &self.name,
                count,
                &oracle,
                self.exact.as_deref(),
            )
        };
        self.counts.iter().flat_map(|count| one(*count)).collect()
    }
}

/// The parts of the table.
pub fn cases() -> Vec<Case> {
    use crate::fields;
    use dcb_samples::spatial_beam::{BeamMass, BeamTheory, SpatialBeam};
    use dcb_samples::{RodSection, SolidElement, reference_hexahedra, reference_tetrahedra};
    let mut cases = Vec::new();
    for elements in [1, 2, 4, 8, 16] {
        let all = 3 * elements;
        let counts = [0, 1, 3, 8, all]
            .into_iter()
            .filter(|count| *count <= all)
            .collect();
        let points = fields::rod_points(elements, &RodSection::default());
        cases.push(Case {
            name: format!("planar rod, {elements} element(s)"),
            component: crate::parts::rod(elements),
            counts,
            exact: Some(Box::new(move |centre, psi| {
                fields::invariants(&points, centre, psi.as_ref())
            })),
        });
    }
    let points = fields::rod_points(
        5,
        &RodSection {
            angle: 0.7,
            ..RodSection::default()
        },
    );
    cases.push(Case {
        name: "planar rod, tilted".into(),
        component: crate::parts::tilted_rod(5),
        counts: vec![0, 4],
        exact: Some(Box::new(move |centre, psi| {
            fields::invariants(&points, centre, psi.as_ref())
        })),
    });
    for elements in [2, 8] {
        let beam = SpatialBeam {
            elements,
            ..SpatialBeam::default()
        };
        let points = fields::beam_points(&beam);
        cases.push(Case {
            name: format!("spatial beam, {elements} elements"),
            component: crate::parts::beam(
                elements,
                BeamTheory::EulerBernoulli,
                BeamMass::Consistent,
            ),
            counts: if elements == 2 {
                vec![0, 1, 12]
            } else {
                vec![0, 1, 10]
            },
            exact: Some(Box::new(move |centre, psi| {
                fields::invariants(&points, centre, psi.as_ref())
            })),
        });
    }
    let mut solid = |name: &str, component, counts: &[usize]| {
        cases.push(Case {
            name: name.into(),
            component,
            counts: counts.to_vec(),
            exact: None,
        });
    };
    solid("hexahedra, 30 nodes", reference_hexahedra(), &[0, 1, 6, 84]);
    solid(
        "tetrahedra, 16 nodes",
        reference_tetrahedra(),
        &[0, 1, 6, 42],
    );
    solid(
        "box of hexahedra20",
        crate::parts::steel_box([4, 2, 1], SolidElement::Hexahedron20),
        &[0, 1, 12],
    );
    solid(
        "box of tetrahedra10",
        crate::parts::steel_box([3, 1, 1], SolidElement::Tetra10),
        &[0, 1, 12],
    );
    solid(
        "rotor (published matrices)",
        crate::parts::rotor(),
        &[0, 2, 12],
    );
    solid(
        "slender box, 2 m x 12 mm x 8 mm",
        dcb_samples::box_block(
            [20, 1, 1],
            [2.0, 0.012, 0.008],
            SolidElement::Hexahedron20,
            &dcb_samples::Material::STEEL,
        ),
        &[0, 6],
    );
    cases
}

/// Frequencies of the symmetric ring, too large for the whole comparison: against eigenvalues of L⁻¹ K L⁻ᵀ only.
pub fn ring() -> Measurement {
    let ring = dcb_samples::hard::symmetric_ring(8);
    let lower = dense(&ring.mass)
        .llt(Side::Lower)
        .expect("a positive definite mass")
        .L()
        .to_owned();
    let mut half = dense(&ring.stiffness);
    solve_lower_triangular_in_place(lower.as_ref(), half.as_mut(), Par::Seq);
    let mut matrix = half.transpose().to_owned();
    solve_lower_triangular_in_place(lower.as_ref(), matrix.as_mut(), Par::Seq);
    let values = symmetric(&matrix)
        .self_adjoint_eigenvalues(Side::Lower)
        .expect("finite numbers");
    let found = crate::lowest(&ring, 20).superelement.modes.eigenvalues;
    let frequencies = |values: &[f64]| values.iter().map(|v| v.sqrt()).collect::<Vec<_>>();
    // The dense values are good to ε times the largest.
    let rounding = 1e-15 * values[values.len() - 1] / found[0];
    Measurement {
        quantity: "frequencies",
        part: "symmetric ring, 8-fold".into(),
        n_e: ring.dofs.len(),
        modes: found.len(),
        error: relative(
            &frequencies(&found),
            &frequencies(&values[6..6 + found.len()]),
        ),
        bound: rounding.max(BOUND),
        oracle: "dense eigenvalues",
    }
}
