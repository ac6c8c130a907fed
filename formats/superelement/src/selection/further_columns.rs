//! Further columns with fewer modes: what the modes left out did of each response goes into its column.
//!
//! A column is X = s G_res f over the modes kept (`docs/theory.md`, section 12). With the modes Φ, Ω² left out as well
//!
//! ```text
//! spin, loads   X' = X + s Φ Ω⁻² Φᵀ f             s as before: it scales G f, which knows no modes
//! krylov        X' = s' (X / s + Φ Ω⁻⁴ Φᵀ L_bᵀ e)    f = M G_res L_bᵀ e; s' makes X' of unit M norm
//! ```
//! Φᵀ f is in the file: the first-order change of inertia is the work of centrifugal forces, loads have theirs. s follows from the norm with no mode kept,
//! 1 = XᵀMX + s² Σ (φᵀf)² / ω⁴, or from ψᵀKX = s ψᵀf for any column ψ beyond the modes. Both have to agree, or the columns aren't the
//! responses that they are named after.

use dcb_formats::further_column::Answer;
use dcb_formats::superelement::{Enrichment, Superelement};
use faer::{Mat, MatRef};

use super::statics::attached;
use crate::Error;

/// Largest difference of a column's norm and stiffness, relative to those of the response with no mode kept.
const AGREEMENT: f64 = 1e-6;
/// The reducer's rule: a response with less than this part of the strain energy of the strongest of its kind has no column.
const WEAK_RESPONSE: f64 = 1e-10;

/// Further columns that stay, and their shares of the modes left out.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FurtherColumns {
    /// Their places in the file.
    pub places: Vec<usize>,
    /// Factor of each.
    pub scale: Vec<f64>,
    /// Shares of the modes left out, (modes left out, columns that stay).
    pub absorbed: Mat<f64>,
}

impl FurtherColumns {
    /// As they are in the file.
    pub fn unchanged(places: &[usize], left_out: usize) -> Self {
        Self {
            places: places.to_vec(),
            scale: vec![1.0; places.len()],
            absorbed: Mat::zeros(left_out, places.len()),
        }
    }

    /// Those of a superelement that keeps its `modes` lowest modes.
    ///
    /// # Errors
    /// [`Error::NotHandled`] for columns that aren't those which `reduce` makes, and where fewer modes need a column that the file doesn't have.
    pub fn with_fewer_modes(superelement: &Superelement, modes: usize) -> Result<Self, Error> {
        let left_out_modes = superelement.mode_count() - modes;
        let Some(enrichment) = &superelement.enrichment else {
            return Ok(Self::unchanged(&[], left_out_modes));
        };
        let whole = Whole {
            superelement,
            enrichment,
            eigenvalues: &superelement.modes.eigenvalues,
            modes,
            attached: attached(superelement),
        };
        let refused = |what| Error::NotHandled {
            body: superelement.name.clone(),
            what,
            remedy: super::FEWER_MODES,
        };
        let unknown = || refused("it has further columns other than those of `reduce --enrich`");
        if enrichment.names.len() != enrichment.interface_shapes.ncols() {
            return Err(unknown());
        }
        let columns: Option<Vec<Column>> = (enrichment.names.iter().enumerate())
            .map(|(place, name)| Some(whole.column(place, whole.response(name)?)))
            .collect();
        let columns = columns.ok_or_else(unknown)?;
        if !whole.agree(&columns) {
            return Err(refused(
                "its further columns don't answer to the loads and centrifugal forces that it tells of",
            ));
        }
        let derivation = superelement.derivation.as_ref();
        let missing: Option<Vec<Response>> = (derivation.iter())
            .flat_map(|derivation| &derivation.left_out_columns)
            .map(|name| whole.response(name))
            .collect();
        let missing = missing.ok_or_else(unknown)?;
        let strongest = |kind: Kind| {
            let there = columns.iter().filter(|column| column.response.kind == kind);
            let there = there.map(|column| column.energy);
            let missing = missing.iter().filter(|response| response.kind == kind);
            let missing = missing.map(|response| whole.energy(&response.modal));
            there.chain(missing).fold(0.0, f64::max)
        };
        let matters = |kind: Kind, energy: f64| energy > WEAK_RESPONSE * strongest(kind);
        let comes_back = |response: &Response| {
            let beyond = squares(&response.modal[modes..]);
            matters(response.kind, whole.energy(&response.modal))
                && beyond > superelement.residual.tolerance * squares(&response.modal)
        };
        if missing.iter().any(comes_back) {
            return Err(refused(
                "with fewer modes it needs a further column that it was made without",
            ));
        }
        let columns: Vec<&Column> = (columns.iter())
            .filter(|column| matters(column.response.kind, column.energy))
            .collect();
        let scale: Vec<f64> = columns.iter().map(|column| column.scale_now()).collect();
        Ok(Self {
            places: columns.iter().map(|column| column.place).collect(),
            absorbed: Mat::from_fn(left_out_modes, columns.len(), |k, j| {
                scale[j] * columns[j].response.modal[modes + k]
            }),
            scale: (columns.iter().zip(&scale))
                .map(|(column, scale)| scale / column.scale)
                .collect(),
        })
    }

