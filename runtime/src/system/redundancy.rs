//! Forces of redundant constraints: the directions of δλ that do nothing are left alone.
//!
//! In the scaled system `A = Λ + ε` only the regularization ε resists in them. A few are known as an orthonormal basis, found by inverse
//! iteration with each factor. Many are never written down: `(ε A⁻¹)² x` is what a vector has of them, and to one part in
//! (ε/μ)² what it has where the compliance is μ instead of zero. That costs solves with the factor, which are as cheap as the
//! mechanism's graph is simple, where a basis takes the rows times the square of its size.

use super::joint_system::JointSystem;
use super::number::Number;

/// Up to this many directions are known as a basis.
const FEW: usize = 32;
/// Inverse iterations for the basis.
const ITERATIONS: usize = 4;
/// How nearly a direction's compliance must be the regularization alone.
const NULL: f64 = 1e-4;
/// Share of a force that does work in forces that do nothing which isn't rounding.
const WORKING_SHARE: f64 = 1e-6;

/// Directions of δλ that do nothing, in the scaled system.
pub(super) struct Redundancy<T: Number> {
    /// How many rows are redundant.
    count: usize,
    /// Orthonormal directions, one after the other; empty where there are many.
    basis: Vec<f64>,
    /// Whether they belong to the last factor.
    pub(super) is_known: bool,
    /// Whether they belong to an earlier one: a good guess.
    was_known: bool,
    /// A number for each row.
    probe: Vec<T>,
}

impl<T: Number> Default for Redundancy<T> {
    fn default() -> Self {
        Self {
            count: 0,
            basis: Vec::new(),
            is_known: false,
            was_known: false,
            probe: Vec::new(),
        }
    }
}

impl<T: Number> Redundancy<T> {
    /// The directions that another factor of the same rows knows.
    pub(super) fn adopt(&mut self, other: &Redundancy<f64>) {
        self.count = other.count;
        self.is_known = other.is_known;
        self.basis.clone_from(&other.basis);
        self.probe.resize(other.probe.len(), T::of(0.0));
    }
}

impl JointSystem {
    /// Makes room for so many redundant rows.
    pub fn expect_redundant(&mut self, count: usize) {
        self.redundancy = match count {
            ..=FEW => Redundancy {
                count,
                basis: vec![0.0; count * self.rows],
                ..Redundancy::default()
            },
            _ => Redundancy {
                count,
                probe: vec![0.0; self.rows],
                ..Redundancy::default()
            },
        };
    }

    /// Looks for the directions in which only the regularization of the last factor resists. They are known if there are as many as are
    /// expected and no row of `working`, whose forces do work, has a share in them.
    pub fn find_redundant(&mut self, working: &[usize]) {
        if self.redundancy.count <= FEW {
            return self.find_basis(working);
        }
        let mut probe = std::mem::take(&mut self.redundancy.probe);
        let is_possible = self.regularization > 0.0;
        let is_idle = |row: &usize| {
            probe.fill(0.0);
            probe[*row] = 1.0;
            self.keep_redundant(&mut probe);
            probe[*row].abs() < WORKING_SHARE.powi(2)
        };
        self.redundancy.is_known = is_possible && working.iter().all(is_idle);
        self.redundancy.probe = probe;
    }

