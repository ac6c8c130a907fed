//! Estimated errors of superelements against true ones: the whole matrices and the projected ones, solved at every frequency, with null
//! spaces for held interfaces. Nothing here uses a moment; `docs/error-estimate.md` shows the outcome.

use dcb_formats::component::Role;
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::Compatibility;
use dcb_formats::{Component, Superelement};
use dcb_reducer::{Grounding, InterfaceModes, Reduced, Reduction};
use dcb_samples::spatial_beam::{BeamMass, BeamTheory};
use dcb_samples::{Material, PseudoRandom, SolidElement, hard};
use dcb_superelement::FrequencyBand;
use dcb_superelement::error_bounds::{Bracket, ErrorBounds, Estimate};
use faer::linalg::solvers::Solve as _;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side, c64};
use serde_json::{Value, json};

use crate::dense::{dense, eigen, solve, symmetric, times};
use crate::localization::localization;
use crate::oracle::{Oracle, centre_of_mass, rigid_motions};
use crate::random_parts::{Recipe, SpringMass, Springs};
use crate::{parts, with};

/// Structural loss factor of all responses.
pub const LOSS_FACTOR: f64 = 0.02;
/// Parts with more dofs than this are solved as sparse ones, without held frequencies and static responses.
const DENSE: usize = 1200;

/// A part, and how it is reduced.
pub struct Case {
    /// Name.
    pub name: &'static str,
    /// The part.
    pub component: Component,
    /// Modes and the like.
    pub options: Reduction,
}

impl Case {
    fn new(name: &'static str, component: Component, modes: usize) -> Self {
        Self {
            name,
            component,
            options: Reduction {
                grounding: Grounding::Allow,
                ..Reduction::lowest(modes)
            },
        }
    }
}

fn springs(dimension: Dimension, seed: u64) -> Component {
    let mut random = PseudoRandom::new(seed);
    let count = 8;
    let recipe = Recipe::Springs(Springs {
        dimension,
        points: (0..count)
            .map(|i| {
                let corner = [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f64);
                std::array::from_fn(|a| corner[a] * (1.0 + 0.2 * a as f64) + 0.2 * random.number())
            })
            .collect(),
        stiffness: (0..28)
            .map(|_| 10.0_f64.powf(5.0 + random.number()))
            .collect(),
        mass: SpringMass::Lumped((0..count).map(|_| 1.0 + 0.5 * random.number()).collect()),
    });
    recipe.component()
}

fn random_box(seed: u64, element: SolidElement) -> Component {
    let mut random = PseudoRandom::new(seed);
    let recipe = Recipe::Box {
        cells: [3, 2, 1],
        size: std::array::from_fn(|_| 0.2 + 0.1 * random.number()),
        element,
        material: Material {
            youngs_modulus: 10.0_f64.powf(10.0 + random.number()),
            poisson_ratio: 0.25 + 0.1 * random.number(),
            density: 4000.0 + 2000.0 * random.number(),
        },
    };
    recipe.component()
}

/// Parts that dense algebra can follow.
pub fn cases() -> Vec<Case> {
    let flat = |seed| {
        springs(Dimension::Planar, seed)
            .changed(|draft| draft.name = "planar springs".into())
            .expect("a component")
    };
    vec![
        Case::new("rod, 4 elements", parts::rod(4), 3),
        Case::new("tilted rod, 8 elements", parts::tilted_rod(8), 5),
        Case::new(
            "beam, 8 elements",
            parts::beam(8, BeamTheory::EulerBernoulli, BeamMass::Consistent),
            6,
        ),
        Case::new("skew Timoshenko beam", parts::skew_beam(), 5),
        Case::new(
            "beam with massless rotations",
            parts::beam(8, BeamTheory::EulerBernoulli, BeamMass::LumpedWithRoll),
            5,
        ),
        Case::new(
            "box, 20 nodes",
            parts::steel_box([4, 1, 1], SolidElement::Hexahedron),
            6,
        ),
        Case::new(
            "reference hexahedra",
            dcb_samples::solid::reference_hexahedra(),
            6,
        ),
        Case::new(
            "reference tetrahedra",
            dcb_samples::solid::reference_tetrahedra(),
            4,
        ),
        Case::new("square block, double roots", hard::square_block(), 6),
        Case::new("held block", hard::grounded_block(), 4),
        Case::new("published rotor", parts::rotor(), 6),
        Case::new("planar springs", flat(3), 3),
        Case::new("spatial springs", springs(Dimension::Spatial, 5), 4),
        Case::new(
            "random box, hexahedra",
            random_box(7, SolidElement::Hexahedron20),
            5,
        ),
        Case::new(
            "random box, tetrahedra",
            random_box(11, SolidElement::Tetra10),
            8,
        ),
    ]
}