    /// Any linear quantity over the columns that stay, (m, n_x), from it over all columns and over the modes left out, (m, modes left out).
    pub fn over(&self, columns: MatRef<'_, f64>, left_out: MatRef<'_, f64>) -> Mat<f64> {
        let stay = Mat::from_fn(columns.nrows(), self.places.len(), |i, j| {
            self.scale[j] * columns[(i, self.places[j])]
        });
        match self.absorbed.nrows() {
            0 => stay,
            _ => stay + left_out * &self.absorbed,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Spin,
    Load,
    Krylov,
}

/// A response G f, as far as the file tells it.
struct Response {
    kind: Kind,
    /// φᵀ G f of each mode, (n_k); zero for modes without stiffness, and for those that f isn't allowed to move.
    modal: Vec<f64>,
    /// ψᵀ f of the columns beyond the modes, (n_b + n_x).
    work: Vec<f64>,
}

/// A further column and its response.
struct Column {
    place: usize,
    response: Response,
    /// s.
    scale: f64,
    /// Xᵀ M X.
    mass: f64,
    /// fᵀ G f.
    energy: f64,
}

impl Column {
    /// s with the modes left out.
    fn scale_now(&self) -> f64 {
        match self.response.kind {
            Kind::Spin | Kind::Load => self.scale,
            Kind::Krylov => {
                let norm = self.mass / self.scale.powi(2) + squares(&self.response.modal);
                1.0 / norm.sqrt()
            }
        }
    }
}

fn squares(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum()
}

/// The superelement as its file has it, seen from the further columns.
struct Whole<'a> {
    superelement: &'a Superelement,
    enrichment: &'a Enrichment,
    eigenvalues: &'a [f64],
    /// Modes that stay.
    modes: usize,
    /// Rows that have columns.
    attached: Vec<bool>,
}

impl Whole<'_> {
    /// Where columns beyond the modes begin.
    fn first(&self) -> usize {
        self.eigenvalues.len()
    }

    /// `None` for a name that says nothing here.
    fn response(&self, name: &str) -> Option<Response> {
        let of = self.superelement;
        let elastic = super::without_stiffness(self.eigenvalues);
        let all = 0..of.basis_count();
        let static_response = |kind, work: Vec<f64>| Response {
            kind,
            modal: (0..self.first())
                .map(|k| match k < elastic {
                    true => 0.0,
                    false => work[k] / self.eigenvalues[k],
                })
                .collect(),
            work: work[self.first()..].to_vec(),
        };
        Some(match Answer::named(name, of.dimension)? {
            Answer::Spin(dimension, pattern) => {
                let work = all.map(|column| of.inertia.spin_work(dimension, column)[pattern]);
                static_response(Kind::Spin, work.collect())
            }
            Answer::Load(name) => {
                let load = of.loads.iter().find(|load| load.name == name)?;
                static_response(Kind::Load, load.work.clone())
            }
            // f has no part along the modes kept: G_res sees to that.
            Answer::Krylov(name) => {
                let mut rows = 0..of.boundary_row_count();
                let row = rows.find(|row| self.attached[*row] && of.row_name(*row) == name)?;
                let shapes = &of.modes.interface_shapes;
                Response {
                    kind: Kind::Krylov,
                    modal: (0..self.first())
                        .map(|k| match k < self.modes {
                            true => 0.0,
                            false => shapes[(row, k)] / self.eigenvalues[k].powi(2),
                        })
                        .collect(),
                    work: (self.first()..all.end)
                        .map(|column| self.enrichment.reduced_mass[(self.first() + row, column)])
                        .collect(),
                }
            }
        })
    }

    fn column(&self, place: usize, response: Response) -> Column {
        let beyond = self.superelement.boundary_row_count() + place;
        let at = (self.first() + beyond, self.first() + beyond);
        let (mass, stiffness) = (
            self.enrichment.reduced_mass[at],
            self.enrichment.reduced_stiffness[at],
        );
        // Whichever keeps its digits.
        let scale = match mass < 0.5 {
            true => ((1.0 - mass) / squares(&response.modal)).sqrt(),
            false => stiffness / response.work[beyond],
        };
        Column {
            place,
            scale,
            mass,
            energy: stiffness / scale.powi(2) + self.energy(&response.modal),
            response,
        }
    }

    /// Σ ω² (φᵀ G f)².
    fn energy(&self, modal: &[f64]) -> f64 {
        let modes = self.eigenvalues.iter().zip(modal);
        modes.map(|(square, amount)| square * amount * amount).sum()
    }

    /// Whether norm and stiffness of all columns are those of their responses.
    fn agree(&self, columns: &[Column]) -> bool {
        let of = self.superelement;
        let stiffness = |i: usize, j: usize| {
            self.enrichment.reduced_stiffness[(self.first() + i, self.first() + j)]
        };
        // ψᵀ K ψ of attachments and further columns with no mode kept.
        let n_b = of.boundary_row_count();
        let shapes = &of.modes.interface_shapes;
        let elastic = super::without_stiffness(self.eigenvalues);
        let attachment = |row: usize| {
            let modes =
                (elastic..self.first()).map(|k| shapes[(row, k)].powi(2) / self.eigenvalues[k]);
            stiffness(row, row) + modes.sum::<f64>()
        };
        let further = |column: &Column| match column.response.kind {
            Kind::Spin | Kind::Load => column.energy * column.scale.powi(2),
            Kind::Krylov => stiffness(n_b + column.place, n_b + column.place),
        };
        let mut energies: Vec<f64> = (0..n_b).map(attachment).collect();
        energies.extend(columns.iter().map(further));
        columns.iter().all(|column| {
            let carried = match column.response.kind {
                Kind::Spin | Kind::Load => squares(&column.response.modal),
                Kind::Krylov => 0.0,
            };
            let norm = column.mass + column.scale.powi(2) * carried;
            let j = n_b + column.place;
            let pulls = (0..energies.len()).all(|i| {
                let left = stiffness(i, j) - column.scale * column.response.work[i];
                left.abs() <= AGREEMENT * (energies[i] * energies[j]).sqrt()
            });
            column.scale.is_finite() && (norm - 1.0).abs() <= AGREEMENT && pulls
        })
    }
}
