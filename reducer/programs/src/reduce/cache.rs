//! The cache on the command line: its options, superelements taken from it instead of being made or kept there once they are made, and the
//! `reduce cache` command, which lists it.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::program::Told;
use clap::Args;
use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::output::copy_whole;
use dcb_formats::units::readable;
use serde_json::json;

use crate::outcome::Outcome;
use crate::program::Detail;
use crate::reduce::part::report::{further_columns, stage_lines, verdict};
use crate::reduce::part::timing::StageClock;
use crate::reduce::scene::Made;
use crate::reduce::superelement::inspect::{frequency_table, interface_table, mass_lines};
use dcb_reducer::error::{CommandRefusal, Error};
use dcb_reducer::quality::Quality;
use dcb_reducer::resources::memory_limit::size;
use dcb_workflow::cache::eviction::Removal;
use dcb_workflow::cache::folder::{
    DEFAULT_LIMIT, FOLDER_VARIABLE, LIMIT_VARIABLE, default_folder, variable,
};
use dcb_workflow::cache::{Cache, Claim, Entry, Listed, ModeRequest, Request, Reservation, Stored};
use dcb_workflow::file_form::FileForm;

/// Superelements that were made before.
#[derive(Clone, Debug, Args)]
pub struct CacheArguments {
    /// Take from a cache what was made before, and keep what is made.
    ///
    /// The folder is by default $DCB_CACHE, or dcb in the folder that the user's system has for caches.
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, require_equals = true)]
    pub cache: Option<Option<PathBuf>>,
    /// How large the cache may grow [default: $DCB_CACHE_LIMIT, or 20G].
    #[arg(long, value_name = "SIZE", allow_hyphen_values = true, value_parser = size)]
    pub cache_limit: Option<u64>,
}

impl CacheArguments {
    /// The folder, named or not; `None` for a user without home.
    pub fn folder(&self) -> Option<PathBuf> {
        self.cache.clone().flatten().or_else(default_folder)
    }

    /// How many bytes may be kept.
    pub fn limit(&self) -> Result<u64, Error> {
        if let Some(limit) = self.cache_limit {
            return Ok(limit);
        }
        let Some(text) = variable(LIMIT_VARIABLE) else {
            return Ok(DEFAULT_LIMIT);
        };
        let text = text.to_string_lossy();
        size(&text).map_err(|wanted| {
            let (variable, found) = (LIMIT_VARIABLE, text.into_owned());
            CommandRefusal::NoSize {
                variable,
                found,
                wanted,
            }
            .into()
        })
    }

    /// The cache, whether or not `--cache` asks for it; `None`, with a warning, where there can't be one.
    pub fn open(&self, told: Told) -> Result<Option<Cache>, Error> {
        let limit = self.limit()?;
        let opened = match self.folder() {
            Some(folder) => {
                Cache::at(&folder, limit).map_err(|error| format!("{}: {error}", folder.display()))
            }
            None => Err(format!(
                "no folder is known; name one with --cache=FOLDER or {FOLDER_VARIABLE}"
            )),
        };
        match opened {
            Ok(cache) => Ok(Some(cache)),
            Err(why) => {
                told.say("warning", &format!("the cache isn't used: {why}"));
                Ok(None)
            }
        }
    }
}

/// Request to the cache.
#[derive(Debug, Args)]
pub struct InventoryArguments {
    #[command(flatten)]
    pub cache: CacheArguments,
    /// Remove all superelements, or the one whose key begins so.
    #[arg(long, value_name = "KEY", num_args = 0..=1)]
    pub clear: Option<Option<String>>,
    /// As JSON; sizes in bytes, times in seconds (last use since 1970).
    #[arg(long, conflicts_with = "clear")]
    pub json: bool,
}

pub fn run(arguments: &InventoryArguments) -> Result<Outcome, Error> {
    let Some(folder) = arguments.cache.folder() else {
        let variable = FOLDER_VARIABLE;
        return Err(CommandRefusal::NoCacheFolder { variable }.into());
    };
    let cache = Cache::existing(&folder, arguments.cache.limit()?);
    let entries = cache.entries();
    let output = match &arguments.clear {
        Some(key) => clear(&cache, entries, key.as_deref())?,
        None if arguments.json => as_json(&cache, &entries),
        None => table(&cache, &entries),
    };
    Ok(Outcome::done(output))
}

fn clear(cache: &Cache, mut entries: Vec<Listed>, key: Option<&str>) -> Result<String, Error> {
    if let Some(start) = key {
        entries.retain(|entry| entry.key.to_string().starts_with(start));
        if entries.len() != 1 {
            return Err(CommandRefusal::NotOneKey {
                folder: cache.folder().to_owned(),
                start: start.to_owned(),
                found: entries.len(),
            }
            .into());
        }
    }
    let (mut text, mut bytes, mut count) = (String::new(), 0, 0);
    for entry in &entries {
        let path = cache.superelement_path(&entry.key);
        let told = |source| dcb_formats::Error::io(&path, "cannot remove", source);
        let removal = cache.remove(&entry.key).map_err(told)?;
        match removal {
            Removal::Removed => {
                bytes += entry.record.bytes;
                count += 1;
            }
            Removal::InUse => {
                let _ = writeln!(text, "{} is in use and stays", entry.key.short());
            }
        }
    }
    cache.remove_leftovers();
    let _ = writeln!(
        text,
        "removed {count} of {}, {}",
        entries.len(),
        readable(bytes)
    );
    Ok(text)
}

