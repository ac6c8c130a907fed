//! The times at which runs of different steps are compared, and the values of a run at them.

use std::collections::VecDeque;

/// Times of comparison, at most.
pub const MOST_TIMES: u64 = 2000;
/// A step that ends closer to a time of comparison than this part of it is there.
const THERE: f64 = 1e-6;
/// Steps between which a value is interpolated.
const NEIGHBOURS: usize = 4;

/// Equidistant times from zero on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Time between two of them.
    pub spacing: f64,
    /// How many there are.
    pub count: usize,
}

impl Grid {
    /// Every step of the longest of `steps` up to `end`, or every second, third and so on if these are more than [`MOST_TIMES`].
    pub fn of(steps: impl IntoIterator<Item = f64>, end: f64) -> Self {
        let longest = steps.into_iter().fold(0.0, f64::max);
        let count = (end / longest * (1.0 + THERE)).floor().max(1.0) as u64;
        let stride = count.div_ceil(MOST_TIMES);
        Self {
            spacing: stride as f64 * longest,
            count: (count / stride) as usize + 1,
        }
    }

    /// The time at `index`.
    pub fn time(&self, index: usize) -> f64 {
        index as f64 * self.spacing
    }

    /// How many steps of this length lead from one time to the next; `None` if that isn't a whole number.
    pub fn steps_between(&self, step: f64) -> Option<u64> {
        let ratio = self.spacing / step;
        let whole = ratio.round();
        let is_whole = whole >= 1.0 && (ratio - whole).abs() * self.count as f64 <= THERE;
        is_whole.then_some(whole as u64)
    }
}

/// The values of a run at the times of a grid, as far as it came: one row of `width` values for each time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Values of a row.
    pub width: usize,
    /// Row by row.
    pub values: Vec<f64>,
}

impl Trace {
    /// The row at a time of the grid, if the run came so far.
    pub fn row(&self, index: usize) -> Option<&[f64]> {
        self.values
            .get(index * self.width..(index + 1) * self.width)
    }

