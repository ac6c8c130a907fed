//! Inertia invariants of the whole from those of its parts, without loss.
//!
//! In a part the functions 1, ρ_a (position from its centre) and ψ_k,a have the inner products ∫ρ f g
//!
//! ```text
//! <1, 1> = m    <1, ρ_a> = 0    <ρ_a, ρ_b> = P_ab = ½ tr(J) δ_ab − J_ab    <1, ψ_k,a> = L1_ak    <ρ_a, ψ_k,b> = X_k,ab    <ψ_k,a, ψ_l,b> = S_ab,kl
//! X_k = ¼ tr(I1_k) 1 − ½ I1_k + ½ skew(I3_k)          S_ab = ½ tr(I2) δ_ab − I2_ab + ½ Σ_c ε_abc L3_c
//! ```
//! A column of the whole is in each part a rigid motion and a combination of ψ; its inner products are sums of these, and the invariants follow back:
//!
//! ```text
//! I1 = 2 (tr(X) 1 − sym X)    I3_c = ε_cab X_ab    I2_ab = tr(S) δ_ab − ½ (S_ab + S_ba)    L3_c = ε_cab S_ab
//! ```
//! In the plane S has the trace M and the antisymmetric part L3, X the trace I1 and the antisymmetric part I3; nothing else is needed.

use dcb_formats::mesh::Dimension;
use dcb_formats::superelement::{Inertia, Superelement};
use faer::{Mat, Scale};
use nalgebra::{Matrix3, Vector3};

use crate::part::Part;

/// xx, yy, zz, xy, yz, zx: the order of I2.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// The columns of the whole in one part.
pub(crate) struct PartColumns {
    /// Translation of the centre and rotation, axes of the assembly, (6, columns).
    pub rigid: Mat<f64>,
    /// Amplitudes of the file's columns, (n of the file, columns); without rows for a rigid body.
    pub deformation: Mat<f64>,
}

/// ε_abc.
fn sign(a: usize, b: usize, c: usize) -> f64 {
    match ((b + 3 - a) % 3, (c + 3 - a) % 3) {
        (1, 2) => 1.0,
        (2, 1) => -1.0,
        _ => 0.0,
    }
}

/// Inner products of the fields of one part: six rigid motions, then the file's columns; axes of the assembly.
struct Fields {
    /// <f_a, g_b>, (fields, fields).
    pairs: [[Mat<f64>; 3]; 3],
    /// <ρ_a, f_b>, (fields).
    moments: Vec<Matrix3<f64>>,
    /// <1, f>, (fields).
    sums: Vec<Vector3<f64>>,
}

impl Fields {
    fn of(part: &Part) -> Self {
        let element = part.flexible().map(|of| &of.element);
        let n = element.map_or(0, Superelement::basis_count);
        let turn = part.axes;
        let second = match part.dimension {
            Dimension::Planar => {
                Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0)) * (0.5 * part.tensor[(2, 2)])
            }
            Dimension::Spatial => Matrix3::identity() * (0.5 * part.tensor.trace()) - part.tensor,
        };
        let own_sum = |k: usize| {
            element.map_or_else(Vector3::zeros, |of| {
                let d = of.inertia.l1.nrows();
                turn * Vector3::from_fn(|a, _| if a < d { of.inertia.l1[(a, k)] } else { 0.0 })
            })
        };
        let own_moment = |k: usize| {
            element.map_or_else(Matrix3::zeros, |of| turn * moment(of, k) * turn.transpose())
        };
        let mut sums: Vec<Vector3<f64>> = (0..3).map(|a| Vector3::ith(a, part.mass)).collect();
        sums.extend((0..3).map(|_| Vector3::zeros()));
        sums.extend((0..n).map(own_sum));
        let mut moments: Vec<Matrix3<f64>> = vec![Matrix3::zeros(); 3];
        // <ρ_a, (e_j × ρ)_b> = ε_bjc P_ac
        moments.extend((0..3).map(|j| {
            Matrix3::from_fn(|a, b| (0..3).map(|c| sign(b, j, c) * second[(a, c)]).sum())
        }));
        moments.extend((0..n).map(own_moment));
        let own = element.map(|of| turned_products(of, &turn));
        let count = 6 + n;
        let entry = |a: usize, b: usize, f: usize, g: usize| -> f64 {
            match (f, g) {
                (0..3, 0..3) => {
                    if f == a && g == b {
                        part.mass
                    } else {
                        0.0
                    }
                }
                (0..3, 3..6) | (3..6, 0..3) => 0.0,
                (3..6, 3..6) => {
                    let (j, l) = (f - 3, g - 3);
                    let pairs = (0..3).flat_map(|c| (0..3).map(move |d| (c, d)));
                    pairs
                        .map(|(c, d)| sign(a, j, c) * sign(b, l, d) * second[(c, d)])
                        .sum()
                }
                (0..3, _) => {
                    if f == a {
                        sums[g][b]
                    } else {
                        0.0
                    }
                }
                (3..6, _) => (0..3).map(|c| sign(a, f - 3, c) * moments[g][(c, b)]).sum(),
                _ => own.as_ref().map_or(0.0, |own| own[a][b][(f - 6, g - 6)]),
            }
        };
        let pairs = std::array::from_fn(|a| {
            std::array::from_fn(|b| {
                Mat::from_fn(count, count, |f, g| match f < 6 || g >= 6 {
                    true => entry(a, b, f, g),
                    false => entry(b, a, g, f),
                })
            })
        });
        Self {
            pairs,
            moments,
            sums,
        }
    }
}

