//! Which coordinates move in a plane and which out of it.
//!
//! Mirrored at the plane a coordinate of a symmetric component becomes itself (in the plane) or its negative (out of it). Rows tell it by their direction, modes and
//! further columns by what they do at the rows and to the inertia. Modes of one multiple root come in any combination: they are turned apart first.

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::component::Role;
use dcb_formats::superelement::Superelement;
use faer::Mat;

use super::Normal;
use crate::Error;
use crate::selection::statics::Statics;

/// Eigenvalues closer than this, relatively, are one multiple root: the reducer's rule for its choice of vectors.
const MULTIPLE: f64 = 1e-9;
/// Smallest effect of a coordinate on rows and on the inertia, relative to the largest possible, that tells its parity.
const SILENT: f64 = 1e-8;

/// In the plane or out of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parity {
    In,
    Out,
}

/// Sizes with which couplings become cosines.
pub(super) struct Norms {
    /// √ of the static flexibility of each row, zero where no force acts, (n_b).
    pub rows: Vec<f64>,
    /// √ of the mass of each coordinate with no mode kept, (n).
    pub mass: Vec<f64>,
    /// √ of its stiffness, (n).
    pub energy: Vec<f64>,
}

impl Norms {
    pub fn of(whole: &Superelement) -> Self {
        let statics = Statics::with_all_modes(whole);
        let root = |value: f64| value.max(0.0).sqrt();
        let of_acting = |row: usize, value: f64| match statics.acting[row] {
            true => root(value),
            false => 0.0,
        };
        let rows: Vec<f64> = (0..whole.rows.len())
            .map(|row| of_acting(row, statics.flexibility0[(row, row)]))
            .collect();
        let mut mass = vec![1.0; whole.mode_count()];
        let masses = whole.residual.mass_diagonal0.iter().enumerate();
        mass.extend(masses.map(|(row, mass)| of_acting(row, *mass)));
        let eigenvalues = &whole.modes.eigenvalues;
        let lowest = eigenvalues.iter().copied().find(|value| *value > 0.0);
        let lowest = lowest.unwrap_or(0.0);
        let mut energy: Vec<f64> = (eigenvalues.iter())
            .map(|value| root(value.max(lowest)))
            .collect();
        energy.extend(&rows);
        if let Some(enrichment) = &whole.enrichment {
            for k in mass.len()..whole.basis_count() {
                mass.push(root(enrichment.reduced_mass[(k, k)]));
                energy.push(root(enrichment.reduced_stiffness[(k, k)]));
            }
        }
        Self { rows, mass, energy }
    }
}

/// a / (b c), nothing where one of these is.
pub(super) fn cosine(a: f64, b: f64, c: f64) -> f64 {
    if b > 0.0 && c > 0.0 { a / (b * c) } else { 0.0 }
}

/// Parities of all coordinates.
pub(super) struct Parities {
    pub rows: Vec<Parity>,
    pub modes: Vec<Parity>,
    pub further: Vec<Parity>,
}

impl Parities {
    /// # Errors
    /// [`Error::Selection`] for an attachment with explicit rows, which say nothing of their direction.
    pub fn of(whole: &Superelement, normal: Normal, norms: &Norms) -> Result<Self, Error> {
        let rows = row_parities(whole, normal)?;
        let (n_k, n_b) = (whole.mode_count(), rows.len());
        let features = Features {
            whole,
            normal,
            norms,
            rows: &rows,
        };
        let modes: Vec<Option<Parity>> = (0..n_k).map(|k| features.parity(k)).collect();
        let further: Vec<Option<Parity>> = (n_k + n_b..whole.basis_count())
            .map(|k| features.parity(k))
            .collect();
        let mut known = modes.clone();
        known.extend(rows.iter().map(|parity| Some(*parity)));
        known.extend(&further);
        let decided = |(k, parity): (usize, Option<Parity>)| {
            parity.unwrap_or_else(|| features.by_company(k, &known))
        };
        Ok(Self {
            modes: modes.into_iter().enumerate().map(decided).collect(),
            further: (further.into_iter().enumerate())
                .map(|(j, parity)| decided((n_k + n_b + j, parity)))
                .collect(),
            rows,
        })
    }

    /// Of every coordinate in the basis's order.
    pub fn of_basis(&self) -> Vec<Parity> {
        [self.modes.as_slice(), &self.rows, &self.further].concat()
    }
}

/// Combinations within multiple roots that lie in the plane or out of it, (n_k, n_k); `None` where there are no multiple roots.
///
/// # Errors
/// [`Error::Selection`] for an attachment with explicit rows; [`Error::NoEigenvalues`] if the shapes aren't finite.
pub(super) fn turn(
    whole: &Superelement,
    normal: Normal,
    norms: &Norms,
) -> Result<Option<Mat<f64>>, Error> {
    let rows = row_parities(whole, normal)?;
    let features = Features {
        whole,
        normal,
        norms,
        rows: &rows,
    };
    let modes = &whole.modes;
    let count = modes.eigenvalues.len();
    let mut turn = Mat::<f64>::identity(count, count);
    let (mut first, mut is_turned) = (0, false);
    while first < count {
        let root = modes.eigenvalues[first];
        let is_same = |k: &usize| {
            modes.eigenvalues[*k] - root <= MULTIPLE * root
                && modes.damping[*k] == modes.damping[first]
        };
        let size = (first..count).take_while(is_same).count();
        if size > 1 {
            let balance = features.balance(first..first + size);
            let (_, vectors) = symmetric_eigen(balance.as_ref()).ok_or(Error::NoEigenvalues)?;
            turn.as_mut()
                .submatrix_mut(first, first, size, size)
                .copy_from(&vectors);
            is_turned = true;
        }
        first += size;
    }
    Ok(is_turned.then_some(turn))
}

