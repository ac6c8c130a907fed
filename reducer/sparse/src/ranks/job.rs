//! A program under `mpirun` that obeys commands, with a private folder for what it reads and writes: started, asked, ended. Whatever
//! happens, neither processes nor files stay behind.

use std::ffi::{OsStr, OsString};
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use dcb_formats::output::{UnfinishedFolder, remove_unfinished};
use nix::sys::signal::{SigSet, Signal, killpg};
use nix::unistd::Pid;

use crate::Error;

/// Time that `mpirun` gets to end its processes everywhere before it is killed itself.
const GRACE: Duration = Duration::from_secs(10);
/// Between two looks whether it has ended.
const PAUSE: Duration = Duration::from_millis(20);
/// Bytes of a program's messages that are remembered.
const REMEMBERED: usize = 16 * 1024;
/// Lines of them that a failure repeats.
const REPEATED_LINES: usize = 6;
/// How the program's own lines begin; others on its output are messages.
const REPLY: &str = "dcb ";
/// A reply that is the last one.
const FAILED: &str = "failed ";

/// Folders in use and the process groups that work there, for an interruption.
static OPEN: Mutex<Open> = Mutex::new(Open {
    closed: false,
    jobs: Vec::new(),
});

struct Open {
    /// Nothing may be started any more.
    closed: bool,
    jobs: Vec<(PathBuf, Option<Pid>)>,
}

fn open() -> MutexGuard<'static, Open> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends every program and removes every folder, for a process that is about to end; nothing can be started afterwards.
pub fn end_all() {
    let mut open = open();
    open.closed = true;
    for (_, group) in open.jobs.drain(..) {
        if let Some(group) = group {
            end(group, || is_collected(group));
        }
    }
    drop(open);
    remove_unfinished();
}

/// Asks a group to end, and makes it end if it doesn't.
fn end(group: Pid, mut is_over: impl FnMut() -> bool) {
    let _ = killpg(group, Signal::SIGTERM);
    let start = Instant::now();
    while !is_over() && start.elapsed() < GRACE {
        std::thread::sleep(PAUSE);
    }
    let _ = killpg(group, Signal::SIGKILL);
}

/// Whether a group's first process has ended, here or where it is waited for; collects it.
fn is_collected(group: Pid) -> bool {
    // SAFETY: plain numbers, and no status wanted.
    unsafe { libc::waitpid(group.as_raw(), std::ptr::null_mut(), libc::WNOHANG) != 0 }
}

/// A folder that nobody else can look into, removed at the end, or by the next program if this one is killed.
pub struct PrivateFolder {
    unfinished: UnfinishedFolder,
}

impl PrivateFolder {
    /// Makes one in `place`.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn within(place: &Path) -> Result<Self, Error> {
        let mut open = open();
        if open.closed {
            return Err(interrupted());
        }
        let unfinished = UnfinishedFolder::within(place, OsStr::new("dcb-ranks"))
            .map_err(|source| file_error(place, "cannot make a folder here", source))?;
        open.jobs.push((unfinished.path().to_owned(), None));
        Ok(Self { unfinished })
    }

    /// A file in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.unfinished.path()
    }

    /// Notes which process group works here.
    fn set_group(&self, open: &mut Open, group: Option<Pid>) {
        for job in open.jobs.iter_mut().filter(|job| job.0 == self.path()) {
            job.1 = group;
        }
    }
}

impl Drop for PrivateFolder {
    fn drop(&mut self) {
        open().jobs.retain(|(path, _)| path != self.path());
    }
}

/// A running program with its folder, which goes after the program.
pub struct Job {
    running: Running,
    folder: PrivateFolder,
}

/// Processes; ended when they are dropped.
struct Running {
    command: Vec<OsString>,
    child: Child,
    group: Pid,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    /// Lines on the output that are no replies.
    said: String,
    errors: Option<JoinHandle<String>>,
    /// Why there will be no further reply.
    failure: Option<String>,
}

impl Job {
    /// Starts a command in a process group of its own: an interruption at the terminal reaches it by [`end_all`] only.
    ///
    /// # Errors
    /// [`Error::CannotStart`].
    pub fn start(folder: PrivateFolder, command: Vec<OsString>) -> Result<Self, Error> {
        let mut open = open();
        if open.closed {
            return Err(interrupted());
        }
        let running = Running::start(command)?;
        folder.set_group(&mut open, Some(running.group));
        Ok(Self { running, folder })
    }

