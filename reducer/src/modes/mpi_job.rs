//! A program under `mpirun` with a private folder for what it reads and writes: started, followed, ended. Whatever
//! happens, neither processes nor files stay behind.

use std::ffi::{OsStr, OsString};
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use dcb_formats::output::{UnfinishedFolder, remove_unfinished};
use nix::sys::signal::{SigSet, Signal, killpg};
use nix::unistd::Pid;

use crate::error::{CommandRefusal, EigenSolverRefusal, Error};

/// Time that `mpirun` gets to end its processes everywhere before it is killed itself.
const GRACE: Duration = Duration::from_secs(10);
/// Between two looks whether it has ended.
const PAUSE: Duration = Duration::from_millis(20);
/// Bytes of a program's messages that are remembered.
const REMEMBERED: usize = 16 * 1024;
/// Lines of them that a failure repeats.
const REPEATED_LINES: usize = 6;
/// The rest of PETSc's message describes the installation.
const END_OF_PETSC_MESSAGE: &str = "for trouble shooting";

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
            // Whoever waits for the process collects it, and then its group is gone.
            end(group, || killpg(group, None).is_err());
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
        let unfinished = UnfinishedFolder::within(place, OsStr::new("dcb-slepc"))
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

    /// Runs a command to its end and gives each line of its standard output to `line`, which tells whether it was
    /// meant for it; other lines are messages.
    ///
    /// # Errors
    /// [`Error::CannotStart`], or [`Error::EigenSolver`] with its messages if it doesn't end well.
    pub fn run(
        &self,
        command: &[OsString],
        mut line: impl FnMut(&str) -> bool,
    ) -> Result<(), Error> {
        let mut running = self.start(command)?;
        let errors = running.child.stderr.take();
        let errors = std::thread::Builder::new()
            .spawn(move || errors.map_or_else(String::new, messages))
            .map_err(|source| cannot_start(command, source))?;
        let mut said = String::new();
        if let Some(output) = running.child.stdout.take() {
            for text in lossy_lines(output) {
                if !line(&text) && said.len() < REMEMBERED {
                    said += &text;
                    said.push('\n');
                }
            }
        }
        let status = running.wait();
        let mut all = errors.join().unwrap_or_default();
        all += &said;
        match status {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(failure(command, status, &all)),
            Err(source) => Err(cannot_start(command, source)),
        }
    }

    /// Starts a command in a process group of its own: an interruption at the terminal reaches it by [`end_all`] only.
    fn start(&self, command: &[OsString]) -> Result<Running<'_>, Error> {
        let (program, arguments) = command
            .split_first()
            .ok_or_else(|| CommandRefusal::from(EigenSolverRefusal::EmptyLauncher))?;
        let mut open = open();
        if open.closed {
            return Err(interrupted());
        }
        let mut starting = Command::new(program);
        // SAFETY: only gives the child the signals back that this program blocks, which allocates nothing.
        unsafe {
            starting.pre_exec(|| Ok(SigSet::all().thread_unblock()?));
        }
        let child = starting
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0)
            .spawn()
            .map_err(|source| cannot_start(command, source))?;
        let group = Pid::from_raw(child.id() as i32);
        self.set_group(&mut open, Some(group));
        Ok(Running {
            folder: self,
            child,
            group,
            is_over: false,
        })
    }
}

impl Drop for PrivateFolder {
    fn drop(&mut self) {
        open().jobs.retain(|(path, _)| path != self.path());
    }
}

/// A process with its group; ended if it is still there when it is dropped.
struct Running<'a> {
    folder: &'a PrivateFolder,
    child: Child,
    group: Pid,
    is_over: bool,
}

impl Running<'_> {
    fn wait(&mut self) -> std::io::Result<ExitStatus> {
        let status = self.child.wait();
        self.is_over = true;
        self.folder.set_group(&mut open(), None);
        status
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        if !self.is_over {
            let child = &mut self.child;
            end(self.group, || !matches!(child.try_wait(), Ok(None)));
            let _ = self.wait();
        }
    }
}

/// "File cannot be …".
pub fn file_error(path: &Path, action: &'static str, source: std::io::Error) -> Error {
    dcb_formats::Error::io(path, action, source).into()
}

