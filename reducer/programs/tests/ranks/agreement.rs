//! A factor in this process and one on ranks give one answer.

use dcb_formats::Component;
use dcb_formats::component::InterfaceKind;
use dcb_formats::superelement::Superelement;
use dcb_reducer::resources::memory_limit::MemoryLimit;
use dcb_reducer::{EnrichmentSource, Grounding, LoosePieces, Reduced, Reduction, reduce};
use dcb_samples::{connecting_rod, hard};
use dcb_sparse::block_algebra::{gram, symmetric_product};
use dcb_sparse::ranks::RanksRun;
use faer::Mat;

use crate::MPIRUN;
use crate::support::{Folder, answer};

/// Relative to the eigenvalue, to the modes' mass, to the diagonals of F_res, M_res and the moments.
const AGREEMENT: f64 = 1e-9;
/// Roots closer than this are compared as one space.
const ONE_SPACE: f64 = 1e-6;

/// The same reduction with the factor on ranks.
fn on_ranks(component: &Component, options: &Reduction, ranks: u32) -> Reduced {
    let launcher = MPIRUN.split_whitespace().map(str::to_owned).collect();
    let run = RanksRun {
        launcher,
        ..RanksRun::with_ranks(ranks)
    };
    let memory = MemoryLimit {
        ranks: Some(run),
        ..MemoryLimit::default()
    };
    let options = Reduction {
        memory,
        ..options.clone()
    };
    let reduced = reduce(component, &options, &mut ()).unwrap();
    assert_eq!(reduced.work.rank_peak_bytes.len(), ranks as usize);
    assert!(
        reduced
            .work
            .rank_peak_bytes
            .iter()
            .all(|bytes| *bytes > 1 << 20)
    );
    reduced
}

