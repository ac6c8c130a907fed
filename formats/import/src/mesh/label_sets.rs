//! Sets as a deck writes them, and what is in them: labels, ranges, other sets.

use indexmap::IndexMap;

use super::fields::{self, shown};
use super::node_sets::Marks;
use super::nodes::LabelIndex;

/// Sets by their names in capitals.
pub(super) type Sets = IndexMap<String, SetDraft>;

/// A set before it is known what there is.
#[derive(Debug, Default)]
pub(super) struct SetDraft {
    /// Name as it is written first.
    pub name: String,
    /// A set that Abaqus/CAE made for itself.
    pub is_internal: bool,
    /// Labels; 0 stands for the next of `others`.
    labels: Vec<u32>,
    others: Vec<Member>,
}

/// What a set has besides labels.
#[derive(Clone, Debug)]
pub(super) enum Member {
    /// Labels from one to another.
    Range(LabelRange),
    /// A set of the same kind, by its key.
    Set(String),
    /// Nodes of a set of elements, by its key.
    NodesOf(String),
}

/// Labels from the first to the last.
#[derive(Clone, Debug)]
pub(super) struct LabelRange {
    pub first: u32,
    pub last: u32,
    pub step: u32,
    /// First and last labels that are left out, rising.
    pub except: Vec<(u32, u32)>,
}

impl LabelRange {
    fn has(&self, label: u32) -> bool {
        let next = self.except.partition_point(|(_, last)| *last < label);
        (label - self.first).is_multiple_of(self.step)
            && self
                .except
                .get(next)
                .is_none_or(|(first, _)| label < *first)
    }
}

impl SetDraft {
    pub fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..Self::default()
        }
    }

    pub fn put_label(&mut self, label: u32) {
        self.labels.push(label);
    }

    pub fn put(&mut self, member: Member) {
        self.labels.push(0);
        self.others.push(member);
    }

    /// `first, last, step` of GENERATE.
    pub fn put_range(&mut self, fields: &[&[u8]]) -> Result<(), String> {
        let number = |at: usize| fields.get(at).filter(|field| !field.is_empty());
        let (Some(first), Some(last)) = (number(0), number(1)) else {
            return Err("needs the first and the last label, and perhaps a step".into());
        };
        let (first, last) = (fields::label(first)?, fields::label(last)?);
        let step = number(2).map_or(Ok(1), |step| fields::label(step))?;
        if last < first {
            return Err(format!(
                "goes from {first} to {last}; the first label is the smaller one"
            ));
        }
        self.put(Member::Range(LabelRange {
            first,
            last,
            step,
            except: Vec::new(),
        }));
        Ok(())
    }
}

/// The key of a set's name; `Part-1.Set-1` means `Set-1`.
pub(super) fn key_of(name: &str) -> String {
    let last = name.rsplit('.').next().unwrap_or(name);
    last.trim().to_uppercase()
}

/// Members of sets as places, and labels that nothing has.
#[derive(Debug, Default)]
pub(super) struct Resolved {
    pub members: Vec<Vec<u32>>,
    /// Of each set: how many labels are unknown, and the first.
    pub unknown: Vec<(usize, u32)>,
}

/// Finds the members of all sets. `nodes_of` puts the nodes of a set of elements.
///
/// # Errors
/// The set and what is wrong with it.
pub(super) fn resolved(
    sets: &Sets,
    index: &LabelIndex,
    marks: &mut Marks,
    mut nodes_of: impl FnMut(&str, &mut Vec<u32>, &mut Marks) -> Result<(), String>,
) -> Result<Resolved, String> {
    let mut found = Resolved {
        members: vec![Vec::new(); sets.len()],
        unknown: vec![(0, 0); sets.len()],
    };
    let mut state = vec![State::Untouched; sets.len()];
    for start in 0..sets.len() {
        let mut stack = vec![start];
        while let Some(&at) = stack.last() {
            let Some((_, set)) = sets.get_index(at) else {
                break;
            };
            if state[at] == State::Untouched {
                state[at] = State::Open;
                let before = stack.len();
                for other in &set.others {
                    if let Member::Set(key) = other {
                        let needed = sets.get_index_of(key).ok_or_else(|| {
                            format!(
                                "set {} names the set {}, which isn't there",
                                set.name,
                                shown(key.as_bytes())
                            )
                        })?;
                        match state[needed] {
                            State::Untouched => stack.push(needed),
                            State::Done => {}
                            State::Open => return Err(format!("set {} holds itself", set.name)),
                        }
                    }
                }
                if stack.len() > before {
                    continue;
                }
            }
            stack.pop();
            if state[at] == State::Open {
                state[at] = State::Done;
                let (mut members, unknown) =
                    members_of(set, sets, &found, index, marks, &mut nodes_of)
                        .map_err(|message| format!("set {}: {message}", set.name))?;
                members.shrink_to_fit();
                found.members[at] = members;
                found.unknown[at] = unknown;
            }
        }
    }
    Ok(found)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Untouched,
    Open,
    Done,
}

/// Members and unknown labels of a set whose parts are known.
fn members_of(
    set: &SetDraft,
    sets: &Sets,
    found: &Resolved,
    index: &LabelIndex,
    marks: &mut Marks,
    nodes_of: &mut impl FnMut(&str, &mut Vec<u32>, &mut Marks) -> Result<(), String>,
) -> Result<(Vec<u32>, (usize, u32)), String> {
    let mut members = Vec::new();
    let mut unknown = (0, 0);
    let mut others = set.others.iter();
    marks.start();
    for label in &set.labels {
        if *label != 0 {
            match index.place(*label) {
                Some(place) => marks.put(&mut members, place).map_err(|e| e.message())?,
                None if unknown.0 == 0 => unknown = (1, *label),
                None => unknown.0 += 1,
            }
            continue;
        }
        match others.next() {
            Some(Member::Range(range)) => put_range(&mut members, index, marks, range)?,
            Some(Member::Set(key)) => {
                let other = sets.get_index_of(key).map(|at| &found.members[at]);
                for place in other.into_iter().flatten() {
                    marks.put(&mut members, *place).map_err(|e| e.message())?;
                }
            }
            Some(Member::NodesOf(key)) => nodes_of(key, &mut members, marks)?,
            None => {}
        }
    }
    Ok((members, unknown))
}

/// Labels of a range that exist, with the fewer looks: at all numbers, or at all labels.
fn put_range(
    members: &mut Vec<u32>,
    index: &LabelIndex,
    marks: &mut Marks,
    range: &LabelRange,
) -> Result<(), String> {
    let LabelRange {
        first, last, step, ..
    } = *range;
    let numbers = (last - first) / step + 1;
    let existing = index.between(first, last);
    marks
        .look_at((existing.len() as u64).min(u64::from(numbers)))
        .map_err(|e| e.message())?;
    if existing.len() as u64 <= u64::from(numbers) {
        for (label, place) in existing {
            if range.has(label) {
                marks.put(members, place).map_err(|e| e.message())?;
            }
        }
    } else {
        for number in 0..numbers {
            let label = first + number * step;
            if let Some(place) = index.place(label).filter(|_| range.has(label)) {
                marks.put(members, place).map_err(|e| e.message())?;
            }
        }
    }
    Ok(())
}
