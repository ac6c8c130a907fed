//! Times order, factorization, eigenvalue count, block solves, products and invariants of one part:
//! `factor PART.mtx [ROUNDS [single|disk=FOLDER]]`, processor time beside wall time.
#![allow(clippy::unwrap_used, clippy::expect_used)]
use std::time::Instant;

use dcb_formats::component_files::{ComponentFiles, Overrides, read_component};
use dcb_reducer::inertia::invariants::inertia_invariants;
use dcb_reducer::model::condensation::Model;
use dcb_reducer::model::piece_motions::Pieces;
use dcb_reducer::model::rigid_body::{MassProperties, RigidBodyModes};
use dcb_reducer::model::shift::SpectrumScale;
use dcb_sparse::block_algebra::{largest_entry, symmetric_product, symmetric_product_into};
use dcb_sparse::factor_store::{FactorStorage, Place, Precision};
use dcb_sparse::factorization::SymmetricFactor;
use dcb_sparse::multifrontal::{Cholesky, Matrix, eliminate, solve_columns};
use faer::Mat;

#[global_allocator]
static ALLOCATOR: dcb_reducer::resources::huge_pages::HugePages =
    dcb_reducer::resources::huge_pages::HugePages;

fn cpu() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap();
    let fields: Vec<&str> = text
        .rsplit(')')
        .next()
        .unwrap()
        .split_whitespace()
        .collect();
    (fields[11].parse::<f64>().unwrap() + fields[12].parse::<f64>().unwrap()) / 100.0
}

fn timed<R>(what: &str, work: impl FnOnce() -> R) -> R {
    let (wall, before) = (Instant::now(), cpu());
    let result = work();
    println!(
        "{what:24} wall {:.3} s cpu {:.3} s",
        wall.elapsed().as_secs_f64(),
        cpu() - before
    );
    result
}

/// Solutions with a factor in single precision as they are, without refinement.
fn rounded_solves(factor: &SymmetricFactor, model: &Model, shift: f64, rounds: usize) {
    let matrix = Matrix {
        stiffness: &model.stiffness,
        mass: &model.mass,
        shift,
    };
    let fronts = factor.fronts();
    let mut values = vec![0.0_f32; fronts.stored_entries()];
    eliminate(fronts, matrix, &Cholesky::<f32>::default(), &mut values).unwrap();
    let mut x = Mat::from_fn(model.len(), 16, |i, j| ((i * (j + 1)) as f64).sin());
    timed(&format!("{rounds} solves of 8, rounded"), || {
        for _ in 0..rounds {
            solve_columns::<f32, 8>(fronts, &values, x.as_mut().subcols_mut(0, 8));
        }
    });
    timed(&format!("{rounds} solves of 16, rounded"), || {
        for _ in 0..rounds {
            solve_columns::<f32, 16>(fronts, &values, x.as_mut());
        }
    });
}

fn main() {
    let path = std::env::args().nth(1).expect("PART.mtx");
    let rounds: usize = std::env::args().nth(2).map_or(5, |n| n.parse().unwrap());
    let files = ComponentFiles::beside(path.as_ref(), &Overrides::default()).unwrap();
    let component = timed("read", || read_component(&files, None)).unwrap();
    let model = timed("model", || Model::of(&component)).unwrap();
    let mut factor = timed("analyse", || {
        SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points())
    })
    .unwrap();
    println!(
        "dofs {} stored {:.2} M, flops {:.2} G",
        model.len(),
        factor.stored_entries() as f64 / 1e6,
        factor.flops() / 1e9
    );
    let storage = match std::env::args().nth(3).as_deref() {
        Some("single") => FactorStorage {
            precision: Precision::Single,
            place: Place::Memory,
        },
        Some(place) => FactorStorage {
            precision: Precision::Double,
            place: Place::Disk {
                folder: place.strip_prefix("disk=").expect("disk=FOLDER").into(),
            },
        },
        None => FactorStorage::default(),
    };
    factor.keep_in(storage, Place::Memory).unwrap();
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
    println!("shift {shift:e}");
    for _ in 0..2 {
        timed("factor", || {
            factor
                .factorize(&model.stiffness, &model.mass, shift)
                .map(|_| ())
        })
        .unwrap();
    }
    let inertia = timed("count", || {
        factor.inertia(&model.stiffness, &model.mass, 1e9)
    });
    println!("{} eigenvalues below 1e9", inertia.unwrap().negative);
    println!("{:?}", factor.warning());
    let positive = factor
        .factorize(&model.stiffness, &model.mass, shift)
        .unwrap();
    for width in [1, 8, 16, 32] {
        let rhs = Mat::from_fn(model.len(), width, |i, j| ((i * (j + 1)) as f64).sin());
        let mut x = rhs.clone();
        timed(&format!("{rounds} solves of {width}"), || {
            for _ in 0..rounds {
                x.copy_from(&rhs);
                positive.solve_in_place(x.as_mut()).unwrap();
            }
        });
        let mut residual = symmetric_product(&model.stiffness, x.as_ref()) - &rhs;
        residual += faer::Scale(shift) * symmetric_product(&model.mass, x.as_ref());
        println!(
            "residual {:.1e} {:?}",
            largest_entry(residual.as_ref()),
            positive.least_accurate()
        );
    }
    drop(positive);
    rounded_solves(&factor, &model, shift, rounds);
    for (name, matrix) in [("K", &model.stiffness), ("M", &model.mass)] {
        let entries = matrix.compute_nnz() as f64;
        for width in [1, 8, 16, 32] {
            let x = Mat::from_fn(model.len(), width, |i, j| ((i * (j + 1)) as f64).sin());
            let mut y = Mat::zeros(model.len(), width);
            let start = Instant::now();
            timed(&format!("{rounds} {name} x of {width}"), || {
                for _ in 0..rounds {
                    symmetric_product_into(matrix, x.as_ref(), y.as_mut());
                }
            });
            let product = start.elapsed().as_secs_f64() / rounds as f64;
            println!(
                "{:.1} GFLOP/s, {:.1} GB/s of the matrix",
                2e-9 * entries * width as f64 / product,
                12e-9 * entries * width.div_ceil(16) as f64 / product
            );
        }
    }
    let properties = MassProperties::of(&component).unwrap();
    let basis = Mat::from_fn(component.dofs.len(), 144, |i, j| {
        ((i * (j + 1)) as f64).sin()
    });
    timed("invariants, 144 columns", || {
        inertia_invariants(&component, &properties, &[basis.as_ref()])
    });
}