    fn find_basis(&mut self, working: &[usize]) {
        let rows = self.rows;
        let mut basis = std::mem::take(&mut self.redundancy.basis);
        if !self.redundancy.was_known {
            for (place, entry) in basis.iter_mut().enumerate() {
                // No symmetry hides a direction, and no two of the vectors are alike.
                let place = place as f64;
                *entry = (1.0 + 0.7 * place + 0.013 * place * place).cos();
            }
        }
        let mut is_known = false;
        let is_possible = !basis.is_empty() && self.regularization > 0.0;
        for _ in 0..if is_possible { ITERATIONS } else { 0 } {
            is_known = true;
            for place in 0..basis.len() / rows {
                let (known, rest) = basis.split_at_mut(place * rows);
                let direction = &mut rest[..rows];
                for earlier in known.chunks_exact(rows) {
                    remove(direction, earlier);
                }
                normalize(direction);
                self.solve_scaled(direction);
                for earlier in known.chunks_exact(rows) {
                    remove(direction, earlier);
                }
                let growth = normalize(direction) * self.regularization;
                is_known &= (growth - 1.0).abs() < NULL;
            }
            if is_known {
                break;
            }
        }
        let mut directions = basis.chunks_exact(rows.max(1));
        let held = directions.all(|direction| {
            let mut shares = working.iter().map(|row| direction[*row]);
            shares.all(|share| share.abs() < WORKING_SHARE)
        });
        self.redundancy.is_known = is_known && held;
        self.redundancy.was_known = is_known;
        self.redundancy.basis = basis;
    }

    /// Whether the directions that do nothing are known for the last factor.
    pub fn knows_redundant(&self) -> bool {
        self.redundancy.is_known
    }

    /// Forgets them.
    pub fn forget_redundant(&mut self) {
        (self.redundancy.is_known, self.redundancy.was_known) = (false, false);
    }

    /// Takes out of δλ what does nothing. Where nothing does it stays as it is, to the last bit: scales of an earlier factor would leave rounding
    /// that a restored run doesn't have.
    pub fn remove_redundant(&mut self, forces: &mut [f64]) {
        if !self.redundancy.is_known {
            return;
        }
        for (force, scale) in forces.iter_mut().zip(&self.scale) {
            *force /= scale;
        }
        self.remove_scaled(forces, 2);
        for (force, scale) in forces.iter_mut().zip(&self.scale) {
            *force *= scale;
        }
    }

    /// Takes out of λ what only the regularization ε of the last factor resists, λ − ε (Λ + ε)⁻¹ λ in the scaled system, whether or not its
    /// directions are known. `probe` has a number for each row and is overwritten.
    pub fn share_redundant(&mut self, forces: &mut [f64], probe: &mut [f64]) {
        // What rounding of Λ leaves of them goes the second time.
        for _ in 0..2 {
            for (entry, (force, scale)) in probe.iter_mut().zip(forces.iter().zip(&self.scale)) {
                *entry = force / scale;
            }
            self.solve_scaled(probe);
            for (force, (entry, scale)) in forces.iter_mut().zip(probe.iter().zip(&self.scale)) {
                *force -= self.regularization * entry * scale;
            }
        }
    }
}

impl<T: Number> JointSystem<T> {
    /// Takes out of a vector of the scaled system what does nothing. Where it isn't known as a basis, each of the `rounds` leaves about
    /// 10⁻⁵ of it.
    pub(super) fn remove_scaled(&mut self, scaled: &mut [T], rounds: usize) {
        if !self.redundancy.is_known {
            return;
        }
        for direction in self.redundancy.basis.chunks_exact(self.rows.max(1)) {
            remove(scaled, direction);
        }
        if self.redundancy.count <= FEW {
            return;
        }
        let mut probe = std::mem::take(&mut self.redundancy.probe);
        for _ in 0..rounds {
            probe.copy_from_slice(scaled);
            self.keep_redundant(&mut probe);
            for (entry, part) in scaled.iter_mut().zip(&probe) {
                *entry -= *part;
            }
        }
        self.redundancy.probe = probe;
    }

