//! Further columns that answer to a load whose work on the basis the file has: named loads and, by I1, centrifugal forces.
//!
//! ```text
//! X = s G_res f:   Ψ_jᵀ K X = s Ψ_jᵀ f beyond the modes,   s = XᵀKX / Xᵀf > 0
//! ```
//! The work of the centrifugal forces of ω_a ω_b on ψ is −I1_ab (a ≠ b) and ¼ tr I1 − ½ I1_aa; in the plane that of ω² is I1.

use super::Identity;
use super::residual::flexibilities;
use super::scaled::larger;
use crate::further_column::Answer;
use crate::superelement::{CouplingSource, Enrichment, Superelement};

/// Largest difference of solutions with different right sides.
const WORK_LIMIT: f64 = 1e-6;

pub(super) fn in_full(of: &Superelement) -> Vec<Identity> {
    let Some(enrichment) = &of.enrichment else {
        return Vec::new();
    };
    let mut all = vec![Identity {
        path: "/loads/work",
        what: "beyond the modes it is proportional to what the column `load NAME` has in K",
        defect: largest(of, enrichment, &|answer| match answer {
            Answer::Load(name) => {
                let load = of.loads.iter().find(|load| load.name == name)?;
                Some(load.work.clone())
            }
            _ => None,
        }),
        limit: WORK_LIMIT,
    }];
    if of.coupling_source() == CouplingSource::Integrals {
        all.push(Identity {
            path: "/inertia/I1",
            what: "beyond the modes it is proportional to what the columns `spin` have in K",
            defect: largest(of, enrichment, &|answer| match answer {
                Answer::Spin(dimension, pattern) => {
                    let columns = 0..of.basis_count();
                    let work = |column| of.inertia.spin_work(dimension, column)[pattern];
                    Some(columns.map(work).collect())
                }
                _ => None,
            }),
            limit: WORK_LIMIT,
        });
    }
    all
}

/// Largest |K_jx − s w_j| / √(K_jj K_xx) over columns x whose work w is known.
fn largest(
    of: &Superelement,
    enrichment: &Enrichment,
    work: &dyn Fn(Answer<'_>) -> Option<Vec<f64>>,
) -> f64 {
    let (n_k, n_b, n) = (of.mode_count(), of.rows.len(), of.basis_count());
    let stiffness = &enrichment.reduced_stiffness;
    let rows = flexibilities(of);
    let size = |j: usize| match j < n_k + n_b {
        true => rows[j - n_k].sqrt(),
        false => stiffness[(j, j)].max(0.0).sqrt(),
    };
    let mut defect = 0.0;
    for (place, name) in enrichment.names.iter().enumerate() {
        let answer = Answer::named(name, of.dimension);
        let Some(work) = answer.and_then(work) else {
            continue;
        };
        let x = n_k + n_b + place;
        let scale = stiffness[(x, x)] / work[x];
        if scale.is_nan() || scale <= 0.0 {
            return f64::INFINITY;
        }
        for j in n_k..n {
            let found = (stiffness[(j, x)] - scale * work[j]).abs();
            if found > 0.0 {
                defect = larger(defect, found / (size(j) * size(x)));
            }
        }
    }
    defect
}