/// The shipped connecting rod, too large for dense algebra.
pub fn connecting_rod() -> Case {
    Case::new("connecting rod", dcb_samples::connecting_rod(0), 10)
}

/// Errors as they are.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Largest of a held frequency below the top of the band.
    pub held: Option<f64>,
    /// Of the static response, worst interface.
    pub fixed: Option<f64>,
    /// Collocated response over the band.
    pub collocated: f64,
    /// Transfer response over the band.
    pub transfer: Option<f64>,
}

/// Matrices of a part, whole or projected, and what its rows see of its coordinates.
pub struct System {
    stiffness: Mat<f64>,
    mass: Mat<f64>,
    rows: Mat<f64>,
    /// Flexibility that follows without coordinates.
    constant: Mat<f64>,
    sparse: Option<(dcb_formats::SparseMatrix, dcb_formats::SparseMatrix)>,
}

impl System {
    /// The unreduced part.
    pub fn whole(component: &Component) -> Self {
        let rows = localization(component);
        let n_b = rows.nrows();
        let large = component.dofs.len() > DENSE;
        let matrix = |of: &dcb_formats::SparseMatrix| match large {
            true => Mat::zeros(0, 0),
            false => dense(of),
        };
        Self {
            stiffness: matrix(&component.stiffness),
            mass: matrix(&component.mass),
            rows,
            constant: Mat::zeros(n_b, n_b),
            sparse: large.then(|| (component.stiffness.clone(), component.mass.clone())),
        }
    }

    /// The part projected on what a superelement has in a form.
    pub fn reduced(component: &Component, reduced: &Reduced, form: Compatibility) -> Self {
        let element = &reduced.superelement;
        let recovery = &reduced.recovery;
        let rows = localization(component);
        let mut blocks = vec![recovery.modes.clone()];
        if element.frame_kind == dcb_formats::superelement::FrameKind::MeanAxis {
            blocks.insert(
                0,
                rigid_motions(component, centre_of_mass_of(component, element)),
            );
        }
        let attached = &recovery.residual * &element.residual.transform;
        let mut constant = &rows * &recovery.residual;
        if form == Compatibility::Strong {
            // Directions without mass follow the forces.
            let seen = &rows * &attached;
            let sigma = &element.residual.sigma_squared;
            let scaled = Mat::from_fn(seen.nrows(), seen.ncols(), |i, j| seen[(i, j)] / sigma[j]);
            constant -= scaled * seen.transpose();
            blocks.push(attached);
            blocks.extend(recovery.enrichment.clone());
        }
        let mut basis = beside(&blocks);
        if recovery.enrichment.is_some() {
            // Further columns may depend on the attachments.
            let gram = basis.transpose() * times(&component.mass, basis.as_ref());
            let size: Vec<f64> = (0..gram.nrows()).map(|i| gram[(i, i)].sqrt()).collect();
            let unit = Mat::from_fn(size.len(), size.len(), |i, j| {
                gram[(i, j)] / (size[i] * size[j])
            });
            let (values, vectors) = eigen(&symmetric(&unit));
            let kept: Vec<usize> = (0..size.len()).filter(|k| values[*k] > 1e-11).collect();
            let independent = Mat::from_fn(size.len(), kept.len(), |i, j| {
                vectors[(i, kept[j])] / (size[i] * values[kept[j]].sqrt())
            });
            basis = &basis * independent;
        }
        Self {
            stiffness: basis.transpose() * times(&component.stiffness, basis.as_ref()),
            mass: basis.transpose() * times(&component.mass, basis.as_ref()),
            rows: &rows * &basis,
            constant,
            sparse: None,
        }
    }

