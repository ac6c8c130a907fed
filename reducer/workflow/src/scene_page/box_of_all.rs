//! How large a mechanism is in its motion.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// The box around places in the world.
pub struct BoxOfAll {
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Default for BoxOfAll {
    fn default() -> Self {
        Self {
            low: Vector3::repeat(f64::MAX),
            high: Vector3::repeat(f64::MIN),
        }
    }
}

impl BoxOfAll {
    /// Includes places of a body that is there.
    pub fn include(&mut self, frame: &[f64; 7], places: &[Vector3<f64>]) {
        let [x, y, z, w, i, j, k] = *frame;
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        for place in places {
            let at = Vector3::new(x, y, z) + turn * place;
            self.low = self.low.inf(&at);
            self.high = self.high.sup(&at);
        }
    }

    /// Its diagonal; 1 where there is none.
    pub fn diagonal(&self) -> f64 {
        let diagonal = (self.high - self.low).norm();
        if diagonal.is_finite() && diagonal > 0.0 {
            diagonal
        } else {
            1.0
        }
    }
}