    /// Leaves of a vector of the scaled system what does nothing: (ε A⁻¹)².
    fn keep_redundant(&mut self, scaled: &mut [T]) {
        for _ in 0..2 {
            self.solve_scaled(scaled);
            for entry in scaled.iter_mut() {
                *entry = entry.times(self.regularization);
            }
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes a direction of length one out of another.
fn remove<T: Number>(of: &mut [T], direction: &[f64]) {
    let mut amount = [T::of(0.0)];
    T::add_products(&mut amount, direction, of);
    for (entry, other) in of.iter_mut().zip(direction) {
        *entry -= amount[0].times(*other);
    }
}

/// Makes the length one; what it was.
fn normalize(direction: &mut [f64]) -> f64 {
    let length = dot(direction, direction).sqrt();
    for entry in direction.iter_mut() {
        *entry /= length;
    }
    length
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
mod tests {
    use super::*;

    /// Orthonormal directions.
    fn directions(rows: usize, count: usize) -> Vec<Vec<f64>> {
        let mut all: Vec<Vec<f64>> = Vec::new();
        for place in 0..count {
            let w = 0.9 + 1.4 * place as f64;
            let mut direction: Vec<f64> = (0..rows)
                .map(|row| (w * (row as f64 + 1.0) + 0.1 * (row * row) as f64).sin())
                .collect();
            for _ in 0..2 {
                for earlier in &all {
                    remove(&mut direction, earlier);
                }
            }
            normalize(&mut direction);
            all.push(direction);
        }
        all
    }

    /// The projector away from some directions, in very different units: few that are known as a basis, and many that aren't.
    #[test]
    fn directions_that_do_nothing_are_found_and_left_alone() {
        for (rows, count) in [(6, 2), (40, 2), (100, FEW), (100, FEW + 1), (120, 90)] {
            let pairs: Vec<_> = (0..rows)
                .flat_map(|row| (0..rows).map(move |column| (row, column)))
                .collect();
            let (mut system, places) = JointSystem::with_pattern(rows, 0, &pairs).unwrap();
            let unit = |row: usize| if row.is_multiple_of(3) { 1e5 } else { 1e-2 };
            let directions = directions(rows, count);
            let entry = |row: usize, column: usize| {
                let shared: f64 = directions.iter().map(|n| n[row] * n[column]).sum();
                (f64::from(u8::from(row == column)) - shared) * unit(row) * unit(column)
            };
            let times = |x: &[f64]| -> Vec<f64> {
                let row = |row: usize| (0..rows).map(|k| entry(row, k) * x[k]).sum();
                (0..rows).map(row).collect()
            };
            let mut factor = |expected: usize| {
                system.values_mut().0.fill(0.0);
                for ((row, column), place) in pairs.iter().zip(&places) {
                    system.values_mut().0[*place] = entry(*row, *column);
                }
                system.expect_redundant(expected);
                assert!(system.factor(1e-7));
                system.find_redundant(&[]);
                system.knows_redundant()
            };
            if count < FEW {
                assert!(!factor(count + 1), "{rows}");
            }
            assert!(!factor(0) && factor(count), "{rows} {count}");
            let forces: Vec<f64> = (0..rows)
                .map(|row| (row as f64).cos() / unit(row))
                .collect();
            let demand = times(&forces);
            let mut solved = demand.clone();
            system.solve(&mut solved);
            let mut left = forces.clone();
            system.remove_redundant(&mut left);
            for found in [&solved, &left] {
                for (row, (found, demand)) in times(found).iter().zip(&demand).enumerate() {
                    let apart = (found - demand).abs() / unit(row);
                    assert!(apart < 1e-6, "{rows} {count} {row}: {apart:e}");
                }
            }
            // Nothing of the directions is in the solution, so that both are the same.
            for (row, (solved, left)) in solved.iter().zip(&left).enumerate() {
                let apart = (solved - left).abs() * unit(row);
                assert!(apart < 1e-6, "{rows} {count} {row}: {apart:e}");
            }
            assert!(
                forces
                    .iter()
                    .zip(&left)
                    .any(|(a, b)| (a - b).abs() > 1e-3 * a.abs())
            );
            // A row with a share in the directions may not do work.
            system.find_redundant(&[rows / 2]);
            assert!(!system.knows_redundant(), "{rows} {count}");
        }
    }
}
