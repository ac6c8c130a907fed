//! Whether bodies stay where the linear floating frame describes them.
//!
//! Deflections are taken as small: against the body's size, and turns of interfaces against one. A spin across a slender part makes
//! it stiffer by the pull along it, which the linear theory lacks unless the body has geometric stiffening:
//!
//! ```text
//! in the plane of the spin     ω² = ω₁² + (S - 1) Ω²        linear: ω₁² - Ω²
//! out of it                    ω² = ω₁² + S Ω²              linear: ω₁²
//! ```
//! with S = 3.05 for the first bending of a free uniform rod. In the plane nothing is left of the linear stiffness at Ω = ω₁, and nothing
//! above could be called right. Nothing pulls along a shaft that spins about its own axis: what counts is the spin across the body's length.
//! Each limit is told once for each body. Where a body deflects or turns too far because drives contradict each
//! other, the motion is refused.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use crate::error::Error;
use crate::system::{State, System};
use crate::watch::contradicting_drives::ContradictingDrives;

/// A deflection beyond this share of the body's size is told.
const DEFLECTION: f64 = 0.1;
/// An interface's turn beyond this is told, rad.
const TURN: f64 = 0.2;
/// A spin beyond this share of the first angular frequency is told.
const SPIN: f64 = 0.3;
/// S of the first bending mode φ of a free uniform rod of unit length: ½ ∫ (x - x²) φ'² dx / ∫ φ² dx.
const ROD_STIFFENING: f64 = 3.049_764;

/// By which part the linear theory has the first frequency of a free slender rod too low in the plane of its spin, which is `ratio` (below
/// one) of that frequency: `1 - √((1 - r²) / (1 + (S - 1) r²))`, about S r²/2.
pub fn rod_frequency_deficit(ratio: f64) -> f64 {
    let square = ratio * ratio;
    1.0 - ((1.0 - square) / (1.0 + (ROD_STIFFENING - 1.0) * square)).sqrt()
}

/// A body is long in the directions in which its mass has at least this share of its largest second moment.
const LONG: f64 = 0.5;

/// The directions in which a body is long: along them a spin pulls at it.
///
/// ```text
/// S = ½ tr(J) 1 - J = Σ s_i n_i n_iᵀ        long: s_i ≥ s_max / 2        Ω_across² = max_i (Ω² - (Ω·n_i)²) over these
/// ```
///
/// A shaft that spins about its own axis isn't pulled along it; a bar that spins across its length is by all of the spin, and a disc by any spin.
#[derive(Clone, Debug)]
struct Extent {
    /// n_i, body axes.
    directions: Vec<Vector3<f64>>,
}

impl Extent {
    /// From the tensor of inertia about the centre of mass, body axes; that of a planar body has only (z, z).
    fn of(tensor: &Matrix3<f64>) -> Self {
        let moments = Matrix3::from_diagonal_element(0.5 * tensor.trace()) - tensor;
        let found = SymmetricEigen::new(moments);
        let least = LONG * found.eigenvalues.max();
        let principal = found
            .eigenvalues
            .iter()
            .zip(found.eigenvectors.column_iter());
        let long = principal.filter(|(moment, _)| **moment >= least);
        Self {
            directions: long.map(|(_, direction)| direction.into_owned()).collect(),
        }
    }

    /// The spin across the extent, rad by time.
    fn spin_across(&self, spin: &Vector3<f64>) -> f64 {
        let across = |along: &Vector3<f64>| spin.cross(along).norm();
        self.directions.iter().map(across).fold(0.0, f64::max)
    }
}

/// Messages that have been given.
#[derive(Clone, Debug)]
pub struct Validity {
    told: Vec<[bool; 4]>,
    first_frequencies: Vec<f64>,
    extents: Vec<Extent>,
    drives: ContradictingDrives,
}

impl Validity {
    /// For the bodies of a system that starts at this state.
    pub fn of(system: &System, start: &State) -> Self {
        let first = |stiffness: &[f64]| {
            let elastic = stiffness.iter().filter(|s| **s > 0.0);
            elastic.fold(f64::INFINITY, |least, s| least.min(s.sqrt()))
        };
        Self {
            told: vec![[false; 4]; system.bodies.len()],
            first_frequencies: system
                .bodies
                .iter()
                .map(|body| first(&body.flexible.stiffness))
                .collect(),
            extents: system
                .bodies
                .iter()
                .map(|body| Extent::of(body.flexible.inertia.rotation().tensor()))
                .collect(),
            drives: ContradictingDrives::at(system, start),
        }
    }

    /// A violated constraint with its unit, `length` where it isn't an angle; as the drives that contradict each other, where it is they that do.
    pub fn naming_drives(
        &self,
        error: Error,
        system: &System,
        state: &State,
        length: &str,
    ) -> Error {
        let Error::Contradiction {
            time,
            joint,
            misfit,
            unit,
        } = error
        else {
            return error;
        };
        let unit = match unit.as_str() {
            "rad" => unit,
            _ => length.to_owned(),
        };
        let drives = self.drives.names_at(system, state);
        if drives.is_empty() {
            return Error::Contradiction {
                time,
                joint,
                misfit,
                unit,
            };
        }
        let what = format!("{joint:?} opens by {:.3e} {unit}", misfit.abs());
        Error::DrivesContradict { time, drives, what }
    }

