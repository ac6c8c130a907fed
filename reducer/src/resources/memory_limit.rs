//! How much memory a reduction may take, and where the factor goes accordingly.

use std::path::PathBuf;

use clap::ValueEnum;
use dcb_sparse::factor_store::{FactorStorage, Place, Precision};
#[cfg(feature = "ranks")]
use dcb_sparse::ranks::RanksRun;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::resources::basis_size::BasisSize;
use crate::resources::forecast::{EstimateChoice, Forecast};

/// Where the factor is kept.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "Factor")]
pub enum FactorChoice {
    /// In memory if it fits, else on disk.
    #[default]
    Auto,
    /// In memory.
    Memory,
    /// In memory in single precision: half the room, slower; solutions are refined to the same accuracy.
    Single,
    /// On disk.
    Disk,
}

/// How much memory a reduction may take.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MemoryLimit {
    /// Bytes; `None` for no limit.
    pub bytes: Option<u64>,
    /// Where the factor is kept.
    pub factor: FactorChoice,
    /// Folder of a factor on disk.
    pub scratch: PathBuf,
    /// Processes that hold the factor in place of this one; the limit isn't theirs.
    #[cfg(feature = "ranks")]
    pub ranks: Option<RanksRun>,
}

impl MemoryLimit {
    /// For a factor in this process; its file would be in the folder `scratch`.
    pub fn here(bytes: Option<u64>, factor: FactorChoice, scratch: PathBuf) -> Self {
        Self {
            bytes,
            factor,
            scratch,
            #[cfg(feature = "ranks")]
            ranks: None,
        }
    }

    fn in_memory(precision: Precision) -> FactorStorage {
        FactorStorage {
            precision,
            place: Place::Memory,
        }
    }

    fn on_disk(&self) -> FactorStorage {
        FactorStorage {
            precision: Precision::Double,
            place: Place::Disk {
                folder: self.scratch.clone(),
            },
        }
    }

    /// Whether other processes hold the factor.
    #[cfg(feature = "ranks")]
    pub fn is_on_ranks(&self) -> bool {
        self.ranks.is_some()
    }

    /// Whether other processes hold the factor: not in this build.
    #[cfg(not(feature = "ranks"))]
    pub fn is_on_ranks(&self) -> bool {
        false
    }

    /// Possible choices, best first.
    pub fn candidates(&self) -> Vec<FactorStorage> {
        #[cfg(feature = "ranks")]
        if let Some(run) = &self.ranks {
            return vec![FactorStorage {
                precision: Precision::Double,
                place: Place::Ranks(run.clone()),
            }];
        }
        match self.factor {
            FactorChoice::Auto => vec![Self::in_memory(Precision::Double), self.on_disk()],
            FactorChoice::Memory => vec![Self::in_memory(Precision::Double)],
            FactorChoice::Single => vec![Self::in_memory(Precision::Single)],
            FactorChoice::Disk => vec![self.on_disk()],
        }
    }

    /// The forecast with a short Krylov basis, and then without an error estimate, where that saves the factor's place in memory, or where
    /// nothing fits without.
    pub fn fitted(&self, forecast: Forecast) -> Forecast {
        let sizes = [
            (BasisSize::Comfortable, forecast.estimate),
            (BasisSize::Short, forecast.estimate),
            (BasisSize::Short, EstimateChoice::LeftOut),
        ]
        .map(|(basis, estimate)| Forecast {
            basis,
            estimate,
            ..forecast
        });
        let candidates = self.candidates();
        let fitting = candidates.iter().find_map(|storage| {
            let mut sizes = sizes.iter();
            sizes.find(|forecast| self.allows(forecast, storage))
        });
        *fitting.unwrap_or(&sizes[2])
    }

    /// Whether a reduction fits with the factor kept so.
    pub fn allows(&self, forecast: &Forecast, storage: &FactorStorage) -> bool {
        self.bytes
            .is_none_or(|limit| forecast.peak_bytes(storage) <= limit)
    }

    /// Where the factor goes.
    ///
    /// # Errors
    /// [`Error::NotEnoughMemory`] if the reduction fits nowhere.
    pub fn choose(&self, forecast: &Forecast) -> Result<FactorStorage, Error> {
        let mut candidates = self.candidates();
        if let Some(fitting) = candidates
            .iter()
            .position(|storage| self.allows(forecast, storage))
        {
            return Ok(candidates.swap_remove(fitting));
        }
        let needed = |storage: &FactorStorage| forecast.peak_bytes(storage);
        Err(Error::NotEnoughMemory {
            needed: candidates.iter().map(needed).min().unwrap_or(0),
            available: self.bytes.unwrap_or(0),
            remedies: self.remedies(forecast),
        })
    }