    /// Where files are exchanged.
    pub fn folder(&self) -> &PrivateFolder {
        &self.folder
    }

    /// Writes a command and waits for its reply.
    ///
    /// # Errors
    /// As [`Job::reply`].
    pub fn ask(&mut self, command: &str) -> Result<String, Error> {
        if let Some(input) = &mut self.running.input {
            // A program that has ended says why in place of a reply.
            let _ = writeln!(input, "{command}").and_then(|()| input.flush());
        }
        self.reply()
    }

    /// Waits for a line of the program.
    ///
    /// # Errors
    /// [`Error::Ranks`] if it fails or has ended, with the first lines of what was said.
    pub fn reply(&mut self) -> Result<String, Error> {
        let running = &mut self.running;
        if running.failure.is_none() {
            match running.next_reply() {
                Some(reply) => match reply.strip_prefix(FAILED) {
                    None => return Ok(reply),
                    Some(why) => running.failure = Some(why.to_owned()),
                },
                None => running.failure = Some(running.last_words()),
            }
        }
        Err(Error::Ranks(running.failure.clone().unwrap_or_default()))
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        self.running.end();
        self.folder.set_group(&mut open(), None);
    }
}

impl Running {
    fn start(command: Vec<OsString>) -> Result<Self, Error> {
        let words = command.split_first().filter(|words| !words.0.is_empty());
        let Some((program, arguments)) = words else {
            return Err(cannot_start(&command, std::io::ErrorKind::NotFound.into()));
        };
        let mut starting = Command::new(program);
        // SAFETY: only gives the child the signals back that this program blocks, which allocates nothing.
        unsafe {
            starting.pre_exec(|| Ok(SigSet::all().thread_unblock()?));
        }
        let child = starting
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0)
            .spawn();
        let mut child = child.map_err(|source| cannot_start(&command, source))?;
        let group = Pid::from_raw(child.id() as i32);
        let (input, output, errors) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let reader =
            std::thread::Builder::new().spawn(move || errors.map_or_else(String::new, messages));
        match (output, reader) {
            (Some(output), Ok(errors)) => Ok(Self {
                command,
                child,
                group,
                input,
                output: BufReader::new(output),
                said: String::new(),
                errors: Some(errors),
                failure: None,
            }),
            (_, reader) => {
                end(group, || !matches!(child.try_wait(), Ok(None)));
                let source = reader
                    .err()
                    .unwrap_or_else(|| std::io::ErrorKind::BrokenPipe.into());
                Err(cannot_start(&command, source))
            }
        }
    }

    /// The next line that is a reply, without its beginning.
    fn next_reply(&mut self) -> Option<String> {
        loop {
            let line = next_line(&mut self.output)?;
            if let Some(reply) = line.strip_prefix(REPLY) {
                return Some(reply.to_owned());
            }
            remember(&mut self.said, &line);
        }
    }

    /// How the program has ended, with the first lines that say something, in one line.
    fn last_words(&mut self) -> String {
        self.input = None;
        let status = self.child.wait();
        let errors = self.errors.take().map(JoinHandle::join);
        let said = errors.and_then(Result::ok).unwrap_or_default() + &self.said;
        failure(&self.command, status.ok(), &said)
    }

    /// Asks the program to end, and makes it.
    fn end(&mut self) {
        if let Some(mut input) = self.input.take()
            && self.failure.is_none()
        {
            let _ = writeln!(input, "end");
            let start = Instant::now();
            while matches!(self.child.try_wait(), Ok(None)) && start.elapsed() < GRACE {
                std::thread::sleep(PAUSE);
            }
        }
        if matches!(self.child.try_wait(), Ok(None)) {
            let child = &mut self.child;
            end(self.group, || !matches!(child.try_wait(), Ok(None)));
            let _ = self.child.wait();
        }
    }
}

/// "File cannot be …".
pub fn file_error(path: &Path, action: &'static str, source: std::io::Error) -> Error {
    Error::File(dcb_formats::Error::io(path, action, source))
}

fn interrupted() -> Error {
    Error::Ranks("interrupted".into())
}