    /// What the numbers of a superelement without further columns say, its nodal fields unseen.
    pub fn of_superelement(element: &Superelement, form: Compatibility) -> Self {
        let rigid = rigid_rows(element);
        let residual = &element.residual;
        let stored = (residual.output_shapes.as_ref()).unwrap_or(&residual.flexibility);
        let seen = match form {
            Compatibility::Strong => stored * &residual.transform,
            Compatibility::Static => Mat::zeros(stored.nrows(), 0),
            Compatibility::Weak => unreachable!("no oracle for weak compatibility"),
        };
        let sigma = &residual.sigma_squared;
        let scaled = Mat::from_fn(seen.nrows(), seen.ncols(), |i, j| seen[(i, j)] / sigma[j]);
        let modes = &element.modes;
        let mut stiffness = vec![0.0; rigid.ncols()];
        stiffness.extend(&modes.eigenvalues);
        stiffness.extend(&sigma[..seen.ncols()]);
        let n = stiffness.len();
        let blocks = [&rigid, &modes.interface_shapes, &seen];
        let columns: Vec<_> = blocks.iter().flat_map(|block| block.col_iter()).collect();
        Self {
            stiffness: Mat::from_fn(n, n, |i, j| if i == j { stiffness[i] } else { 0.0 }),
            mass: Mat::identity(n, n),
            rows: Mat::from_fn(seen.nrows(), n, |i, j| columns[j][i]),
            constant: stored - scaled * seen.transpose(),
            sparse: None,
        }
    }

    /// The same between forces in place of rows, (rows, forces).
    pub fn between(mut self, forces: &Mat<f64>) -> Self {
        self.rows = forces.transpose() * &self.rows;
        self.constant = forces.transpose() * &self.constant * forces;
        self
    }

    /// The same with motions of a subspace only.
    pub fn within(mut self, basis: &Mat<f64>) -> Self {
        self.stiffness = basis.transpose() * &self.stiffness * basis;
        self.mass = basis.transpose() * &self.mass * basis;
        self.rows = &self.rows * basis;
        self
    }

    /// H(ω) = L (K (1 + iη) - ω² M)⁻¹ Lᵀ to forces at some rows.
    pub fn response(&self, square: f64, forced: &[usize]) -> Mat<c64> {
        let damped = c64::new(1.0, LOSS_FACTOR);
        let real = |value: f64| c64::new(value, 0.0);
        let n = self.rows.ncols();
        let forces = Mat::from_fn(n, forced.len(), |i, j| real(self.rows[(forced[j], i)]));
        let motion = match &self.sparse {
            None => {
                let matrix = Mat::from_fn(n, n, |i, j| {
                    damped * self.stiffness[(i, j)] - real(square * self.mass[(i, j)])
                });
                let lu = matrix.partial_piv_lu();
                let mut motion = lu.solve(&forces);
                let left = &forces - &matrix * &motion;
                motion += lu.solve(&left);
                motion
            }
            Some((stiffness, mass)) => {
                let mut entries = Vec::new();
                for (matrix, factor) in [(stiffness, damped), (mass, real(-square))] {
                    for column in 0..n {
                        let values = matrix.val_of_col(column);
                        for (row, value) in matrix.row_idx_of_col_raw(column).iter().zip(values) {
                            entries.push(Triplet::new(*row as usize, column, factor * *value));
                        }
                    }
                }
                let matrix = SparseColMat::<usize, c64>::try_new_from_triplets(n, n, &entries)
                    .expect("entries in range");
                matrix.sp_lu().expect("a damped part").solve(&forces)
            }
        };
        let rows = Mat::from_fn(self.rows.nrows(), n, |i, j| real(self.rows[(i, j)]));
        let seen = rows * motion;
        Mat::from_fn(seen.nrows(), seen.ncols(), |i, j| {
            seen[(i, j)] + real(self.constant[(i, forced[j])]) / damped
        })
    }

