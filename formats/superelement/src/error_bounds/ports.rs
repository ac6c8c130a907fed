//! Ports of an estimate: where forces act along some directions only, these directions in place of the rows of their interfaces.
//!
//! With L for the rows and B for the forces, moments, shapes and flexibilities become those of the rows Bᵀ L, which have static shapes X B of their own: all that
//! holds for rows holds for them. Each interface's are orthonormal in scaled rows, so that no choice among the same forces changes a norm.

use faer::Mat;

/// A force is dependent on the others of its interface if less than this fraction of its size is beyond them.
const DEPENDENT: f64 = 1e-6;

/// Rows of L_b alone, and combinations of rows.
pub(super) struct Ports {
    /// W, orthonormal columns over scaled rows and further columns, (n_b + n_x, p + n_x).
    pub columns: Mat<f64>,
    /// The row that each stands for, if it is one; (p).
    pub rows: Vec<Option<usize>>,
    /// Interface of each, (p).
    pub interface: Vec<usize>,
    /// Whether forces act along each, (p).
    pub attached: Vec<bool>,
}

impl Ports {
    /// Of forces on the rows, (n_b, n_p). `scale` is that of rows and further columns, `interface` and `attached` say what each row belongs to.
    pub(super) fn of(
        forces: &Mat<f64>,
        scale: &[f64],
        interface: &[usize],
        attached: &[bool],
    ) -> Self {
        let n_b = interface.len();
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let (mut of, mut acts) = (Vec::new(), Vec::new());
        let count = interface.last().map_or(0, |last| last + 1);
        for wanted in 0..count {
            let own: Vec<usize> = (0..n_b).filter(|row| interface[*row] == wanted).collect();
            let is_attached = own.iter().all(|row| attached[*row]);
            let units = own.iter().map(|row| unit(n_b, *row));
            let found = match is_attached {
                false => units.collect(),
                true => orthonormal(forces, &own, scale),
            };
            of.extend(std::iter::repeat_n(wanted, found.len()));
            acts.extend(std::iter::repeat_n(is_attached, found.len()));
            columns.extend(found);
        }
        let p = columns.len();
        let row = |column: &Vec<f64>| {
            let mut rows = (0..n_b).filter(|row| column[*row] != 0.0);
            let first = rows.next();
            first.filter(|row| rows.next().is_none() && column[*row] > 0.0)
        };
        Self {
            rows: columns.iter().map(row).collect(),
            interface: of,
            attached: acts,
            columns: Mat::from_fn(scale.len(), p + scale.len() - n_b, |i, j| {
                match (i < n_b, j < p) {
                    (true, true) => columns[j][i],
                    (false, false) => f64::from(u8::from(i - n_b == j - p)),
                    _ => 0.0,
                }
            }),
        }
    }

    /// Ports without further columns, p.
    pub(super) fn count(&self) -> usize {
        self.rows.len()
    }

    /// W over rows alone, (n_b, p), or over further columns too, (n_b + n_x, p + n_x).
    pub(super) fn over(&self, rows: usize) -> Mat<f64> {
        match rows == self.columns.nrows() {
            true => self.columns.clone(),
            false => self.columns.get(..rows, ..self.count()).to_owned(),
        }
    }
}

fn unit(count: usize, at: usize) -> Vec<f64> {
    (0..count)
        .map(|row| f64::from(u8::from(row == at)))
        .collect()
}

/// The forces on some rows over the rows' scale, made orthonormal one after the other.
fn orthonormal(forces: &Mat<f64>, own: &[usize], scale: &[f64]) -> Vec<Vec<f64>> {
    let size = |of: &[f64]| of.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
    let mut found: Vec<Vec<f64>> = Vec::new();
    for force in forces.col_iter() {
        let mut column = vec![0.0; forces.nrows()];
        for row in own.iter().filter(|row| scale[**row] > 0.0) {
            column[*row] = force[*row] / scale[*row];
        }
        let whole = size(&column);
        if whole == 0.0 {
            continue;
        }
        for _ in 0..2 {
            for other in &found {
                let shared: f64 = column.iter().zip(other).map(|(a, b)| a * b).sum();
                for (entry, known) in column.iter_mut().zip(other) {
                    *entry -= shared * known;
                }
            }
        }
        let rest = size(&column);
        if rest > DEPENDENT * whole {
            found.push(column.into_iter().map(|entry| entry / rest).collect());
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_the_forces_of_each_interface_whatever_their_sizes() {
        // Two interfaces of three rows, the second for output; scaled, the forces on the first are (1, 1, 0) and (1, 1, 0) + (0, 0, tiny).
        let scale = [2.0, 1.0, 1e-3, 1.0, 1.0, 1.0, 5.0];
        let forces = Mat::from_fn(6, 3, |i, j| match (i, j) {
            (0, _) => 2.0 * (j + 1) as f64,
            (1, _) => (j + 1) as f64,
            (2, 1) => 1e-4,
            _ => 0.0,
        });
        let interface = [0, 0, 0, 1, 1, 1];
        let attached = [true, true, true, false, false, false];
        let ports = Ports::of(&forces, &scale, &interface, &attached);
        assert_eq!(ports.interface, [0, 0, 1, 1, 1]);
        assert_eq!(ports.attached, [true, true, false, false, false]);
        assert_eq!(ports.rows[0], None);
        assert_eq!(ports.rows[2..], [Some(3), Some(4), Some(5)]);
        assert!((ports.columns[(2, 1)] - 1.0).abs() < 1e-12);
        assert_eq!(ports.columns.shape(), (7, 6));
        let half = 0.5_f64.sqrt();
        assert!((ports.columns[(0, 0)] - half).abs() < 1e-15);
        assert!((ports.columns[(1, 0)] - half).abs() < 1e-15);
        assert_eq!(ports.columns[(6, 5)], 1.0);
        assert_eq!(ports.over(6).shape(), (6, 5));
    }
}
