//! Other ways to the free modes with the same factor, products and threads, beside the block Lanczos that `reduce` uses:
//! `eigen_alternatives PART.mtx [MODES]`. Wall time, passes over the factor and the worst residual of each. Notes on what lost are in
//! `docs/performance.md`.
#![allow(clippy::unwrap_used, clippy::expect_used)]
use std::time::Instant;

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::component_files::{ComponentFiles, Overrides, read_component};
use dcb_reducer::model::condensation::Model;
use dcb_reducer::model::piece_motions::Pieces;
use dcb_reducer::model::rigid_body::{MassProperties, RigidBodyModes};
use dcb_reducer::model::shift::SpectrumScale;
use dcb_reducer::modes::free_modes::{FreeModes, KnownMotions, Search};
use dcb_sparse::block_algebra::{column_norms, combination, gram, symmetric_product};
use dcb_sparse::factorization::{PositiveFactor, SymmetricFactor};
use faer::{Mat, MatRef};

#[global_allocator]
static ALLOCATOR: dcb_reducer::resources::huge_pages::HugePages =
    dcb_reducer::resources::huge_pages::HugePages;

/// Residual ‖K φ - ω² M φ‖ / ‖K φ‖ that every method goes on to.
const RESIDUAL: f64 = 1e-8;

/// Steps made and the worst residual.
type Method<'a> = &'a dyn Fn() -> (usize, f64);

struct Problem<'a> {
    model: &'a Model<'a>,
    rigid: &'a RigidBodyModes,
    factor: &'a PositiveFactor<'a>,
    wanted: usize,
}

/// A subspace with its Ritz values.
struct Subspace {
    x: Mat<f64>,
    eigenvalues: Vec<f64>,
}

impl Problem<'_> {
    fn random(&self, columns: usize) -> Mat<f64> {
        let mut state = 7_u64;
        Mat::from_fn(self.model.len(), columns, |_, _| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        })
    }

    /// (K + σ M)⁻¹ f without rigid motion.
    fn solve(&self, mut f: Mat<f64>) -> Mat<f64> {
        self.factor.solve_in_place(f.as_mut()).unwrap();
        self.rigid.project_out(&mut f);
        f
    }

    fn mass(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        symmetric_product(&self.model.mass, x)
    }

    /// Rayleigh–Ritz in the span of some columns, the `keep` lowest pairs; directions that are nearly dependent are dropped.
    fn ritz(&self, y: MatRef<'_, f64>, keep: usize) -> Subspace {
        let mass = symmetrized(gram(y, self.mass(y).as_ref()).as_ref());
        let sizes: Vec<f64> = (0..y.ncols()).map(|j| mass[(j, j)].sqrt()).collect();
        let scaled = Mat::from_fn(y.ncols(), y.ncols(), |i, j| {
            mass[(i, j)] / (sizes[i] * sizes[j])
        });
        let (values, vectors) = symmetric_eigen(scaled.as_ref()).unwrap();
        let kept: Vec<usize> = (0..values.len()).filter(|i| values[*i] > 1e-12).collect();
        let forward = Mat::from_fn(y.ncols(), kept.len(), |i, j| {
            vectors[(i, kept[j])] / (sizes[i] * values[kept[j]].sqrt())
        });
        let q = combination(y, forward.as_ref());
        let stiffness = gram(
            q.as_ref(),
            symmetric_product(&self.model.stiffness, q.as_ref()).as_ref(),
        );
        let (eigenvalues, turn) =
            symmetric_eigen(symmetrized(stiffness.as_ref()).as_ref()).unwrap();
        let keep = keep.min(eigenvalues.len());
        Subspace {
            x: combination(q.as_ref(), turn.as_ref().subcols(0, keep)),
            eigenvalues: eigenvalues[..keep].to_vec(),
        }
    }

    /// K x - M x Λ and its worst relative norm over the wanted pairs.
    fn residual(&self, space: &Subspace) -> (Mat<f64>, f64) {
        let forces = symmetric_product(&self.model.stiffness, space.x.as_ref());
        let norms = column_norms(forces.as_ref());
        let mut left = self.mass(space.x.as_ref());
        for (j, value) in space.eigenvalues.iter().enumerate() {
            let column = left.as_mut().col_mut(j);
            for (left, force) in column.iter_mut().zip(forces.col(j).iter()) {
                *left = force - value * *left;
            }
        }
        let worst = column_norms(left.as_ref())
            .iter()
            .zip(&norms)
            .take(self.wanted)
            .map(|(left, norm)| left / norm)
            .fold(0.0, f64::max);
        (left, worst)
    }

    /// Subspace iteration, each step a Chebyshev polynomial of this degree in S = (K + σ M)⁻¹ M that is small where θ is below that
    /// of the last column; degree 1 is the classical iteration.
    fn subspace_iteration(&self, columns: usize, degree: usize) -> (usize, f64) {
        let start = self.solve(self.mass(self.random(columns).as_ref()));
        let mut space = self.ritz(start.as_ref(), columns);
        for step in 1..=200 {
            let apply = |x: MatRef<'_, f64>| self.solve(self.mass(x));
            let mut y = apply(space.x.as_ref());
            if degree > 1 {
                // The polynomial makes columns nearly dependent; with fewer than wanted left it has broken down.
                let Some(last) = space.eigenvalues.get(self.wanted..).and_then(<[f64]>::last)
                else {
                    return (step, f64::NAN);
                };
                let edge = 1.0 / last;
                let scaled = |sx: &Mat<f64>, x: &Mat<f64>| {
                    Mat::from_fn(x.nrows(), x.ncols(), |i, j| {
                        2.0 / edge * sx[(i, j)] - x[(i, j)]
                    })
                };
                let (mut before, mut now) = (space.x.clone(), scaled(&y, &space.x));
                for _ in 1..degree {
                    let image = scaled(&apply(now.as_ref()), &now);
                    let next = faer::Scale(2.0) * &image - &before;
                    before = now;
                    now = next;
                }
                y = now;
            }
            space = self.ritz(y.as_ref(), columns);
            let (_, worst) = self.residual(&space);
            if worst < RESIDUAL {
                return (step, worst);
            }
        }
        (200, f64::NAN)
    }

    /// LOBPCG with the factor as preconditioner.
    fn lobpcg(&self, columns: usize) -> (usize, f64) {
        let start = self.solve(self.mass(self.random(columns).as_ref()));
        let mut space = self.ritz(start.as_ref(), columns);
        let mut last: Option<Mat<f64>> = None;
        for step in 1..=200 {
            let (left, worst) = self.residual(&space);
            if worst < RESIDUAL {
                return (step, worst);
            }
            let directions = self.solve(left);
            let previous = last
                .take()
                .unwrap_or_else(|| Mat::zeros(self.model.len(), 0));
            let width = columns + directions.ncols() + previous.ncols();
            let mut trial = Mat::zeros(self.model.len(), width);
            let parts = [&space.x, &directions, &previous];
            let mut first = 0;
            for part in parts {
                trial
                    .as_mut()
                    .subcols_mut(first, part.ncols())
                    .copy_from(part);
                first += part.ncols();
            }
            let next = self.ritz(trial.as_ref(), columns);
            // What the step added, without the part along the vectors before.
            let along = gram(self.mass(space.x.as_ref()).as_ref(), next.x.as_ref());
            last = Some(&next.x - combination(space.x.as_ref(), along.as_ref()));
            space = next;
        }
        (200, f64::NAN)
    }
}

