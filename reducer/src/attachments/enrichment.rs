//! Further columns of the basis: quasi-static responses to what interfaces and modes don't cover.
//!
//! X = s G_res f solves K X = s P' f like an attachment (`docs/theory.md`), so it is on mean axes and orthogonal to the kept modes in K and
//! M. The scale s makes the response with no mode kept, G f, of unit M norm: what is left of that norm in X says, without a unit,
//! how much the modes lack.
//!
//! | source | forces f |
//! |---|---|
//! | [`EnrichmentSource::Spin`] | ∫ ρ Nᵀ S r for the symmetric S, one per product of spins (planar: S = I); what centrifugal forces do, constant or not |
//! | [`EnrichmentSource::Loads`] | the component's named loads |
//! | [`EnrichmentSource::Krylov`] | M G_res L_bᵀ: the next term of the interfaces' dynamic flexibility in ω² |
//!
//! Gravity moves the part rigidly and the Euler force of an angular acceleration is rigid too: neither needs a column.

use dcb_dense::symmetrized;
use dcb_formats::SparseMatrix;
use dcb_formats::component::Component;
use dcb_formats::further_column::Answer;
use dcb_formats::superelement::Enrichment;
use dcb_sparse::block_algebra::{gram, symmetric_product};
use dcb_sparse::factorization::PositiveFactor;
use faer::Mat;

use crate::attachments::columns::{AttachmentProblem, Loads};
use crate::attachments::enrichment_source::EnrichmentSource;
use crate::attachments::residual::ResidualFlexibility;
use crate::error::Error;
use crate::inertia::spin_forces::spin_forces;
use crate::model::condensation::Model;
use crate::model::localization::Localization;
use crate::model::rigid_body::{MassProperties, RigidBodyModes};
use crate::modes::free_modes::FreeModes;
use crate::observer::Observer;
use dcb_superelement::MASS_TOLERANCE;

/// A pattern whose response carries less than this part of the strain energy of the strongest is left out: what discretisation leaves of
/// a rigid motion, as for a pattern across a straight beam.
const WEAK_PATTERN: f64 = 1e-10;

/// Forces over the model's dofs, with their names.
struct Forces {
    columns: Mat<f64>,
    names: Vec<String>,
}

/// Further columns of the reduced basis.
#[derive(Clone, Debug)]
pub struct FurtherColumns {
    /// Load that each responds to.
    pub names: Vec<String>,
    /// X over the model's dofs, (n_c, n_x).
    pub shapes: Mat<f64>,
    /// Largest relative residual of the columns.
    pub residual: f64,
    /// The part of it that rounding explains.
    pub residual_rounding: f64,
    /// Largest entry of Φᵀ M X; columns have at most unit M norm.
    pub mass_orthogonality: f64,
    /// Largest entry of Φᵀ K X over the square root of both stiffnesses.
    pub stiffness_orthogonality: f64,
    /// Responses that were left out: none beyond the kept modes, or hardly any at all.
    pub left_out: Vec<String>,
    /// Xᵀ M X, (n_x, n_x).
    mass: Mat<f64>,
    /// Xᵀ K X, (n_x, n_x).
    stiffness: Mat<f64>,
}

/// Sources of the columns.
#[derive(Clone, Copy)]
pub struct Reducing<'a> {
    /// The component.
    pub component: &'a Component,
    /// Its mass properties.
    pub properties: &'a MassProperties,
    /// Its model.
    pub model: &'a Model<'a>,
    /// L_b.
    pub localization: &'a Localization,
    /// Rigid motions.
    pub rigid: &'a RigidBodyModes,
    /// Kept modes.
    pub modes: &'a FreeModes,
    /// Attachments.
    pub residual: &'a ResidualFlexibility,
}

