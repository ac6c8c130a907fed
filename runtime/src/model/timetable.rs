//! Times at which something is asked for, taken off one after the other while a motion goes on.

use crate::integrator::equal_steps::SAME_TIME;
use dcb_formats::scene::Record;

/// Times from zero on, increasing.
#[derive(Clone, Debug)]
pub struct Timetable {
    times: Times,
    next: u64,
}

#[derive(Clone, Debug)]
enum Times {
    Listed(Vec<f64>),
    Every(f64),
}

/// Where a time that has come is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Due {
    /// Before where the motion is now.
    Within(f64),
    /// Where it is now, but for rounding.
    Now,
}

impl Timetable {
    /// These times, strictly increasing.
    pub fn listed(times: Vec<f64>) -> Self {
        Self {
            times: Times::Listed(times),
            next: 0,
        }
    }

    /// All multiples of a time above zero, from zero on.
    pub fn every(interval: f64) -> Self {
        Self {
            times: Times::Every(interval),
            next: 0,
        }
    }

    /// Takes off the next time, if it has come; multiples are counted, not summed.
    pub fn take(&mut self, now: f64) -> Option<Due> {
        let time = match &self.times {
            Times::Listed(times) => *times.get(usize::try_from(self.next).ok()?)?,
            Times::Every(interval) => self.next as f64 * interval,
        };
        let is_now = (time - now).abs() <= SAME_TIME * now;
        let due = match is_now {
            true => Due::Now,
            false if time < now => Due::Within(time),
            false => return None,
        };
        self.next += 1;
        Some(due)
    }
}

/// When rows are recorded.
#[derive(Clone, Debug)]
pub enum Rows {
    /// After every so many steps; and how many have been made since the last row.
    EverySteps {
        /// Steps from row to row.
        steps: u32,
        /// Steps since the last row.
        since: u32,
    },
    /// At times.
    AtTimes(Timetable),
}

impl Rows {
    /// As a scene asks for them. The start is the first row.
    pub fn of(record: Record) -> Self {
        match record {
            Record::Every(steps) => Self::EverySteps { steps, since: 0 },
            Record::Interval(interval) => {
                let mut table = Timetable::every(interval);
                table.take(0.0);
                Self::AtTimes(table)
            }
        }
    }

    /// Told that a step has been made.
    pub fn count_step(&mut self) {
        if let Self::EverySteps { since, .. } = self {
            *since += 1;
        }
    }

    /// Takes off the next row, if it is due where the motion is now.
    pub fn take(&mut self, now: f64) -> Option<Due> {
        match self {
            Self::EverySteps { steps, since } if *since >= *steps => {
                *since = 0;
                Some(Due::Now)
            }
            Self::EverySteps { .. } => None,
            Self::AtTimes(table) => table.take(now),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn multiples_come_one_after_the_other_wherever_the_motion_stops() {
        let mut table = Timetable::every(0.1);
        assert_eq!(table.take(0.0), Some(Due::Now));
        assert_eq!(table.take(0.05), None);
        // 3 · 0.1 is 0.30000000000000004.
        assert_eq!(table.take(0.3), Some(Due::Within(0.1)));
        assert_eq!(table.take(0.3), Some(Due::Within(0.2)));
        assert_eq!(table.take(0.3), Some(Due::Now));
        assert_eq!(table.take(0.3), None);
        let mut listed = Timetable::listed(vec![0.25, 0.5]);
        assert_eq!(listed.take(1.0), Some(Due::Within(0.25)));
        assert_eq!(listed.take(1.0), Some(Due::Within(0.5)));
        assert_eq!(listed.take(1.0), None);
    }
}
