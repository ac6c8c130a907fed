//! The marker of an interface.

use super::Turning;
use crate::body::{Attachment, FlexibleBody};
use crate::system::marker::{Elasticity, Marker};

/// The frame of an interface; its axes follow the interface's rotation rows where it has them and `turning` says so.
pub(crate) fn marker_of(
    body: usize,
    flexible: &FlexibleBody,
    interface: usize,
    attachment: &Attachment,
    turning: Turning,
) -> Marker {
    let n = attachment.coordinate_count();
    let rotates = turning == Turning::Interface && attachment.rotations.contains(&true);
    let mut shapes = Vec::with_capacity(6 * n);
    for axis in 0..3 {
        shapes.extend_from_slice(attachment.translation_shape(axis));
    }
    for axis in 0..3 {
        if rotates {
            shapes.extend_from_slice(attachment.rotation_shape(axis));
        } else {
            shapes.extend(std::iter::repeat_n(0.0, n));
        }
    }
    let deflects = n > 0 || flexible.residual_flexibility.is_some();
    let elasticity = match (deflects, rotates) {
        (false, _) => Elasticity::Rigid,
        (true, false) => Elasticity::Place,
        (true, true) => Elasticity::PlaceAndAxes,
    };
    let mut rows = [None; 6];
    for (index, row) in flexible.rows.iter().enumerate() {
        let slot = usize::try_from(row.direction).ok().filter(|slot| *slot < 6);
        if let Some(slot) = slot.filter(|slot| row.interface == interface && (rotates || *slot < 3))
        {
            rows[slot] = Some(index);
        }
    }
    Marker {
        body: Some(body),
        interface: Some(interface),
        position: attachment.position,
        axes: attachment.axes,
        shapes,
        elasticity,
        stiffening: attachment
            .stiffening()
            .iter()
            .filter(|(slot, _)| rotates || *slot < 3)
            .cloned()
            .collect(),
        rows,
    }
}