impl FurtherColumns {
    /// Solves for the columns of some sources; `None` without any.
    ///
    /// # Errors
    /// [`Error::AttachmentsNotConverged`] naming a column; [`Error::Lacking`] if loads are asked for and there are none.
    pub fn compute(
        sources: &[EnrichmentSource],
        of: &Reducing<'_>,
        factor: &PositiveFactor,
        observer: &mut dyn Observer,
    ) -> Result<Option<Self>, Error> {
        if sources.is_empty() {
            return Ok(None);
        }
        let forces = of.forces(sources)?;
        let problem = of.problem(&forces);
        let solved = problem.solve(factor, observer)?;
        problem.refuse_unconverged(&solved)?;
        let (residual, residual_rounding) = solved
            .worst
            .map_or((0.0, 0.0), |worst| (worst.residual, worst.rounding));
        let found = Self {
            names: forces.names.clone(),
            shapes: solved.columns,
            residual,
            residual_rounding,
            mass_orthogonality: 0.0,
            stiffness_orthogonality: 0.0,
            left_out: Vec::new(),
            mass: Mat::zeros(0, 0),
            stiffness: Mat::zeros(0, 0),
        };
        Ok(Some(found.normalised(of, &forces)))
    }

    /// Given columns by the names that a file has for them, with what they leave of their equation; `None` for a name that isn't one
    /// of this program's.
    ///
    /// # Errors
    /// [`Error::Lacking`] if a named load isn't there.
    pub fn recognised(
        names: &[String],
        shapes: Mat<f64>,
        of: &Reducing<'_>,
    ) -> Result<Option<Self>, Error> {
        let begins = |word: &str| {
            names
                .iter()
                .any(|name| name.split(' ').next() == Some(word))
        };
        let sources: Vec<EnrichmentSource> = [
            ("spin", EnrichmentSource::Spin),
            ("load", EnrichmentSource::Loads),
            ("krylov", EnrichmentSource::Krylov),
        ]
        .into_iter()
        .filter(|(word, _)| begins(word))
        .map(|(_, source)| source)
        .collect();
        let all = of.forces(&sources)?;
        let places: Option<Vec<usize>> = names
            .iter()
            .map(|name| all.names.iter().position(|known| known == name))
            .collect();
        let Some(places) = places.filter(|places| places.len() == shapes.ncols()) else {
            return Ok(None);
        };
        let stiffness_shapes = symmetric_product(&of.model.stiffness, shapes.as_ref());
        // The scale of each column: the one that fits K X = s P' f best.
        let mut forces = Forces {
            columns: Mat::from_fn(of.model.len(), places.len(), |i, j| {
                all.columns[(i, places[j])]
            }),
            names: names.to_vec(),
        };
        let relieved = of.problem(&forces).relieved();
        for j in 0..places.len() {
            let (f, k_x) = (relieved.col(j), stiffness_shapes.col(j));
            let scale = (f.transpose() * k_x) / f.squared_norm_l2().max(f64::MIN_POSITIVE);
            for value in forces.columns.as_mut().col_mut(j).iter_mut() {
                *value *= scale;
            }
        }
        let solved = of.problem(&forces).judge(shapes);
        let (residual, residual_rounding) = solved
            .worst
            .map_or((0.0, 0.0), |worst| (worst.residual, worst.rounding));
        let between = |product: &Mat<f64>| {
            symmetrized(gram(solved.columns.as_ref(), product.as_ref()).as_ref())
        };
        let mass_shapes = symmetric_product(&of.model.mass, solved.columns.as_ref());
        let found = Self {
            names: names.to_vec(),
            residual,
            residual_rounding,
            mass_orthogonality: 0.0,
            stiffness_orthogonality: 0.0,
            left_out: Vec::new(),
            mass: between(&mass_shapes),
            stiffness: between(&stiffness_shapes),
            shapes: solved.columns,
        };
        Ok(Some(found.with_orthogonality(of)))
    }

