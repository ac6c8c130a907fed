//! Solutions of small and of large systems.

use super::*;

/// A ring of rows, each meeting its two neighbours, with very different units; small is dense, large is sparse.
#[test]
fn ring_is_solved_whatever_its_size_and_units() {
    for rows in [1, 5, DENSE_ROWS, DENSE_ROWS + 1, 200] {
        let pairs: Vec<_> = (0..rows)
            .flat_map(|row| [0, 1, rows - 1].map(|shift| (row, (row + shift) % rows)))
            .collect();
        let (mut system, places) = JointSystem::with_pattern(rows, 0, &pairs).unwrap();
        let unit = |row: usize| if row.is_multiple_of(2) { 1e6 } else { 1e-3 };
        let entry = |row: usize, column: usize| {
            let weight = if row == column {
                3.0
            } else {
                -1.0 + 0.01 * row as f64 / rows as f64
            };
            weight * unit(row) * unit(column)
        };
        let mut dense = Mat::<f64>::zeros(rows, rows);
        for round in 0..2 {
            system.values_mut().0.fill(0.0);
            dense.fill(0.0);
            for ((row, column), place) in pairs.iter().zip(&places) {
                let value = entry(*row, *column) * (1.0 + f64::from(round));
                system.values_mut().0[*place] = value;
                dense[(*row, *column)] = value;
            }
            assert!(system.factor(0.0));
        }
        let expected: Vec<f64> = (0..rows)
            .map(|row| (row as f64).sin() / unit(row))
            .collect();
        let mut solution: Vec<f64> = (0..rows)
            .map(|row| (0..rows).map(|k| dense[(row, k)] * expected[k]).sum())
            .collect();
        system.solve(&mut solution);
        for row in 0..rows {
            let error = (solution[row] - expected[row]).abs() * unit(row);
            assert!(error < 1e-12, "{rows} rows, row {row}: {error:e}");
        }
    }
}

/// Rows that all meet at one body: with its motions among the unknowns they are solved as with the body eliminated.
#[test]
fn motions_among_the_unknowns_change_no_solution() {
    for rows in [4, 60] {
        let wave = |i: usize, k: usize| (1.0 + 0.7 * i as f64 + 1.9 * (k * k) as f64).sin();
        let inertia = |k: usize, l: usize| match k == l {
            true => 2.0 + k as f64,
            false => 0.3 * wave(k + l, 1) * f64::from(u8::from(k + l > 2)),
        };
        let body = nalgebra::Matrix6::from_fn(inertia);
        let gradients = nalgebra::OMatrix::<f64, nalgebra::Dyn, nalgebra::U6>::from_fn(rows, wave);
        let compliance = &gradients * body.try_inverse().unwrap() * gradients.transpose();
        let own = |row: usize| 0.5 + 0.01 * row as f64;
        let all: Vec<_> = (0..rows)
            .flat_map(|row| (0..rows).map(move |column| (row, column)))
            .collect();
        let (mut whole, places) = JointSystem::with_pattern(rows, 0, &all).unwrap();
        for ((row, column), place) in all.iter().zip(&places) {
            let more = if row == column { own(*row) } else { 0.0 };
            whole.values_mut().0[*place] = compliance[(*row, *column)] + more;
        }
        let motions = rows..rows + 6;
        let mut pairs: Vec<_> = (0..rows).map(|row| (row, row)).collect();
        for motion in motions.clone() {
            pairs.extend((0..rows).flat_map(|row| [(row, motion), (motion, row)]));
            pairs.extend(motions.clone().map(|other| (other, motion)));
        }
        let (mut kept, places) = JointSystem::with_pattern(rows, 6, &pairs).unwrap();
        for ((row, column), place) in pairs.iter().zip(&places) {
            kept.values_mut().0[*place] = match (*row < rows, *column < rows) {
                (true, true) => own(*row),
                (true, false) => gradients[(*row, column - rows)],
                (false, true) => -gradients[(*column, row - rows)],
                (false, false) => body[(row - rows, column - rows)],
            };
        }
        for row in 0..rows {
            kept.values_mut().1[row] = compliance[(row, row)];
        }
        assert!(whole.factor(1e-3) && kept.factor(1e-3));
        let mut expected: Vec<f64> = (0..rows).map(|row| wave(row, 3)).collect();
        let mut found = expected.clone();
        whole.solve(&mut expected);
        kept.solve(&mut found);
        for row in 0..rows {
            let apart = (found[row] - expected[row]).abs();
            assert!(apart < 1e-10, "{rows} {row}: {apart:e}");
            let regularizing = [&whole, &kept].map(|s| s.regularizing_compliance(row));
            assert!((regularizing[0] / regularizing[1] - 1.0).abs() < 1e-12);
        }
    }
}
