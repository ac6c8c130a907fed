//! Keyword lines: `*NODE, NSET=ALL`, without regard to case and blanks outside quotes.

/// A keyword with its parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Keyword {
    /// Capitals without blanks and star: `RIGIDBODY`.
    pub name: String,
    /// Keys as the keyword, values as they are, without quotes.
    parameters: Vec<(String, String)>,
}

impl Keyword {
    /// Takes a keyword line apart; continuation lines are joined already.
    pub fn parse(line: &str) -> Self {
        let mut parts = split(line.trim_start_matches('*')).into_iter();
        let name = key(&parts.next().unwrap_or_default());
        let parameters = parts
            .map(|part| match part.split_once('=') {
                Some((parameter, value)) => (
                    key(parameter),
                    value.trim().trim_matches(['"', '\'']).trim().to_owned(),
                ),
                None => (key(&part), String::new()),
            })
            .collect();
        Self { name, parameters }
    }

    /// Value of a parameter; empty for one without value.
    pub fn get(&self, parameter: &str) -> Option<&str> {
        let found = self.parameters.iter().find(|(key, _)| key == parameter)?;
        Some(&found.1)
    }
}

fn key(text: &str) -> String {
    let visible = text.chars().filter(|c| !c.is_whitespace());
    visible.flat_map(char::to_uppercase).collect()
}

/// Parts between commas that aren't in quotes.
fn split(line: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut quote = None;
    for c in line.chars() {
        match (quote, c) {
            (None, ',') => {
                parts.push(String::new());
                continue;
            }
            (None, '"' | '\'') => quote = Some(c),
            (Some(open), _) if open == c => quote = None,
            _ => {}
        }
        if let Some(part) = parts.last_mut() {
            part.push(c);
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn case_and_blanks_do_not_matter_but_in_values() {
        let keyword = Keyword::parse("* rigid Body , nset = \"my, set\", ref node=9001,GENERATE");
        assert_eq!(keyword.name, "RIGIDBODY");
        assert_eq!(keyword.get("NSET"), Some("my, set"));
        assert_eq!(keyword.get("REFNODE"), Some("9001"));
        assert_eq!(keyword.get("GENERATE"), Some(""));
        assert_eq!(keyword.get("ELSET"), None);
    }
}
