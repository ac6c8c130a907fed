//! Cards of bulk data: a name and fields, in free, small or large form, over as many lines as it takes.

use super::super::fields::{self, shown};

/// Bytes of a line that count, its continuation mark included.
const LINE: usize = 80;

/// A card, as far as its lines are read.
#[derive(Debug, Default)]
pub(super) struct Card {
    /// Capitals, without the star of large fields.
    pub name: String,
    text: Vec<u8>,
    /// Beginning and end of each field in `text`.
    fields: Vec<(u32, u32)>,
    /// What field 10 of the last line says without its `+` or `*`.
    mark: Vec<u8>,
}

/// A line of a card in its form.
#[derive(Debug)]
pub(super) struct CardLine<'a> {
    /// Field 1, without blanks at its ends.
    pub head: &'a [u8],
    form: Form<'a>,
    is_large: bool,
}

#[derive(Debug)]
enum Form<'a> {
    Free(&'a [u8]),
    /// All columns.
    Fixed(&'a [u8]),
}

impl<'a> CardLine<'a> {
    /// Finds the form of a line, whose tabs are blanks already.
    pub fn of(line: &'a [u8]) -> Self {
        let (head, form) = match line.iter().position(|byte| *byte == b',') {
            Some(comma) => (&line[..comma], Form::Free(&line[comma + 1..])),
            None => (&line[..line.len().min(8)], Form::Fixed(line)),
        };
        let head = head.trim_ascii();
        Self {
            head,
            form,
            is_large: head.contains(&b'*'),
        }
    }

    /// Whether the line goes on with the card before it.
    pub fn is_continuation(&self) -> bool {
        matches!(self.head.first(), None | Some(b'+' | b'*'))
    }

    /// Calls with each field, 8 or 4, and then with field 10.
    fn each(&self, mut took: impl FnMut(&[u8])) -> Result<(), String> {
        let count = if self.is_large { 4 } else { 8 };
        match self.form {
            Form::Free(rest) => {
                let mut found = 0;
                for field in rest.split(|byte| *byte == b',') {
                    let field = field.trim_ascii();
                    let is_data = found > count && !field.is_empty()
                        || found == count && field.first().is_some_and(u8::is_ascii_digit);
                    if is_data {
                        return Err(format!(
                            "has more than {count} fields between commas; the rest goes on in a further line, and decimals have a point"
                        ));
                    }
                    if found <= count {
                        took(field);
                    }
                    found += 1;
                }
                (found..=count).for_each(|_| took(b""));
            }
            Form::Fixed(line) => {
                let width = 64 / count;
                for at in (8..72).step_by(width).chain([72]) {
                    let end = if at == 72 { LINE } else { at + width };
                    let field = line.get(at..line.len().min(end)).unwrap_or_default();
                    took(field.trim_ascii());
                }
            }
        }
        Ok(())
    }
}

impl Card {
    /// Begins with the first line of a card.
    pub fn begin(&mut self, line: &CardLine) -> Result<(), String> {
        self.text.clear();
        self.fields.clear();
        self.name.clear();
        let name = line
            .head
            .strip_suffix(b"*")
            .unwrap_or(line.head)
            .trim_ascii();
        self.name.push_str(&String::from_utf8_lossy(name));
        self.name.make_ascii_uppercase();
        self.add(line)
    }

    /// Goes on with a further line.
    pub fn go_on(&mut self, line: &CardLine) -> Result<(), String> {
        if self.fields.len() % 8 == 4 && !line.is_large {
            return Err(format!(
                "{} goes on in small fields after half of its large ones; write both halves",
                self.name
            ));
        }
        let mark = bare(line.head);
        if !mark.is_empty() && !self.mark.is_empty() && !mark.eq_ignore_ascii_case(&self.mark) {
            return Err(format!(
                "continuation {} doesn't follow its card, which ends with {}; only decks are read whose lines are in order",
                shown(mark),
                shown(&self.mark)
            ));
        }
        self.add(line)
    }

    fn add(&mut self, line: &CardLine) -> Result<(), String> {
        let Self {
            text, fields, mark, ..
        } = self;
        line.each(|field| {
            let start = text.len() as u32;
            text.extend_from_slice(field);
            fields.push((start, text.len() as u32));
        })?;
        // The last one is field 10.
        if let Some((start, _)) = fields.pop() {
            mark.clear();
            mark.extend_from_slice(bare(&text[start as usize..]));
            text.truncate(start as usize);
        }
        if text.len() > u32::MAX as usize - LINE {
            return Err(format!("{} is longer than a card can be", self.name));
        }
        Ok(())
    }

    /// A field behind the name, from 0; empty where there is none.
    pub fn field(&self, at: usize) -> &[u8] {
        match self.fields.get(at) {
            Some((start, end)) => &self.text[*start as usize..*end as usize],
            None => b"",
        }
    }

    /// All fields.
    pub fn fields(&self) -> impl Iterator<Item = &[u8]> {
        (0..self.fields.len()).map(|at| self.field(at))
    }

    /// The label in a field.
    pub fn label(&self, at: usize) -> Result<u32, String> {
        fields::label(self.field(at)).map_err(|message| self.said(at, &message))
    }

    /// The label of a system, 0 for the basic one; `None` for a blank field.
    pub fn system(&self, at: usize) -> Result<Option<i64>, String> {
        match self.field(at) {
            b"" => Ok(None),
            field => fields::integer(field)
                .map(Some)
                .map_err(|message| self.said(at, &message)),
        }
    }

    /// Three numbers from a field on; blank ones are 0.
    pub fn point(&self, from: usize) -> Result<[f64; 3], String> {
        let mut point = [0.0; 3];
        for (axis, number) in point.iter_mut().enumerate() {
            let field = self.field(from + axis);
            if !field.is_empty() {
                *number =
                    fields::real(field).map_err(|message| self.said(from + axis, &message))?;
            }
        }
        Ok(point)
    }

    fn said(&self, at: usize, message: &str) -> String {
        format!("{}, field {}: {message}", self.name, at + 2)
    }
}

/// A mark of continuation without its first character.
fn bare(mark: &[u8]) -> &[u8] {
    match mark.first() {
        Some(b'+' | b'*') => mark[1..].trim_ascii(),
        _ => mark,
    }
}

/// A line without comment, its tabs as blanks up to the next column of eight.
pub(super) fn plain(line: &[u8], into: &mut Vec<u8>) {
    into.clear();
    let line = match line.iter().position(|byte| *byte == b'$') {
        Some(comment) => &line[..comment],
        None => line,
    };
    for byte in line {
        match byte {
            b'\t' => into.resize(into.len() / 8 * 8 + 8, b' '),
            _ => into.push(*byte),
        }
    }
    into.truncate(into.trim_ascii_end().len());
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn card(lines: &[&str]) -> Result<Vec<String>, String> {
        let mut card = Card::default();
        let mut text = Vec::new();
        for (at, line) in lines.iter().enumerate() {
            plain(line.as_bytes(), &mut text);
            let line = CardLine::of(&text);
            if at == 0 {
                card.begin(&line)?;
            } else {
                assert!(line.is_continuation());
                card.go_on(&line)?;
            }
        }
        let fields = card
            .fields()
            .map(|field| String::from_utf8_lossy(field).into_owned());
        let mut fields: Vec<String> = std::iter::once(card.name.clone()).chain(fields).collect();
        while fields.last().is_some_and(String::is_empty) {
            fields.pop();
        }
        Ok(fields)
    }

    #[test]
    fn the_same_card_in_every_form() {
        let small = ["GRID    7               1.5     -2.5-3  .5      4"];
        let expected = ["GRID", "7", "", "1.5", "-2.5-3", ".5", "4"];
        for lines in [
            &small[..],
            &["GRID,7,,1.5,-2.5-3,.5,4"],
            &["grid\t7\t\t1.5\t-2.5-3\t.5\t4 $ comment, with a comma"],
            &[
                "GRID*   7                               1.5             -2.5-3          *A",
                "*A      .5              4",
            ],
            &["GRID*,7,,1.5,-2.5-3", "*,.5,4"],
            &[
                "GRID*   7                               1.5             -2.5-3",
                "*,.5,4",
            ],
        ] {
            assert_eq!(card(lines).unwrap(), expected, "{lines:?}");
        }
    }

    #[test]
    fn continuations_by_blank_plus_comma_and_star() {
        let long = [
            "CHEXA", "1", "1", "1", "2", "3", "4", "5", "6", "7", "8", "9",
        ];
        for lines in [
            [
                "CHEXA   1       1       1       2       3       4       5       6       +A",
                "+A      7       8       9",
            ],
            [
                "CHEXA   1       1       1       2       3       4       5       6",
                "        7       8       9",
            ],
            ["CHEXA,1,1,1,2,3,4,5,6,+", "+,7,8,9"],
            ["CHEXA,1,1,1,2,3,4,5,6", ",7,8,9"],
            [
                "CHEXA,1,1,1,2,3,4,5,6",
                "*       7               8               9",
            ],
        ] {
            assert_eq!(card(&lines).unwrap(), long, "{lines:?}");
        }
        let swapped = card(&["CHEXA,1,1,1,2,3,4,5,6,+A", "+B,7"]).unwrap_err();
        assert!(
            swapped.contains("continuation `B` doesn't follow its card"),
            "{swapped}"
        );
        let half = card(&["GRID*,7,,1.5,2.5", "+,.5"]).unwrap_err();
        assert!(half.contains("goes on in small fields"), "{half}");
        let commas = card(&["GRID,7,,1,5,2,5,3,5,4,0,1"]).unwrap_err();
        assert!(commas.contains("decimals have a point"), "{commas}");
    }
}
