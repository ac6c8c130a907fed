//! Free bodies on the springs of a statically determinate support, against the dense generalized inverse.

use dcb_formats::Component;
use dcb_reducer::model::condensation::Model;
use dcb_reducer::model::piece_motions::Pieces;
use dcb_reducer::model::regularization::Regularization;
use dcb_reducer::model::rigid_body::{MassProperties, RigidBodyModes};
use dcb_reducer::model::shift::SpectrumScale;
use dcb_samples::SolidElement;
use dcb_samples::spatial_beam::{BeamMass, BeamTheory};
use dcb_sparse::factorization::SymmetricFactor;
use dcb_tests::oracle::Oracle;
use dcb_tests::parts;
use faer::Mat;

/// A free body before anything is factorized.
struct Free<'a> {
    model: Model<'a>,
    rigid: RigidBodyModes,
    scale: SpectrumScale,
}

impl<'a> Free<'a> {
    fn of(component: &'a Component) -> Self {
        let properties = MassProperties::of(component).unwrap();
        let model = Model::of(component).unwrap();
        let rigid = RigidBodyModes::of(component, &model, &properties).unwrap();
        let pieces = Pieces::of(&model, &rigid);
        let dimension = component.dimension();
        let scale = SpectrumScale::of(&model, &rigid, &pieces, dimension, properties.centre);
        Self {
            model,
            rigid,
            scale,
        }
    }
}

/// Largest error of a response to balanced forces, of the root of its energy, and the same of what one solution with a shift leaves.
fn errors(component: &Component) -> (f64, f64) {
    let Free {
        model,
        rigid,
        scale,
    } = &Free::of(component);
    let oracle = Oracle::of(component);
    let forces = Mat::from_fn(model.len(), 5, |i, j| ((i * (j + 2)) as f64).sin());
    // (I - M R Rᵀ) f
    let at_rigid = rigid.shapes.transpose() * &forces;
    let balanced = &forces - &rigid.mass_shapes * at_rigid;
    let exact = &oracle.inverse * &forces;
    let energy = |x: &Mat<f64>, j: usize| {
        let x = x.as_ref().subcols(j, 1);
        (x.transpose() * &oracle.stiffness * x)[(0, 0)].sqrt()
    };
    let mut factor =
        SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points()).unwrap();
    let mut largest_with = |regularization: &Regularization| {
        let positive = regularization.factorize(model, &mut factor).unwrap();
        let mut x = balanced.clone();
        positive.solve_in_place(x.as_mut()).unwrap();
        rigid.project_out(&mut x);
        let off = &x - &exact;
        (0..off.ncols())
            .map(|j| energy(&off, j) / energy(&exact, j))
            .fold(0.0, f64::max)
    };
    let supports = Regularization::by_supports(model, rigid, scale);
    let Regularization::Supports(springs) = &supports else {
        panic!("{}: no place for springs", component.name);
    };
    assert_eq!(springs.val().len(), rigid.count(), "{}", component.name);
    assert!(springs.val().iter().all(|stiffness| *stiffness > 0.0));
    (
        largest_with(&supports),
        largest_with(&Regularization::by_shift(scale)),
    )
}

#[test]
fn one_solution_on_springs_is_that_of_the_free_body() {
    let parts = [
        parts::steel_box([4, 2, 2], SolidElement::Hexahedron20),
        parts::moved(
            &parts::steel_box([6, 1, 1], SolidElement::Hexahedron),
            [40.0, -3.0, 7.0],
        ),
        parts::rod(6),
        parts::tilted_rod(5),
        parts::beam(8, BeamTheory::Timoshenko, BeamMass::Consistent),
        parts::skew_beam(),
        parts::rotor(),
    ];
    for part in parts {
        let (on_springs, with_shift) = errors(&part);
        println!(
            "{}: {on_springs:.1e}, with a shift {with_shift:.1e}",
            part.name
        );
        assert!(on_springs < 1e-9, "{}: {on_springs:e}", part.name);
        assert!(
            with_shift > 10.0 * on_springs,
            "{}: {with_shift:e}",
            part.name
        );
    }
}

/// Pieces have motions without stiffness that springs for the whole don't hold.
#[test]
fn two_pieces_have_no_factor_on_the_springs_of_one() {
    let bar = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    let pieces = parts::side_by_side(&[bar.clone(), bar]);
    let Free {
        model,
        rigid,
        scale,
    } = &Free::of(&pieces);
    let mut factor =
        SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points()).unwrap();
    let supports = Regularization::by_supports(model, rigid, scale);
    if let Ok(positive) = supports.factorize(model, &mut factor) {
        // Rounding made the last pivots positive: a response is as large as the inverse of rounding.
        let mut x = Mat::from_fn(model.len(), 1, |i, _| (i as f64).sin());
        positive.solve_in_place(x.as_mut()).unwrap();
        assert!(x.norm_max().is_nan() || x.norm_max() > 1e-3);
    }
    let shift = Regularization::by_shift(scale);
    assert!(shift.factorize(model, &mut factor).is_ok());
}
