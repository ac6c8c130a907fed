//! Settings for people: each value with what it is called, in place of JSON.

use serde_json::Value;

/// The values in an object, each with the keys that lead to it; nothing for what is absent.
pub fn plain_words(settings: &Value) -> Vec<(String, String)> {
    let mut found = Vec::new();
    collect("", settings, &mut found);
    found
}

fn collect(at: &str, value: &Value, found: &mut Vec<(String, String)>) {
    let said = match value {
        Value::Null => return,
        Value::Object(members) => {
            for (key, value) in members {
                let key = key.replace('_', " ");
                let at = match at.is_empty() {
                    true => key,
                    false => format!("{at}, {key}"),
                };
                collect(&at, value, found);
            }
            return;
        }
        Value::Bool(true) => "yes".to_owned(),
        Value::Bool(false) => "no".to_owned(),
        Value::String(text) => text.clone(),
        Value::Number(number) => number.to_string(),
        Value::Array(values) if values.is_empty() => "none".to_owned(),
        Value::Array(values) => {
            let each = values.iter().map(|value| match value {
                Value::String(text) => text.clone(),
                other => other.to_string(),
            });
            each.collect::<Vec<_>>().join(", ")
        }
    };
    found.push((at.to_owned(), said));
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn values_have_the_keys_that_lead_to_them() {
        let settings = json!({"generalized_alpha": {"step": 0.001, "adaptive": null}, "fields": ["a", "b"], "force": true});
        let expected = [
            ("generalized alpha, step", "0.001"),
            ("fields", "a, b"),
            ("force", "yes"),
        ];
        let mut found = plain_words(&settings);
        found.sort();
        let mut expected = expected.map(|(key, value)| (key.to_owned(), value.to_owned()));
        expected.sort();
        assert_eq!(found, expected);
    }
}
