//! Joints and springs closed: what gives way without mass is solved for, what doesn't is left as a constraint.
//!
//! ```text
//! value of a measure  =  A x + F f          f forces along the measures, F the flexibility without mass
//! joints              0  =  value           springs  0 = value + f / k
//! f_c = −C⁻¹ (A_c x + F_ce f_e),   C = F_cc + diag(1/k)      of joint directions with flexibility, and springs
//! K  += A_cᵀ C⁻¹ A_c                        of interfaces: A_e − F_ec C⁻¹ A_c,   F_ee − F_ec C⁻¹ F_ce
//! H x = 0                                   of joint directions without flexibility
//! ```
//! So nothing indefinite remains: K is positive semi-definite, and the motions with H x = 0 have an orthonormal basis.

use dcb_dense::{symmetric_eigen, symmetrized};
use faer::linalg::solvers::Llt;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side};

use crate::Error;
use crate::joint::Held;
use crate::measure::{Measure, Measured, stiffness};
use crate::part::Part;
use crate::spring::Sprung;

/// Joint directions whose flexibility without mass is below this fraction of their whole flexibility are constraints.
const RIGID: f64 = 1e-10;

/// Measures of joints, springs and interfaces after the closing.
pub(crate) struct Closing {
    /// H: what joints hold, (h, all coordinates), each row of unit length.
    pub constraints: Mat<f64>,
    /// Names of its rows, where each is one row of a joint.
    pub constraint_names: Vec<String>,
    /// L⁻¹ A_c with C = L Lᵀ: the stiffness of what is closed is its square, (c, all coordinates).
    pub stiffness_root: Mat<f64>,
    /// Interface rows over the coordinates, (e, all coordinates).
    pub interfaces: Mat<f64>,
    /// Their flexibility without mass, (e, e).
    pub flexible: Mat<f64>,
    /// Dampers over the coordinates, each row times the root of its damping, (dampers, all coordinates).
    pub damping_root: Mat<f64>,
    forces: Forces,
}

/// How forces in closed measures act on the interface rows of the parts.
struct Forces {
    /// f_c by coordinates, (c, all coordinates), and by interface forces, (c, e).
    by_motion: Mat<f64>,
    by_forces: Mat<f64>,
    /// Weights of each part's rows in closed measures, (n_b, c), and in interface rows, (n_b, e).
    closed: Vec<Mat<f64>>,
    interfaces: Vec<Mat<f64>>,
    /// Weights of each part's rows in the rows of H, (n_b, h).
    constraints: Vec<Mat<f64>>,
}

impl Closing {
    /// Of joints, springs and interface rows.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn of(
        held: &[Held],
        sprung: &[Sprung],
        interfaces: &[Measure],
        parts: &[Part],
    ) -> Result<Self, Error> {
        let joints: Vec<&Measure> = held.iter().map(|held| &held.measure).collect();
        let joints = Measured::of(&joints, parts);
        let stiff: Vec<&Sprung> = sprung.iter().filter(|one| one.stiffness > 0.0).collect();
        let springs = Measured::of(
            &stiff.iter().map(|one| &one.measure).collect::<Vec<_>>(),
            parts,
        );
        let damped: Vec<&Sprung> = sprung.iter().filter(|one| one.damping > 0.0).collect();
        let dampers = Measured::of(
            &damped.iter().map(|one| &one.measure).collect::<Vec<_>>(),
            parts,
        );
        let chosen = Measured::of(&interfaces.iter().collect::<Vec<_>>(), parts);
        let split = Split::of(&joints, parts)?;
        // All that is closed: combinations of joint rows, then springs.
        let (soft, spring_count) = (split.soft.ncols(), stiff.len());
        let combine = |of_joints: &Mat<f64>, of_springs: &Mat<f64>| {
            let combined = of_joints * &split.soft;
            Mat::from_fn(combined.nrows(), soft + spring_count, |i, j| {
                match j < soft {
                    true => combined[(i, j)],
                    false => of_springs[(i, j - soft)],
                }
            })
        };
        let closed: Vec<Mat<f64>> = (joints.rows.iter().zip(&springs.rows))
            .map(|(of_joints, of_springs)| combine(of_joints, of_springs))
            .collect();
        let motion = combine(
            &joints.motion.transpose().to_owned(),
            &springs.motion.transpose().to_owned(),
        );
        let motion = motion.transpose().to_owned();
        let between = |left: &[Mat<f64>], right: &[Mat<f64>], rows: usize, columns: usize| {
            let mut whole = Mat::<f64>::zeros(rows, columns);
            for ((part, left), right) in parts.iter().zip(left).zip(right) {
                if let Some(massless) = part.flexible().and_then(|of| of.massless.as_ref()) {
                    whole += left.transpose() * massless * right;
                }
            }
            whole
        };
        let (c, e) = (soft + spring_count, interfaces.len());
        let mut compliance = symmetrized(between(&closed, &closed, c, c));
        for (k, spring) in stiff.iter().enumerate() {
            compliance[(soft + k, soft + k)] += 1.0 / spring.stiffness;
        }
        let to_interfaces = between(&chosen.rows, &closed, e, c);
        let from_interfaces = between(&closed, &chosen.rows, c, e);
        let flexible = between(&chosen.rows, &chosen.rows, e, e);
        let root = lower_root(&compliance)?;
        let solved = |rhs: &Mat<f64>| {
            let mut rhs = rhs.clone();
            solve_lower_triangular_in_place(root.as_ref(), rhs.as_mut(), Par::Seq);
            rhs
        };
        let stiffness_root = solved(&motion);
        let of_forces = solved(&from_interfaces);
        let seen = solved(&to_interfaces.transpose().to_owned());
        let full = |half: &Mat<f64>| {
            let mut whole = half.clone();
            faer::linalg::triangular_solve::solve_upper_triangular_in_place(
                root.transpose(),
                whole.as_mut(),
                Par::Seq,
            );
            -whole
        };
        let of_dampers = Mat::from_fn(damped.len(), motion.ncols(), |i, j| {
            damped[i].damping.sqrt() * dampers.motion[(i, j)]
        });
        Ok(Self {
            constraints: split.rigid.transpose() * &joints.motion,
            constraint_names: split.names(held),
            interfaces: &chosen.motion - seen.transpose() * &stiffness_root,
            flexible: flexible - seen.transpose() * &of_forces,
            damping_root: of_dampers,
            forces: Forces {
                by_motion: full(&stiffness_root),
                by_forces: full(&of_forces),
                constraints: joints.rows.iter().map(|rows| rows * &split.rigid).collect(),
                closed,
                interfaces: chosen.rows,
            },
            stiffness_root,
        })
    }

    /// Forces on the interface rows of a part where bodies move by `motion` (all coordinates, k) under interface forces (e, k), those in rigid joint
    /// directions left aside: they meet no flexibility without mass.
    pub fn forces_on(&self, part: usize, motion: &Mat<f64>, forces: &Mat<f64>) -> Mat<f64> {
        let closed = &self.forces.by_motion * motion + &self.forces.by_forces * forces;
        &self.forces.closed[part] * closed + &self.forces.interfaces[part] * forces
    }

    /// Forces on the interface rows of a part by forces in the rows of H.
    pub fn constraint_forces_on(&self, part: usize, forces: &Mat<f64>) -> Mat<f64> {
        &self.forces.constraints[part] * forces
    }
}

