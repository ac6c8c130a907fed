//! Processes that reduce, and how they are ended when the user interrupts.

use std::io::Read;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::workers::lock;

/// How often a process is looked at.
const INTERVAL: Duration = Duration::from_millis(20);
/// How long an interrupted process may clean up before it is killed.
const GRACE: Duration = Duration::from_secs(5);
/// After a process that was interrupted by itself, how long this one waits for its own interruption.
const SAME_MOMENT: Duration = Duration::from_millis(500);
/// Exit statuses of processes that a signal ended: SIGINT, SIGTERM, SIGHUP.
const INTERRUPTED: [i32; 3] = [130, 143, 129];

/// Processes that run, and whether more may begin.
#[derive(Debug)]
pub struct Processes(Mutex<Running>);

#[derive(Debug)]
struct Running {
    children: Vec<Arc<Mutex<Child>>>,
    is_ended: bool,
}

/// How a process ended.
#[derive(Debug)]
pub struct Ended {
    /// Its status.
    pub status: ExitStatus,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Processes {
    /// None yet.
    pub const fn none() -> Self {
        Self(Mutex::new(Running {
            children: Vec::new(),
            is_ended: false,
        }))
    }

    /// Runs a process to its end.
    ///
    /// # Errors
    /// It can't be started.
    pub fn run(&self, command: &mut Command) -> std::io::Result<Ended> {
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let (child, stdout, stderr) = {
            let mut running = lock(&self.0);
            while running.is_ended {
                drop(running);
                std::thread::park();
                running = lock(&self.0);
            }
            let mut child = command.spawn()?;
            let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
            let child = Arc::new(Mutex::new(child));
            running.children.push(Arc::clone(&child));
            (child, stdout, stderr)
        };
        let (stdout, stderr) = std::thread::scope(|scope| {
            // Both pipes are read at a time, else a full one stops the process.
            let reader = std::thread::Builder::new().spawn_scoped(scope, || text_of(stdout));
            if reader.is_err() {
                let _ = lock(&child).kill();
            }
            let stderr = text_of(stderr);
            reader.map(|reader| (reader.join().unwrap_or_default(), stderr))
        })
        .inspect_err(|_| {
            let _ = lock(&child).wait();
            let mut running = lock(&self.0);
            running.children.retain(|other| !Arc::ptr_eq(other, &child));
        })?;
        let status = loop {
            if let Some(status) = lock(&child).try_wait()? {
                break status;
            }
            std::thread::sleep(INTERVAL);
        };
        lock(&self.0)
            .children
            .retain(|other| !Arc::ptr_eq(other, &child));
        if status
            .code()
            .is_some_and(|code| INTERRUPTED.contains(&code))
        {
            // Ctrl-C reaches all processes of a terminal at once; this one is ended by its own handler.
            std::thread::sleep(SAME_MOMENT);
        }
        while lock(&self.0).is_ended {
            std::thread::park();
        }
        Ok(Ended {
            status,
            stdout,
            stderr,
        })
    }

    /// Ends all processes, and lets none begin or report any more: only for a program that ends itself thereafter.
    pub fn end_all(&self) {
        let children = {
            let mut running = lock(&self.0);
            running.is_ended = true;
            running.children.clone()
        };
        for child in &children {
            terminate(&mut lock(child));
        }
        let start = Instant::now();
        let has_ended = |child: &Arc<Mutex<Child>>| !matches!(lock(child).try_wait(), Ok(None));
        while !children.iter().all(has_ended) {
            if start.elapsed() > GRACE {
                for child in &children {
                    let _ = lock(child).kill();
                }
                return;
            }
            std::thread::sleep(INTERVAL);
        }
    }
}

fn text_of(pipe: Option<impl Read>) -> String {
    let mut bytes = Vec::new();
    if let Some(mut pipe) = pipe {
        // What was read before an error is as good as there is.
        let _ = pipe.read_to_end(&mut bytes);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Asks a process to end, so that it can remove what it has begun to write. It wasn't waited for to its end: its number is still its own.
#[cfg(unix)]
pub fn terminate(child: &mut Child) {
    use nix::sys::signal::{Signal, kill};
    use nix::unistd::Pid;

    if matches!(child.try_wait(), Ok(None))
        && let Ok(number) = i32::try_from(child.id())
    {
        let _ = kill(Pid::from_raw(number), Signal::SIGTERM);
    }
}

/// Ends a process.
#[cfg(not(unix))]
pub fn terminate(child: &mut Child) {
    let _ = child.kill();
}