/// X_k in body axes.
fn moment(of: &Superelement, k: usize) -> Matrix3<f64> {
    let inertia = &of.inertia;
    match of.dimension {
        Dimension::Planar => {
            let (trace, turn) = (0.5 * inertia.i1[k][2][2], 0.5 * inertia.i3[(0, k)]);
            Matrix3::new(trace, turn, 0.0, -turn, trace, 0.0, 0.0, 0.0, 0.0)
        }
        Dimension::Spatial => {
            let block = Matrix3::from_fn(|a, b| 0.5 * (inertia.i1[k][a][b] + inertia.i1[k][b][a]));
            let skew =
                Matrix3::from_fn(|a, b| (0..3).map(|c| sign(a, b, c) * inertia.i3[(c, k)]).sum());
            Matrix3::identity() * (0.25 * block.trace()) - block * 0.5 + skew * 0.5
        }
    }
}

/// S_ab in axes of the assembly: A S Aᵀ.
fn turned_products(of: &Superelement, turn: &Matrix3<f64>) -> [[Mat<f64>; 3]; 3] {
    let inertia = &of.inertia;
    let n = of.basis_count();
    let own: [[Mat<f64>; 3]; 3] = match of.dimension {
        Dimension::Planar => {
            let mass = Mat::from_fn(n, n, |k, l| of.reduced_mass(k, l));
            let l3 = &inertia.l3[0];
            std::array::from_fn(|a| {
                std::array::from_fn(|b| match (a, b) {
                    (0, 0) | (1, 1) => &mass * Scale(0.5),
                    (0, 1) => l3 * Scale(0.5),
                    (1, 0) => l3 * Scale(-0.5),
                    _ => Mat::zeros(n, n),
                })
            })
        }
        Dimension::Spatial => {
            let trace = (&inertia.i2[0] + &inertia.i2[1] + &inertia.i2[2]) * Scale(0.5);
            std::array::from_fn(|a| {
                std::array::from_fn(|b| {
                    let at = PAIRS
                        .iter()
                        .position(|pair| *pair == (a, b) || *pair == (b, a));
                    let second = &inertia.i2[at.unwrap_or(0)];
                    let mut products = &trace * Scale(f64::from(u8::from(a == b))) - second;
                    for c in 0..3 {
                        if sign(a, b, c) != 0.0 {
                            products += &inertia.l3[c] * Scale(0.5 * sign(a, b, c));
                        }
                    }
                    products
                })
            })
        }
    };
    std::array::from_fn(|a| {
        std::array::from_fn(|b| {
            let mut sum = Mat::zeros(n, n);
            for c in 0..3 {
                for d in 0..3 {
                    let weight = turn[(a, c)] * turn[(b, d)];
                    if weight != 0.0 {
                        sum += &own[c][d] * Scale(weight);
                    }
                }
            }
            sum
        })
    })
}