fn main() {
    dcb_reducer::resources::huge_pages::keep_freed_memory();
    let path = std::env::args().nth(1).expect("PART.mtx");
    let wanted: usize = std::env::args().nth(2).map_or(30, |n| n.parse().unwrap());
    let files = ComponentFiles::beside(path.as_ref(), &Overrides::default()).unwrap();
    let component = read_component(&files, None).unwrap();
    let model = Model::of(&component).unwrap();
    let properties = MassProperties::of(&component).unwrap();
    let rigid = RigidBodyModes::of(&component, &model, &properties).unwrap();
    let scale = SpectrumScale::of(
        &model,
        &rigid,
        &Pieces::of(&model, &rigid),
        component.dimension(),
        properties.centre,
    );
    let shift = scale.shift();
    let mut factor =
        SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points()).unwrap();
    let factor = factor
        .factorize(&model.stiffness, &model.mass, shift)
        .unwrap();
    let problem = Problem {
        model: &model,
        rigid: &rigid,
        factor: &factor,
        wanted,
    };
    let lanczos = || {
        let search = Search::lowest(wanted);
        let known = KnownMotions {
            rigid: &rigid,
            loose: &Mat::zeros(model.len(), 0),
        };
        let modes = FreeModes::compute(&model, known, &factor, shift, search, &mut ()).unwrap();
        let worst = modes.residuals.iter().copied().fold(0.0, f64::max);
        (modes.iterations, worst)
    };
    let methods: [(&str, Method); 4] = [
        ("block Lanczos", &lanczos),
        ("subspace iteration", &|| {
            problem.subspace_iteration(2 * wanted, 1)
        }),
        ("filtered, degree 3", &|| {
            problem.subspace_iteration(wanted + 8, 3)
        }),
        ("LOBPCG", &|| problem.lobpcg(wanted + 8)),
    ];
    for (name, method) in methods {
        let start = Instant::now();
        let (steps, worst) = method();
        println!(
            "{name:20} {:.2} s, {steps} steps, residual {worst:.0e}",
            start.elapsed().as_secs_f64()
        );
    }
}
