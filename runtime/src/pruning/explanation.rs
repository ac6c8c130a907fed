//! Pruning in words.

use std::fmt::{self, Display, Formatter};

use super::LeftOut;

impl Display for LeftOut {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "without {}: {}", self.what, self.why)?;
        match self.cost {
            None => Ok(()),
            Some(cost) => write!(f, " (changes the response by {cost:.1e})"),
        }
    }
}

/// Numbers from 1, in ranges: `2, 4–7`.
pub(super) fn ranges(places: &[usize]) -> String {
    let mut parts: Vec<(usize, usize)> = Vec::new();
    for place in places {
        match parts.last_mut() {
            Some((_, last)) if *last + 1 == *place => *last = *place,
            _ => parts.push((*place, *place)),
        }
    }
    let written: Vec<String> = parts
        .iter()
        .map(|(first, last)| match first == last {
            true => (first + 1).to_string(),
            false => format!("{}–{}", first + 1, last + 1),
        })
        .collect();
    written.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_told_in_ranges() {
        assert_eq!(ranges(&[1, 3, 4, 5, 6]), "2, 4–7");
        assert_eq!(ranges(&[]), "");
    }

    #[test]
    fn a_cost_is_told_where_there_is_one() {
        let mut left_out = LeftOut {
            what: "modes 3–5".into(),
            why: "too fast".into(),
            cost: Some(2.5e-5),
        };
        let told = "without modes 3–5: too fast (changes the response by 2.5e-5)";
        assert_eq!(left_out.to_string(), told);
        left_out.cost = None;
        assert_eq!(left_out.to_string(), "without modes 3–5: too fast");
    }
}
