//! Block Lanczos and SLEPc on two ranks give one answer.

use dcb_formats::Component;
use dcb_formats::component::InterfaceKind;
use dcb_reducer::modes::slepc::SlepcRun;
use dcb_reducer::{EigenSolver, Grounding, LoosePieces, Reduced, Reduction, reduce};
use dcb_samples::{connecting_rod, hard};
use dcb_sparse::block_algebra::{gram, symmetric_product};
use faer::Mat;

use crate::MPIRUN;
use crate::support::{Folder, answer};

/// Relative to the eigenvalue, to the modes' mass, to the diagonals of F_res and M_res.
const AGREEMENT: f64 = 1e-9;
/// Roots closer than this are compared as one space.
const ONE_SPACE: f64 = 1e-6;

fn slepc(ranks: u32) -> EigenSolver {
    let launcher = MPIRUN.split_whitespace().map(str::to_owned).collect();
    EigenSolver::Slepc(SlepcRun {
        launcher,
        ..SlepcRun::with_ranks(ranks)
    })
}

/// Reduces in both ways, compares, and gives the one by SLEPc.
fn compared(component: &Component, options: &Reduction) -> Reduced {
    let built_in = reduce(component, options, &mut ()).unwrap();
    let options = Reduction {
        eigen_solver: slepc(2),
        ..options.clone()
    };
    let other = reduce(component, &options, &mut ()).unwrap();
    assert_eq!(other.quality.broken_limits(), Vec::new());
    assert_eq!(other.quality.sturm.found, other.quality.sturm.counted);
    let differences = [
        ("eigenvalues", eigenvalue_difference(&built_in, &other)),
        ("shapes", space_difference(component, &built_in, &other)),
        (
            "F_res",
            residual_difference(&built_in, &other, |r| &r.flexibility),
        ),
        ("M_res", residual_difference(&built_in, &other, |r| &r.mass)),
    ];
    println!(
        "{} ({} dofs): {differences:?}",
        component.name,
        component.dofs.len()
    );
    for (what, difference) in differences {
        assert!(
            difference < AGREEMENT,
            "{}: {what} {difference:e}",
            component.name
        );
    }
    other
}

fn eigenvalue_difference(a: &Reduced, b: &Reduced) -> f64 {
    let values = |reduced: &Reduced| {
        let modes = &reduced.superelement.modes;
        let omitted = Some(modes.first_omitted_eigenvalue).filter(|value| value.is_finite());
        modes
            .eigenvalues
            .iter()
            .copied()
            .chain(omitted)
            .collect::<Vec<f64>>()
    };
    let (a, b) = (values(a), values(b));
    assert_eq!(a.len(), b.len());
    let relative = |(x, y): (&f64, &f64)| if x == y { 0.0 } else { (x - y).abs() / x.abs() };
    a.iter().zip(&b).map(relative).fold(0.0, f64::max)
}

/// How much of a shape of `b` lies outside `a`'s shapes of the same root: 1 - |Pφ|²_M.
fn space_difference(component: &Component, a: &Reduced, b: &Reduced) -> f64 {
    let mass_b = symmetric_product(&component.mass, b.recovery.modes.as_ref());
    let cosines = gram(a.recovery.modes.as_ref(), mass_b.as_ref());
    let lambda = &a.superelement.modes.eigenvalues;
    let outside = |j: usize| {
        let same_root = |i: &usize| (lambda[*i] - lambda[j]).abs() <= ONE_SPACE * lambda[j];
        let inside = (0..lambda.len())
            .filter(same_root)
            .map(|i| cosines[(i, j)].powi(2));
        (1.0 - inside.sum::<f64>()).abs()
    };
    (0..lambda.len()).map(outside).fold(0.0, f64::max)
}

fn residual_difference(
    a: &Reduced,
    b: &Reduced,
    of: impl Fn(&dcb_formats::superelement::Residual) -> &Mat<f64>,
) -> f64 {
    let (a, b) = (of(&a.superelement.residual), of(&b.superelement.residual));
    let scaled =
        |i: usize, j: usize| (a[(i, j)] - b[(i, j)]).abs() / (a[(i, i)] * a[(j, j)]).sqrt();
    let rows = 0..a.nrows();
    rows.flat_map(|i| (0..a.ncols()).map(move |j| scaled(i, j)))
        .fold(0.0, f64::max)
}

#[test]
fn a_connecting_rod() {
    compared(&connecting_rod(0), &Reduction::lowest(30));
}

/// Condensed before: what travels is the model, not the component.
#[test]
fn a_rigid_interface() {
    let component = connecting_rod(0)
        .changed(|draft| draft.interfaces[0].kind = InterfaceKind::Rigid)
        .unwrap();
    compared(&component, &Reduction::lowest(12));
}

/// Asked for one of a pair, both are kept, and the space is the same.
#[test]
fn double_roots_are_complete() {
    let reduced = compared(&hard::square_block(), &Reduction::lowest(20));
    let lambda = &reduced.superelement.modes.eigenvalues;
    let pairs = lambda
        .windows(2)
        .filter(|two| two[1] - two[0] < 1e-7 * two[1]);
    assert!(pairs.count() > 4, "{lambda:?}");
    assert!(lambda[1] - lambda[0] < 1e-7 * lambda[1], "{lambda:?}");
    let one = compared(&hard::square_block(), &Reduction::lowest(1));
    assert_eq!(one.superelement.mode_count(), 2);
}

#[test]
fn a_ring_with_double_roots_everywhere() {
    compared(&hard::symmetric_ring(16), &Reduction::lowest(25));
}

#[test]
fn a_part_that_is_held() {
    let options = Reduction {
        grounding: Grounding::Allow,
        ..Reduction::lowest(8)
    };
    compared(&hard::grounded_block(), &options);
}

/// Six motions without stiffness beyond the rigid ones, all at one place of the spectrum.
#[test]
fn loose_pieces() {
    let options = Reduction {
        loose_pieces: LoosePieces::Allow,
        ..Reduction::lowest(10)
    };
    let reduced = compared(&hard::two_loose_blocks(), &options);
    assert_eq!(reduced.quality.zero_modes, 6);
}

#[test]
fn the_number_of_ranks_does_not_matter() {
    let component = hard::square_block();
    let with = |ranks| {
        let options = Reduction {
            eigen_solver: slepc(ranks),
            ..Reduction::lowest(10)
        };
        reduce(&component, &options, &mut ()).unwrap()
    };
    let one = with(1);
    for ranks in [2, 3] {
        assert!(eigenvalue_difference(&one, &with(ranks)) < AGREEMENT);
    }
}

/// From outside: the usual size, a file that verifies, nothing left behind.
#[test]
fn the_program_writes_a_superelement_that_verifies() {
    let folder = Folder::with(&connecting_rod(1));
    std::fs::create_dir(folder.path("scratch")).unwrap();
    let mut command = folder.command("part.mtx --modes 30 --eigen-solver slepc --ranks 2");
    command
        .args(["--mpirun", MPIRUN])
        .env("TMPDIR", folder.path("scratch"));
    let done = answer(&mut command);
    assert_eq!((done.code, done.stderr.as_str()), (Some(0), ""), "{done:?}");
    assert_eq!(
        std::fs::read_dir(folder.path("scratch")).unwrap().count(),
        0
    );
    folder.done("verify part.dcb.h5 --component part.mtx");
    let options = &folder.inspected("part.dcb.h5")["options"];
    assert_eq!(options["eigen_solver"]["slepc"]["ranks"], 2);
}
