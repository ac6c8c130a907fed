//! The space of wrenches that act on one interface.

use dcb_formats::scene::ExertedDirections;
use nalgebra::Vector3;

/// A direction depends on others if what they leave of it is below this fraction of its length: the rounding of seven written digits.
const DEPENDENT: f64 = 1e-6;

/// Directions at a place, in its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Span {
    /// None.
    Nothing,
    /// One; of any length.
    Along(Vector3<f64>),
    /// Those perpendicular to one.
    Across(Vector3<f64>),
    /// All.
    Everything,
}

impl Span {
    /// Directions by the axis of a joint; all where an axis is needed and isn't known.
    pub(super) fn of(directions: ExertedDirections, axis: Option<Vector3<f64>>) -> Self {
        match (directions, axis) {
            (ExertedDirections::None, _) => Self::Nothing,
            (ExertedDirections::Along, Some(axis)) => Self::Along(axis),
            (ExertedDirections::Across, Some(axis)) => Self::Across(axis),
            (ExertedDirections::All, _) | (_, None) => Self::Everything,
        }
    }

    /// Vectors that span it.
    pub(super) fn vectors(&self) -> Vec<Vector3<f64>> {
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        match self {
            Self::Nothing => Vec::new(),
            Self::Along(direction) => vec![*direction],
            Self::Across(direction) => {
                let unit = direction.normalize();
                axes.map(|axis| axis - unit * unit.dot(&axis)).into()
            }
            Self::Everything => axes.into(),
        }
    }
}

/// Forces and moments of one interface, each with its own basis: none of it mixes the two.
#[derive(Clone, Debug)]
pub(super) struct WrenchSpace {
    /// Which of the six components reach the interface's rows.
    reached: [bool; 6],
    /// Orthonormal forces, orthonormal moments.
    bases: [Vec<Vector3<f64>>; 2],
}

/// Forces or moments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Half {
    Force = 0,
    Moment = 1,
}

impl WrenchSpace {
    /// No wrench, where only these components reach the interface.
    pub(super) fn reaching(reached: [bool; 6]) -> Self {
        Self {
            reached,
            bases: [Vec::new(), Vec::new()],
        }
    }

    /// Adds a direction, component axes.
    pub(super) fn add(&mut self, half: Half, direction: &Vector3<f64>) {
        let first = 3 * half as usize;
        let size = direction.norm();
        let own = Vector3::from_fn(|axis, _| match self.reached[first + axis] {
            true => direction[axis] / size,
            false => 0.0,
        });
        let basis = &mut self.bases[half as usize];
        let mut left = own;
        // Twice, so that what is left is perpendicular to rounding.
        for _ in 0..2 {
            for known in basis.iter() {
                left -= known * known.dot(&left);
            }
        }
        if left.norm() > DEPENDENT {
            basis.push(left.normalize());
        }
    }

    /// Orthonormal, force and moment, component axes: forces first. Coordinate axes where they span it.
    pub(super) fn basis(&self) -> Vec<[f64; 6]> {
        let mut all = Vec::new();
        for half in [Half::Force, Half::Moment] {
            let first = 3 * half as usize;
            let basis = &self.bases[half as usize];
            let reached: Vec<usize> = (0..3).filter(|axis| self.reached[first + axis]).collect();
            let vectors: Vec<Vector3<f64>> = match basis.len() == reached.len() {
                true => reached
                    .iter()
                    .map(|axis| Vector3::ith(*axis, 1.0))
                    .collect(),
                false => basis.clone(),
            };
            all.extend(vectors.iter().map(|vector| {
                let mut six = [0.0; 6];
                six[first..first + 3].copy_from_slice(vector.as_slice());
                six
            }));
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_that_others_make_up_add_nothing() {
        let mut space = WrenchSpace::reaching([true; 6]);
        for vector in Span::Across(Vector3::new(1.0, 2.0, 2.0)).vectors() {
            space.add(Half::Force, &vector);
        }
        assert_eq!(space.basis().len(), 2);
        space.add(Half::Force, &Vector3::new(2.0, -1.0, 0.0));
        assert_eq!(space.basis().len(), 2);
        space.add(Half::Force, &Vector3::x());
        let expected = [0, 1, 2].map(|axis| {
            let mut six = [0.0; 6];
            six[axis] = 1.0;
            six
        });
        assert_eq!(space.basis(), expected);
    }

    #[test]
    fn components_that_reach_no_row_are_left_out() {
        let mut space = WrenchSpace::reaching([true, true, false, false, false, false]);
        space.add(Half::Force, &Vector3::new(3.0, 0.0, 4.0));
        space.add(Half::Moment, &Vector3::z());
        assert_eq!(space.basis(), [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]]);
    }
}