    /// ω² with some rows held, ascending, motions that stay loose left out.
    pub fn held(&self, rows: &[usize], scale: &[f64]) -> Vec<f64> {
        let coordinates = self.stiffness.nrows();
        // Coordinates without mass stand for the constant flexibility.
        let constant = Mat::from_fn(rows.len(), rows.len(), |i, j| {
            scale[rows[i]] * self.constant[(rows[i], rows[j])] * scale[rows[j]]
        });
        let (values, vectors) = eigen(&symmetric(&constant));
        let follow: Vec<usize> = (0..rows.len()).filter(|k| values[*k] > 1e-10).collect();
        let n = coordinates + follow.len();
        let size = (0..coordinates)
            .map(|i| self.stiffness[(i, i)])
            .fold(1e-300, f64::max);
        let shapes = Mat::from_fn(rows.len(), n, |i, j| match j.checked_sub(coordinates) {
            None => scale[rows[i]] * self.rows[(rows[i], j)],
            Some(j) => vectors[(i, follow[j])] * (values[follow[j]] * size).sqrt(),
        });
        let block = |matrix: &Mat<f64>, further: f64| {
            Mat::from_fn(n, n, |i, j| match i.max(j) < coordinates {
                true => matrix[(i, j)],
                false => further * f64::from(u8::from(i == j)),
            })
        };
        let (stiffness, mass) = (block(&self.stiffness, size), block(&self.mass, 0.0));
        let rank = rows.len().min(n);
        let q = shapes.transpose().qr().compute_Q();
        let motions = q.subcols(rank, n - rank).to_owned();
        if motions.ncols() == 0 {
            return Vec::new();
        }
        let projected = |matrix: &Mat<f64>| symmetric(&(motions.transpose() * matrix * &motions));
        let (k, m) = (projected(&stiffness), projected(&mass));
        let shift = 1e-6 * (0..k.nrows()).map(|i| k[(i, i)]).fold(0.0, f64::max)
            / (0..m.nrows()).map(|i| m[(i, i)]).fold(1e-300, f64::max);
        // Coordinates of one size.
        let shifted = Mat::from_fn(k.nrows(), k.nrows(), |i, j| k[(i, j)] + shift * m[(i, j)]);
        let root: Vec<f64> = (0..k.nrows()).map(|i| shifted[(i, i)].sqrt()).collect();
        let sized = |matrix: &Mat<f64>| {
            Mat::from_fn(k.nrows(), k.nrows(), |i, j| {
                matrix[(i, j)] / (root[i] * root[j])
            })
        };
        let lower = sized(&shifted)
            .llt(Side::Lower)
            .expect("positive")
            .L()
            .to_owned();
        let half = solve(&lower, &sized(&m));
        let compliance = solve(&lower, &half.transpose().to_owned());
        let (compliances, _) = eigen(&symmetric(&compliance));
        let top = compliances.last().copied().unwrap_or(0.0);
        (compliances.iter().rev())
            .filter(|value| **value > 1e-13 * top)
            .map(|value| 1.0 / value - shift)
            // Loose motions have the shift alone.
            .filter(|value| *value > 1e-6 * shift)
            .collect()
    }
}

/// Rigid motions at the rows of a superelement in a mean-axis frame, M-orthonormal.
fn rigid_rows(element: &Superelement) -> Mat<f64> {
    let inertia = &element.inertia;
    let planar = element.dimension == Dimension::Planar;
    let axes: &[usize] = if planar {
        &[0, 1, 5]
    } else {
        &[0, 1, 2, 3, 4, 5]
    };
    let moved = Mat::from_fn(element.rows.len(), axes.len(), |row, k| {
        let of = &element.rows[row];
        let direction = usize::try_from(of.direction).expect("no explicit rows");
        match (axes[k], direction) {
            (translation, _) if translation < 3 => f64::from(u8::from(translation == direction)),
            (rotation, _) if direction >= 3 => f64::from(u8::from(rotation == direction)),
            (rotation, _) => {
                let mut turn = [0.0; 3];
                turn[rotation - 3] = 1.0;
                let [x, y, z] = of.position;
                [
                    turn[1] * z - turn[2] * y,
                    turn[2] * x - turn[0] * z,
                    turn[0] * y - turn[1] * x,
                ][direction]
            }
        }
    });
    let mass = Mat::from_fn(axes.len(), axes.len(), |i, j| match (axes[i], axes[j]) {
        (a, b) if a < 3 || b < 3 => inertia.mass * f64::from(u8::from(a == b)),
        (a, b) => inertia.tensor[a - 3][b - 3],
    });
    let lower = mass.llt(Side::Lower).expect("a mass").L().to_owned();
    solve(&lower, &moved.transpose().to_owned())
        .transpose()
        .to_owned()
}

fn centre_of_mass_of(component: &Component, element: &Superelement) -> [f64; 3] {
    match component.dofs.len() > DENSE {
        true => element.origin,
        false => centre_of_mass(component).1,
    }
}

fn beside(blocks: &[Mat<f64>]) -> Mat<f64> {
    let columns: Vec<_> = blocks.iter().flat_map(|block| block.col_iter()).collect();
    Mat::from_fn(blocks[0].nrows(), columns.len(), |i, j| {
        columns[j][i] / columns[j].norm_l2()
    })
}

/// Whether forces act on each row.
pub fn attached(element: &Superelement) -> Vec<bool> {
    let role = |interface: usize| element.interfaces[interface].role;
    let rows = element.rows.iter();
    rows.map(|row| role(row.interface) == Role::Attachment)
        .collect()
}

