//! The superelement of the whole: modes, attachments, invariants, moments.

use dcb_dense::symmetrized;
use dcb_formats::assembly::Assembly;
use dcb_formats::component::Role;
use dcb_formats::superelement::{
    CouplingSource, Derivation, FrameKind, Modes, Moments, PartLoad, Provenance, Residual,
    Stiffening, Superelement,
};
use dcb_superelement::error_bounds::DENSE_ROUNDING;
use dcb_superelement::{MASS_TOLERANCE, ResidualFilter, extended_to_gap};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

use crate::Error;
use crate::beyond::{added, has_all_attachments};
use crate::chosen::Chosen;
use crate::closing::Closing;
use crate::inertia::{PartColumns, invariants};
use crate::measure::starts;
use crate::part::Part;
use crate::whole::{Support, Whole};

/// Rows that feel less than this fraction of their motion as elastic motion are rigid.
const UNFELT: f64 = 1e-12;

/// The modes that are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeptModes {
    /// This many, the lowest, and what belongs to a multiple root of the last.
    Lowest(usize),
    /// All with an ω² below this.
    Below(f64),
}

/// Modes and attachments over all coordinates of the bodies.
pub(crate) struct Basis {
    /// ω² of kept modes, loose motions first.
    pub eigenvalues: Vec<f64>,
    /// The lowest ω² of the assembly that is left out; infinite if none is.
    pub first_omitted: f64,
    /// Modes, (all coordinates, n_k).
    pub modes: Mat<f64>,
    /// Static shapes beyond the modes of unit forces on every row, output rows too, (e, n_b).
    statics: Mat<f64>,
    /// The same with no mode kept.
    statics0: Mat<f64>,
    /// Forces over the elastic motions, (e, n_b).
    forces: Mat<f64>,
    /// Whether a force acts on a row.
    loaded: Vec<bool>,
    /// Shapes of kept elastic modes over the elastic motions, (e, kept).
    kept: Mat<f64>,
}

impl Basis {
    pub fn of(whole: &Whole, closing: &Closing, chosen: &Chosen, wanted: KeptModes) -> Self {
        let loose = whole.loose.ncols();
        let all: Vec<f64> = std::iter::repeat_n(0.0, loose)
            .chain(whole.eigenvalues.iter().copied())
            .collect();
        let kept = match wanted {
            KeptModes::Lowest(count) => extended_to_gap(&all, count.max(loose).min(all.len())),
            KeptModes::Below(limit) => extended_to_gap(
                &all,
                all.partition_point(|square| *square < limit).max(loose),
            ),
        };
        let elastic = kept - loose;
        let kept_shapes = whole.shapes.subcols(0, elastic).to_owned();
        let of_modes = &whole.elastic * &kept_shapes;
        let modes = Mat::from_fn(of_modes.nrows(), kept, |i, k| match k < loose {
            true => whole.loose[(i, k)],
            false => of_modes[(i, k - loose)],
        });
        let seen = &closing.interfaces * &whole.elastic;
        let moved = &closing.interfaces;
        let is_unfelt = |row: usize| {
            closing.flexible[(row, row)] <= 0.0
                && seen.row(row).norm_l2() <= UNFELT * moved.row(row).norm_l2()
        };
        let mut forces = seen.transpose().to_owned();
        for row in (0..seen.nrows()).filter(|row| is_unfelt(*row)) {
            forces.as_mut().col_mut(row).fill(0.0);
        }
        let without =
            |columns: &Mat<f64>| columns - &kept_shapes * (kept_shapes.transpose() * columns);
        let statics = without(&whole.solved(without(&forces)));
        let statics0 = whole.solved(forces.clone());
        Self {
            first_omitted: all.get(kept).copied().unwrap_or(f64::INFINITY),
            eigenvalues: all[..kept].to_vec(),
            modes,
            statics,
            statics0,
            forces,
            loaded: (chosen.rows.iter())
                .map(|row| chosen.interfaces[row.interface].role == Role::Attachment)
                .collect(),
            kept: kept_shapes,
        }
    }

