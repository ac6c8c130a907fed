//! How far a reduced part is off, by every measure of a study. All numbers are relative; rows are scaled by their own
//! flexibility, so that translations and rotations count alike and no number depends on units.

use faer::linalg::solvers::DenseSolveCore as _;
use faer::{Mat, c64};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::record::StoredCurves;
use super::reference::ComponentReference;
use super::variant::ReducedPart;

/// Blocks of H smaller than this beside the blocks on their diagonals vanish by symmetry: no level is compared.
const NO_COUPLING: f64 = 1e-9;

/// Deviation of a response over the band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResponseDeviation {
    /// Largest ‖H - H_ref‖ / ‖H_ref‖ of any frequency (Frobenius norms over all entries concerned).
    pub largest: f64,
    /// ω² where that is.
    pub at: f64,
    /// Root mean square of 20 lg (‖H_ij‖ / ‖H_ref,ij‖), over frequencies and pairs of interfaces, dB; `None` where a response is missing.
    pub level_db: Option<f64>,
}

/// Error of the static response to unit forces at one interface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InterfaceError {
    /// Name.
    pub interface: String,
    /// ‖F - F_ref‖ / ‖F_ref‖ over the columns of its rows.
    pub error: f64,
}

/// All of them for one row. `None` where a measure doesn't apply or the row has no such response.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// |f - f_ref| / f_ref of each frequency with the interfaces held, within the band; 1 for one that the row lacks.
    pub held_frequencies: Option<Vec<f64>>,
    /// (f - f_ref) / f_ref of the first free frequency beyond the kept modes, which the softest attachment stands for.
    pub next_free_frequency: Option<f64>,
    /// Static response with the inertia relieved.
    pub static_response: Vec<InterfaceError>,
    /// Receptance of each interface at itself.
    pub collocated: ResponseDeviation,
    /// Receptance between different interfaces.
    pub transfer: Option<ResponseDeviation>,
    /// Dynamic stiffness Z = H⁻¹: forces needed to move the interfaces.
    pub interface_force: Option<ResponseDeviation>,
}

/// The entries of H that are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drawn {
    /// Row and column on the diagonal.
    pub collocated: usize,
    /// Row of another interface that this one moves most.
    pub transfer: Option<usize>,
}

impl Drawn {
    /// The softest row, and the row elsewhere that it moves most.
    pub fn of(reference: &ComponentReference) -> Self {
        let flexibility = &reference.flexibility;
        let softest = (0..flexibility.nrows())
            .max_by(|a, b| flexibility[(*a, *a)].total_cmp(&flexibility[(*b, *b)]))
            .unwrap_or(0);
        let home = (reference.rows.groups.iter()).find(|group| group.contains(&softest));
        let transfer = (0..flexibility.nrows())
            .filter(|row| home.is_some_and(|group| !group.contains(row)))
            .max_by(|a, b| {
                let moved = |row: &usize| flexibility[(*row, softest)].abs();
                moved(a).total_cmp(&moved(b))
            });
        Self {
            collocated: softest,
            transfer,
        }
    }
}

/// Squares of Frobenius norms of the blocks of H, (g, g).
struct Blocks(Mat<f64>);

impl Blocks {
    fn of(reference: &ComponentReference, h: &Mat<c64>) -> Self {
        let groups = &reference.rows.groups;
        Self(Mat::from_fn(groups.len(), groups.len(), |a, b| {
            let entries = groups[a]
                .clone()
                .flat_map(|i| groups[b].clone().map(move |j| (i, j)));
            entries.map(|(i, j)| h[(i, j)].norm_sqr()).sum()
        }))
    }

    fn sum(&self, kind: Kind) -> f64 {
        self.pairs(kind).map(|(a, b)| self.0[(a, b)]).sum()
    }

