//! The primal form: stiffness, mass and damping over the displacements of frames, as Craig and Bampton's matrices have them.
//!
//! With α a rigid motion about the centre of mass, R_b that motion at the frames' rows, C η the modes and S ζ the attachments there,
//!
//! ```text
//! u_Γ = R_b α + C η + S ζ          α = R_b⁺ u_Γ + a'
//! ζ   = D⁻¹ Sᵀ F⁻¹ (u_Γ − R_b α − C η) + N w          D = diag(σ²),  F = S D⁻¹ Sᵀ,  S N = 0,  Nᵀ D N = 1
//! ```
//! which is one square transform from (u_Γ, a', η, w) to (α, η, ζ), where M = diag(m 1, J, 1, 1) and K = diag(0, ω², σ²). Without further columns F is F_res,
//! ζ = T_r⁻¹ g, and there is no w. The rigid motions are (R_b, 0, 0, 0), exactly.

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::Error;
use dcb_formats::component::Role;
use dcb_formats::mesh::Direction;
use dcb_formats::superelement::FrameKind;
use faer::Mat;
use nalgebra::DMatrix;

use crate::part::Part;
use crate::part::frames::Frame;
use crate::part::names::listed;

/// Largest condition number of F, scaled to a unit diagonal, that still leaves digits in K.
const CONDITION_LIMIT: f64 = 1e12;
/// Components of an eigenvector above this fraction of its largest one name the rows that depend on each other.
const NAMED_FRACTION: f64 = 0.3;

/// K, M and C, frames first.
#[derive(Debug)]
pub(crate) struct Primal {
    /// Frames, six coordinates each in their order: ux, uy, uz, rx, ry, rz.
    pub frames: Vec<Frame>,
    /// K, (N, N).
    pub stiffness: Mat<f64>,
    /// M, (N, N).
    pub mass: Mat<f64>,
    /// C, (N, N); `None` where nothing is damped.
    pub damping: Option<Mat<f64>>,
    /// Coordinates behind those of the frames: 6 of inertia relief, the free modes, further columns.
    pub modal_count: usize,
    /// R_b, (6 frames, 6): rigid motions about the centre of mass, translations first.
    pub rigid: Mat<f64>,
    /// Condition number of F, scaled to a unit diagonal.
    pub condition: f64,
}

impl Primal {
    /// Of a part whose attachments are frames of six independent rows.
    ///
    /// # Errors
    /// [`Error::File`] naming the rows where they aren't.
    pub(crate) fn of(part: &Part<'_>) -> Result<Self, Error> {
        let frames = attached_frames(part)?;
        let rows: Vec<usize> = frames
            .iter()
            .flat_map(|frame| frame.rows.iter().flatten().copied())
            .collect();
        let basis = &part.basis;
        let (n_b, n_k, q) = (rows.len(), basis.mode_count, basis.count());
        let r = q - n_k;
        if r < n_b {
            return Err(dependent(part, &rows));
        }
        let inverse = Mat::from_fn(r, r, |i, j| match i == j {
            true => 1.0 / basis.stiffness[n_k + i],
            false => 0.0,
        });
        let shapes = Mat::from_fn(n_b, r, |i, j| basis.rows[(rows[i], n_k + j)]);
        let flexibility = symmetrized(&shapes * &inverse * shapes.transpose());
        let (force, condition) = inverted(part, &rows, &flexibility)?;
        let to_attached = &inverse * shapes.transpose() * &force;
        let unseen = unseen(&inverse, &shapes, &to_attached, r - n_b)
            .ok_or_else(|| part.refused("the attachments have no eigenvalues".to_owned()))?;

        let rigid = rigid_motions(&frames);
        let (relief, seen) = split(&rigid);
        let modes = Mat::from_fn(n_b, n_k, |i, k| basis.rows[(rows[i], k)]);
        let of_modes = &to_attached * &modes;
        let of_rigid = &to_attached * &rigid;
        let of_frames = &to_attached * (Mat::<f64>::identity(n_b, n_b) - seen);
        let size = n_b + 6 + n_k + (r - n_b);
        let (at_relief, at_modes, at_unseen) = (n_b, n_b + 6, n_b + 6 + n_k);
        let transform = Mat::from_fn(6 + q, size, |i, j| match (i, j) {
            (i, j) if i < 6 && j < at_relief => relief[(i, j)],
            (i, j) if i < 6 + n_k => f64::from(u8::from(j == at_relief + i)),
            (i, j) if j < at_relief => of_frames[(i - 6 - n_k, j)],
            (i, j) if j < at_modes => -of_rigid[(i - 6 - n_k, j - at_relief)],
            (i, j) if j < at_unseen => -of_modes[(i - 6 - n_k, j - at_modes)],
            (i, j) => unseen[(i - 6 - n_k, j - at_unseen)],
        });
        let diagonal = |of: &[f64]| {
            let of = |i: usize| if i < 6 { 0.0 } else { of[i - 6] };
            let scaled = Mat::from_fn(6 + q, size, |i, j| of(i) * transform[(i, j)]);
            symmetrized(transform.transpose() * scaled)
        };
        let damped = basis.damping.iter().any(|value| *value > 0.0);
        Ok(Self {
            stiffness: diagonal(&basis.stiffness),
            mass: symmetrized(transform.transpose() * masses(part) * &transform),
            damping: damped.then(|| diagonal(&basis.damping)),
            modal_count: size - n_b,
            frames,
            rigid,
            condition,
        })
    }

