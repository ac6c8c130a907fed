//! Steps of one length from zero to an end, counted in integers.

/// Times that differ by no more than this part of them are the same: a hundred times what rounding makes of the same number written twice.
pub(crate) const SAME_TIME: f64 = 1e-13;

/// A remainder below this part of a step is shared by the last two: by itself it would be a step of any shortness, in which rounding of the
/// positions becomes forces.
const SHARED: f64 = 0.5;

/// A whole number of equal steps. Where the end is no multiple of the step the last one, or the last two, are shorter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EqualSteps {
    step: f64,
    end: f64,
    count: u64,
    /// Steps at the end that share what the full ones before them leave; none where all are full.
    sharing: u64,
}

impl EqualSteps {
    /// From zero to `end`; both are positive. A remainder below rounding is no step.
    pub fn new(step: f64, end: f64) -> Self {
        let ratio = end / step;
        let whole = ratio.round();
        let is_whole = whole >= 1.0 && (ratio - whole).abs() <= SAME_TIME * ratio;
        let (count, sharing) = match ratio.ceil() {
            _ if is_whole => (whole, 0),
            count if ratio - ratio.floor() < SHARED && count >= 2.0 => (count, 2),
            count => (count.max(1.0), 1),
        };
        Self {
            step,
            end,
            count: count as u64,
            sharing,
        }
    }

    /// How many there are.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Steps of full length.
    fn full(&self) -> u64 {
        self.count - self.sharing
    }

    /// The length of a step, counted from 1.
    pub fn length(&self, index: u64) -> f64 {
        match index <= self.full() {
            true => self.step,
            // One rounding only.
            false => (self.full() as f64).mul_add(-self.step, self.end) / self.sharing as f64,
        }
    }

    /// The time after so many of them; exactly the end after the last.
    pub fn time(&self, index: u64) -> f64 {
        if index >= self.count {
            self.end
        } else if index <= self.full() {
            index as f64 * self.step
        } else {
            self.end - self.length(self.count)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_at_the_end_and_none_is_very_short() {
        for (step, end, count, last) in [
            (1e-5, 1.0, 100_000, 1e-5),
            // 1/1e-9 is 999999999.9999999.
            (1e-9, 1.0, 1_000_000_000, 1e-9),
            (1.0 / 3.0, 7.0, 21, 1.0 / 3.0),
            (0.1, 0.3, 3, 0.1),
            (0.1, 1.06, 11, 0.06),
            // A third of a step too much, and a millionth.
            (0.3, 1.0, 4, 0.2),
            (0.333333, 1.0, 4, 0.166667),
            (2.0, 1.0, 1, 1.0),
        ] {
            let steps = EqualSteps::new(step, end);
            assert_eq!(steps.count(), count, "{step} {end}");
            assert!((steps.length(count) - last).abs() < 1e-15, "{step} {end}");
            assert_eq!(steps.length(1), step.min(end));
            assert_eq!(steps.time(count), end);
            let led = steps.time(count - 1) + steps.length(count);
            assert!((led - end).abs() <= f64::EPSILON * end, "{step} {end}");
            let before = count.saturating_sub(2);
            let led = steps.time(before) + steps.length(before + 1);
            assert!((led - steps.time(before + 1)).abs() <= f64::EPSILON * end);
        }
    }
}
