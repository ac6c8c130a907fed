//! Text on its way to a terminal. Names, units, notes and paths may come from anybody's file: control characters would move the cursor,
//! change the window's title or reverse the direction of reading, and a name of 10 MB would bury the message that holds it.
//!
//! Both programs write through [`for_terminal`] alone, so that no other place has to think of it; what is put into a message besides is kept
//! short by [`shortened`].

use std::borrow::Cow;
use std::fmt::Write as _;

/// Characters of a file's text that a message shows.
const SHOWN: usize = 80;
/// Characters of a word and of a line of text, at most: longer ones are a file's, not the program's.
const LONGEST_WORD: usize = 1000;
const LONGEST_LINE: usize = 5000;
/// Characters of a number, at most: what Rust writes in full beyond that (1e300 has 301 digits) nobody can read.
const LONGEST_NUMBER: usize = 24;

/// Whether a terminal would do something else with a character than show it, or show others in another order.
fn is_unprintable(c: char) -> bool {
    let changes_order = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let ends_lines = matches!(c, '\u{2028}' | '\u{2029}');
    (c.is_control() && c != '\n' && c != '\t') || changes_order || ends_lines
}

/// The same text with control characters and changes of the reading direction written as JSON does, `\u001b`. Line feeds and tabs stay.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_unprintable) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_unprintable(c) {
            // Writing to a string doesn't fail.
            let _ = write!(shown, "\\u{:04x}", u32::from(c));
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

/// A text from a file that must not look like lines of the program's own.
pub fn one_line(text: &str) -> Cow<'_, str> {
    match text.contains('\n') {
        true => Cow::Owned(text.replace('\n', "\\n")),
        false => Cow::Borrowed(text),
    }
}

/// The beginning of a text from a file, on one line, for a message: at most 80 characters.
pub fn shortened(text: &str) -> String {
    let mut shown: String = text.chars().take(SHOWN).collect();
    if shown.len() < text.len() {
        shown.push('…');
    }
    one_line(&printable(&shown)).into_owned()
}

/// A message made of a file's words: its beginning and its end, at most `most` characters.
pub fn abridged(message: &str, most: usize) -> Cow<'_, str> {
    if message.len() <= most || message.chars().count() <= most {
        return Cow::Borrowed(message);
    }
    let half = most / 2;
    let start: String = message.chars().take(half).collect();
    let end: Vec<char> = message.chars().rev().take(half).collect();
    let end: String = end.into_iter().rev().collect();
    Cow::Owned(format!("{start} … {end}"))
}

/// Text as a program shows it: printable, without endless lines and numbers. JSON stays the same JSON.
pub fn for_terminal(text: &str) -> String {
    let shown = printable(text);
    // Read to its end only if it is JSON.
    if serde_json::from_str::<serde::de::IgnoredAny>(&shown).is_ok() {
        return shown.into_owned();
    }
    let mut lines = String::with_capacity(shown.len());
    for line in shown.split_inclusive('\n') {
        let (line, end) = match line.strip_suffix('\n') {
            Some(line) => (line, "\n"),
            None => (line, ""),
        };
        let line = with_short_words(line);
        lines += &with_short_numbers(&abridged(&line, LONGEST_LINE));
        lines += end;
    }
    lines
}

/// Words of more than 1000 characters by their beginning and end, unless they are numbers.
fn with_short_words(line: &str) -> Cow<'_, str> {
    let is_long = |word: &str| word.len() > LONGEST_WORD && !word.chars().all(is_part_of_number);
    if !line.split(char::is_whitespace).any(is_long) {
        return Cow::Borrowed(line);
    }
    let words = line.split_inclusive(char::is_whitespace);
    let shown = words.map(|word| match is_long(word) {
        true => abridged(word, SHOWN),
        false => Cow::Borrowed(word),
    });
    Cow::Owned(shown.collect())
}

fn is_part_of_number(c: char) -> bool {
    c.is_ascii_digit() || matches!(c, '.' | '-' | ',' | ';' | '(' | ')' | ']' | '[')
}

/// Numbers of more than 24 characters as powers of ten.
fn with_short_numbers(line: &str) -> Cow<'_, str> {
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let mut shown = Cow::Borrowed(line);
    let mut longest_first: Vec<&str> = line
        .split(|c: char| !(is_part(c) || c.is_alphanumeric() || c == '_'))
        .filter(|word| word.len() > LONGEST_NUMBER && word.chars().all(is_part))
        .collect();
    longest_first.sort_by_key(|word| std::cmp::Reverse(word.len()));
    for word in longest_first {
        // A full stop may follow.
        let digits = word.trim_end_matches('.');
        if let Ok(number) = digits.parse::<f64>()
            && number.is_finite()
        {
            shown = Cow::Owned(shown.replace(digits, &format!("{number:e}")));
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_shown_and_not_obeyed() {
        assert_eq!(printable("a\u{1b}[2Jb"), "a\\u001b[2Jb");
        assert_eq!(printable("\u{9b}31m\r\u{7f}"), "\\u009b31m\\u000d\\u007f");
        assert_eq!(printable("x\u{202e}y\u{2066}"), "x\\u202ey\\u2066");
        assert_eq!(printable("Größe\tσ²\n→ 名"), "Größe\tσ²\n→ 名");
    }

    #[test]
    fn json_stays_the_same_json() {
        let value = serde_json::json!({"name": "a\u{9b}\u{202e}\u{1b}", "number": "1".repeat(40)});
        let text = serde_json::to_string_pretty(&value).unwrap_or_default() + "\n";
        let shown = for_terminal(&text);
        assert!(!shown.contains(is_unprintable), "{shown:?}");
        assert_eq!(serde_json::from_str(&shown).ok(), Some(value));
    }

    #[test]
    fn endless_words_and_numbers_are_short() {
        assert_eq!(shortened(&"ab".repeat(100)), "ab".repeat(40) + "…");
        assert_eq!(shortened("two\nlines"), "two\\nlines");
        let line = for_terminal(&format!(
            "unknown field `{}`; expected x\n",
            "k ".repeat(1 << 20)
        ));
        assert!(
            line.len() < 6000 && line.ends_with("; expected x\n"),
            "{}",
            line.len()
        );
        let told = format!(
            "at t = {} s, {}. 0.25 and {}",
            1e300,
            -1.5e-40,
            1e-300 / 3.0
        );
        assert_eq!(
            for_terminal(&told),
            "at t = 1e300 s, -1.5e-40. 0.25 and 3.3333333333333334e-301"
        );
        let sha256 = "12".repeat(31) + "ab";
        assert_eq!(for_terminal(&sha256), sha256);
    }
}