    /// Coordinates of the frames.
    pub(crate) fn boundary_count(&self) -> usize {
        6 * self.frames.len()
    }

    /// N.
    pub(crate) fn count(&self) -> usize {
        self.mass.nrows()
    }

    /// Sizes, for people.
    pub(crate) fn summary(&self) -> String {
        format!(
            "K and M of {} coordinates: {} frames of six, then {} (six of inertia relief, then modes){}",
            self.count(),
            self.frames.len(),
            self.modal_count,
            match self.damping {
                Some(_) => "; C",
                None => "",
            }
        )
    }

    /// What shows that the form is right.
    pub(crate) fn rigid_note(&self) -> String {
        format!(
            "rigid motions are forceless: K R is {:.0e} of K; condition of the flexibility that was inverted: {:.0e}",
            self.rigid_residual(&self.stiffness),
            self.condition
        )
    }

    /// Largest entry of K R over the largest of K.
    pub(crate) fn rigid_residual(&self, stiffness: &Mat<f64>) -> f64 {
        let forces = stiffness.as_ref().subcols(0, self.boundary_count()) * &self.rigid;
        forces.norm_max() / stiffness.norm_max()
    }
}

/// Frames of the attachments, if each has its six rows.
fn attached_frames(part: &Part<'_>) -> Result<Vec<Frame>, Error> {
    let element = part.superelement;
    let attached = |interface: usize| element.interfaces[interface].role == Role::Attachment;
    let placeless = part.placeless.iter();
    let placeless: Vec<String> = placeless
        .filter(|row| attached(element.rows[**row].interface))
        .map(|row| element.row_name(*row))
        .collect();
    if !placeless.is_empty() {
        return Err(part.refused(format!(
            "has rows without a place, {}, and this target wants frames of six rows; reduce it with interfaces of kind `average` or `rigid`",
            listed(&placeless)
        )));
    }
    let frames = part.frames.iter();
    let frames: Vec<Frame> = frames
        .filter(|frame| frame.role == Role::Attachment)
        .cloned()
        .collect();
    if let Some(frame) = frames.iter().find(|frame| !frame.missing().is_empty()) {
        return Err(part.refused(format!(
            "interface {:?} has no row for {}, and this target wants frames of six rows (ux uy uz rx ry rz); reduce it with that interface as `average` or `rigid`, without `dofs`",
            frame.name,
            frame.missing().join(", ")
        )));
    }
    match frames.is_empty() {
        true => Err(part.refused(
            "has no interface on which forces act, and this target wants frames to attach to"
                .to_owned(),
        )),
        false => Ok(frames),
    }
}

/// diag(m 1, J, 1), with the couplings of a frame that isn't on mean axes.
fn masses(part: &Part<'_>) -> Mat<f64> {
    let (basis, inertia) = (&part.basis, &part.superelement.inertia);
    let coupled = part.superelement.frame_kind == FrameKind::Given;
    let i3 = &inertia.i3 * &basis.to_file;
    let of = |i: usize, j: usize| match (i, j) {
        (0..3, 0..3) | (6.., 6..) if i == j => match i {
            0..3 => basis.mass,
            _ => 1.0,
        },
        (3..6, 3..6) => basis.tensor[(i - 3, j - 3)],
        (0..3, 6..) if coupled => basis.l1[(i, j - 6)],
        (3..6, 6..) if coupled => i3[(i - 3, j - 6)],
        _ => 0.0,
    };
    let size = 6 + basis.count();
    Mat::from_fn(size, size, |i, j| of(i.min(j), i.max(j)))
}

/// R_b about the centre of mass.
fn rigid_motions(frames: &[Frame]) -> Mat<f64> {
    Mat::from_fn(6 * frames.len(), 6, |i, j| {
        let (frame, direction) = (&frames[i / 6], i % 6);
        match (direction < 3, j < 3) {
            (true, false) => -frame.arm.cross_matrix()[(direction, j - 3)],
            _ => f64::from(u8::from(direction == j)),
        }
    })
}

/// R_b⁺ and R_b R_b⁺, by orthogonal columns: what is rigid is seen as rigid to the last digit.
fn split(rigid: &Mat<f64>) -> (Mat<f64>, Mat<f64>) {
    let n_b = rigid.nrows();
    let of = DMatrix::from_fn(n_b, 6, |i, j| rigid[(i, j)]).qr();
    let (q, r) = (of.q(), of.r());
    let relief = r
        .solve_upper_triangular(&q.transpose())
        .unwrap_or_else(|| DMatrix::zeros(6, n_b));
    let seen = &q * q.transpose();
    (
        Mat::from_fn(6, n_b, |i, j| relief[(i, j)]),
        Mat::from_fn(n_b, n_b, |i, j| seen[(i, j)]),
    )
}

