//! Saved states of a unit, in memory and as bytes.

use dcb_runtime::simulation::{Simulation, Snapshot};
use sha2::{Digest, Sha256};

use crate::choice::Choice;
use crate::error::Error;
use crate::mode::Mode;
use crate::stepping::Progress;

/// What the bytes begin with.
const MAGIC: &[u8; 16] = b"dcb unit state 1";
/// Bytes of the digest at their end.
const DIGEST: usize = 32;
/// No place on the grid of steps.
const OFF_GRID: u64 = u64::MAX;

/// What the continuation of a unit depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedState {
    pub(crate) token: String,
    pub(crate) mode: Mode,
    pub(crate) choice: Choice,
    pub(crate) time: f64,
    pub(crate) progress: Progress,
    pub(crate) motion: Snapshot,
}

impl SavedState {
    /// The state as bytes: little-endian numbers between a title and a digest (SHA-256) over all before it.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(self.token.as_bytes());
        bytes.push(match self.mode {
            Mode::Instantiated => 0,
            Mode::Initialization => 1,
            Mode::Step => 2,
            Mode::Terminated => 3,
        });
        let (size, settled) = self.progress.size;
        bytes.extend(self.progress.made.unwrap_or(OFF_GRID).to_le_bytes());
        bytes.extend((settled as u64).to_le_bytes());
        let numbers = self.choice.parameters.iter().chain(&self.choice.inputs);
        let own = [size, self.choice.end, self.time];
        for number in own.iter().chain(numbers).chain(&self.motion.numbers()) {
            bytes.extend(number.to_le_bytes());
        }
        let digest = Sha256::digest(&bytes);
        bytes.extend(&digest[..]);
        bytes
    }

    /// The state in bytes of a unit with this token, so many parameters and inputs, and this motion or another one of the same system.
    pub(crate) fn of_bytes(
        bytes: &[u8],
        token: &str,
        counts: [usize; 2],
        simulation: &Simulation,
    ) -> Result<Self, Error> {
        let foreign = Error::ForeignState;
        let other = || foreign("its size is that of another unit");
        let content = bytes
            .len()
            .checked_sub(DIGEST)
            .map(|end| bytes.split_at(end));
        let (content, digest) = content.ok_or_else(other)?;
        let rest = content.strip_prefix(MAGIC);
        let rest = rest.ok_or(foreign("it doesn't begin as one"))?;
        if Sha256::digest(content)[..] != *digest {
            return Err(foreign("it is damaged"));
        }
        let rest = rest.strip_prefix(token.as_bytes());
        let rest = rest.ok_or(foreign("it is of another unit"))?;
        let (mode, rest) = rest.split_first().ok_or_else(other)?;
        let mode = match mode {
            0 => Mode::Instantiated,
            1 => Mode::Initialization,
            2 => Mode::Step,
            3 => Mode::Terminated,
            _ => return Err(foreign("it has an unknown mode")),
        };
        let (grid, rest) = rest.split_first_chunk::<8>().ok_or_else(other)?;
        let (settled, rest) = rest.split_first_chunk::<8>().ok_or_else(other)?;
        let [made, settled] = [grid, settled].map(|bytes| u64::from_le_bytes(*bytes));
        let (numbers, []) = rest.as_chunks::<8>() else {
            return Err(other());
        };
        let numbers: Vec<f64> = numbers
            .iter()
            .map(|bytes| f64::from_le_bytes(*bytes))
            .collect();
        if numbers.len() < 3 + counts[0] + counts[1] {
            return Err(other());
        }
        let (own, numbers) = numbers.split_at(3);
        let (parameters, numbers) = numbers.split_at(counts[0]);
        let (inputs, numbers) = numbers.split_at(counts[1]);
        Ok(Self {
            mode,
            choice: Choice {
                parameters: parameters.to_vec(),
                inputs: inputs.to_vec(),
                end: own[1],
            },
            time: own[2],
            progress: Progress {
                made: (made != OFF_GRID).then_some(made),
                size: (own[0], settled as usize),
            },
            motion: simulation.snapshot_of(numbers)?,
            token: token.to_owned(),
        })
    }
}
