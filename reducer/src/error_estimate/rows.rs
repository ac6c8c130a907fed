//! The rows of a superelement in units of their own flexibility, as a study scales them: translations and rotations count alike.

use dcb_formats::Superelement;
use dcb_formats::component::Role;
use dcb_formats::superelement::Moments;
use faer::Mat;

/// Scales of boundary rows and further columns, and the motions that the modes and the frame give the rows.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    /// One over the root of a row's flexibility, (n_b), then of a further column's, (n_x); zero where nothing moves.
    pub scale: Vec<f64>,
    /// Whether forces act on a row, (n_b).
    pub attached: Vec<bool>,
    /// Interface of a row, (n_b).
    pub interface: Vec<usize>,
    /// Flexibility with the inertia relieved and no mode kept over that with the rigid motions, (n_b).
    pub elastic_flexibility: Vec<f64>,
    /// ω² of motions that are exact: zeros of rigid and loose ones, then the elastic modes'.
    pub poles: Vec<f64>,
    /// How many of them are zero.
    pub zero_count: usize,
    /// Relative bounds of what they are off.
    pub pole_errors: Vec<f64>,
    /// M-orthonormal motions at the rows, scaled, (n_b, poles).
    pub shapes: Mat<f64>,
    /// The eigenvalue that rigid motions are weighed with.
    pub first_elastic: f64,
}

impl Rows {
    pub(super) fn of(element: &Superelement, moments: &Moments) -> Self {
        let (n_b, n) = (element.boundary_row_count(), moments.first.nrows());
        let modes = &element.modes;
        let loose = modes.eigenvalues.iter().take_while(|v| **v == 0.0).count();
        let first_elastic = (modes.eigenvalues.get(loose).copied())
            .unwrap_or(moments.eigenvalue_bound.min(f64::MAX));
        let rigid = moments.rigid_shapes.ncols();
        let zero_count = rigid + loose;
        let mut poles = vec![0.0; zero_count];
        poles.extend(&modes.eigenvalues[loose..]);
        let mut pole_errors = vec![0.0; rigid];
        pole_errors.extend(&moments.eigenvalue_errors);
        let shape = |row: usize, pole: usize| match pole < rigid {
            true => moments.rigid_shapes[(row, pole)],
            false => modes.interface_shapes[(row, pole - rigid)],
        };
        let elastic = |row: usize| -> f64 {
            let of_modes: f64 = (zero_count..poles.len())
                .map(|pole| shape(row, pole).powi(2) / poles[pole])
                .sum();
            moments.first[(row, row)] + of_modes
        };
        let whole = |row: usize| -> f64 {
            let moved: f64 = (0..zero_count).map(|pole| shape(row, pole).powi(2)).sum();
            elastic(row) + moved / first_elastic
        };
        let scale: Vec<f64> = (0..n)
            .map(|i| {
                let flexibility = if i < n_b {
                    whole(i)
                } else {
                    moments.first[(i, i)]
                };
                if flexibility > 0.0 {
                    1.0 / flexibility.sqrt()
                } else {
                    0.0
                }
            })
            .collect();
        Self {
            attached: (element.rows.iter())
                .map(|row| element.interfaces[row.interface].role == Role::Attachment)
                .collect(),
            interface: element.rows.iter().map(|row| row.interface).collect(),
            elastic_flexibility: (0..n_b)
                .map(|row| elastic(row) * scale[row].powi(2))
                .collect(),
            shapes: Mat::from_fn(n_b, poles.len(), |row, pole| scale[row] * shape(row, pole)),
            scale,
            poles,
            zero_count,
            pole_errors,
            first_elastic,
        }
    }

    /// n_b.
    pub(super) fn count(&self) -> usize {
        self.attached.len()
    }

    /// Scaled from both sides; of boundary rows, or of these and further columns.
    pub(super) fn scaled_square(&self, matrix: &Mat<f64>) -> Mat<f64> {
        Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
            self.scale[i] * matrix[(i, j)] * self.scale[j]
        })
    }

    /// Columns of forces in the units that belong to the scale, (n, k).
    pub(super) fn scaled_amounts(&self, columns: &Mat<f64>) -> Mat<f64> {
        Mat::from_fn(self.scale.len(), columns.ncols(), |i, j| {
            match (i < columns.nrows(), self.scale[i]) {
                (true, scale) if scale > 0.0 => columns[(i, j)] / scale,
                _ => 0.0,
            }
        })
    }

    /// What further columns do to the boundary rows, (n_b, n_x), scaled from both sides.
    pub(super) fn scaled_further(&self, shapes: &Mat<f64>) -> Mat<f64> {
        let n_b = self.count();
        Mat::from_fn(n_b, shapes.ncols(), |i, j| {
            self.scale[i] * shapes[(i, j)] * self.scale[n_b + j]
        })
    }
}
