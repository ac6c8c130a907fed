//! Where the cache is, and how large it may grow, where nobody says so on the command line.

use std::ffi::OsString;
use std::path::PathBuf;

use etcetera::BaseStrategy;

/// Names the folder.
pub const FOLDER_VARIABLE: &str = "DCB_CACHE";
/// Names the limit, as `--cache-limit` does.
pub const LIMIT_VARIABLE: &str = "DCB_CACHE_LIMIT";
/// Bytes that are kept where nothing else is said: 20 GB.
pub const DEFAULT_LIMIT: u64 = 20 << 30;

/// Value of an environment variable, if it is set.
pub fn variable(name: &str) -> Option<OsString> {
    std::env::var_os(name).filter(|value| !value.is_empty())
}

/// `$DCB_CACHE`, or `dcb` in the folder that the user's system has for caches; `None` for a user without home.
pub fn default_folder() -> Option<PathBuf> {
    if let Some(folder) = variable(FOLDER_VARIABLE) {
        return Some(folder.into());
    }
    let strategy = etcetera::choose_base_strategy().ok()?;
    Some(strategy.cache_dir().join("dcb"))
}

/// The option that names a cache to another process.
pub fn option(folder: &std::path::Path) -> std::ffi::OsString {
    let mut option = std::ffi::OsString::from("--cache=");
    option.push(folder);
    option
}