    /// Rows there are.
    pub fn len(&self) -> usize {
        self.values.len() / self.width.max(1)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Fills a trace from the steps of a run: takes what is at a time of the grid, and interpolates by a cubic through the four nearest
/// steps where none ends there.
pub struct Sampler {
    grid: Grid,
    step: f64,
    recent: VecDeque<(f64, Vec<f64>)>,
    trace: Trace,
}

impl Sampler {
    /// For rows of `width` values of a run with this step.
    pub fn new(grid: Grid, step: f64, width: usize) -> Self {
        Self {
            grid,
            step,
            recent: VecDeque::with_capacity(NEIGHBOURS),
            trace: Trace {
                width,
                values: Vec::with_capacity(grid.count * width),
            },
        }
    }

    /// Takes the values at the end of a step; steps come in the order of time, and none may be left out unless they are at the
    /// times of the grid.
    pub fn take(&mut self, time: f64, values: &[f64]) {
        if self
            .due()
            .is_some_and(|due| (time - due).abs() <= THERE * self.step)
        {
            self.trace.values.extend_from_slice(values);
        }
        // A last step of no length, all but rounding, is no neighbour.
        let before = self.recent.back().map(|(before, _)| *before);
        if before.is_some_and(|before| time - before <= THERE * self.step) {
            return;
        }
        let mut row = match self.recent.len() == NEIGHBOURS {
            true => self
                .recent
                .pop_front()
                .map_or_else(Vec::new, |(_, row)| row),
            false => Vec::new(),
        };
        row.clear();
        row.extend_from_slice(values);
        self.recent.push_back((time, row));
        if self.recent.len() == NEIGHBOURS {
            // A step that ends at a time of the grid is not interpolated.
            self.interpolate_up_to(self.recent[NEIGHBOURS - 2].0 - THERE * self.step);
        }
    }

    /// The trace of a run that came to its end.
    pub fn finish(mut self) -> Trace {
        if let Some((last, _)) = self.recent.back() {
            self.interpolate_up_to(last + THERE * self.step);
        }
        self.trace
    }

    /// The next time of the grid.
    fn due(&self) -> Option<f64> {
        let index = self.trace.len();
        (index < self.grid.count).then(|| self.grid.time(index))
    }

    /// Times of the grid up to this one that no step has ended at.
    fn interpolate_up_to(&mut self, time: f64) {
        while let Some(due) = self.due().filter(|due| *due <= time) {
            let weights = lagrange(self.recent.iter().map(|(time, _)| *time), due);
            for column in 0..self.trace.width {
                let terms = weights.iter().zip(&self.recent);
                let value = terms.map(|(weight, (_, row))| weight * row[column]).sum();
                self.trace.values.push(value);
            }
        }
    }
}

/// Weights of the values at `times` in the polynomial through them, at `time`.
fn lagrange(times: impl Iterator<Item = f64> + Clone, time: f64) -> Vec<f64> {
    let weight = |(index, own): (usize, f64)| -> f64 {
        let others = times
            .clone()
            .enumerate()
            .filter(|(other, _)| *other != index);
        others
            .map(|(_, other)| (time - other) / (own - other))
            .product()
    };
    times.clone().enumerate().map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(step: f64, end: f64, grid: Grid, value: impl Fn(f64) -> f64) -> Trace {
        let mut sampler = Sampler::new(grid, step, 1);
        let count = (end / step - 1e-9).ceil() as usize;
        for index in 0..=count {
            let time = (index as f64 * step).min(end);
            sampler.take(time, &[value(time)]);
        }
        sampler.finish()
    }

    #[test]
    fn a_step_that_fits_is_taken_and_another_interpolated_to_fourth_order() {
        let grid = Grid::of([0.01, 0.02], 1.0);
        assert_eq!((grid.spacing, grid.count), (0.02, 51));
        assert_eq!(grid.steps_between(0.01), Some(2));
        assert_eq!(grid.steps_between(0.015), None);
        let exact = sampled(0.01, 1.0, grid, f64::sin);
        assert_eq!(exact.len(), 51);
        for index in 0..grid.count {
            let [value] = exact.row(index).unwrap_or_default() else {
                unreachable!("one column")
            };
            assert!((value - grid.time(index).sin()).abs() < 1e-14);
        }
        let largest = |step: f64| {
            let trace = sampled(step, 1.0, grid, |time| (5.0 * time).sin());
            assert_eq!(trace.len(), grid.count, "{step}");
            (0..grid.count)
                .map(|index| (trace.values[index] - (5.0 * grid.time(index)).sin()).abs())
                .fold(0.0, f64::max)
        };
        // 5⁴ h⁴ · 1/24 at most, at the ends where the cubic isn't centred.
        assert!(largest(0.015) < 625.0 * 0.015_f64.powi(4) / 24.0 && largest(0.015) > 0.0);
        assert!(largest(0.0075) < largest(0.015) / 8.0);
    }

    #[test]
    fn a_cubic_is_interpolated_exactly() {
        let grid = Grid::of([0.3], 3.0);
        let cubic = |t: f64| 1.0 - t + 2.0 * t * t - 0.5 * t * t * t;
        let trace = sampled(0.07, 3.0, grid, cubic);
        for index in 0..grid.count {
            assert!((trace.values[index] - cubic(grid.time(index))).abs() < 1e-12);
        }
    }

    #[test]
    fn long_runs_are_thinned_and_short_ones_stay_short() {
        let grid = Grid::of([1e-5], 1.0);
        assert!(grid.count <= MOST_TIMES as usize + 1 && grid.steps_between(1e-5) == Some(50));
        assert!(grid.time(grid.count - 1) <= 1.0 + 1e-9);
        assert_eq!(Grid::of([0.4], 1.0).count, 3);
    }
}