    /// Where a factor goes for which single precision was not enough.
    pub fn fallback(&self, forecast: &Forecast) -> Place {
        let memory = Self::in_memory(Precision::Double);
        if self.allows(forecast, &memory) {
            memory.place
        } else {
            self.on_disk().place
        }
    }

    fn remedies(&self, forecast: &Forecast) -> String {
        let mut remedies = Vec::new();
        let forecast = &Forecast {
            basis: BasisSize::Short,
            estimate: EstimateChoice::LeftOut,
            ..*forecast
        };
        let mut offer = |storage: FactorStorage, option: &str| {
            if !self.is_on_ranks()
                && !self.candidates().contains(&storage)
                && self.allows(forecast, &storage)
            {
                remedies.push(option.to_owned());
            }
        };
        offer(self.on_disk(), "--factor disk");
        offer(Self::in_memory(Precision::Single), "--factor single");
        remedies.push("fewer --modes".into());
        remedies.push("fewer interface rows".into());
        remedies.push("a coarser mesh".into());
        remedies.push("a larger --memory, if the machine has it".into());
        remedies.join(", ")
    }
}

/// A size such as `8G`; units of 1024.
///
/// # Errors
/// Expected form.
pub fn size(text: &str) -> Result<u64, String> {
    let wanted = || "a size such as 8G or 512M is wanted (K, M, G or T)".to_owned();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let power = match text[digits.len()..].to_ascii_uppercase().as_str() {
        "K" | "KB" | "KIB" => 1,
        "M" | "MB" | "MIB" => 2,
        "G" | "GB" | "GIB" => 3,
        "T" | "TB" | "TIB" => 4,
        _ => return Err(wanted()),
    };
    let number: f64 = digits.trim_end().parse().map_err(|_| wanted())?;
    let bytes = number * 1024_f64.powi(power);
    if !(bytes.is_finite() && bytes >= 1.0 && bytes < u64::MAX as f64) {
        return Err(wanted());
    }
    Ok(bytes as u64)
}

/// Memory that this process may still take, bytes: what the machine has left, or what its control group leaves. `None` where the
/// system doesn't tell.
pub fn available() -> Option<u64> {
    let machine = std::fs::read_to_string("/proc/meminfo")
        .ok()
        .and_then(|text| kilobytes(&text, "MemAvailable:"));
    machine.into_iter().chain(control_group()).min()
}

fn kilobytes(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}

/// Memory that the control groups of this process leave, both versions.
fn control_group() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    groups.lines().filter_map(left_in).min()
}

/// Memory that a line of `/proc/self/cgroup` leaves; its files may be mounted as the group itself or as the whole tree.
fn left_in(line: &str) -> Option<u64> {
    let mut fields = line.splitn(3, ':');
    let (_, controllers, group) = (fields.next()?, fields.next()?, fields.next()?);
    let (root, limit, usage) = match controllers {
        "" => ("/sys/fs/cgroup", "memory.max", "memory.current"),
        "memory" => (
            "/sys/fs/cgroup/memory",
            "memory.limit_in_bytes",
            "memory.usage_in_bytes",
        ),
        _ => return None,
    };
    let number = |folder: &str, name: &str| -> Option<u64> {
        let text = std::fs::read_to_string(format!("{folder}/{name}")).ok()?;
        text.trim().parse().ok()
    };
    let folders = [format!("{root}{group}"), root.to_owned()];
    folders
        .iter()
        .filter_map(|folder| {
            let cache = std::fs::read_to_string(format!("{folder}/memory.stat"))
                .ok()
                .and_then(|text| {
                    let line = text
                        .lines()
                        .find_map(|line| line.strip_prefix("inactive_file "))?;
                    line.trim().parse().ok()
                })
                .unwrap_or(0);
            let used = number(folder, usage)?.saturating_sub(cache);
            Some(number(folder, limit)?.saturating_sub(used))
        })
        .min()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn sizes_are_read_with_their_unit() {
        for (text, bytes) in [
            ("8G", 8 << 30),
            ("512M", 512 << 20),
            ("1.5GiB", 3 << 29),
            ("2 TB", 2 << 40),
            ("64k", 64 << 10),
        ] {
            assert_eq!(size(text).unwrap(), bytes, "{text}");
        }
        for text in [
            "", "G", "12x", "12", "-1G", "0G", "nanG", "infG", "1e400G", "8GG", "8 Gb x",
        ] {
            assert!(size(text).is_err(), "{text}");
        }
    }
}
