//! The fewest coordinates that keep an error within a tolerance.

/// Precision with which the fewest coordinates are found.
pub const EXACTLY: f64 = 0.0;

/// One number of coordinates that was tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Coordinates kept, the first of the ranking.
    pub kept: usize,
    /// The error with them; infinite where the run didn't come to its end.
    pub error: f64,
}

/// Trials in the order in which they were made, and the smallest number of coordinates found good.
#[derive(Clone, Debug, PartialEq)]
pub struct Searched {
    /// Every trial once.
    pub trials: Vec<Trial>,
    /// The smallest good one; all coordinates where nothing less is good.
    pub best: Trial,
}

/// Bisects between none and all of `count` coordinates; with all of them the error is `whole`. What is found is larger than the fewest
/// by less than its part `precision`. `None` if a trial says that the user wants an end.
///
/// The error needn't fall with every coordinate: what is returned was tried, not inferred.
///
/// # Errors
/// Those of the trials.
pub fn fewest<E>(
    count: usize,
    whole: f64,
    tolerance: f64,
    precision: f64,
    mut trial: impl FnMut(usize) -> Result<Option<f64>, E>,
) -> Result<Option<Searched>, E> {
    let mut trials = Vec::new();
    let mut best = Trial {
        kept: count,
        error: whole,
    };
    // Good at `best.kept`; bad below `bad`.
    let mut bad = 0;
    while bad < best.kept && (best.kept - bad) as f64 >= precision * best.kept as f64 {
        let kept = (bad + best.kept) / 2;
        let Some(error) = trial(kept)? else {
            return Ok(None);
        };
        let tried = Trial { kept, error };
        trials.push(tried);
        if error <= tolerance {
            best = tried;
        } else {
            bad = kept + 1;
        }
    }
    Ok(Some(Searched { trials, best }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    #[test]
    fn the_fewest_good_coordinates_are_found() -> Result<(), Infallible> {
        for needed in 0..=13 {
            let mut made = 0;
            let found = fewest::<Infallible>(13, 0.0, 1e-3, EXACTLY, |kept| {
                made += 1;
                Ok(Some(if kept >= needed { 1e-4 } else { 1e-2 }))
            })?;
            assert_eq!(found.map(|found| found.best.kept), Some(needed));
            assert!(made <= 4, "{made} trials");
        }
        Ok(())
    }

    #[test]
    fn nearly_the_fewest_take_fewer_trials() -> Result<(), Infallible> {
        for needed in [1, 7, 100, 199, 333, 500] {
            let found = fewest::<Infallible>(500, 0.0, 1e-3, 0.05, |kept| {
                Ok(Some(if kept >= needed { 1e-4 } else { 1e-2 }))
            })?;
            let is_close = |found: Searched| {
                let kept = found.best.kept;
                kept >= needed
                    && (kept - needed) as f64 <= 0.05 * kept as f64
                    && (needed < 100 || found.trials.len() <= 7)
            };
            assert!(found.clone().is_some_and(is_close), "{needed}: {found:?}");
        }
        Ok(())
    }

    #[test]
    fn what_is_never_good_keeps_everything_and_a_stop_is_no_answer() -> Result<(), Infallible> {
        let none = fewest::<Infallible>(5, 0.0, 1e-3, EXACTLY, |_| Ok(Some(f64::INFINITY)))?;
        assert_eq!(none.map(|found| found.best.kept), Some(5));
        assert_eq!(
            fewest::<Infallible>(5, 0.0, 1e-3, EXACTLY, |_| Ok(None))?,
            None
        );
        Ok(())
    }
}
