//! The sides of rows on a body.

use crate::kinematics::frame_motion::Six;
use crate::system::System;
use crate::system::evaluation::Evaluation;

/// The side of a term on a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    pub(super) row: usize,
    pub(super) term: usize,
    pub(super) side: Side,
    /// Marker, counted among the body's own.
    pub(super) local: usize,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Side {
    A,
    B,
}

impl Touch {
    pub(super) fn marker(&self, system: &System) -> usize {
        match self.side {
            Side::A => system.terms[self.term].a,
            Side::B => system.terms[self.term].b,
        }
    }
}

/// Where the entries of one body are in the joints' system, in the order of [`super::Condensed::factor_joints`].
pub(super) fn body_pairs(own: &[Touch], motion: Option<usize>) -> Vec<(usize, usize)> {
    let Some(first) = motion else {
        let column = |column: &Touch| {
            let column = column.row;
            own.iter().map(move |row| (row.row, column))
        };
        return own.iter().flat_map(column).collect();
    };
    let motions = first..first + 6;
    let mut pairs = Vec::with_capacity(12 * own.len() + 36);
    for touch in own {
        for motion in motions.clone() {
            pairs.extend([(touch.row, motion), (motion, touch.row)]);
        }
    }
    for column in motions.clone() {
        pairs.extend(motions.clone().map(|row| (row, column)));
    }
    pairs
}

/// The gradient of a touch, world axes.
pub(super) fn side<'a>(evaluation: &'a Evaluation, touch: &Touch) -> &'a Six {
    match touch.side {
        Side::A => &evaluation.gradients[touch.term].a,
        Side::B => &evaluation.gradients[touch.term].b,
    }
}
