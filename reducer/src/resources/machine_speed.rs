//! How fast this machine multiplies and reads, measured in about a tenth of a second.

use std::hint::black_box;
use std::time::Instant;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use rayon::prelude::*;

/// Order of the matrices multiplied.
const ORDER: usize = 1000;
/// Numbers read: more than caches hold.
const NUMBERS: usize = 12 << 20;
/// Numbers that one task reads.
const CHUNK: usize = 1 << 16;

/// Speed with all threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineSpeed {
    /// Pairs of a multiplication and an addition in a dense product, 1/s.
    pub flops: f64,
    /// Bytes read from memory, 1/s.
    pub bandwidth: f64,
}

impl MachineSpeed {
    /// Measures.
    pub fn measure() -> Self {
        Self {
            flops: (ORDER as f64).powi(3) / best_of_two(&mut dense_product()),
            bandwidth: (NUMBERS * size_of::<f64>()) as f64 / best_of_two(&mut reading()),
        }
    }
}

fn dense_product() -> impl FnMut() {
    let a = Mat::from_fn(ORDER, ORDER, |i, j| ((i + 3 * j) % 7) as f64);
    let mut c = Mat::<f64>::zeros(ORDER, ORDER);
    move || {
        matmul(
            c.as_mut(),
            Accum::Replace,
            a.as_ref(),
            a.as_ref(),
            1.0,
            Par::rayon(0),
        );
        black_box(&c);
    }
}

fn reading() -> impl FnMut() {
    let numbers = vec![1.0_f64; NUMBERS];
    move || {
        let sum: f64 = numbers
            .par_chunks(CHUNK)
            .map(|chunk| {
                let (lanes, _) = chunk.as_chunks::<16>();
                let mut sums = [0.0; 16];
                for lane in lanes {
                    for (sum, number) in sums.iter_mut().zip(lane) {
                        *sum += number;
                    }
                }
                sums.iter().sum::<f64>()
            })
            .sum();
        black_box(sum);
    }
}

/// Seconds of the faster of two runs.
fn best_of_two(work: &mut impl FnMut()) -> f64 {
    let mut seconds = || {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    seconds().min(seconds()).max(1e-9)
}