fn row_parities(whole: &Superelement, normal: Normal) -> Result<Vec<Parity>, Error> {
    let parity = |row: usize| {
        let of = &whole.rows[row];
        let interface = &whole.interfaces[of.interface];
        match usize::try_from(of.direction) {
            Ok(direction) => Ok(match normal.planar_direction(direction) {
                Some(_) => Parity::In,
                None => Parity::Out,
            }),
            Err(_) if interface.role == Role::Output => Ok(Parity::Out),
            Err(_) => Err(Error::Selection {
                body: whole.name.clone(),
                message: format!(
                    "the explicit rows of interface {:?} don't say whether they lie in a plane; drop it, or make it `average` or `rigid`",
                    interface.name
                ),
            }),
        }
    };
    (0..whole.rows.len()).map(parity).collect()
}

/// Parities that coordinates show.
struct Features<'a> {
    whole: &'a Superelement,
    normal: Normal,
    norms: &'a Norms,
    rows: &'a [Parity],
}

impl Features<'_> {
    /// By rows and first-order change of inertia; `None` if it shows too little.
    fn parity(&self, coordinate: usize) -> Option<Parity> {
        let (mut inside, mut outside) = (0.0_f64, 0.0_f64);
        for (parity, feature) in self.features(coordinate) {
            match parity {
                Parity::In => inside += feature * feature,
                Parity::Out => outside += feature * feature,
            }
        }
        match inside.max(outside) > SILENT * SILENT {
            true if inside >= outside => Some(Parity::In),
            true => Some(Parity::Out),
            false => None,
        }
    }

    /// Σ f fᵀ over features in the plane less those out of it, over some modes.
    fn balance(&self, modes: std::ops::Range<usize>) -> Mat<f64> {
        let features: Vec<Vec<(Parity, f64)>> = modes.map(|mode| self.features(mode)).collect();
        let product = |i: usize, j: usize| {
            let pairs = features[i].iter().zip(&features[j]);
            pairs
                .map(|((parity, a), (_, b))| match parity {
                    Parity::In => a * b,
                    Parity::Out => -a * b,
                })
                .sum()
        };
        symmetrized(Mat::from_fn(features.len(), features.len(), product).as_ref())
    }

    fn features(&self, coordinate: usize) -> Vec<(Parity, f64)> {
        let Self {
            whole,
            normal,
            norms,
            rows,
        } = self;
        let (n_k, n_b) = (whole.mode_count(), whole.rows.len());
        let shape = |row: usize| match (&whole.enrichment, coordinate < n_k) {
            (_, true) => whole.modes.interface_shapes[(row, coordinate)],
            (Some(enrichment), false) => enrichment.interface_shapes[(row, coordinate - n_k - n_b)],
            (None, false) => 0.0,
        };
        let mut features: Vec<(Parity, f64)> = (rows.iter().enumerate())
            .map(|(row, parity)| {
                (
                    *parity,
                    cosine(shape(row), norms.rows[row], norms.energy[coordinate]),
                )
            })
            .collect();
        let inertia = &whole.inertia;
        let trace: f64 = (0..3).map(|a| inertia.tensor[a][a]).sum();
        let [a, b, c] = normal.axes();
        for (i, j) in [(a, a), (b, b), (c, c), (a, b), (b, c), (c, a)] {
            let parity = match (i == c) == (j == c) {
                true => Parity::In,
                false => Parity::Out,
            };
            let entry = inertia.i1[coordinate][i][j];
            features.push((parity, cosine(entry, norms.mass[coordinate], trace.sqrt())));
        }
        features
    }

    /// By how it couples with those that are known.
    fn by_company(&self, coordinate: usize, known: &[Option<Parity>]) -> Parity {
        let [.., c] = self.normal.axes();
        let inertia = &self.whole.inertia;
        let (mut inside, mut outside) = (0.0, 0.0);
        for (other, parity) in known.iter().enumerate() {
            let Some(parity) = parity else { continue };
            let of = |matrix: &Mat<f64>| {
                let masses = &self.norms.mass;
                cosine(
                    matrix[(coordinate, other)],
                    masses[coordinate],
                    masses[other],
                )
                .powi(2)
            };
            let alike = of(&inertia.l3[c]) + of(&inertia.i2[c]);
            let unlike: f64 = (0..3)
                .filter(|axis| *axis != c)
                .map(|axis| of(&inertia.l3[axis]))
                .sum();
            let (to_in, to_out) = match parity {
                Parity::In => (alike, unlike),
                Parity::Out => (unlike, alike),
            };
            inside += to_in;
            outside += to_out;
        }
        match inside > outside {
            true => Parity::In,
            false => Parity::Out,
        }
    }
}