/// F⁻¹ and the condition number of F, scaled to a unit diagonal.
fn inverted(
    part: &Part<'_>,
    rows: &[usize],
    flexibility: &Mat<f64>,
) -> Result<(Mat<f64>, f64), Error> {
    let n_b = rows.len();
    let scale: Vec<f64> = (0..n_b).map(|i| 1.0 / flexibility[(i, i)].sqrt()).collect();
    if scale.iter().any(|scale| !scale.is_finite()) {
        return Err(dependent(part, rows));
    }
    let scaled = Mat::from_fn(n_b, n_b, |i, j| scale[i] * flexibility[(i, j)] * scale[j]);
    let (values, vectors) =
        symmetric_eigen(scaled.as_ref()).ok_or_else(|| dependent(part, rows))?;
    let (least, most) = (values[0], values[n_b - 1]);
    let condition = most / least;
    if !(least > 0.0 && condition <= CONDITION_LIMIT) {
        return Err(part.refused(format!(
            "rows {} depend on each other: the flexibility that the modes leave is singular to {:.0e}, and K is its inverse (condition {CONDITION_LIMIT:.0e} is the limit); keep fewer modes, or leave out one of the rows",
            named(part, rows, &vectors, 0),
            least.max(0.0) / most
        )));
    }
    let weighted = Mat::from_fn(n_b, n_b, |i, k| scale[i] * vectors[(i, k)] / values[k]);
    let back = Mat::from_fn(n_b, n_b, |k, j| vectors[(j, k)] * scale[j]);
    Ok((weighted * back, condition))
}

/// Fewer attachments than rows: which rows depend on each other.
fn dependent(part: &Part<'_>, rows: &[usize]) -> Error {
    let residual = &part.superelement.residual;
    let diagonal = |row: usize| residual.flexibility[(row, row)];
    let silent = rows.iter().filter(|row| diagonal(**row) <= 0.0);
    let silent: Vec<String> = silent.map(|row| part.superelement.row_name(*row)).collect();
    let which = match silent.is_empty() {
        false => listed(&silent),
        true => {
            let n_b = rows.len();
            let scaled = Mat::from_fn(n_b, n_b, |i, j| {
                let (i, j) = (rows[i], rows[j]);
                residual.flexibility[(i, j)] / (diagonal(i) * diagonal(j)).sqrt()
            });
            match symmetric_eigen(symmetrized(scaled).as_ref()) {
                Some((_, vectors)) => named(part, rows, &vectors, 0),
                None => "of its interfaces".to_owned(),
            }
        }
    };
    part.refused(format!(
        "{} attachment coordinates for {} rows: rows {which} have nothing of their own beyond the {} modes, and this target wants independent rows; keep fewer modes (at least {} rows need an attachment), or leave out interfaces",
        part.basis.count() - part.basis.mode_count,
        rows.len(),
        part.basis.mode_count,
        rows.len()
    ))
}

/// Rows that take part in an eigenvector.
fn named(part: &Part<'_>, rows: &[usize], vectors: &Mat<f64>, vector: usize) -> String {
    let entries = (0..rows.len()).map(|i| vectors[(i, vector)].abs());
    let most = entries.clone().fold(0.0, f64::max);
    let names = entries.enumerate();
    let names: Vec<String> = names
        .filter(|(_, entry)| *entry > NAMED_FRACTION * most)
        .map(|(i, _)| part.superelement.row_name(rows[i]))
        .collect();
    listed(&names)
}

/// N: combinations of attachments that no row sees, of unit stiffness. The eigenvectors of 1 − D^(-½) Sᵀ F⁻¹ S D^(-½) whose value is 1.
fn unseen(
    inverse: &Mat<f64>,
    shapes: &Mat<f64>,
    to_attached: &Mat<f64>,
    count: usize,
) -> Option<Mat<f64>> {
    let r = inverse.nrows();
    if count == 0 {
        return Some(Mat::zeros(r, 0));
    }
    let root = |i: usize| inverse[(i, i)].sqrt();
    let seen = to_attached * shapes;
    let projector = Mat::from_fn(r, r, |i, j| {
        f64::from(u8::from(i == j)) - seen[(i, j)] * root(j) / root(i)
    });
    let (_, vectors) = symmetric_eigen(symmetrized(projector).as_ref())?;
    Some(Mat::from_fn(r, count, |i, j| {
        root(i) * vectors[(i, r - count + j)]
    }))
}

/// Names of the coordinates of frames, in their order.
pub(crate) fn boundary(frames: &[Frame]) -> Vec<(usize, Direction)> {
    let all = |frame: usize| Direction::ALL.map(|direction| (frame, direction));
    (0..frames.len()).flat_map(all).collect()
}