    /// Attachments over the elastic motions; zero for rows without force, (e, n_b).
    fn attachments(&self, of: &Mat<f64>) -> Mat<f64> {
        Mat::from_fn(of.nrows(), of.ncols(), |i, j| {
            if self.loaded[j] { of[(i, j)] } else { 0.0 }
        })
    }

    fn residual(&self, closing: &Closing) -> Result<Residual, Error> {
        let count = self.loaded.len();
        let (columns, columns0) = (
            self.attachments(&self.statics),
            self.attachments(&self.statics0),
        );
        let answers = self.forces.transpose() * &columns;
        let seen = Mat::from_fn(count, count, |i, j| {
            if self.loaded[j] {
                answers[(i, j)] + closing.flexible[(i, j)]
            } else {
                0.0
            }
        });
        let flexibility = symmetrized(Mat::from_fn(count, count, |i, j| {
            if self.loaded[i] { seen[(i, j)] } else { 0.0 }
        }));
        let mass = symmetrized(columns.transpose() * &columns);
        let mass0 = symmetrized(columns0.transpose() * &columns0);
        let mass_diagonal0: Vec<f64> = (0..count).map(|i| mass0[(i, i)].max(0.0)).collect();
        let failed = |_| Error::NotFinite {
            what: "the attachments of the assembly",
        };
        let filter = ResidualFilter::of(&mass_diagonal0, &mass0).map_err(failed)?;
        let (transform, sigma_squared) = filter
            .directions(MASS_TOLERANCE, &flexibility, &mass)
            .map_err(failed)?;
        Ok(Residual {
            output_shapes: self.loaded.contains(&false).then_some(seen),
            flexibility,
            mass,
            mass_diagonal0,
            transform,
            sigma_squared,
            tolerance: MASS_TOLERANCE,
        })
    }

    /// Power moments of what the modes leave out, the parts' omitted motions included, with the shift zero; `None` where a part's attachments aren't all in
    /// its file.
    fn moments(
        &self,
        parts: &[Part],
        whole: &Whole,
        closing: &Closing,
        certified: Certified,
    ) -> Option<Moments> {
        if !parts.iter().all(has_all_attachments) {
            return None;
        }
        let statics = &self.statics;
        let without = |columns: &Mat<f64>| columns - &self.kept * (self.kept.transpose() * columns);
        let next = without(&whole.solved(statics.clone()));
        let count = self.loaded.len();
        let in_parts = |columns: &Mat<f64>, forces: &Mat<f64>| {
            over_parts(parts, closing, &(&whole.elastic * columns), forces)
        };
        let [third, fourth] = added(
            parts,
            &in_parts(statics, &Mat::identity(count, count)),
            &in_parts(&next, &Mat::zeros(count, count)),
        )?;
        let product = |a: &Mat<f64>, b: &Mat<f64>| symmetrized(a.transpose() * b);
        // Moments of the parts without their shifts are right to this.
        let shifts = parts.iter().filter_map(Part::flexible).filter_map(|of| {
            let moments = of.element.moments.as_ref()?;
            Some(moments.shift / moments.eigenvalue_bound.max(moments.shift))
        });
        let shifts = shifts.fold(0.0, f64::max);
        Some(Moments {
            eigenvalue_bound: certified.eigenvalue_bound,
            eigenvalue_errors: certified.eigenvalue_errors,
            rigid_shapes: &closing.interfaces * &whole.rigid,
            shift: 0.0,
            first: product(&self.forces, statics) + symmetrized(&closing.flexible),
            second: product(statics, statics),
            third: product(statics, &next) + third,
            fourth: product(&next, &next) + fourth,
            rounding: vec![16.0 * DENSE_ROUNDING + 2.0 * shifts; count],
            loaded: None,
        })
    }
}

