//! Linear isotropic materials.

/// Linear isotropic elastic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Density, kg/m³.
    pub density: f64,
}

impl Material {
    /// Steel: 210 GPa, 0.3, 7850 kg/m³.
    pub const STEEL: Self = Self {
        youngs_modulus: 2.1e11,
        poisson_ratio: 0.3,
        density: 7850.0,
    };

    /// Soft and light: 2 GPa, 0.3, 1000 kg/m³; the material of the spatial reference boxes.
    pub const SOFT: Self = Self {
        youngs_modulus: 2.0e9,
        poisson_ratio: 0.3,
        density: 1000.0,
    };

    /// Lamé's constants `(lambda, mu)`, Pa.
    pub fn lame(&self) -> (f64, f64) {
        let Self {
            youngs_modulus: e,
            poisson_ratio: nu,
            ..
        } = *self;
        (
            e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
            e / (2.0 * (1.0 + nu)),
        )
    }
}