    /// Tells what is beyond its limit for the first time.
    ///
    /// # Errors
    /// [`Error::DrivesContradict`] if a deflection or a turn is beyond its limit where drives contradict each other.
    pub fn check(
        &mut self,
        system: &System,
        state: &State,
        mut tell: impl FnMut(String),
    ) -> Result<(), Error> {
        let mut strained = None;
        for (index, body) in system.bodies.iter().enumerate() {
            if body.coordinates.is_empty() {
                continue;
            }
            let told = &mut self.told[index];
            let name = &body.name;
            let y = &state.coordinates[body.coordinates.clone()];
            let (mut deflection, mut turn) = (0.0_f64, 0.0_f64);
            for marker in &body.markers {
                let (u, theta) = system.markers[*marker].displacement(y);
                deflection = deflection.max(u.norm());
                turn = turn.max(theta.norm());
            }
            // Interface forces among the coordinates are no deflection.
            let displacements = &y[..body.flexible.displacement_count()];
            let mean =
                displacements.iter().map(|y| y * y).sum::<f64>() / body.flexible.inertia.mass();
            let share = deflection.max(mean.sqrt()) / body.length;
            let is_new = (share > DEFLECTION && !told[0]) || (turn > TURN && !told[1]);
            let mut once = |which: usize, beyond: bool, what: &str, message: String| {
                if beyond && !told[which] {
                    told[which] = true;
                    tell(format!("{what}{message}"));
                }
            };
            let deflects = format!("body {name:?} deflects by {share:.2} of its size");
            let turns =
                format!("an interface of body {name:?} turns by {turn:.2} rad against the body");
            let [to_deflection, to_turn] = [format!("{DEFLECTION}"), format!("{TURN} rad")]
                .map(|limit| format!("; the theory is linear, good to about {limit}"));
            once(0, share > DEFLECTION, &deflects, to_deflection);
            once(1, turn > TURN, &turns, to_turn);
            if is_new && strained.is_none() {
                strained = Some(match share > DEFLECTION {
                    true => format!("{deflects} (good to about {DEFLECTION})"),
                    false => format!("{turns} (good to about {TURN} rad)"),
                });
            }
            // With geometric stiffening frequencies rise with the spin as they do.
            if body.flexible.inertia.is_stiffened() {
                continue;
            }
            let spin = state.body_rates(system, index).0.angular;
            let ratio = self.extents[index].spin_across(&spin) / self.first_frequencies[index];
            once(
                2,
                ratio > SPIN && ratio < 1.0,
                "",
                format!(
                    "body {name:?} spins at {ratio:.2} of its first frequency: without geometric stiffening the first frequency of a \
                     slender part that spins across its length is too low by about {:.0} %",
                    100.0 * rod_frequency_deficit(ratio)
                ),
            );
            once(
                3,
                ratio >= 1.0,
                "",
                format!(
                    "body {name:?} spins at {ratio:.2} of its first frequency: the linear floating frame is not valid there"
                ),
            );
        }
        let Some(what) = strained else { return Ok(()) };
        match self.drives.names_at(system, state) {
            drives if drives.is_empty() => Ok(()),
            drives => Err(Error::DrivesContradict {
                time: state.time,
                drives,
                what,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bar of length 1 and square section of width 0.1, its long axis along x, mass 1.
    fn bar() -> Extent {
        let across = (1.0 + 0.01) / 12.0;
        Extent::of(&Matrix3::from_diagonal(&Vector3::new(
            2.0 * 0.01 / 12.0,
            across,
            across,
        )))
    }

    #[test]
    fn a_shaft_that_spins_about_its_own_axis_is_not_pulled() {
        let spin = Vector3::new(50.0, 0.0, 0.0);
        assert!(bar().spin_across(&spin) < 1e-12);
        // With a disc on it: as the public rotor, whose mass reaches along the axis more than twice as far.
        let rotor = Extent::of(&Matrix3::from_diagonal(&Vector3::new(1.031, 1.678, 1.678)));
        assert!(rotor.spin_across(&spin) < 1e-12);
    }

    #[test]
    fn a_bar_that_spins_across_its_length_is_pulled_by_all_of_it() {
        assert!((bar().spin_across(&Vector3::new(0.0, 0.0, 50.0)) - 50.0).abs() < 1e-12);
        let oblique = bar().spin_across(&Vector3::new(40.0, 0.0, 30.0));
        assert!((oblique - 30.0).abs() < 1e-12, "{oblique}");
    }

    #[test]
    fn a_disc_and_a_planar_body_are_pulled_by_every_spin() {
        let disc = Extent::of(&Matrix3::from_diagonal(&Vector3::new(0.25, 0.25, 0.5)));
        let planar = Extent::of(&Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, 0.3)));
        let about_z = Vector3::new(0.0, 0.0, 7.0);
        for extent in [&disc, &planar] {
            assert!((extent.spin_across(&about_z) - 7.0).abs() < 1e-12);
        }
        assert!((disc.spin_across(&Vector3::new(7.0, 0.0, 0.0)) - 7.0).abs() < 1e-12);
    }
}