/// What is known of the assembly's eigenvalues beside the parts' meshes.
pub(crate) struct Certified {
    pub eigenvalue_bound: f64,
    pub eigenvalue_errors: Vec<f64>,
}

/// The superelement, the columns of the whole in each part, and how far damping turns modes into each other.
///
/// # Errors
/// [`Error::NotFinite`].
pub(crate) fn superelement(
    assembly: &Assembly,
    parts: &[Part],
    whole: &Whole,
    closing: &Closing,
    chosen: Chosen,
    basis: &Basis,
    certified: Option<Certified>,
) -> Result<(Superelement, Vec<PartColumns>, f64), Error> {
    let residual = basis.residual(closing)?;
    let attachments = &whole.elastic * basis.attachments(&basis.statics);
    let (n_k, n_b) = (basis.modes.ncols(), attachments.ncols());
    let motion = Mat::from_fn(attachments.nrows(), n_k + n_b, |i, k| match k < n_k {
        true => basis.modes[(i, k)],
        false => attachments[(i, k - n_k)],
    });
    let forces = Mat::from_fn(n_b, n_k + n_b, |i, k| {
        f64::from(u8::from(k >= n_k && k - n_k == i && basis.loaded[i]))
    });
    let columns = over_parts(parts, closing, &motion, &forces);
    let inertia = invariants(parts, &columns, whole.centre, assembly.scene.dimension);
    let (damping, residual_damping, coupling) =
        damping(parts, closing, basis, &attachments, &residual);
    let interface_shapes = &closing.interfaces * &basis.modes;
    let moments = certified.and_then(|of| basis.moments(parts, whole, closing, of));
    let superelement = Superelement {
        name: assembly.name.clone(),
        dimension: assembly.scene.dimension,
        units: assembly.scene.units.clone(),
        origin: whole.centre.into(),
        frame_kind: match whole.support {
            Support::Free => FrameKind::MeanAxis,
            Support::Held => FrameKind::Given,
        },
        interfaces: chosen.interfaces,
        rows: chosen.rows,
        modes: Modes {
            eigenvalues: basis.eigenvalues.clone(),
            damping,
            residual_damping,
            interface_shapes,
            first_omitted_eigenvalue: basis.first_omitted.min(parts_omitted(parts)),
        },
        residual,
        loads: loads(parts, &columns, whole.centre),
        stresses: Vec::new(),
        inertia,
        stiffening: Stiffening::default(),
        enrichment: None,
        moments,
        derivation: Some(Derivation {
            coupling_source: coupling_source(parts),
            ..Derivation::default()
        }),
        provenance: Provenance::default(),
    };
    Ok((superelement, columns, coupling))
}

/// The lowest ω² that any part has left out: the whole has motions like these beyond its own coordinates.
fn parts_omitted(parts: &[Part]) -> f64 {
    let omitted = parts
        .iter()
        .filter_map(Part::flexible)
        .map(|of| of.element.modes.first_omitted_eigenvalue);
    omitted.fold(f64::INFINITY, f64::min)
}

/// The columns of the whole in each part.
fn over_parts(
    parts: &[Part],
    closing: &Closing,
    motion: &Mat<f64>,
    forces: &Mat<f64>,
) -> Vec<PartColumns> {
    let starts = starts(parts);
    (parts.iter().enumerate())
        .map(|(i, part)| {
            let r = part.rigid_count();
            let rigid = &part.rigid * motion.subrows(starts[i], r);
            let deformation = match part.flexible() {
                None => Mat::zeros(0, motion.ncols()),
                Some(flexible) => {
                    let own =
                        &flexible.to_file * motion.subrows(starts[i] + r, flexible.stiffness.len());
                    match &flexible.massless_to_file {
                        Some(massless) => own + massless * closing.forces_on(i, motion, forces),
                        None => own,
                    }
                }
            };
            PartColumns { rigid, deformation }
        })
        .collect()
}

