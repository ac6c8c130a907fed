//! One superelement of the cache, and what is known of it.

use std::fs::File;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use dcb_formats::Superelement;
use dcb_formats::dcb::SuperelementFile;
use serde::{Deserialize, Serialize};

use super::{Cache, Key, ModeRequest, RECORD, Request};

/// Content of `KEY.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Request.
    pub request: Request,
    /// Name of the part.
    pub part: String,
    /// Digest of the superelement.
    pub digest: String,
    /// Size of its file.
    pub bytes: u64,
    /// Modes kept.
    pub modes: usize,
    /// Frequency of the first mode left out, Hz; `None` where nothing was left out, or the time unit isn't known.
    pub first_omitted_hertz: Option<f64>,
    /// Rows of the interfaces.
    pub rows: usize,
    /// Time of making it, s.
    pub seconds: f64,
}

/// An entry as `reduce cache` lists it.
#[derive(Clone, Debug, PartialEq)]
pub struct Listed {
    /// Its key.
    pub key: Key,
    /// Description of the entry.
    pub record: Record,
    /// When it was last used, or made.
    pub last_used: SystemTime,
}

/// An entry whose every dataset was compared with its hash. It can't be removed as long as this lives.
#[derive(Debug)]
pub struct Entry {
    /// The superelement.
    pub file: SuperelementFile,
    /// Where it is.
    pub path: PathBuf,
    /// Description of the entry.
    pub record: Record,
    pub(super) _lock: File,
}

impl Record {
    /// Of a superelement that was made.
    pub fn of(request: &Request, element: &Superelement, seconds: f64) -> Self {
        let omitted = element.modes.first_omitted_eigenvalue;
        let second = dcb_formats::units::si_factor(&element.units.time);
        Self {
            request: request.clone(),
            part: element.name.clone(),
            digest: String::new(),
            bytes: 0,
            modes: element.mode_count(),
            first_omitted_hertz: (omitted.is_finite() && second.is_some())
                .then(|| dcb_formats::units::hertz(omitted, &element.units.time)),
            rows: element.boundary_row_count(),
            seconds,
        }
    }

    /// Whether it has all modes that are asked for.
    fn has_at_least(&self, modes: ModeRequest) -> bool {
        match (modes, self.request.modes) {
            (ModeRequest::Lowest(count), _) if self.modes >= count => true,
            (ModeRequest::BelowHertz(hertz), ModeRequest::BelowHertz(limit)) if limit >= hertz => {
                true
            }
            (ModeRequest::BelowHertz(hertz), _) => {
                self.first_omitted_hertz.is_some_and(|first| first >= hertz)
            }
            _ => false,
        }
    }
}

impl Listed {
    /// Seconds since 1970.
    pub fn last_used_seconds(&self) -> u64 {
        self.last_used
            .duration_since(UNIX_EPOCH)
            .map_or(0, |duration| duration.as_secs())
    }
}

impl Cache {
    /// All entries, the one used last first. Files that can't be read, or aren't records, are left out.
    pub fn entries(&self) -> Vec<Listed> {
        let mut entries: Vec<Listed> = self
            .names()
            .into_iter()
            .filter_map(|name| self.listed(&Key::parse(name.strip_suffix(RECORD)?)?))
            .collect();
        entries.sort_by(|a, b| b.last_used.cmp(&a.last_used).then(a.key.cmp(&b.key)));
        entries
    }

    /// The entry with the fewest modes that has at least those asked for, of the same part and options: a superelement with fewer
    /// modes can be made of it without the part's matrices.
    pub fn find_at_least(&self, request: &Request) -> Option<Listed> {
        self.entries()
            .into_iter()
            .filter(|listed| {
                let record = &listed.record;
                record.request.differs_in_modes_alone(request) && record.has_at_least(request.modes)
            })
            .min_by_key(|listed| listed.record.modes)
    }

    /// Whether there is an entry; whether it is intact shows when it is read.
    pub fn has(&self, key: &Key) -> bool {
        self.record_path(key).exists() && self.superelement_path(key).exists()
    }

    pub(super) fn listed(&self, key: &Key) -> Option<Listed> {
        let path = self.record_path(key);
        let last_used = std::fs::metadata(&path)
            .and_then(|data| data.modified())
            .ok()?;
        let record = serde_json::from_slice(&std::fs::read(&path).ok()?).ok()?;
        Some(Listed {
            key: key.clone(),
            record,
            last_used,
        })
    }

    /// The names in the folder.
    pub(super) fn names(&self) -> Vec<String> {
        let Ok(listing) = std::fs::read_dir(&self.folder) else {
            return Vec::new();
        };
        listing
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .collect()
    }
}