fn table(cache: &Cache, entries: &[Listed]) -> String {
    let mut text = String::new();
    let width = entries
        .iter()
        .map(|entry| entry.record.part.chars().count())
        .chain([4])
        .max()
        .unwrap_or(0);
    if !entries.is_empty() {
        let _ = writeln!(
            text,
            "{:<12}  {:<width$}  {:<16}  {:>5}  {:>4}  {:>9}  {:>9}  last use",
            "key", "part", "asked for", "modes", "rows", "size", "made in"
        );
    }
    for entry in entries {
        let record = &entry.record;
        let asked = match record.request.modes {
            ModeRequest::Lowest(count) => format!("{count} modes"),
            ModeRequest::BelowHertz(hertz) => format!("below {hertz} Hz"),
        };
        let _ = writeln!(
            text,
            "{:<12}  {:<width$}  {asked:<16}  {:>5}  {:>4}  {:>9}  {:>7.1} s  {}",
            entry.key.short(),
            record.part,
            record.modes,
            record.rows,
            readable(record.bytes),
            record.seconds,
            age(entry.last_used)
        );
    }
    let _ = writeln!(
        text,
        "{} superelements, {} of at most {}, in {}",
        entries.len(),
        readable(total(entries)),
        readable(cache.limit()),
        cache.folder().display()
    );
    text
}

fn total(entries: &[Listed]) -> u64 {
    entries.iter().map(|entry| entry.record.bytes).sum()
}

fn age(time: SystemTime) -> String {
    let seconds = SystemTime::now()
        .duration_since(time)
        .map_or(0, |age| age.as_secs());
    match seconds {
        0..120 => format!("{seconds} s ago"),
        120..7200 => format!("{} min ago", seconds / 60),
        7200..172_800 => format!("{} h ago", seconds / 3600),
        _ => format!("{} days ago", seconds / 86_400),
    }
}

fn as_json(cache: &Cache, entries: &[Listed]) -> String {
    let listed: Vec<_> = entries
        .iter()
        .map(|entry| {
            json!({
                "key": entry.key,
                "superelement": cache.superelement_path(&entry.key),
                "last_used": entry.last_used_seconds(),
                "record": entry.record,
            })
        })
        .collect();
    let all = json!({
        "folder": cache.folder(),
        "limit_bytes": cache.limit(),
        "total_bytes": total(entries),
        "entries": listed,
    });
    all.to_string() + "\n"
}

/// The entry of a request or its reservation; `None`, with a warning, where the cache can't be used.
pub fn claim<'c>(cache: &'c Cache, request: &Request, told: Told) -> Option<Claim<'c>> {
    let waiting = || {
        told.say(
            "waiting",
            "another process makes this superelement; its result is taken",
        );
    };
    match cache.claim(request, waiting) {
        Ok(claim) => {
            if let Claim::Missing(reservation) = &claim
                && let Some(damage) = &reservation.damage
            {
                told.say(
                    "warning",
                    &format!("the cache had a damaged superelement, which is made anew: {damage}"),
                );
            }
            Some(claim)
        }
        Err(error) => {
            let folder = cache.folder().display();
            told.say(
                "warning",
                &format!("the cache isn't used: {folder}: {error}"),
            );
            None
        }
    }
}

/// Writes a superelement of the cache as it is asked for, and says what it is.
pub fn serve(
    entry: &Entry,
    form: FileForm,
    target: &Path,
    options: &WriteOptions,
    clock: &mut StageClock,
    (told, detail): (Told, Detail),
) -> Result<Outcome, Error> {
    let mut element = entry.file.superelement()?;
    clock.start("write");
    if form != FileForm::default() {
        form.say(&mut element.provenance.options);
        let (recovery, mesh) = match form.without_fields {
            true => (None, None),
            false => (entry.file.recovery()?, entry.file.mesh()?),
        };
        let contents = Contents {
            superelement: &element,
            recovery: recovery.as_ref(),
            mesh: mesh.as_ref(),
        };
        write_superelement(target, &contents, options)?;
    } else {
        copy_whole(&entry.path, target, options.replace_existing)?;
    }
    clock.clear();
    for warning in &element.provenance.warnings {
        told.say("warning", warning);
    }
    let mut output = String::new();
    let _ = writeln!(
        output,
        "{}: {} modes and {} attachment rows (rank {}){}, from the cache: {} was made in {:.1} s",
        element.name,
        element.mode_count(),
        element.boundary_row_count(),
        element.residual.sigma_squared.len(),
        further_columns(&element),
        entry.record.request.key().short(),
        entry.record.seconds,
    );
    output += &verdict(&element, Quality::stored(&element).as_ref());
    if detail == Detail::Tables {
        output += &mass_lines(&element);
        output += &frequency_table(&element, None, usize::MAX);
        output += &interface_table(&element);
        output += &stage_lines(clock.stages());
    }
    let _ = writeln!(output, "wrote {}", target.display());
    Ok(Outcome::done(output))
}

/// Keeps a superelement that was made, with nodal fields whether or not they were asked for. Where that fails there is a warning.
pub(crate) fn keep(
    reservation: Reservation<'_>,
    form: FileForm,
    made: &mut Made,
    seconds: f64,
    told: Told,
) {
    FileForm::default().say(&mut made.superelement.provenance.options);
    let contents = Contents {
        superelement: &made.superelement,
        recovery: made.fields.as_ref(),
        mesh: made.mesh.as_ref(),
    };
    let stored = reservation.store(&contents, seconds);
    form.say(&mut made.superelement.provenance.options);
    let why = match stored {
        Ok(Stored::Kept) => return,
        Ok(Stored::TooLarge { bytes }) => format!(
            "its {} are more than the cache may have; --cache-limit allows more",
            readable(bytes)
        ),
        Err(error) => error.to_string(),
    };
    told.say(
        "warning",
        &format!("the superelement is complete, but isn't kept in the cache: {why}"),
    );
}
