//! Contents of a superelement that a scene doesn't need.

use std::fmt::{self, Display, Formatter};

/// Something that a scene doesn't need.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Contents.
    pub what: String,
    /// Why it isn't needed.
    pub why: String,
    /// Largest relative change of the receptance by leaving it out after all that stands before it; `None` where nothing changes.
    pub cost: Option<f64>,
}

impl Display for LeftOut {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "without {}: {}", self.what, self.why)?;
        match self.cost {
            None => Ok(()),
            Some(cost) => write!(f, " (changes the response by {cost:.1e})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
