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
        let flexibility = rows.scaled_square(element.residual.flexibility.as_ref());
        let mut poles = vec![0.0; rows.rigid.ncols()];
        poles.extend(&element.modes.eigenvalues);
        let kept = beside(rows.rigid.as_ref(), modes.as_ref());
        let part = |response: Receptance, unknowns: usize, dofs: usize, held| Self {
            response,
            unknowns,
            dofs,
            held,
            first_attachment: None,
        };
        let mode_count = element.mode_count();
        let response = |poles: &[f64], shapes: &Mat<f64>, series: Vec<Mat<f64>>| {
            Receptance::symmetric(poles.to_vec(), shapes.clone(), series, unit)
        };
        Some(match variant {
            Variant::Free => {
                let held = ReducedCoordinates::dynamic(&poles, &kept).held(loose)?;
                part(
                    response(&poles, &kept, Vec::new()),
                    mode_count,
                    rank(&kept),
                    Some(held),
                )
            }
            Variant::Strong => {
                let coordinates = ResidualCoordinates::of(element).ok()?;
                let (squares, shapes) = (&coordinates.stiffness, coordinates.seen(element));
                let poles = [poles.as_slice(), squares].concat();
                let shapes = beside(kept.as_ref(), rows.scaled(shapes.as_ref()).as_ref());
                let held = ReducedCoordinates::dynamic(&poles, &shapes).held(loose)?;
                Self {
                    first_attachment: squares.first().copied(),
                    ..part(
                        response(&poles, &shapes, Vec::new()),
                        mode_count + squares.len(),
                        rank(&shapes),
                        Some(held),
                    )
                }
            }
            Variant::Static => {
                // In the size of the other columns.
                let directions = faer::Scale(unit.sqrt()) * Directions::of(&flexibility)?.root;
                let coordinates = ReducedCoordinates {
                    massless: directions.ncols(),
                    stiffness: [poles.clone(), vec![unit; directions.ncols()]].concat(),
                    shapes: beside(kept.as_ref(), directions.as_ref()),
                };
                let held = coordinates.held(loose)?;
                part(
                    response(&poles, &kept, vec![flexibility]),
                    mode_count,
                    rank(&coordinates.shapes),
                    Some(held),
                )
            }
            Variant::Weak => {
                let directions = Directions::of(&flexibility)?;
                let soft = directions.root.ncols();
                let forces = rows.unscaled_forces(element.residual.transform.as_ref());
                let sigma = &element.residual.sigma_squared;
                let held = match soft > sigma.len() {
                    true => None,
                    false => {
                        let rigid = &directions.rigid;
                        let all = dual_eigenvalues(&poles, &kept, sigma, &forces, rigid, loose);
                        Some(all?)
                    }
                };
                let mass = rows.scaled_square(element.residual.mass.as_ref());
                let series = vec![flexibility, faer::Scale(unit) * &mass];
                part(
                    response(&poles, &kept, series),
                    mode_count + rows.len(),
                    rank(&beside(kept.as_ref(), directions.root.as_ref())),
                    held,
                )
            }
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
