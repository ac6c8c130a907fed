//! Times order, factorization, eigenvalue count and block solves of one part: `factor PART.mtx [ROUNDS]`, processor time beside
//! wall time. The same kernels on a generated part, with statistics, are `cargo bench -p dcb-reducer`.
#![allow(clippy::unwrap_used, clippy::expect_used)]
use std::time::Instant;

use dcb_formats::component_files::{ComponentFiles, Overrides, read_component};
use dcb_reducer::block_algebra::{largest_entry, symmetric_product};
use dcb_reducer::condensation::Model;
use dcb_reducer::factorization::SymmetricFactor;
use faer::Mat;

#[global_allocator]
static ALLOCATOR: dcb_reducer::huge_pages::HugePages = dcb_reducer::huge_pages::HugePages;

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

fn main() {
    let path = std::env::args().nth(1).expect("PART.mtx");
    let rounds: usize = std::env::args().nth(2).map_or(5, |n| n.parse().unwrap());
    let files = ComponentFiles::beside(path.as_ref(), &Overrides::default()).unwrap();
    let component = timed("read", || read_component(&files)).unwrap();
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
    let shift = 1e6;
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
    println!("{} eigenvalues below 1e9", inertia.negative);
    let positive = factor
        .factorize(&model.stiffness, &model.mass, shift)
        .unwrap();
    for width in [1, 8, 16, 32] {
        let rhs = Mat::from_fn(model.len(), width, |i, j| ((i * (j + 1)) as f64).sin());
        let mut x = rhs.clone();
        timed(&format!("{rounds} solves of {width}"), || {
            for _ in 0..rounds {
                x.copy_from(&rhs);
                positive.solve_in_place(x.as_mut());
            }
        });
        let mut residual = symmetric_product(&model.stiffness, x.as_ref()) - &rhs;
        residual += faer::Scale(shift) * symmetric_product(&model.mass, x.as_ref());
        println!("residual {:.1e}", largest_entry(residual.as_ref()));
    }
    let x = Mat::from_fn(model.len(), 8, |i, j| ((i * (j + 1)) as f64).sin());
    timed(&format!("{rounds} K x, 8 columns"), || {
        (0..rounds).for_each(|_| drop(symmetric_product(&model.stiffness, x.as_ref())));
    });
    timed(&format!("{rounds} M x, 8 columns"), || {
        (0..rounds).for_each(|_| drop(symmetric_product(&model.mass, x.as_ref())));
    });
}
