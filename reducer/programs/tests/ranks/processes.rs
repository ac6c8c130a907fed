//! What runs.

use std::path::Path;
use std::time::{Duration, Instant};

/// Command lines of processes that name this folder.
pub fn processes(folder: &Path) -> Vec<String> {
    let name = folder.to_str().unwrap();
    let lines = std::fs::read_dir("/proc").unwrap().filter_map(|entry| {
        let line = std::fs::read(entry.ok()?.path().join("cmdline")).ok()?;
        Some(String::from_utf8_lossy(&line).replace('\0', " "))
    });
    lines.filter(|line| line.contains(name)).collect()
}

pub fn waited_for(mut what: impl FnMut() -> bool) -> bool {
    let start = Instant::now();
    while !what() {
        if start.elapsed() > Duration::from_secs(60) {
            return false;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    true
}

/// Process numbers of ranks that exchange files in this folder.
pub fn ranks_in(folder: &Path) -> Vec<u32> {
    let name = folder.to_str().unwrap();
    let ranks = std::fs::read_dir("/proc").unwrap().filter_map(|entry| {
        let path = entry.ok()?.path();
        let line = std::fs::read(path.join("cmdline")).ok()?;
        let line = String::from_utf8_lossy(&line).into_owned();
        let program = line.split('\0').next()?;
        let is_rank = program.ends_with("dcb-mumps-factor") && line.contains(name);
        is_rank
            .then(|| path.file_name()?.to_str()?.parse().ok())
            .flatten()
    });
    let mut ranks: Vec<u32> = ranks.collect();
    ranks.sort_unstable();
    ranks
}
