//! Words of the file for the choices of the data model, and HDF5 link names for the component's own names.
//!
//! A node set may be called anything, but an HDF5 link can't be empty, `.` or contain `/`, and a digest line is
//! cut at spaces: such bytes are written `%2F`, as in a URL.

use crate::component::{InterfaceKind, Role};
use crate::superelement::{CouplingSource, FrameKind};

/// The role of a word.
pub(super) fn role_of(word: &str) -> Option<Role> {
    Role::ALL.into_iter().find(|known| known.name() == word)
}

/// The interface kind of a word.
pub(super) fn interface_kind_of(word: &str) -> Option<InterfaceKind> {
    let mut kinds = InterfaceKind::ALL.into_iter();
    kinds.find(|known| known.name() == word)
}

/// The frame kind of a word.
pub(super) fn frame_kind_of(word: &str) -> Option<FrameKind> {
    [FrameKind::MeanAxis, FrameKind::Given]
        .into_iter()
        .find(|known| known.name() == word)
}

/// The word for the source of couplings.
pub(super) fn coupling_source(source: CouplingSource) -> &'static str {
    match source {
        CouplingSource::Integrals => "integrals",
        CouplingSource::Nodal => "nodal",
        CouplingSource::Unknown => "unknown",
    }
}

/// The source of couplings of a word.
pub(super) fn coupling_source_of(word: &str) -> Option<CouplingSource> {
    use CouplingSource::{Integrals, Nodal, Unknown};
    [Integrals, Nodal, Unknown]
        .into_iter()
        .find(|&known| coupling_source(known) == word)
}

/// The link name of a node set.
pub(super) fn encode(name: &str) -> String {
    if name.is_empty() {
        return "%".to_owned();
    }
    let only_dots = name.bytes().all(|byte| byte == b'.');
    let mut link = String::with_capacity(name.len());
    for character in name.chars() {
        let plain = !matches!(character, '\0'..=' ' | '/' | '%' | '\u{7f}') && !only_dots;
        if plain {
            link.push(character);
        } else {
            link.push_str(&format!("%{:02X}", character as u32));
        }
    }
    link
}

/// The node set of a link name; `None` where no name is written so.
pub(super) fn decode(link: &str) -> Option<String> {
    if link == "%" {
        return Some(String::new());
    }
    let mut parts = link.split('%');
    let mut name = parts.next()?.to_owned();
    for part in parts {
        let byte = u8::from_str_radix(part.get(..2)?, 16)
            .ok()
            .filter(u8::is_ascii)?;
        name.push(char::from(byte));
        name.push_str(part.get(2..)?);
    }
    (encode(&name) == link).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_comes_back() {
        for name in [
            "", ".", "..", "a/b", "50 %", "über", "x\ny", "%", "a.b", "\u{7f}",
        ] {
            let link = encode(name);
            assert!(
                !link.is_empty() && !link.contains(['/', ' ', '\n']) && link != ".",
                "{name:?} {link:?}"
            );
            assert_eq!(decode(&link).as_deref(), Some(name), "{link:?}");
        }
    }

    #[test]
    fn a_link_that_no_name_gives_is_refused() {
        for link in ["%2f", "%41", "a b", "%2", "%zz", "%é"] {
            assert_eq!(decode(link), None, "{link:?}");
        }
    }
}