    /// Scales the columns, and leaves out those that have nothing to add.
    fn normalised(mut self, of: &Reducing<'_>, forces: &Forces) -> Self {
        let modes = of.modes;
        let mass = gram(
            self.shapes.as_ref(),
            symmetric_product(&of.model.mass, self.shapes.as_ref()).as_ref(),
        );
        let stiffness = gram(
            self.shapes.as_ref(),
            symmetric_product(&of.model.stiffness, self.shapes.as_ref()).as_ref(),
        );
        // What the kept modes carry of G f: Φ Ω⁻² Φᵀ f.
        let amounts = gram(modes.shapes.as_ref(), forces.columns.as_ref());
        let carried = |j: usize, power: i32| -> f64 {
            (modes.zero_count..modes.count())
                .map(|k| amounts[(k, j)].powi(2) / modes.eigenvalues[k].powi(power))
                .sum()
        };
        let count = self.names.len();
        let norms: Vec<f64> = (0..count)
            .map(|j| (mass[(j, j)].max(0.0) + carried(j, 2)).sqrt())
            .collect();
        let energies: Vec<f64> = (0..count)
            .map(|j| stiffness[(j, j)].max(0.0) + carried(j, 1))
            .collect();
        let strongest = |j: usize| {
            let kind = self.names[j].split(' ').next();
            let alike = (0..count).filter(|i| self.names[*i].split(' ').next() == kind);
            alike.map(|i| energies[i]).fold(0.0, f64::max)
        };
        let kept: Vec<usize> = (0..count)
            .filter(|&j| {
                mass[(j, j)] > MASS_TOLERANCE * norms[j].powi(2)
                    && energies[j] > WEAK_PATTERN * strongest(j)
            })
            .collect();
        let left_out = (0..count).filter(|j| !kept.contains(j));
        self.left_out = left_out.map(|j| self.names[j].clone()).collect();
        self.names = kept.iter().map(|&j| self.names[j].clone()).collect();
        let between = |matrix: &Mat<f64>| {
            Mat::from_fn(kept.len(), kept.len(), |i, j| {
                matrix[(kept[i], kept[j])] / (norms[kept[i]] * norms[kept[j]])
            })
        };
        self.mass = symmetrized(between(&mass).as_ref());
        self.stiffness = symmetrized(between(&stiffness).as_ref());
        self.shapes = Mat::from_fn(self.shapes.nrows(), kept.len(), |i, j| {
            self.shapes[(i, kept[j])] / norms[kept[j]]
        });
        self.with_orthogonality(of)
    }

    fn with_orthogonality(mut self, of: &Reducing<'_>) -> Self {
        let modes = of.modes;
        let along_mass = gram(modes.mass_shapes.as_ref(), self.shapes.as_ref());
        let k_phi = symmetric_product(&of.model.stiffness, modes.shapes.as_ref());
        let along_stiffness = gram(k_phi.as_ref(), self.shapes.as_ref());
        for j in 0..self.names.len() {
            for k in 0..modes.count() {
                let entry = along_mass[(k, j)].abs();
                self.mass_orthogonality = self.mass_orthogonality.max(entry);
                let size = (modes.eigenvalues[k] * self.stiffness[(j, j)]).sqrt();
                if size > 0.0 {
                    let entry = along_stiffness[(k, j)].abs() / size;
                    self.stiffness_orthogonality = self.stiffness_orthogonality.max(entry);
                }
            }
        }
        self
    }