/// One over the root of a row's flexibility with the inertia relieved, plus the square of its rigid motion over ω₁².
pub fn scale(component: &Component, element: &Superelement) -> Vec<f64> {
    if component.dofs.len() > DENSE {
        let modes = &element.modes;
        let rows = localization(component);
        let x = rigid_motions(component, element.origin);
        let seen = &rows * &x;
        let inertia = x.transpose() * times(&component.mass, x.as_ref());
        let moved = &seen * solve(&inertia, &seen.transpose().to_owned());
        return (0..rows.nrows())
            .map(|i| {
                let elastic: f64 = (modes.eigenvalues.iter().enumerate())
                    .map(|(k, square)| modes.interface_shapes[(i, k)].powi(2) / square)
                    .sum();
                let whole = element.residual.flexibility[(i, i)]
                    + elastic
                    + moved[(i, i)] / modes.eigenvalues[0];
                1.0 / whole.sqrt()
            })
            .collect();
    }
    let oracle = oracle(component, element);
    let l = &oracle.localization;
    let flexibility = l * &oracle.inverse * l.transpose();
    let seen = l * &oracle.rigid;
    let moved = match oracle.rigid.ncols() {
        0 => Mat::zeros(l.nrows(), l.nrows()),
        _ => {
            let inertia = oracle.rigid.transpose() * &oracle.mass * &oracle.rigid;
            &seen * solve(&inertia, &seen.transpose().to_owned())
        }
    };
    (0..l.nrows())
        .map(|i| 1.0 / (flexibility[(i, i)] + moved[(i, i)] / oracle.eigenvalues[0]).sqrt())
        .collect()
}

fn oracle(component: &Component, element: &Superelement) -> Oracle {
    match element.frame_kind {
        dcb_formats::superelement::FrameKind::MeanAxis => Oracle::of(component),
        dcb_formats::superelement::FrameKind::Given => Oracle::from_parts(
            dense(&component.stiffness),
            dense(&component.mass),
            Mat::zeros(component.dofs.len(), 0),
            localization(component),
        ),
    }
}

/// True errors of a superelement in a form between some rows, over the frequencies of a band.
pub fn truth(
    component: &Component,
    reduced: &Reduced,
    form: Compatibility,
    rows: &[usize],
    band: &FrequencyBand,
) -> Truth {
    let element = &reduced.superelement;
    let (whole, part) = (
        System::whole(component),
        System::reduced(component, reduced, form),
    );
    let scale = scale(component, element);
    let attached = attached(element);
    let forced: Vec<usize> = rows.iter().copied().filter(|row| attached[*row]).collect();
    let of = |row: usize| element.rows[row].interface;
    let norm = |h: &Mat<c64>, same: bool| -> f64 {
        let mut sum = 0.0;
        for (j, column) in forced.iter().enumerate() {
            for row in rows.iter().filter(|row| (of(**row) == of(*column)) == same) {
                sum += h[(*row, j)].norm_sqr() * (scale[*row] * scale[*column]).powi(2);
            }
        }
        sum.sqrt()
    };
    let several = rows.iter().any(|row| of(*row) != of(rows[0]));
    let (mut collocated, mut transfer) = (0.0_f64, 0.0_f64);
    for square in &band.squares {
        let exact = whole.response(*square, &forced);
        let off = part.response(*square, &forced) - &exact;
        collocated = collocated.max(norm(&off, true) / norm(&exact, true));
        if several {
            transfer = transfer.max(norm(&off, false) / norm(&exact, false));
        }
    }
    let small = whole.sparse.is_none();
    Truth {
        held: small.then(|| {
            let (exact, found) = (whole.held(&forced, &scale), part.held(&forced, &scale));
            let below = exact.iter().take_while(|value| **value < band.top());
            let errors = below
                .enumerate()
                .map(|(index, exact)| match found.get(index) {
                    Some(found) => ((found / exact).sqrt() - 1.0).abs(),
                    None => 1.0,
                });
            errors.fold(0.0, f64::max)
        }),
        fixed: small.then(|| static_error(component, reduced, rows, &forced, &scale)),
        collocated,
        transfer: several.then_some(transfer),
    }
}