/// Invariants over the columns of the whole, about its centre.
pub(crate) fn invariants(
    parts: &[Part],
    columns: &[PartColumns],
    centre: Vector3<f64>,
    dimension: Dimension,
) -> Inertia {
    let n = columns.first().map_or(0, |of| of.rigid.ncols());
    let mut products: [[Mat<f64>; 3]; 3] =
        std::array::from_fn(|_| std::array::from_fn(|_| Mat::zeros(n, n)));
    let mut moments = vec![Matrix3::<f64>::zeros(); n];
    let mut sums = vec![Vector3::<f64>::zeros(); n];
    let mut tensor = Matrix3::<f64>::zeros();
    let mut mass = 0.0;
    for (part, own) in parts.iter().zip(columns) {
        let fields = Fields::of(part);
        let count = fields.sums.len();
        let amplitudes = Mat::from_fn(count, n, |f, k| match f < 6 {
            true => own.rigid[(f, k)],
            false => own.deformation[(f - 6, k)],
        });
        for (a, of_axis) in products.iter_mut().enumerate() {
            for (b, whole) in of_axis.iter_mut().enumerate() {
                *whole += amplitudes.transpose() * (&fields.pairs[a][b] * &amplitudes);
            }
        }
        let arm = part.centre - centre;
        for k in 0..n {
            let mut sum = Vector3::zeros();
            for f in 0..count {
                sum += fields.sums[f] * amplitudes[(f, k)];
                moments[k] += fields.moments[f] * amplitudes[(f, k)];
            }
            moments[k] += arm * sum.transpose();
            sums[k] += sum;
        }
        mass += part.mass;
        tensor += part.tensor
            + (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * part.mass;
    }
    let block =
        |matrix: Matrix3<f64>| std::array::from_fn(|a| std::array::from_fn(|b| matrix[(a, b)]));
    let antisymmetric =
        |c: usize| &products[(c + 1) % 3][(c + 2) % 3] - &products[(c + 2) % 3][(c + 1) % 3];
    let turning = |c: usize, k: usize| {
        moments[k][((c + 1) % 3, (c + 2) % 3)] - moments[k][((c + 2) % 3, (c + 1) % 3)]
    };
    let d = dimension.coordinate_count();
    let l1 = Mat::from_fn(d, n, |a, k| sums[k][a]);
    match dimension {
        Dimension::Planar => {
            let only = |value: f64| block(Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, value)));
            Inertia {
                mass,
                tensor: only(tensor[(2, 2)]),
                l1,
                i1: moments
                    .iter()
                    .map(|of| only(of[(0, 0)] + of[(1, 1)]))
                    .collect(),
                i3: Mat::from_fn(1, n, |_, k| turning(2, k)),
                l3: vec![antisymmetric(2)],
                i2: Vec::new(),
            }
        }
        Dimension::Spatial => {
            let trace = &products[0][0] + &products[1][1] + &products[2][2];
            let second = |a: usize, b: usize| {
                let mean = (&products[a][b] + &products[b][a]) * Scale(0.5);
                let matrix = match a == b {
                    true => &trace - mean,
                    false => -mean,
                };
                dcb_dense::symmetrized(matrix)
            };
            let first = |of: &Matrix3<f64>| {
                (Matrix3::identity() * of.trace() - (of + of.transpose()) * 0.5) * 2.0
            };
            Inertia {
                mass,
                tensor: block((tensor + tensor.transpose()) * 0.5),
                l1,
                i1: moments.iter().map(|of| block(first(of))).collect(),
                i3: Mat::from_fn(3, n, turning),
                l3: (0..3)
                    .map(|c| {
                        let of = antisymmetric(c);
                        Mat::from_fn(n, n, |k, l| 0.5 * (of[(k, l)] - of[(l, k)]))
                    })
                    .collect(),
                i2: PAIRS.iter().map(|(a, b)| second(*a, *b)).collect(),
            }
        }
    }
}