    fn pairs(&self, kind: Kind) -> impl Iterator<Item = (usize, usize)> + use<> {
        let count = self.0.nrows();
        (0..count)
            .flat_map(move |a| (0..count).map(move |b| (a, b)))
            .filter(move |(a, b)| (a == b) == (kind == Kind::Collocated))
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Collocated,
    Transfer,
}

/// Deviation of one response at one frequency.
#[derive(Clone, Copy)]
struct Sample {
    error: f64,
    /// Sum and number of squared levels.
    levels: (f64, usize),
}

impl Sample {
    fn of_blocks(reference: &Blocks, found: &Blocks, difference: &Blocks, kind: Kind) -> Self {
        let mut levels = (0.0, 0);
        for (a, b) in reference.pairs(kind) {
            let there = reference.0[(a, b)];
            let beside = (reference.0[(a, a)] * reference.0[(b, b)]).sqrt();
            if there > NO_COUPLING * NO_COUPLING * beside {
                levels.0 += (10.0 * (found.0[(a, b)] / there).log10()).powi(2);
                levels.1 += 1;
            }
        }
        Self {
            error: ratio(difference.sum(kind), reference.sum(kind)),
            levels,
        }
    }
}

/// Root of a ratio of squares; 0 where there is nothing.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { (a / b).sqrt() } else { 0.0 }
}

/// Everything one frequency says of one row.
struct Point {
    square: f64,
    collocated: Sample,
    transfer: Sample,
    force: Option<Sample>,
    error: f64,
    drawn: [f64; 2],
}

/// Errors and curves of reduced parts, all against the same reference. Frequencies are shared among the threads.
pub fn evaluate(
    reference: &ComponentReference,
    parts: &[ReducedPart],
    modes: &[usize],
    loss_factor: f64,
    drawn: Drawn,
) -> Vec<(Errors, StoredCurves)> {
    let lambdas: Vec<c64> = reference.band.damped(loss_factor).collect();
    let by_frequency: Vec<Vec<Point>> = lambdas
        .par_iter()
        .zip(&reference.band.squares)
        .map(|(lambda, square)| points(reference, parts, *lambda, *square, drawn))
        .collect();
    let of_part = |index: usize| by_frequency.iter().map(move |points| &points[index]);
    (parts.iter().zip(modes).enumerate())
        .map(|(index, (part, modes))| {
            let several = reference.rows.groups.len() > 1;
            let force = of_part(index)
                .map(|point| point.force.map(|force| (point.square, force)))
                .collect::<Option<Vec<_>>>();
            let samples = |take: fn(&Point) -> Sample| -> Vec<(f64, Sample)> {
                of_part(index)
                    .map(|point| (point.square, take(point)))
                    .collect()
            };
            let errors = Errors {
                held_frequencies: held_errors(reference, part),
                next_free_frequency: next_free(reference, part, *modes),
                static_response: static_errors(reference, part),
                collocated: deviation(&samples(|point| point.collocated)),
                transfer: several.then(|| deviation(&samples(|point| point.transfer))),
                interface_force: force.map(|force| deviation(&force)),
            };
            let error: Vec<f64> = of_part(index).map(|point| point.error).collect();
            let entries: Vec<_> = of_part(index).map(|point| point.drawn).collect();
            let curves = StoredCurves::of(&error, &entries, drawn);
            (errors, curves)
        })
        .collect()
}

/// |H| of the drawn entries of the reference over the band: on the diagonal, and between interfaces.
pub fn reference_curves(
    reference: &ComponentReference,
    loss_factor: f64,
    drawn: Drawn,
) -> StoredCurves {
    let lambdas: Vec<c64> = reference.band.damped(loss_factor).collect();
    let entries: Vec<[f64; 2]> = lambdas
        .par_iter()
        .map(|lambda| entries(&reference.response.at(*lambda), drawn))
        .collect();
    StoredCurves::of(&[], &entries, drawn)
}

fn entries(h: &Mat<c64>, drawn: Drawn) -> [f64; 2] {
    let column = drawn.collocated;
    let transfer = drawn
        .transfer
        .map_or(0.0, |row| h[(row, column)].norm_sqr().sqrt());
    [h[(column, column)].norm_sqr().sqrt(), transfer]
}