fn interrupted() -> Error {
    Error::EigenSolver("interrupted".into())
}

fn cannot_start(command: &[OsString], source: std::io::Error) -> Error {
    let program = command.first().map(OsString::as_os_str).unwrap_or_default();
    Error::CannotStart {
        program: program.to_string_lossy().into_owned(),
        source,
    }
}

/// The first lines that say something, in one line.
fn failure(command: &[OsString], status: ExitStatus, said: &str) -> Error {
    let words: Vec<_> = command.iter().map(|w| OsStr::to_string_lossy(w)).collect();
    let lines: Vec<&str> = said
        .lines()
        .map(without_rank)
        .take_while(|line| !line.contains(END_OF_PETSC_MESSAGE))
        .filter(|line| line.contains(char::is_alphanumeric) && !line.contains("Error Message -"))
        .take(REPEATED_LINES)
        .collect();
    let said = match lines.is_empty() {
        true => String::new(),
        false => format!(": {}", lines.join(" ")),
    };
    Error::EigenSolver(format!("`{}` ended with {status}{said}", words.join(" ")))
}

/// A line without PETSc's `[0]PETSC ERROR: `.
fn without_rank(line: &str) -> &str {
    let line = line.trim();
    line.split_once("PETSC ERROR:")
        .map_or(line, |(_, message)| message.trim())
}

fn lossy_lines(input: impl Read) -> impl Iterator<Item = String> {
    let mut input = BufReader::new(input);
    std::iter::from_fn(move || {
        let mut line = Vec::new();
        match input.read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => None,
            Ok(_) => Some(String::from_utf8_lossy(&line).trim_end().to_owned()),
        }
    })
}

/// Reads to the end and remembers the beginning.
fn messages(input: impl Read) -> String {
    let mut said = String::new();
    for line in lossy_lines(input) {
        if said.len() < REMEMBERED {
            said += &line;
            said.push('\n');
        }
    }
    said
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn shell(script: &str) -> Vec<OsString> {
        ["sh", "-c", script].map(OsString::from).to_vec()
    }

    fn is_empty(folder: &Path) -> bool {
        std::fs::read_dir(folder).unwrap().next().is_none()
    }

    #[test]
    fn lines_are_given_on_and_the_folder_is_private_and_removed() {
        let place = tempfile::tempdir().unwrap();
        let folder = PrivateFolder::within(place.path()).unwrap();
        let second = PrivateFolder::within(place.path()).unwrap();
        assert_ne!(folder.path(), second.path());
        let mut lines = Vec::new();
        let script = format!("echo one; stat -c %a '{}'", folder.path().display());
        folder
            .run(&shell(&script), |line| {
                lines.push(line.to_owned());
                true
            })
            .unwrap();
        assert_eq!(lines, ["one", "700"]);
        std::fs::write(folder.file("left"), "something").unwrap();
        drop((folder, second));
        assert!(is_empty(place.path()));
    }

    #[test]
    fn a_failure_repeats_what_was_said() {
        let place = tempfile::tempdir().unwrap();
        let folder = PrivateFolder::within(place.path()).unwrap();
        let script = "echo noise; echo '[0]PETSC ERROR: --- Error Message ---' >&2; echo '-----' >&2; echo '[0]PETSC ERROR: out of slots' >&2; exit 3";
        let failed = folder.run(&shell(script), |_| false).unwrap_err();
        let message = failed.to_string();
        assert!(
            message.ends_with("ended with exit status: 3: out of slots noise"),
            "{message}"
        );
        assert!(!failed.is_unusable_input());
        let missing = folder
            .run(&["no-such-mpirun".into()], |_| true)
            .unwrap_err();
        assert!(missing.is_unusable_input(), "{missing}");
    }

    #[test]
    fn a_job_that_is_dropped_is_ended() {
        let place = tempfile::tempdir().unwrap();
        let folder = PrivateFolder::within(place.path()).unwrap();
        let running = folder.start(&shell("sleep 600 & wait")).unwrap();
        let group = running.group;
        drop(running);
        // Its children belong to the group too; they are collected by init.
        let start = Instant::now();
        while killpg(group, None).is_ok() && start.elapsed() < GRACE {
            std::thread::sleep(PAUSE);
        }
        assert!(killpg(group, None).is_err());
    }
}