fn cannot_start(command: &[OsString], source: std::io::Error) -> Error {
    let program = command.first().map(OsString::as_os_str).unwrap_or_default();
    Error::CannotStart {
        program: program.to_string_lossy().into_owned(),
        source,
    }
}

/// The first lines that say something, in one line.
fn failure(command: &[OsString], status: Option<ExitStatus>, said: &str) -> String {
    let words: Vec<_> = command.iter().map(|w| OsStr::to_string_lossy(w)).collect();
    let lines: Vec<&str> = (said.lines().map(str::trim))
        .filter(|line| line.contains(char::is_alphanumeric))
        .take(REPEATED_LINES)
        .collect();
    let said = match lines.is_empty() {
        true => String::new(),
        false => format!(": {}", lines.join(" ")),
    };
    let status = status.map_or(String::new(), |status| format!(" with {status}"));
    format!("`{}` ended{status}{said}", words.join(" "))
}

fn next_line(input: &mut impl BufRead) -> Option<String> {
    let mut line = Vec::new();
    match input.read_until(b'\n', &mut line) {
        Ok(0) | Err(_) => None,
        Ok(_) => Some(String::from_utf8_lossy(&line).trim_end().to_owned()),
    }
}

/// Adds a line as long as few are remembered.
fn remember(said: &mut String, line: &str) {
    if said.len() < REMEMBERED {
        *said += line;
        said.push('\n');
    }
}

/// Reads to the end and remembers the beginning.
fn messages(input: impl Read) -> String {
    let (mut input, mut said) = (BufReader::new(input), String::new());
    while let Some(line) = next_line(&mut input) {
        remember(&mut said, &line);
    }
    said
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn job(place: &Path, script: &str) -> Result<Job, Error> {
        let command = ["sh", "-c", script].map(OsString::from).to_vec();
        Job::start(PrivateFolder::within(place)?, command)
    }

    fn is_empty(folder: &Path) -> bool {
        std::fs::read_dir(folder).unwrap().next().is_none()
    }

    #[test]
    fn commands_are_answered_and_the_folder_is_private_and_removed() {
        let place = tempfile::tempdir().unwrap();
        let script = "echo dcb ready; while read line; do [ \"$line\" = end ] && exit; echo noise; echo \"dcb got $line\"; done";
        let mut first = job(place.path(), script).unwrap();
        let second = job(place.path(), script).unwrap();
        assert_ne!(first.folder().path(), second.folder().path());
        assert_eq!(first.reply().unwrap(), "ready");
        assert_eq!(first.ask("solve 3").unwrap(), "got solve 3");
        let mode = std::fs::metadata(first.folder().path()).unwrap();
        assert_eq!(std::os::unix::fs::MetadataExt::mode(&mode) & 0o777, 0o700);
        std::fs::write(first.folder().file("left"), "something").unwrap();
        drop((first, second));
        assert!(is_empty(place.path()));
    }

    #[test]
    fn a_failure_repeats_what_was_said_every_time() {
        let place = tempfile::tempdir().unwrap();
        let script = "echo noise; echo '-----' >&2; echo 'out of slots' >&2; exit 3";
        let mut failing = job(place.path(), script).unwrap();
        for _ in 0..2 {
            let message = failing.ask("memory").unwrap_err().to_string();
            assert!(
                message.ends_with("ended with exit status: 3: out of slots noise"),
                "{message}"
            );
        }
        let mut refusing = job(place.path(), "echo dcb failed no room; sleep 600").unwrap();
        assert_eq!(refusing.reply().unwrap_err().to_string(), "ranks: no room");
        let folder = PrivateFolder::within(place.path()).unwrap();
        let missing = Job::start(folder, vec!["no-such-mpirun".into()]).err();
        assert!(matches!(missing, Some(Error::CannotStart { .. })));
    }

    #[test]
    fn a_job_that_is_dropped_is_ended() {
        let place = tempfile::tempdir().unwrap();
        let mut running = job(place.path(), "echo dcb failed once; sleep 600 & wait").unwrap();
        assert!(running.reply().is_err());
        let group = running.running.group;
        drop(running);
        // Its children belong to the group too; they are collected by init.
        let start = Instant::now();
        while killpg(group, None).is_ok() && start.elapsed() < 2 * GRACE {
            std::thread::sleep(PAUSE);
        }
        assert!(killpg(group, None).is_err());
    }
}
