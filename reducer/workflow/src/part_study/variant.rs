//! The forms in which a superelement can be used, each with the receptance and the held frequencies that it has.

use clap::ValueEnum;
use dcb_dense::symmetric_eigen;
use dcb_formats::Superelement;
use dcb_superelement::ResidualCoordinates;
use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use super::rows::InterfaceRows;
use dcb_superelement::MASS_TOLERANCE;
use dcb_superelement::Receptance;
use dcb_superelement::held_frequencies::{ReducedCoordinates, dual_eigenvalues, rank};

/// How modes and attachments are coupled to what the interfaces are joined to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// Attachments and further columns are dynamic coordinates (Rubin): the default of simulations.
    Strong,
    /// Attachments follow the forces without inertia (MacNeal).
    Static,
    /// Interface forces are coordinates, compatibility in the mean (dual Craig–Bampton, the paper's).
    Weak,
    /// Modes alone, no attachments.
    Free,
}

impl Variant {
    /// All, in the order of tables.
    pub const ALL: [Self; 4] = [Self::Strong, Self::Static, Self::Weak, Self::Free];

    /// Name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Strong => "strong",
            Self::Static => "static",
            Self::Weak => "weak",
            Self::Free => "free",
        }
    }
}

/// A superelement in one of its forms, between the rows of its interfaces that forces act on, scaled as the reference is.
#[derive(Clone, Debug)]
pub struct ReducedPart {
    /// Its receptance.
    pub response: Receptance,
    /// Coordinates beside the six (planar: three) of the frame.
    pub unknowns: usize,
    /// Independent motions that the rows can have at all.
    pub dofs: usize,
    /// ω² with all interfaces held, ascending, without those of motions that the interfaces leave free; `None` where the form has none
    /// (weak, with attachments that have no mass).
    pub held: Option<Vec<f64>>,
    /// The lowest ω² that attachments and further columns add to those of the modes; `None` without such coordinates.
    pub first_attachment: Option<f64>,
}

impl ReducedPart {
    /// `loose`: motions that the interfaces leave free when they are held.
    ///
    /// `None` if a dense eigenproblem fails, which only numbers that aren't finite cause.
    pub fn of(
        element: &Superelement,
        variant: Variant,
        rows: &InterfaceRows,
        unit: f64,
        loose: usize,
    ) -> Option<Self> {
        let modes = rows.scaled(element.modes.interface_shapes.as_ref());
        let mut poles = vec![0.0; rows.rigid.ncols()];
        poles.extend(&element.modes.eigenvalues);
        let kept = Kept {
            element,
            rows,
            shapes: beside(rows.rigid.as_ref(), modes.as_ref()),
            flexibility: rows.scaled_square(element.residual.flexibility.as_ref()),
            poles,
            unit,
            loose,
        };
        match variant {
            Variant::Free => kept.dynamic(&kept.poles, &kept.shapes),
            Variant::Strong => kept.strong(),
            Variant::Static => kept.statical(),
            Variant::Weak => kept.weak(),
        }
    }
}

/// Common to all forms: rigid motions and modes at the rows, and the residual flexibility.
struct Kept<'a> {
    element: &'a Superelement,
    rows: &'a InterfaceRows,
    shapes: Mat<f64>,
    poles: Vec<f64>,
    flexibility: Mat<f64>,
    unit: f64,
    loose: usize,
}

impl Kept<'_> {
    /// Poles with their shapes, and a series beside them; the motions that the rows can have are those of `seen`.
    fn part(
        &self,
        (poles, shapes): (&[f64], &Mat<f64>),
        series: Vec<Mat<f64>>,
        seen: &Mat<f64>,
        held: Option<Vec<f64>>,
    ) -> ReducedPart {
        ReducedPart {
            response: Receptance::symmetric(poles.to_vec(), shapes.clone(), series, self.unit),
            unknowns: poles.len() - self.rows.rigid.ncols(),
            dofs: rank(seen),
            held,
            first_attachment: None,
        }
    }

    fn dynamic(&self, poles: &[f64], shapes: &Mat<f64>) -> Option<ReducedPart> {
        let held = ReducedCoordinates::dynamic(poles, shapes).held(self.loose)?;
        Some(self.part((poles, shapes), Vec::new(), shapes, Some(held)))
    }

    fn strong(&self) -> Option<ReducedPart> {
        let coordinates = ResidualCoordinates::of(self.element).ok()?;
        let (squares, seen) = (&coordinates.stiffness, coordinates.seen(self.element));
        let poles = [self.poles.as_slice(), squares].concat();
        let seen = self.rows.scaled(seen.as_ref());
        let shapes = beside(self.shapes.as_ref(), seen.as_ref());
        Some(ReducedPart {
            first_attachment: squares.first().copied(),
            ..self.dynamic(&poles, &shapes)?
        })
    }

    fn statical(&self) -> Option<ReducedPart> {
        // In the size of the other columns.
        let root = Directions::of(&self.flexibility)?.root;
        let directions = faer::Scale(self.unit.sqrt()) * root;
        let coordinates = ReducedCoordinates {
            massless: directions.ncols(),
            stiffness: [self.poles.clone(), vec![self.unit; directions.ncols()]].concat(),
            shapes: beside(self.shapes.as_ref(), directions.as_ref()),
        };
        let held = coordinates.held(self.loose)?;
        let series = vec![self.flexibility.clone()];
        let kept = (self.poles.as_slice(), &self.shapes);
        Some(self.part(kept, series, &coordinates.shapes, Some(held)))
    }

    fn weak(&self) -> Option<ReducedPart> {
        let (rows, residual) = (self.rows, &self.element.residual);
        let Directions { root, rigid } = Directions::of(&self.flexibility)?;
        let forces = rows.unscaled_forces(residual.transform.as_ref());
        let (poles, shapes) = (&self.poles, &self.shapes);
        let sigma = &residual.sigma_squared;
        let held = match root.ncols() > sigma.len() {
            true => None,
            false => Some(dual_eigenvalues(
                poles, shapes, sigma, &forces, &rigid, self.loose,
            )?),
        };
        let mass = rows.scaled_square(residual.mass.as_ref());
        let series = vec![self.flexibility.clone(), faer::Scale(self.unit) * &mass];
        let seen = beside(shapes.as_ref(), root.as_ref());
        Some(ReducedPart {
            unknowns: self.element.mode_count() + rows.len(),
            ..self.part((poles, shapes), series, &seen, held)
        })
    }
}

/// Columns beside columns.
fn beside(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols() + b.ncols(), |i, j| {
        match j.checked_sub(a.ncols()) {
            None => a[(i, j)],
            Some(j) => b[(i, j)],
        }
    })
}

/// Directions of the rows, by their residual flexibility F.
struct Directions {
    /// V with V Vᵀ = F, a column for each direction that has some.
    root: Mat<f64>,
    /// Orthonormal directions that have none.
    rigid: Mat<f64>,
}

impl Directions {
    fn of(flexibility: &Mat<f64>) -> Option<Self> {
        let (values, vectors) = symmetric_eigen(flexibility.as_ref())?;
        // The scaling makes the whole flexibility's diagonal at most 1: what is rounding of that is rounding.
        let first = values
            .iter()
            .filter(|value| **value <= MASS_TOLERANCE)
            .count();
        Some(Self {
            root: Mat::from_fn(values.len(), values.len() - first, |i, j| {
                vectors[(i, first + j)] * values[first + j].sqrt()
            }),
            rigid: vectors.subcols(0, first).to_owned(),
        })
    }
}