/// Joint rows told apart: combinations that give way without mass, and those that don't.
struct Split {
    /// Combinations with flexibility, (joint rows, c).
    soft: Mat<f64>,
    /// Combinations without, (joint rows, h).
    rigid: Mat<f64>,
    is_by_rows: bool,
}

impl Split {
    fn of(joints: &Measured, parts: &[Part]) -> Result<Self, Error> {
        let count = joints.motion.nrows();
        let flexible = symmetrized(joints.massless(parts));
        if flexible.norm_max() == 0.0 {
            return Ok(Self {
                soft: Mat::zeros(count, 0),
                rigid: of_unit_length(Mat::identity(count, count), joints),
                is_by_rows: true,
            });
        }
        // Scale of each row: its flexibility with all that moves it.
        let stiffness = stiffness(parts);
        let lowest = stiffness
            .iter()
            .copied()
            .filter(|square| *square > 0.0)
            .fold(f64::INFINITY, f64::min);
        let scale: Vec<f64> = (0..count)
            .map(|i| {
                let dynamic: f64 = (0..stiffness.len())
                    .map(|k| joints.motion[(i, k)].powi(2) / stiffness[k].max(lowest))
                    .sum();
                match dynamic + flexible[(i, i)] {
                    whole if whole > 0.0 => whole.sqrt().recip(),
                    _ => 0.0,
                }
            })
            .collect();
        let scaled = Mat::from_fn(count, count, |i, j| scale[i] * flexible[(i, j)] * scale[j]);
        let failed = Error::NotFinite {
            what: "the flexibility at the joints",
        };
        let (values, vectors) = symmetric_eigen(scaled.as_ref()).ok_or(failed)?;
        let pick = |soft: bool| {
            let picked: Vec<usize> = (0..count)
                .filter(|k| (values[*k] > RIGID) == soft)
                .collect();
            Mat::from_fn(count, picked.len(), |i, k| {
                scale[i] * vectors[(i, picked[k])]
            })
        };
        Ok(Self {
            soft: pick(true),
            rigid: of_unit_length(pick(false), joints),
            is_by_rows: false,
        })
    }

    fn names(&self, held: &[Held]) -> Vec<String> {
        if self.is_by_rows {
            return held.iter().map(|held| held.name.clone()).collect();
        }
        // The joint row that has the largest part in each.
        (0..self.rigid.ncols())
            .map(|k| {
                let column = self.rigid.col(k);
                let largest =
                    (0..held.len()).max_by(|i, j| column[*i].abs().total_cmp(&column[*j].abs()));
                largest.map_or_else(String::new, |i| held[i].name.clone())
            })
            .collect()
    }
}

/// Combinations of joint rows, scaled so that each is a row of unit length over the coordinates.
fn of_unit_length(mut combinations: Mat<f64>, joints: &Measured) -> Mat<f64> {
    let rows = combinations.transpose() * &joints.motion;
    for k in 0..combinations.ncols() {
        let norm = rows.row(k).norm_l2();
        if norm > 0.0 {
            for i in 0..combinations.nrows() {
                combinations[(i, k)] /= norm;
            }
        }
    }
    combinations
}

/// L of a positive definite matrix, whose rows may have units of their own.
fn lower_root(matrix: &Mat<f64>) -> Result<Mat<f64>, Error> {
    if matrix.nrows() == 0 {
        return Ok(Mat::zeros(0, 0));
    }
    let failed = || Error::NotFinite {
        what: "the compliance of joints and springs",
    };
    let root: Llt<f64> = matrix.llt(Side::Lower).map_err(|_| failed())?;
    Ok(root.L().to_owned())
}