fn points(
    reference: &ComponentReference,
    parts: &[ReducedPart],
    lambda: c64,
    square: f64,
    drawn: Drawn,
) -> Vec<Point> {
    let exact = reference.response.at(lambda);
    let blocks = Blocks::of(reference, &exact);
    let stiffness = inverted(reference, &exact);
    parts
        .iter()
        .map(|part| {
            let found = part.response.at(lambda);
            let difference = &found - &exact;
            let (found_blocks, difference_blocks) = (
                Blocks::of(reference, &found),
                Blocks::of(reference, &difference),
            );
            let sample = |kind| Sample::of_blocks(&blocks, &found_blocks, &difference_blocks, kind);
            // With fewer independent motions than rows some motion needs infinite forces.
            let has_forces = part.dofs >= reference.independent.ncols();
            let force = has_forces.then(|| {
                let found = inverted(reference, &found);
                let (there, here) = (stiffness.squared_norm_l2(), found.squared_norm_l2());
                Sample {
                    error: ratio((&found - &stiffness).squared_norm_l2(), there),
                    levels: ((10.0 * (here / there).log10()).powi(2), 1),
                }
            });
            Point {
                square,
                collocated: sample(Kind::Collocated),
                transfer: sample(Kind::Transfer),
                force: force.filter(|force| force.error.is_finite()),
                error: ratio(difference.squared_norm_l2(), exact.squared_norm_l2()),
                drawn: entries(&found, drawn),
            }
        })
        .collect()
}

/// Z between independent combinations of rows.
fn inverted(reference: &ComponentReference, h: &Mat<c64>) -> Mat<c64> {
    let w = &reference.independent;
    let part = |take: fn(&c64) -> f64| {
        let part = Mat::from_fn(h.nrows(), h.ncols(), |i, j| take(&h[(i, j)]));
        w.transpose() * part * w
    };
    let (real, imaginary) = (part(|z| z.re), part(|z| z.im));
    Mat::from_fn(real.nrows(), real.ncols(), |i, j| {
        c64::new(real[(i, j)], imaginary[(i, j)])
    })
    .partial_piv_lu()
    .inverse()
}

fn deviation(samples: &[(f64, Sample)]) -> ResponseDeviation {
    let (at, largest) = samples
        .iter()
        .map(|(square, sample)| (*square, sample.error))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0.0, 0.0));
    let sum: f64 = samples.iter().map(|(_, sample)| sample.levels.0).sum();
    let count: usize = samples.iter().map(|(_, sample)| sample.levels.1).sum();
    let level = (sum / count.max(1) as f64).sqrt();
    ResponseDeviation {
        largest,
        at,
        level_db: Some(level).filter(|level| level.is_finite()),
    }
}

fn held_errors(reference: &ComponentReference, part: &ReducedPart) -> Option<Vec<f64>> {
    let held = part.held.as_ref()?;
    Some(
        (reference.held.iter().enumerate())
            .map(|(index, exact)| match held.get(index) {
                Some(found) => ((found.max(0.0) / exact).sqrt() - 1.0).abs(),
                None => 1.0,
            })
            .collect(),
    )
}

fn next_free(reference: &ComponentReference, part: &ReducedPart, modes: usize) -> Option<f64> {
    let exact = reference.free.get(modes)?;
    Some((part.first_attachment? / exact).sqrt() - 1.0)
}

/// Static flexibility with the inertia relieved: the poles without the rigid ones, and the series at λ = 0.
fn static_errors(reference: &ComponentReference, part: &ReducedPart) -> Vec<InterfaceError> {
    let rigid = reference.rows.rigid.ncols();
    let response = &part.response;
    let elastic = response.seen.ncols() - rigid;
    let shapes = response.seen.subcols(rigid, elastic);
    let flexible = Mat::from_fn(shapes.nrows(), elastic, |i, k| {
        shapes[(i, k)] / response.poles[rigid + k]
    });
    let mut found = flexible * shapes.transpose();
    if let Some(constant) = response.series.first() {
        found += constant;
    }
    let exact = &reference.flexibility;
    let difference = &found - exact;
    (reference.rows.groups.iter().zip(&reference.rows.interfaces))
        .map(|(group, name)| {
            let norm =
                |matrix: &Mat<f64>| matrix.subcols(group.start, group.len()).squared_norm_l2();
            InterfaceError {
                interface: name.clone(),
                error: ratio(norm(&difference), norm(exact)),
            }
        })
        .collect()
}