/// Ratios to critical of the modes and of the softest attachment, and how far damping turns modes into each other: the largest d_kl ω_l / |ω_k² − ω_l²| of
/// ΦᵀDΦ, no more than 1.
fn damping(
    parts: &[Part],
    closing: &Closing,
    basis: &Basis,
    attachments: &Mat<f64>,
    residual: &Residual,
) -> (Vec<f64>, f64, f64) {
    let own: Vec<f64> = (parts.iter())
        .flat_map(|part| {
            let elastic = part.flexible().map_or(&[][..], |of| of.damping.as_slice());
            std::iter::repeat_n(0.0, part.rigid_count()).chain(elastic.iter().copied())
        })
        .collect();
    let damped = |columns: &Mat<f64>| {
        let weighted = Mat::from_fn(columns.nrows(), columns.ncols(), |i, k| {
            own[i] * columns[(i, k)]
        });
        let dashpots = &closing.damping_root * columns;
        columns.transpose() * weighted + dashpots.transpose() * &dashpots
    };
    let of_modes = damped(&basis.modes);
    let ratio = |rate: f64, square: f64| {
        if square > 0.0 {
            0.5 * rate / square.sqrt()
        } else {
            0.0
        }
    };
    let ratios = (0..basis.eigenvalues.len())
        .map(|k| ratio(of_modes[(k, k)], basis.eigenvalues[k]))
        .collect();
    // To first order mode k gets d_kl ω_l / (ω_k² − ω_l²) of mode l.
    let mut coupling = 0.0_f64;
    for k in 0..of_modes.ncols() {
        for l in 0..k {
            let (own, other) = (basis.eigenvalues[k], basis.eigenvalues[l]);
            let turned = of_modes[(k, l)].abs() * other.sqrt();
            if turned > 0.0 {
                coupling = coupling.max(turned / (own - other).abs().max(turned));
            }
        }
    }
    let residual_ratio = match residual.sigma_squared.first() {
        Some(square) => {
            let softest = attachments * residual.transform.subcols(0, 1);
            ratio(damped(&softest)[(0, 0)], *square)
        }
        None => 0.0,
    };
    (ratios, residual_ratio, coupling)
}

/// Loads on the inside of the parts, under the names BODY: LOAD.
fn loads(parts: &[Part], columns: &[PartColumns], centre: Vector3<f64>) -> Vec<PartLoad> {
    let mut all = Vec::new();
    for (part, columns) in parts.iter().zip(columns) {
        let Some(flexible) = part.flexible() else {
            continue;
        };
        let axial: Matrix3<f64> = part.axial();
        for load in &flexible.element.loads {
            let force = part.axes * Vector3::from(load.force);
            let own = axial * Vector3::from(load.moment);
            let moment = own + (part.centre - centre).cross(&force);
            let work = (0..columns.rigid.ncols()).map(|k| {
                let of_frame: f64 = (0..3)
                    .map(|a| force[a] * columns.rigid[(a, k)] + own[a] * columns.rigid[(3 + a, k)])
                    .sum();
                let elastic: f64 = (0..columns.deformation.nrows())
                    .map(|i| load.work[i] * columns.deformation[(i, k)])
                    .sum();
                of_frame + elastic
            });
            all.push(PartLoad {
                name: format!("{}: {}", part.name, load.name),
                force: force.into(),
                moment: moment.into(),
                work: work.collect(),
            });
        }
    }
    all
}

/// The least certain of the parts'.
fn coupling_source(parts: &[Part]) -> CouplingSource {
    let sources: Vec<CouplingSource> = parts
        .iter()
        .filter_map(Part::flexible)
        .map(|of| of.element.coupling_source())
        .collect();
    if sources.contains(&CouplingSource::Unknown) {
        CouplingSource::Unknown
    } else if sources.contains(&CouplingSource::Nodal) {
        CouplingSource::Nodal
    } else {
        CouplingSource::Integrals
    }
}
