//! Finite rotations, and the motion of a frame that is fixed in a body.

pub mod frame_motion;
pub mod rotation_vector;
