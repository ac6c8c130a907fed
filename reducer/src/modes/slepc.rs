//! The search for the lowest modes handed to SLEPc: Krylov–Schur on (K + σ M)⁻¹ M with MUMPS, on any number of MPI processes.
//!
//! K, M and the rigid motions travel as PETSc files in a private folder, θ = 1/(λ + σ) and the shapes travel back
//! (`slepc/dcb-slepc-eigen.c` is what runs in between). What comes back is a first guess: inverse iteration and the
//! Rayleigh–Ritz step on K and M, the fixed basis, the true residuals and the eigenvalue count are those of
//! [`crate::modes::free_modes`] and decide as they do for block Lanczos.

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};

use dcb_sparse::block_algebra::symmetric_product;
use dcb_sparse::factorization::PositiveFactor;
use dcb_superelement::extended_to_gap;
use faer::{Mat, MatRef};
use serde::Serialize;

use crate::error::{CommandRefusal, EigenSolverRefusal, Error};
use crate::model::condensation::Model;
use crate::model::rigid_body::RigidBodyModes;
use crate::modes::free_modes::{
    FreeModes, KnownMotions, RESIDUAL_TOLERANCE, Search, motions_without_energy,
};
use crate::modes::mpi_job::{PrivateFolder, file_error};
use crate::modes::petsc_binary::{
    create, read_list_and_number, read_vectors, write_symmetric, write_vectors,
};
use crate::observer::Observer;

/// Name of the program that runs under `mpirun`.
const PROGRAM: &str = "dcb-slepc-eigen";
/// Pairs wanted beyond the modes: they tell where a multiple root ends and where the spectrum goes on.
const GUARDS: usize = 8;
/// Wanted accuracy of a Ritz vector before it is polished.
const TOLERANCE: f64 = 1e-10;
/// Steps of inverse iteration at most; one is usual.
const POLISHES: usize = 3;
/// θ below this fraction of the largest is rounding: a motion without mass.
const WITHOUT_MASS: f64 = 1e-13;

/// How SLEPc is started.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SlepcRun {
    /// MPI processes.
    pub ranks: u32,
    /// The command that starts MPI programs, word by word; `-n RANKS PROGRAM …` is added.
    #[serde(skip)]
    pub launcher: Vec<String>,
    /// `dcb-slepc-eigen`, at this place on every machine that takes part.
    #[serde(skip)]
    pub program: PathBuf,
    /// Where the private folder is made; the machine of rank 0 must see it at the same place.
    #[serde(skip)]
    pub scratch: PathBuf,
}

/// Lowest pairs as SLEPc gave them.
struct Pairs {
    /// λ, ascending.
    eigenvalues: Vec<f64>,
    /// Their vectors, (n_c, pairs).
    shapes: Mat<f64>,
    /// Restarts of Krylov–Schur.
    restarts: usize,
}

/// Its shift over that of our factor: with as small a one, what rounding leaves of deflated motions would be found again.
const OVER_SHIFT: f64 = 1e3;

impl SlepcRun {
    /// `mpirun`, the program beside the running one (or where the build left it), the system's folder for temporary files.
    pub fn with_ranks(ranks: u32) -> Self {
        let beside = std::env::current_exe()
            .ok()
            .map(|exe| exe.with_file_name(PROGRAM));
        let built = PathBuf::from(env!("DCB_SLEPC_EIGEN"));
        Self {
            ranks,
            launcher: vec!["mpirun".into()],
            program: beside.filter(|path| path.is_file()).unwrap_or(built),
            scratch: std::env::temp_dir(),
        }
    }

    /// Finds the lowest modes, as [`FreeModes::compute`] does.
    ///
    /// # Errors
    /// [`Error::CannotStart`], [`Error::File`] and [`Error::Command`] where the search can't begin, [`Error::EigenSolver`] where it fails,
    /// and those of [`FreeModes::compute`].
    pub fn free_modes(
        &self,
        model: &Model,
        rigid: &RigidBodyModes,
        factor: &PositiveFactor,
        shift: f64,
        search: Search,
        observer: &mut dyn Observer,
    ) -> Result<FreeModes, Error> {
        let mut asked = search.wanted + GUARDS + search.missed;
        let shift = OVER_SHIFT * shift;
        loop {
            let pairs = self.lowest(model, rigid, shift, asked, search.attempt, observer)?;
            let available = pairs.eigenvalues.len();
            let without_energy = motions_without_energy(&pairs.eigenvalues, shift);
            let kept = extended_to_gap(&pairs.eigenvalues, search.wanted.max(without_energy));
            if kept + 2 <= available && kept >= search.wanted {
                return sharpened(model, rigid, factor, &pairs, kept, search.wanted);
            }
            if available < asked {
                return Err(Error::EigenSolver(format!(
                    "{available} of {asked} pairs converged after {} restarts of Krylov–Schur; ask for fewer modes, or check the part for extreme stiffness contrasts",
                    pairs.restarts
                )));
            }
            // A multiple root reaches beyond the guards: look further before deciding where it ends.
            asked = 2 * asked.max(kept);
        }
    }

