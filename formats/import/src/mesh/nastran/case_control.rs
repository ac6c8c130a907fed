//! Sets of the case control, and which of them name elements.

use std::collections::HashSet;

use super::super::label_sets::SetDraft;
use super::set_text::SetWords;

/// Requests whose sets name elements.
const OF_ELEMENTS: [&str; 12] = [
    "STRESS", "ELSTRESS", "STRAIN", "ELFORCE", "FORCE", "ESE", "EKE", "EDE", "GPSTRESS",
    "GPSTRAIN", "ELSDCON", "STRFIELD",
];

/// What the case control says of sets.
#[derive(Debug, Default)]
pub(super) struct CaseControl {
    /// Number and members.
    pub sets: Vec<(u32, SetDraft)>,
    /// Numbers of sets that requests take for elements.
    pub of_elements: HashSet<u32>,
    /// The set that goes on in the next line.
    open: Option<(u32, SetWords)>,
}

impl CaseControl {
    /// Takes a line, if it is one of a set or of a request.
    pub fn takes(&mut self, line: &[u8]) -> Result<bool, String> {
        if let Some((number, words)) = self.open.take() {
            self.members(number, words, line)?;
            return Ok(true);
        }
        let Some(equals) = line.iter().position(|byte| *byte == b'=') else {
            return Ok(false);
        };
        let (left, right) = (line[..equals].trim_ascii(), &line[equals + 1..]);
        let left = String::from_utf8_lossy(left).to_ascii_uppercase();
        let right = right.trim_ascii();
        let request = left.split('(').next().unwrap_or_default().trim();
        if OF_ELEMENTS.contains(&request) {
            self.of_elements.extend(number(right));
            return Ok(true);
        }
        match left
            .strip_prefix("SET")
            .map(|rest| number(rest.trim().as_bytes()))
        {
            Some(Some(set)) => {
                self.members(set, SetWords::default(), right)?;
                Ok(true)
            }
            _ => Ok(false),
        }
    }

    fn members(&mut self, number: u32, mut words: SetWords, line: &[u8]) -> Result<(), String> {
        let parts = line.split(|byte| *byte == b',' || byte.is_ascii_whitespace());
        for word in parts.filter(|word| !word.is_empty()) {
            if let Err(message) = words.take(word) {
                // ALL, times and frequencies, names of responses: nothing about nodes.
                if word.first().is_some_and(u8::is_ascii_digit) && !word.contains(&b'.') {
                    return Err(format!("SET {number}: {message}"));
                }
                return Ok(());
            }
        }
        if line.ends_with(b",") {
            self.open = Some((number, words));
        } else {
            self.sets.push((number, words.finish()));
        }
        Ok(())
    }
}

fn number(text: &[u8]) -> Option<u32> {
    std::str::from_utf8(text).ok()?.parse().ok()
}