/// Reduces with the factor here and on two and four ranks, compares, and gives the one on two.
fn compared(component: &Component, options: &Reduction) -> Reduced {
    let here = reduce(component, options, &mut ()).unwrap();
    let [two, four] = [2, 4].map(|ranks| on_ranks(component, options, ranks));
    for (ranks, other) in [(2, &two), (4, &four)] {
        assert_eq!(other.quality.broken_limits(), Vec::new());
        assert_eq!(
            other.quality.mode_count.found,
            other.quality.mode_count.counted
        );
        let mut differences = vec![
            ("eigenvalues", eigenvalue_difference(&here, other)),
            ("shapes", space_difference(component, &here, other)),
            (
                "F_res",
                scaled_difference(&here, other, |e| e.residual.flexibility.clone()),
            ),
            (
                "M_res",
                scaled_difference(&here, other, |e| e.residual.mass.clone()),
            ),
        ];
        assert_eq!(
            here.superelement.moments.is_some(),
            other.superelement.moments.is_some()
        );
        if here.superelement.moments.is_some() {
            differences.extend(moment_differences(&here, other));
        }
        println!(
            "{} ({} dofs), {ranks} ranks: {differences:?}",
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
    }
    two
}

/// Of M_1 to M_4; an element is compared with its diagonals, and moments that are rounding with it.
fn moment_differences(a: &Reduced, b: &Reduced) -> [(&'static str, f64); 4] {
    [
        ("M_1", moment_difference(a, b, |moments| &moments.first)),
        ("M_2", moment_difference(a, b, |moments| &moments.second)),
        ("M_3", moment_difference(a, b, |moments| &moments.third)),
        ("M_4", moment_difference(a, b, |moments| &moments.fourth)),
    ]
}

fn moment_difference(
    a: &Reduced,
    b: &Reduced,
    of: impl Fn(&dcb_formats::superelement::Moments) -> &Mat<f64>,
) -> f64 {
    scaled_difference(a, b, |element| {
        let moments = element.moments.as_ref().unwrap();
        of(moments).clone()
    })
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

fn scaled_difference(a: &Reduced, b: &Reduced, of: impl Fn(&Superelement) -> Mat<f64>) -> f64 {
    let (a, b) = (of(&a.superelement), of(&b.superelement));
    let scaled =
        |i: usize, j: usize| (a[(i, j)] - b[(i, j)]).abs() / (a[(i, i)] * a[(j, j)]).sqrt();
    let rows = 0..a.nrows();
    rows.flat_map(|i| (0..a.ncols()).map(move |j| (i, j)))
        .filter(|(i, j)| a[(*i, *j)] != b[(*i, *j)])
        .map(|(i, j)| scaled(i, j))
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

/// Rotations without mass: M is singular.
#[test]
fn massless_rotations() {
    let sample = dcb_samples::catalogue::find("lumped-beam").unwrap();
    compared(&sample.make(None), &Reduction::lowest(5));
}

/// Further columns come from the same factor.
#[test]
fn further_columns() {
    let options = Reduction {
        enrichment: vec![EnrichmentSource::Spin, EnrichmentSource::Krylov],
        ..Reduction::lowest(10)
    };
    let component = connecting_rod(0);
    let here = reduce(&component, &options, &mut ()).unwrap();
    let other = on_ranks(&component, &options, 2);
    for diagonal in [stiffness_of_further, mass_of_further] {
        let (here, other) = (diagonal(&here), diagonal(&other));
        assert!(!here.is_empty() && here.len() == other.len());
        for (a, b) in here.iter().zip(&other) {
            assert!((a - b).abs() <= AGREEMENT * a.abs(), "{a:e} {b:e}");
        }
    }
}

fn stiffness_of_further(reduced: &Reduced) -> Vec<f64> {
    let further = reduced.superelement.enrichment.as_ref().unwrap();
    diagonal(&further.reduced_stiffness)
}

fn mass_of_further(reduced: &Reduced) -> Vec<f64> {
    let further = reduced.superelement.enrichment.as_ref().unwrap();
    diagonal(&further.reduced_mass)
}

fn diagonal(matrix: &Mat<f64>) -> Vec<f64> {
    matrix.diagonal().column_vector().iter().copied().collect()
}

/// From outside: the usual size, a file that verifies, nothing left behind, no factor in `reduce`.
#[test]
fn the_program_writes_a_superelement_that_verifies() {
    let folder = Folder::with(&connecting_rod(1));
    std::fs::create_dir(folder.path("scratch")).unwrap();
    let mut command =
        folder.command("part.mtx --modes 30 --ranks 2 --scratch scratch --timings times.json");
    command.args(["--mpirun", MPIRUN]);
    let done = answer(&mut command);
    assert_eq!((done.code, done.stderr.as_str()), (Some(0), ""), "{done:?}");
    assert_eq!(
        std::fs::read_dir(folder.path("scratch")).unwrap().count(),
        0
    );
    folder.done("verify part.dcb.h5 --component part.mtx");
    assert_eq!(folder.inspected("part.dcb.h5")["options"]["ranks"], 2);
    let times = folder.json("times.json");
    assert_eq!(
        times["work"]["rank_peak_bytes"].as_array().unwrap().len(),
        2
    );
    // The stage in which the factor is made takes no memory here.
    let peak = |name: &str| {
        let stages = times["stages"].as_array().unwrap().iter();
        let mut found = stages.filter(|stage| stage["stage"] == name);
        found.next().unwrap()["peak_megabytes"].as_f64().unwrap()
    };
    let factor = times["work"]["stored_bytes"].as_f64().unwrap() / (1 << 20) as f64;
    assert!(peak("factor") - peak("order") < 0.25 * factor, "{times}");
}

/// The plan knows that the factor is elsewhere.
#[test]
fn a_plan_has_no_factor_in_memory() {
    let folder = Folder::with(&connecting_rod(1));
    let peak = |options: &str| {
        let plan = folder.done(&format!("plan part.mtx --json {options}"));
        let plan: serde_json::Value = serde_json::from_str(&plan).unwrap();
        let choice = plan["choices"][0].clone();
        (
            plan["chosen"].as_str().unwrap().to_owned(),
            choice["stage_bytes"]["factor"].as_f64().unwrap(),
            choice["factor_bytes"].as_f64().unwrap(),
        )
    };
    let (here, with, factor) = peak("--factor memory");
    let (there, without, _) = peak("--ranks 4");
    assert_eq!(
        (here.as_str(), there.as_str()),
        ("in memory", "by 4 MPI process(es)")
    );
    assert!(with - without >= factor);
}