    /// One run of the program.
    fn lowest(
        &self,
        model: &Model,
        rigid: &RigidBodyModes,
        shift: f64,
        asked: usize,
        seed: usize,
        observer: &mut dyn Observer,
    ) -> Result<Pairs, Error> {
        let elastic = model.len() - rigid.count();
        if 2 * asked > elastic {
            let wanted = asked;
            let refusal = EigenSolverRefusal::TooMany { wanted, elastic };
            return Err(CommandRefusal::from(refusal).into());
        }
        if !self.program.is_file() {
            return Err(Error::CannotStart {
                program: self.program.display().to_string(),
                source: io::ErrorKind::NotFound.into(),
            });
        }
        let folder = PrivateFolder::within(&self.scratch)?;
        write_problem(&folder, model, rigid)?;
        let command = self.command(&folder, rigid.count(), shift, asked, seed);
        folder.run(&command, |line| match converged(line) {
            None => false,
            Some(count) => {
                observer.progress(count as f64 / asked as f64);
                true
            }
        })?;
        read_pairs(&folder, model.len(), shift)
    }

    fn command(
        &self,
        folder: &PrivateFolder,
        rigid: usize,
        shift: f64,
        asked: usize,
        seed: usize,
    ) -> Vec<OsString> {
        let mut command: Vec<OsString> = self.launcher.iter().map(OsString::from).collect();
        command.extend(["-n".into(), self.ranks.to_string().into()]);
        command.push(self.program.clone().into());
        command.extend(["-dcb_folder".into(), folder.path().into()]);
        for (name, value) in [
            ("-dcb_shift", format!("{shift:e}")),
            ("-dcb_tolerance", format!("{TOLERANCE:e}")),
            ("-dcb_wanted", asked.to_string()),
            ("-dcb_rigid", rigid.to_string()),
            ("-dcb_seed", seed.to_string()),
        ] {
            command.extend([name.into(), value.into()]);
        }
        command
    }
}

/// The number in a line `converged NUMBER` of the program.
fn converged(line: &str) -> Option<usize> {
    line.strip_prefix("converged ")?.parse().ok()
}

fn write_problem(
    folder: &PrivateFolder,
    model: &Model,
    rigid: &RigidBodyModes,
) -> Result<(), Error> {
    let failed = |path: &Path, source| file_error(path, "cannot write", source);
    for (name, matrix) in [("stiffness", &model.stiffness), ("mass", &model.mass)] {
        let path = folder.file(name);
        create(&path, |out| write_symmetric(out, matrix)).map_err(|error| failed(&path, error))?;
    }
    let path = folder.file("rigid");
    create(&path, |out| write_vectors(out, rigid.shapes.as_ref()))
        .map_err(|error| failed(&path, error))
}

fn read_pairs(folder: &PrivateFolder, n: usize, shift: f64) -> Result<Pairs, Error> {
    let failed = |name: &str, error: io::Error| {
        Error::EigenSolver(format!("{PROGRAM} left no usable file `{name}`: {error}"))
    };
    let (theta, restarts) = read_list_and_number(&folder.file("eigenvalues"), n)
        .map_err(|error| failed("eigenvalues", error))?;
    let mut room: Vec<f64> = Vec::new();
    room.try_reserve_exact(n.saturating_mul(theta.len()))
        .map_err(|_| Error::OutOfMemory {
            what: "the modes (ask for fewer)",
        })?;
    drop(room);
    let shapes = read_vectors(&folder.file("shapes"), n, theta.len())
        .map_err(|error| failed("shapes", error))?;
    if !theta.is_sorted_by(|a, b| a >= b) {
        let error = io::Error::new(io::ErrorKind::InvalidData, "not in descending order");
        return Err(failed("eigenvalues", error));
    }
    let largest = theta.first().copied().unwrap_or(0.0);
    let finite = theta
        .iter()
        .take_while(|value| **value > WITHOUT_MASS * largest);
    let eigenvalues: Vec<f64> = finite.map(|value| 1.0 / value - shift).collect();
    Ok(Pairs {
        shapes: shapes.as_ref().subcols(0, eigenvalues.len()).to_owned(),
        eigenvalues,
        restarts: restarts as usize,
    })
}

/// Inverse iteration until the residuals are as they should be.
fn sharpened(
    model: &Model,
    rigid: &RigidBodyModes,
    factor: &PositiveFactor,
    pairs: &Pairs,
    kept: usize,
    wanted: usize,
) -> Result<FreeModes, Error> {
    let mut x = pairs.shapes.as_ref().subcols(0, kept + 2).to_owned();
    let mut polishes = 0;
    loop {
        x = inverse_iteration(model, rigid, factor, x.as_ref());
        polishes += 1;
        // Loose pieces are among what it found.
        let known = KnownMotions {
            rigid,
            loose: &Mat::zeros(model.len(), 0),
        };
        let modes = FreeModes::of_subspace(model, known, x.clone(), kept, wanted, pairs.restarts)?;
        let unconverged = modes.unconverged().count();
        if unconverged == 0 {
            return Ok(modes);
        }
        if polishes == POLISHES {
            let residual = modes.residuals.iter().copied().fold(0.0, f64::max);
            return Err(Error::EigenSolver(format!(
                "{unconverged} of {kept} modes are not converged (largest residual {residual:.1e}, wanted {RESIDUAL_TOLERANCE:.0e}); check the part for extreme stiffness contrasts"
            )));
        }
    }
}

/// `(K + σ M)⁻¹ M x` without its rigid part.
fn inverse_iteration(
    model: &Model,
    rigid: &RigidBodyModes,
    factor: &PositiveFactor,
    x: MatRef<'_, f64>,
) -> Mat<f64> {
    let mut y = symmetric_product(&model.mass, x);
    factor.solve_in_place(y.as_mut());
    rigid.project_out(&mut y);
    y
}
