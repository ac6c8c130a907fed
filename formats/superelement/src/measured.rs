//! A superelement beside modes that were measured on the free part: which modes are the same, and a superelement that takes over what was measured.
//!
//! ```text
//! MAC = |φ_mᵀ φ_c|² / (φ_mᵀ φ_m  φ_cᵀ φ_c)
//! ```
//! at the places of the measurement, rotations times the part's radius of gyration, so that all entries are lengths (Allemang and Brown 1982). A pair is the largest
//! MAC that is left, and so on; without shapes it is the nearest frequency.

use dcb_formats::measured::{MeasuredModes, MeasuredPlace};
use dcb_formats::superelement::{RecoveryBasis, Superelement};
use faer::Mat;

use crate::Error;

/// Shapes that agree less aren't the same mode.
pub const SAME_SHAPE: f64 = 0.5;
/// Without shapes, frequencies that differ by more, as a part of the computed one, aren't paired.
pub const SAME_FREQUENCY: f64 = 0.25;

/// Measured modes beside those of a superelement.
#[derive(Clone, Debug, PartialEq)]
pub struct Correlation {
    /// MAC, (measured modes, kept modes); `None` without shapes.
    pub mac: Option<Mat<f64>>,
    /// For each measured mode the kept one that it is, from 0, if it is one.
    pub pairs: Vec<Option<usize>>,
}

/// What a superelement takes over from a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measured {
    /// Modal damping.
    Damping,
    /// Modal frequencies.
    Frequencies,
}

impl Correlation {
    /// Finds the pairs. Places at nodes need the nodal fields.
    ///
    /// # Errors
    /// [`Error::Selection`] for a place that the superelement doesn't have.
    pub fn of(
        element: &Superelement,
        fields: Option<&RecoveryBasis>,
        measured: &MeasuredModes,
    ) -> Result<Self, Error> {
        if measured.places.is_empty() {
            return Ok(Self {
                mac: None,
                pairs: by_frequency(element, measured),
            });
        }
        let length = element.inertia.radius_of_gyration();
        let mut computed = Mat::zeros(measured.places.len(), element.mode_count());
        let mut unit = Vec::with_capacity(measured.places.len());
        for (i, place) in measured.places.iter().enumerate() {
            let scale = if place.direction.is_rotation() {
                length
            } else {
                1.0
            };
            unit.push(scale);
            let row = row(element, fields, place)?;
            for (k, entry) in row.into_iter().enumerate() {
                computed[(i, k)] = scale * entry;
            }
        }
        let shapes = Mat::from_fn(measured.places.len(), measured.modes.len(), |i, m| {
            unit[i] * measured.modes[m].shape[i]
        });
        let mac = mac(&shapes, &computed);
        Ok(Self {
            pairs: by_shape(&mac),
            mac: Some(mac),
        })
    }

    /// The superelement with measured damping or frequencies in place of its own, for the modes that were paired. Power moments, and with them the bounds
    /// of errors, are those of the computed modes: they go with the frequencies.
    ///
    /// # Errors
    /// [`Error::Selection`] if frequencies would change the order of modes, or if no mode has what is to be taken over.
    pub fn applied(
        &self,
        element: &Superelement,
        measured: &MeasuredModes,
        what: &[Measured],
    ) -> Result<Superelement, Error> {
        let refused = |message: String| Error::Selection {
            body: element.name.clone(),
            message,
        };
        let mut updated = element.clone();
        let pairs = || {
            let all = self.pairs.iter().zip(&measured.modes);
            all.filter_map(|(pair, mode)| Some(((*pair)?, mode)))
        };
        if what.contains(&Measured::Damping) {
            let mut count = 0;
            for (kept, mode) in pairs() {
                if let Some(damping) = mode.damping {
                    updated.modes.damping[kept] = damping;
                    count += 1;
                }
            }
            if count == 0 {
                return Err(refused(
                    "no mode that was paired has a measured damping".to_owned(),
                ));
            }
        }
        if what.contains(&Measured::Frequencies) {
            if pairs().next().is_none() {
                return Err(refused(
                    "no measured mode is one of the superelement's".to_owned(),
                ));
            }
            for (kept, mode) in pairs() {
                let square = (std::f64::consts::TAU * mode.frequency).powi(2);
                let before = updated.modes.eigenvalues[kept];
                if before <= 0.0 {
                    return Err(refused(format!(
                        "mode {} is a motion without stiffness, which no frequency is measured of",
                        kept + 1
                    )));
                }
                add_share(&mut updated, kept, square.powi(-2) - before.powi(-2));
                updated.modes.eigenvalues[kept] = square;
                if let Some(enrichment) = &mut updated.enrichment {
                    enrichment.reduced_stiffness[(kept, kept)] = square;
                }
            }
            let squares = &updated.modes.eigenvalues;
            if let Some(k) = squares.windows(2).position(|pair| pair[1] < pair[0]) {
                return Err(refused(format!(
                    "measured frequencies would put mode {} below mode {}; measure the modes between them too, or take over the damping alone",
                    k + 2,
                    k + 1
                )));
            }
            updated.moments = None;
            for field in &mut updated.stresses {
                field.omitted = None;
            }
        }
        Ok(updated)
    }
}