fn static_error(
    component: &Component,
    reduced: &Reduced,
    rows: &[usize],
    forced: &[usize],
    scale: &[f64],
) -> f64 {
    let element = &reduced.superelement;
    let oracle = oracle(component, element);
    let l = &oracle.localization;
    let exact = l * &oracle.inverse * l.transpose();
    let modes = &element.modes;
    let flexible = Mat::from_fn(l.nrows(), modes.eigenvalues.len(), |i, k| {
        modes.interface_shapes[(i, k)] / modes.eigenvalues[k]
    });
    let found = l * &reduced.recovery.residual + flexible * modes.interface_shapes.transpose();
    let mut worst = 0.0_f64;
    for group in forced.iter().map(|row| element.rows[*row].interface) {
        let (mut off, mut whole) = (0.0, 0.0);
        for column in forced
            .iter()
            .filter(|row| element.rows[**row].interface == group)
        {
            for row in rows {
                let scale = scale[*row] * scale[*column];
                off += ((found[(*row, *column)] - exact[(*row, *column)]) * scale).powi(2);
                whole += (exact[(*row, *column)] * scale).powi(2);
            }
        }
        worst = worst.max(f64::sqrt(off / whole));
    }
    worst
}

/// One part in one form over one band.
#[derive(Debug)]
pub struct Outcome {
    /// Name of the part.
    pub name: &'static str,
    /// Modes kept.
    pub modes: usize,
    /// Form.
    pub form: Compatibility,
    /// Upper end of the band over the first frequency left out.
    pub share: f64,
    /// As it is.
    pub truth: Truth,
    /// As it is estimated.
    pub estimate: Estimate,
}

impl Outcome {
    /// Name, true error and bounds of every measure that is known on both sides.
    pub fn measures(&self) -> Vec<(&'static str, f64, Bracket)> {
        let mut measures = Vec::new();
        if let (Some(held), Some(bracket)) = (self.truth.held, self.estimate.held_frequency) {
            measures.push(("held", held, bracket));
        }
        if let Some(fixed) = self.truth.fixed {
            measures.push(("static", fixed, self.estimate.static_response));
        }
        measures.push((
            "collocated",
            self.truth.collocated,
            self.estimate.collocated.largest,
        ));
        if let (Some(transfer), Some(found)) = (self.truth.transfer, self.estimate.transfer) {
            measures.push(("transfer", transfer, found.largest));
        }
        measures
    }

    fn lines(&self) -> Vec<Value> {
        let of = |(measure, truth, bracket): (&str, f64, Bracket)| {
            json!({
                "part": self.name, "modes": self.modes, "form": self.form.name(), "band": self.share,
                "measure": measure, "true": truth, "lower": bracket.lower, "upper": bracket.upper,
            })
        };
        self.measures().into_iter().map(of).collect()
    }
}

/// Every form of a reduced part over the usual band and over one up to nine tenths of the first frequency left out.
pub fn outcomes(case: &Case, points: usize) -> Vec<Outcome> {
    let reduced = with(&case.component, &case.options);
    let element = &reduced.superelement;
    let first = element.modes.first_omitted_eigenvalue;
    let mut outcomes = Vec::new();
    for form in [Compatibility::Strong, Compatibility::Static] {
        let estimate = ErrorBounds::of(element, form).unwrap().expect("moments");
        let rows = estimate.attached_rows();
        let usual = estimate.usual_band(points).expect("a band");
        let wide = 0.81 * first;
        let wide = estimate.band(Some(wide / points.pow(2) as f64), wide, points);
        for band in [usual, wide] {
            outcomes.push(Outcome {
                name: case.name,
                modes: element.mode_count(),
                form,
                share: (band.top() / first).sqrt(),
                truth: truth(&case.component, &reduced, form, &rows, &band),
                estimate: estimate.over(&rows, &band, LOSS_FACTOR).unwrap(),
            });
        }
    }
    outcomes
}

/// A part with an interface reduction.
pub fn with_interface_modes() -> Case {
    let mut case = Case::new(
        "box, 8 of 12 interface modes",
        parts::steel_box([4, 1, 1], SolidElement::Hexahedron),
        6,
    );
    case.options.interface_modes = InterfaceModes::Softest(8);
    case
}

/// The raw lines, without the first, which is the machine's.
pub fn lines() -> Vec<Value> {
    let mut lines = Vec::new();
    let mut all = cases();
    all.push(with_interface_modes());
    for case in &all {
        lines.extend(outcomes(case, 100).iter().flat_map(Outcome::lines));
    }
    lines.extend(
        outcomes(&connecting_rod(), 12)
            .iter()
            .flat_map(Outcome::lines),
    );
    lines
}