    /// Contents of the file about them: over Ψ = [Φ, G_res L_bᵀ, X], with the orthogonality of modes and residual shapes.
    pub fn stored(
        &self,
        model: &Model,
        localization: &Localization,
        modes: &FreeModes,
        residual: &ResidualFlexibility,
    ) -> Enrichment {
        let further = self.shapes.as_ref();
        let attached = residual.shapes.as_ref();
        let (n_k, n_b) = (modes.count(), localization.len());
        let reduced = |modal: &dyn Fn(usize) -> f64,
                       attachments: &Mat<f64>,
                       between: &Mat<f64>,
                       own: &Mat<f64>| {
            let block = |i: usize| match i {
                _ if i < n_k => (0, i),
                _ if i < n_k + n_b => (1, i - n_k),
                _ => (2, i - n_k - n_b),
            };
            let n = n_k + n_b + self.names.len();
            Mat::from_fn(n, n, |i, j| match (block(i), block(j)) {
                ((0, i), (0, j)) if i == j => modal(i),
                ((1, i), (1, j)) => attachments[(i, j)],
                ((1, i), (2, j)) | ((2, j), (1, i)) => between[(i, j)],
                ((2, i), (2, j)) => own[(i, j)],
                _ => 0.0,
            })
        };
        let product =
            |matrix: &SparseMatrix| gram(attached, symmetric_product(matrix, further).as_ref());
        Enrichment {
            names: self.names.clone(),
            interface_shapes: localization.apply(further),
            reduced_mass: reduced(&|_| 1.0, &residual.mass, &product(&model.mass), &self.mass),
            reduced_stiffness: reduced(
                &|k| modes.eigenvalues[k],
                &residual.flexibility,
                &product(&model.stiffness),
                &self.stiffness,
            ),
        }
    }
}

impl Reducing<'_> {
    fn problem<'f>(&'f self, forces: &'f Forces) -> AttachmentProblem<'f> {
        let loads = Loads::Columns {
            forces: forces.columns.as_ref(),
            names: &forces.names,
        };
        AttachmentProblem::new(self.model, loads, self.rigid, self.modes)
    }

    fn forces(&self, sources: &[EnrichmentSource]) -> Result<Forces, Error> {
        let mut names = Vec::new();
        let mut blocks = Vec::new();
        for source in EnrichmentSource::ALL {
            if !sources.contains(&source) {
                continue;
            }
            source.check(self.component)?;
            match source {
                EnrichmentSource::Spin => {
                    let (own, forces) = spin_patterns(self.component, self.properties, self.model);
                    names.extend(own);
                    blocks.push(forces);
                }
                EnrichmentSource::Loads => {
                    let loads = &self.component.loads;
                    names.extend((loads.iter()).map(|load| Answer::Load(&load.name).to_string()));
                    let forces = Mat::from_fn(self.component.dofs.len(), loads.len(), |i, j| {
                        loads[j].forces[i]
                    });
                    blocks.push(self.model.condensed_forces(forces));
                }
                EnrichmentSource::Krylov => {
                    let rows: Vec<usize> = (0..self.localization.len())
                        .filter(|row| self.localization.is_attachment(*row))
                        .collect();
                    let name =
                        |row: &usize| Answer::Krylov(&self.localization.row_name(*row)).to_string();
                    names.extend(rows.iter().map(name));
                    let shapes = self.residual.shapes.as_ref();
                    let attached =
                        Mat::from_fn(shapes.nrows(), rows.len(), |i, j| shapes[(i, rows[j])]);
                    blocks.push(symmetric_product(&self.model.mass, attached.as_ref()));
                }
            }
        }
        Ok(Forces {
            columns: side_by_side(self.model.len(), &blocks),
            names,
        })
    }
}

fn side_by_side(rows: usize, blocks: &[Mat<f64>]) -> Mat<f64> {
    let mut all = Mat::zeros(rows, blocks.iter().map(|block| block.ncols()).sum());
    let mut first = 0;
    for block in blocks {
        all.as_mut()
            .subcols_mut(first, block.ncols())
            .copy_from(block);
        first += block.ncols();
    }
    all
}

/// Names and forces of the centrifugal patterns over the model's dofs, (n_c, 6), planar (n_c, 1).
fn spin_patterns(
    component: &Component,
    properties: &MassProperties,
    model: &Model,
) -> (Vec<String>, Mat<f64>) {
    let spins = Answer::spins(component.dimension());
    let names = spins.iter().map(Answer::to_string).collect();
    let forces = spin_forces(component, properties.centre);
    (names, model.condensed_forces(forces))
}
