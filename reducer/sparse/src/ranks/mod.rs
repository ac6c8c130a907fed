//! A factor on many machines: `mumps/dcb-mumps-factor.c` under `mpirun` holds the factor, spread over its processes (ranks), and obeys one
//! command after the other. This process sends matrices and right-hand sides and gets solutions and counts.
//!
//! ```text
//! matrix    n, entries (u64); rows, columns of the lower triangle (i32, from 1); values (f64); place of each row in the order (i32, from 1)
//! block     columns of n numbers (f64): right-hand sides, then their solutions
//! ```
//! are files in a private folder that the machine of rank 0 sees too; commands and replies are lines on the pipes of `mpirun`.

mod exchange;
pub mod job;

use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use faer::MatMut;

use self::exchange::{read_block, write_block, write_matrix};
use self::job::{Job, PrivateFolder, file_error};
use crate::Error;
use crate::inertia::Inertia;
use crate::multifrontal::{Fronts, Matrix};
use crate::unfactorized::Unfactorized;

/// Name of the program that runs under `mpirun`.
const PROGRAM: &str = "dcb-mumps-factor";
/// File of a matrix.
const MATRIX: &str = "matrix";
/// File of right-hand sides and solutions.
const BLOCK: &str = "block";

/// How ranks are started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RanksRun {
    /// MPI processes.
    pub ranks: u32,
    /// The command that starts MPI programs, word by word; `-n RANKS PROGRAM FOLDER` is added.
    pub launcher: Vec<String>,
    /// `dcb-mumps-factor`, at this place on every machine that takes part.
    pub program: PathBuf,
    /// Where the private folder is made; the machine of rank 0 must see it at the same place.
    pub scratch: PathBuf,
}

impl RanksRun {
    /// `mpirun`, the program beside the running one (or where the build left it), the system's folder for temporary files.
    pub fn with_ranks(ranks: u32) -> Self {
        let beside = std::env::current_exe()
            .ok()
            .map(|exe| exe.with_file_name(PROGRAM));
        let built = PathBuf::from(env!("DCB_MUMPS_FACTOR"));
        Self {
            ranks,
            launcher: vec!["mpirun".into()],
            program: beside.filter(|path| path.is_file()).unwrap_or(built),
            scratch: std::env::temp_dir(),
        }
    }
}

/// Running ranks; they end when this is dropped.
pub(crate) struct Ranks {
    job: Mutex<Job>,
}

impl Ranks {
    /// Starts them.
    ///
    /// # Errors
    /// [`Error::CannotStart`], [`Error::File`] without a folder, [`Error::Ranks`] if they end at once.
    pub fn start(run: &RanksRun) -> Result<Self, Error> {
        if !run.program.is_file() {
            return Err(Error::CannotStart {
                program: run.program.display().to_string(),
                source: std::io::ErrorKind::NotFound.into(),
            });
        }
        let folder = PrivateFolder::within(&run.scratch)?;
        let mut command: Vec<_> = run.launcher.iter().map(Into::into).collect();
        command.extend(["-n".into(), run.ranks.to_string().into()]);
        command.extend([
            run.program.clone().into_os_string(),
            folder.path().as_os_str().to_owned(),
        ]);
        let mut job = Job::start(folder, command)?;
        let reply = job.reply()?;
        match numbers(&reply, "ready").as_deref() {
            Some([ranks]) if *ranks == u64::from(run.ranks) => Ok(Self { job: job.into() }),
            Some([ranks]) => Err(Error::Ranks(format!(
                "{} processes were started that know of {ranks}: `{}` must be of the MPI that {PROGRAM} was built with",
                run.ranks,
                run.launcher.join(" ")
            ))),
            _ => Err(unexpected(&reply)),
        }
    }

    /// Computes the factor of a positive definite matrix in the order of its analysis.
    ///
    /// # Errors
    /// [`Unfactorized`].
    pub fn factorize(&self, matrix: Matrix<'_>, fronts: &Fronts) -> Result<(), Unfactorized> {
        let mut job = self.job();
        let reply = with_matrix(&mut job, "factorize", matrix, fronts)?;
        match reply.as_str() {
            "indefinite" => Err(Unfactorized::NotPositive),
            reply if reply.starts_with("factorized ") => Ok(()),
            reply => Err(unexpected(reply).into()),
        }
    }

    /// Signs of the pivots of a matrix. Where they are negative isn't told.
    ///
    /// # Errors
    /// [`Error::Ranks`], [`Error::File`].
    pub fn count(&self, matrix: Matrix<'_>, fronts: &Fronts) -> Result<Inertia, Error> {
        let reply = with_matrix(&mut self.job(), "count", matrix, fronts)?;
        match numbers(&reply, "counted").as_deref() {
            Some([negative, zero]) => Ok(Inertia {
                negative: *negative as usize,
                zero: *zero as usize,
                negative_dofs: Vec::new(),
            }),
            _ => Err(unexpected(&reply)),
        }
    }

    /// Replaces every column by its solution.
    ///
    /// # Errors
    /// [`Error::Ranks`], [`Error::File`].
    pub fn solve_in_place(&self, mut columns: MatMut<'_, f64>) -> Result<(), Error> {
        let mut job = self.job();
        let path = job.folder().file(BLOCK);
        let path = &path;
        let cannot = |what| move |source| file_error(path, what, source);
        open(path)
            .and_then(|mut file| write_block(&mut file, columns.as_ref()))
            .map_err(cannot("cannot write right-hand sides for the ranks"))?;
        let reply = job.ask(&format!("solve {}", columns.ncols()))?;
        if reply != "solved" {
            return Err(unexpected(&reply));
        }
        File::open(path)
            .and_then(|mut file| read_block(&mut file, columns.as_mut()))
            .map_err(cannot("cannot read solutions of the ranks"))
    }

    /// Gives up the factor's room. A failure shows at the next command.
    pub fn release(&self) {
        let _ = self.job().ask("release");
    }

    /// Most memory that each rank has had in use, bytes.
    ///
    /// # Errors
    /// [`Error::Ranks`].
    pub fn peak_bytes(&self) -> Result<Vec<u64>, Error> {
        let reply = self.job().ask("memory")?;
        numbers(&reply, "memory").ok_or_else(|| unexpected(&reply))
    }

    fn job(&self) -> MutexGuard<'_, Job> {
        self.job.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Sends a matrix with a command; its file is gone afterwards.
fn with_matrix(
    job: &mut Job,
    command: &str,
    matrix: Matrix<'_>,
    fronts: &Fronts,
) -> Result<String, Error> {
    let path = job.folder().file(MATRIX);
    let written = File::create(&path).and_then(|file| write_matrix(file, matrix, &fronts.inverse));
    let reply = match written {
        Ok(()) => job.ask(command),
        Err(source) => Err(file_error(
            &path,
            "cannot write the matrix for the ranks",
            source,
        )),
    };
    let _ = std::fs::remove_file(&path);
    reply
}

fn open(path: &Path) -> std::io::Result<File> {
    OpenOptions::new()
        .write(true)
        .create(true)
        .truncate(false)
        .open(path)
}

/// The numbers of a reply that begins with this word.
fn numbers(reply: &str, word: &str) -> Option<Vec<u64>> {
    let rest = reply.strip_prefix(word)?.split_whitespace();
    rest.map(|number| number.parse().ok()).collect()
}

fn unexpected(reply: &str) -> Error {
    Error::Ranks(format!("{PROGRAM} answered {reply:?}"))
}
