//! How interfaces move under interface forces, with everything and with what is selected, and how far the two are apart.
//!
//! ```text
//! H(λ) = Σ_p s_p f_p / (λ_p - λ) + F        λ = ω² / (1 + iη);  poles λ_p: rigid motions at 0, ω², σ²
//! ```
//! under strong compatibility, F what acts statically. Measures are those of a study (`docs/study.md`): rows scaled by the root of their flexibility,
//! Frobenius norms, blocks of one interface (collocated) and between two (transfer).

use crate::LOSS_FACTOR;
use dcb_formats::superelement::Superelement;
use faer::{Mat, MatRef, c64, concat};

use super::Selection;
use super::ports::ScaledPorts;
use crate::DynamicCoordinates;
use crate::{Error, Receptance};
use dcb_formats::scene::Compatibility;

/// How far a selection's receptance is from that of the whole, at each of the frequencies that were asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceptanceDifference {
    /// ‖ΔH‖ / ‖H‖ over the blocks of one interface each.
    pub collocated: Vec<f64>,
    /// The same over the blocks between two interfaces; zero where there is one only, or none sees the other.
    pub transfer: Vec<f64>,
    /// The same over all.
    pub together: Vec<f64>,
}

impl ReceptanceDifference {
    /// The largest of all frequencies: collocated, transfer, together.
    pub fn largest(&self) -> [f64; 3] {
        let of = |errors: &[f64]| errors.iter().copied().fold(0.0, f64::max);
        [of(&self.collocated), of(&self.transfer), of(&self.together)]
    }
}

impl Selection {
    /// How far the receptance of what is selected is from that of `whole`, over the forces and rows that are selected, at angular
    /// frequencies whose squares are given, with the loss factor [`LOSS_FACTOR`]. Exact within the whole's coordinates; what these leave out of the component
    /// is no part of it.
    ///
    /// # Errors
    /// Those of [`Selection::superelement`] and [`DynamicCoordinates::of`].
    pub fn receptance_difference(
        &self,
        whole: &Superelement,
        squares: &[f64],
    ) -> Result<ReceptanceDifference, Error> {
        let ports = ScaledPorts::of(whole, self)?;
        let everywhere: Vec<usize> = (0..whole.rows.len()).collect();
        let exact = receptance(whole, &ports, &everywhere)?;
        let selected = receptance(&self.superelement(whole)?, &ports, &ports.rows)?;
        let mut found = ReceptanceDifference {
            collocated: Vec::new(),
            transfer: Vec::new(),
            together: Vec::new(),
        };
        for square in squares {
            let lambda = damped(*square);
            let reference = exact.at(lambda);
            let difference = selected.at(lambda) - &reference;
            let (apart, all) = (ports.squares(&difference), ports.squares(&reference));
            found.collocated.push(ratio(apart[0], all[0]));
            found.transfer.push(ratio(apart[1], all[1]));
            found
                .together
                .push(ratio(apart[0] + apart[1], all[0] + all[1]));
        }
        Ok(found)
    }
}

/// λ at an angular frequency whose square is given.
pub(super) fn damped(square: f64) -> c64 {
    c64::new(square, 0.0) / c64::new(1.0, LOSS_FACTOR)
}

/// Root of a ratio of squares; 0 where there is nothing.
pub(super) fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { (a / b).sqrt() } else { 0.0 }
}

impl ScaledPorts {
    /// Squares of Frobenius norms: over blocks of one interface, and between two.
    fn squares(&self, h: &Mat<c64>) -> [f64; 2] {
        let mut squares = [0.0; 2];
        for (j, loaded) in self.force_interfaces.iter().enumerate() {
            for (i, seen) in self.row_interfaces.iter().enumerate() {
                squares[usize::from(seen != loaded)] += h[(i, j)].norm_sqr();
            }
        }
        squares
    }
}

/// H between forces and rows, scaled. `places` are the rows of `of` among those of the whole.
pub(super) fn receptance(
    of: &Superelement,
    ports: &ScaledPorts,
    places: &[usize],
) -> Result<Receptance, Error> {
    let coordinates = DynamicCoordinates::of(of, Compatibility::Strong)?;
    let at = |row: &usize| places.partition_point(|place| place < row);
    let rows: Vec<usize> = ports.rows.iter().map(at).collect();
    let scaled = |columns: MatRef<'_, f64>| {
        Mat::from_fn(rows.len(), columns.ncols(), |i, j| {
            ports.scale[i] * columns[(rows[i], j)]
        })
    };
    let forces = Mat::from_fn(places.len(), ports.forces.ncols(), |i, j| {
        ports.forces[(places[i], j)]
    });
    let rigid = Mat::from_fn(places.len(), ports.rigid.ncols(), |i, k| {
        ports.rigid[(places[i], k)]
    });
    let elastic = &coordinates.interface_shapes;
    let shapes = concat![[rigid, elastic]];
    let mut poles = vec![0.0; rigid.ncols()];
    poles.extend(&coordinates.stiffness);
    Ok(Receptance {
        poles,
        seen: scaled(shapes.as_ref()),
        driven: shapes.transpose() * &forces,
        series: (coordinates.residual_flexibility.iter())
            .map(|flexibility| scaled((flexibility * &forces).as_ref()))
            .collect(),
        unit: 1.0,
    })
}