/// Changes diag(M_res) with no mode kept by (L_b φ)² times a difference of 1/ω⁴: the scale of the residual filter has the modes' share.
fn add_share(element: &mut Superelement, mode: usize, change: f64) {
    let shapes = &element.modes.interface_shapes;
    for (row, felt) in element.residual.mass_diagonal0.iter_mut().enumerate() {
        if *felt > 0.0 {
            *felt += shapes[(row, mode)].powi(2) * change;
        }
    }
}

fn mac(measured: &Mat<f64>, computed: &Mat<f64>) -> Mat<f64> {
    let products = measured.transpose() * computed;
    let norm = |of: &Mat<f64>, k: usize| of.col(k).squared_norm_l2();
    Mat::from_fn(measured.ncols(), computed.ncols(), |m, c| {
        let whole = norm(measured, m) * norm(computed, c);
        match whole > 0.0 {
            true => products[(m, c)].powi(2) / whole,
            false => 0.0,
        }
    })
}

/// Takes the largest MAC, then the largest of what is left.
fn by_shape(mac: &Mat<f64>) -> Vec<Option<usize>> {
    taken(mac.nrows(), mac.ncols(), |m, c| {
        (mac[(m, c)] >= SAME_SHAPE).then_some(mac[(m, c)])
    })
}

fn by_frequency(element: &Superelement, measured: &MeasuredModes) -> Vec<Option<usize>> {
    let squares = &element.modes.eigenvalues;
    taken(measured.modes.len(), squares.len(), |m, c| {
        let computed = squares[c].max(0.0).sqrt() / std::f64::consts::TAU;
        let off = (measured.modes[m].frequency / computed - 1.0).abs();
        (off <= SAME_FREQUENCY).then_some(-off)
    })
}

/// Pairs by the best merit, each row and column once; no merit, no pair.
fn taken(
    rows: usize,
    columns: usize,
    merit: impl Fn(usize, usize) -> Option<f64>,
) -> Vec<Option<usize>> {
    let places = (0..rows).flat_map(|m| (0..columns).map(move |c| (m, c)));
    let mut all: Vec<(usize, usize, f64)> = places
        .filter_map(|(m, c)| Some((m, c, merit(m, c)?)))
        .collect();
    all.sort_by(|a, b| b.2.total_cmp(&a.2));
    let mut pairs = vec![None; rows];
    let mut is_used = vec![false; columns];
    for (m, c, _) in all {
        if pairs[m].is_none() && !is_used[c] {
            pairs[m] = Some(c);
            is_used[c] = true;
        }
    }
    pairs
}

/// Motion of a place in each kept mode.
fn row(
    element: &Superelement,
    fields: Option<&RecoveryBasis>,
    place: &MeasuredPlace,
) -> Result<Vec<f64>, Error> {
    let refused = |message: String| {
        Err(Error::Selection {
            body: element.name.clone(),
            message,
        })
    };
    let modes = 0..element.mode_count();
    let index = place.direction.index() as i64;
    let of_interface = element.interfaces.iter().position(|of| of.name == place.at);
    if let Some(interface) = of_interface {
        let mut rows = element.rows.iter().enumerate();
        return match rows.find(|(_, row)| row.interface == interface && row.direction == index) {
            Some((row, _)) => Ok(modes
                .map(|k| element.modes.interface_shapes[(row, k)])
                .collect()),
            None => refused(format!(
                "interface {:?} has no row {}",
                place.at,
                place.direction.name()
            )),
        };
    }
    let Ok(node) = place.at.parse::<u32>() else {
        let names: Vec<&str> = element
            .interfaces
            .iter()
            .map(|of| of.name.as_str())
            .collect();
        return refused(format!(
            "{:?} is neither a node's number nor an interface{} (interfaces: {})",
            place.at,
            dcb_formats::description::suggestion(&place.at, names.iter().copied()),
            dcb_formats::description::listed(names)
        ));
    };
    let Some(fields) = fields else {
        return refused(format!(
            "{} is at a node, but the file has no nodal fields; reduce the part with them, or name interfaces",
            place.name()
        ));
    };
    let mut dofs = fields.dofs.iter().enumerate();
    match dofs.find(|(_, dof)| dof.node == node && dof.direction == place.direction) {
        Some((row, _)) => Ok(modes.map(|k| fields.modes[(row, k)]).collect()),
        None => refused(format!(
            "node {node} has no field {}",
            place.direction.name()
        )),
    }
}
