//! Sets: `3, 7, 10 THRU 20 EXCEPT 15, 16`.

use super::super::fields;
use super::super::label_sets::{LabelRange, Member, SetDraft};

/// Takes the words of a set one after the other.
#[derive(Debug, Default)]
pub(super) struct SetWords {
    pub set: SetDraft,
    last: Option<u32>,
    range: Option<LabelRange>,
    expects: Expects,
}

#[derive(Debug, Default, PartialEq, Eq)]
enum Expects {
    #[default]
    Label,
    /// The end of a range.
    End,
    Step,
    /// The end of a range that is left out.
    ExceptedEnd,
}

impl SetWords {
    /// Takes a label or `THRU`, `EXCEPT`, `BY`.
    ///
    /// # Errors
    /// What is neither.
    pub fn take(&mut self, word: &[u8]) -> Result<(), String> {
        let is = |key: &[u8]| word.eq_ignore_ascii_case(key);
        let is_excepting = self
            .range
            .as_ref()
            .is_some_and(|range| !range.except.is_empty());
        if is(b"THRU") {
            self.expects = if is_excepting {
                Expects::ExceptedEnd
            } else {
                Expects::End
            };
            return Ok(());
        }
        if is(b"BY") {
            self.expects = Expects::Step;
            return Ok(());
        }
        if is(b"EXCEPT") {
            let range = self.range.as_mut();
            let range = range.ok_or("EXCEPT has no range before it")?;
            // Marks that the next labels are left out; nothing is below the first label.
            range.except.push((0, 0));
            return Ok(());
        }
        let label = fields::label(word)?;
        match std::mem::take(&mut self.expects) {
            Expects::Label if is_excepting => {
                let range = self
                    .range
                    .as_mut()
                    .filter(|range| (range.first..=range.last).contains(&label));
                match range {
                    Some(range) => {
                        range.except.push((label, label));
                        return Ok(());
                    }
                    None => self.end_range(),
                }
                self.last = Some(label);
            }
            Expects::Label => {
                self.end_range();
                self.last = Some(label);
            }
            Expects::End => {
                let first = self.last.take().ok_or("THRU has no label before it")?;
                if label < first {
                    return Err(format!(
                        "goes from {first} to {label}; the first label is the smaller one"
                    ));
                }
                self.range = Some(LabelRange {
                    first,
                    last: label,
                    step: 1,
                    except: Vec::new(),
                });
            }
            Expects::Step => match self.range.as_mut() {
                Some(range) => range.step = label,
                None => return Err("BY has no range before it".into()),
            },
            Expects::ExceptedEnd => {
                if let Some((first, last)) = self
                    .range
                    .as_mut()
                    .and_then(|range| range.except.last_mut())
                    && *first > 0
                {
                    *last = label.max(*first);
                }
            }
        }
        Ok(())
    }

    fn end_range(&mut self) {
        if let Some(mut range) = self.range.take() {
            range.except.sort_unstable();
            // Each begins behind the one before, so that one can be looked up.
            let mut end = 0;
            range.except.retain_mut(|(first, last)| {
                *first = (*first).max(end + 1);
                end = end.max(*last);
                *first <= *last
            });
            self.set.put(Member::Range(range));
        }
        if let Some(label) = self.last.take() {
            self.set.put_label(label);
        }
    }

    /// The set.
    pub fn finish(mut self) -> SetDraft {
        self.end_range();
        self.set
    }
}
