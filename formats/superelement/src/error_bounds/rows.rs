//! The rows of a superelement in units of their own flexibility, as a study scales them: translations and rotations count alike. Where it is made for some
//! forces only, these take the place of their interfaces' rows ([`Ports`]).

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::Superelement;
use dcb_formats::component::Role;
use dcb_formats::superelement::Moments;
use faer::Mat;

use super::ports::Ports;

/// Flexibilities below this fraction of the largest belong to dependent forces.
const DEPENDENT: f64 = 1e-12;

/// Scales of boundary rows and further columns, and the motions that the modes and the frame give the rows.
pub(super) struct Rows {
    /// One over the root of a file row's flexibility, (n_b), then of a further column's, (n_x); zero where nothing moves.
    file_scale: Vec<f64>,
    /// Ports in place of the file's rows, which are n_b otherwise.
    ports: Option<Ports>,
    /// The scale of a row; 1 for a force on several rows of the file, (n_b).
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
        let rows = Self {
            attached: (element.rows.iter())
                .map(|row| element.interfaces[row.interface].role == Role::Attachment)
                .collect(),
            interface: element.rows.iter().map(|row| row.interface).collect(),
            elastic_flexibility: (0..n_b)
                .map(|row| elastic(row) * scale[row].powi(2))
                .collect(),
            shapes: Mat::from_fn(n_b, poles.len(), |row, pole| scale[row] * shape(row, pole)),
            scale: scale[..n_b].to_vec(),
            file_scale: scale,
            ports: None,
            poles,
            zero_count,
            pole_errors,
            first_elastic,
        };
        match &moments.loaded {
            Some(loaded) => rows.through(&loaded.forces, moments),
            None => rows,
        }
    }

    /// The same with forces in place of the rows that they act on.
    fn through(self, forces: &Mat<f64>, moments: &Moments) -> Self {
        let ports = Ports::of(forces, &self.file_scale, &self.interface, &self.attached);
        let (n_b, count) = (self.interface.len(), ports.count());
        let columns = ports.over(n_b);
        let shapes = columns.transpose() * &self.shapes;
        let first = self.scaled(&moments.first.get(..n_b, ..n_b).to_owned());
        let beyond = columns.transpose() * first * &columns;
        let elastic = |row: usize| -> f64 {
            let of_modes: f64 = (self.zero_count..self.poles.len())
                .map(|pole| shapes[(row, pole)].powi(2) / self.poles[pole])
                .sum();
            beyond[(row, row)] + of_modes
        };
        let scale = |port: usize| ports.rows[port].map_or(1.0, |row| self.file_scale[row]);
        Self {
            elastic_flexibility: (0..count).map(elastic).collect(),
            scale: (0..count).map(scale).collect(),
            attached: ports.attached.clone(),
            interface: ports.interface.clone(),
            shapes,
            ports: Some(ports),
            ..self
        }
    }

    /// Forces of unit amount on the file's rows, one for each row here, (n_b of the file, n_b).
    pub(super) fn forces(&self) -> Mat<f64> {
        let Some(ports) = &self.ports else {
            return Mat::identity(self.count(), self.count());
        };
        let rows = self.file_scale.len() + ports.count() - ports.columns.ncols();
        Mat::from_fn(rows, self.count(), |i, j| match self.scale[j] {
            0.0 => f64::from(u8::from(ports.rows[j] == Some(i))),
            scale => self.file_scale[i] * ports.columns[(i, j)] / scale,
        })
    }

    /// How many rows an interface has here, and in the file.
    pub(super) fn counts(&self, interface: usize, element: &Superelement) -> (usize, usize) {
        let own = self.interface.iter().filter(|of| **of == interface);
        // Rows that nothing moves can't be loaded.
        let rows = element.rows.iter().zip(&self.file_scale);
        let all = rows.filter(|(row, scale)| row.interface == interface && **scale > 0.0);
        (own.count(), all.count())
    }

    /// n_b.
    pub(super) fn count(&self) -> usize {
        self.attached.len()
    }

    /// The file's matrix scaled from both sides; of boundary rows, or of these and further columns.
    pub(super) fn scaled(&self, matrix: &Mat<f64>) -> Mat<f64> {
        Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
            self.file_scale[i] * matrix[(i, j)] * self.file_scale[j]
        })
    }

    /// A scaled matrix of the file's rows, and further columns, between the rows here.
    pub(super) fn seen(&self, scaled: Mat<f64>) -> Mat<f64> {
        match &self.ports {
            Some(ports) => {
                let columns = ports.over(scaled.nrows());
                columns.transpose() * scaled * columns
            }
            None => scaled,
        }
    }

    /// Bounds of what each row is off, of the file's and of further columns, for the rows here: no combination is off by more than the sum.
    pub(super) fn seen_roots(&self, roots: Vec<f64>) -> Vec<f64> {
        match &self.ports {
            Some(ports) => (ports.columns.col_iter())
                .map(|column| column.iter().zip(&roots).map(|(w, r)| w.abs() * r).sum())
                .collect(),
            None => roots,
        }
    }

    /// Columns of forces on the file's rows, and of further columns, as amounts of the rows here, (n, k): static shapes of other forces than these are
    /// combinations of theirs. `flexibility` is the file's, L G_res Lᵀ. `None` for numbers that aren't finite.
    pub(super) fn scaled_amounts(
        &self,
        columns: &Mat<f64>,
        flexibility: &Mat<f64>,
    ) -> Option<Mat<f64>> {
        let n = self.file_scale.len();
        let scaled = Mat::from_fn(n, columns.ncols(), |i, j| {
            match (i < columns.nrows(), self.file_scale[i]) {
                (true, scale) if scale > 0.0 => columns[(i, j)] / scale,
                _ => 0.0,
            }
        });
        let Some(ports) = &self.ports else {
            return Some(scaled);
        };
        let (n_b, count) = (flexibility.nrows(), ports.count());
        let acting: Vec<usize> = (0..count).filter(|port| self.attached[*port]).collect();
        let all = ports.over(n_b);
        let forces = Mat::from_fn(n_b, acting.len(), |i, j| all[(i, acting[j])]);
        let answers = forces.transpose() * self.scaled(flexibility);
        let own = &answers * &forces;
        let (values, vectors) = symmetric_eigen(symmetrized(own.as_ref()).as_ref())?;
        let limit = DEPENDENT * values.last().copied().unwrap_or(0.0);
        let asked = vectors.transpose() * (&answers * scaled.subrows(0, n_b));
        let shared = Mat::from_fn(values.len(), columns.ncols(), |k, j| {
            match values[k] > limit {
                true => asked[(k, j)] / values[k],
                false => 0.0,
            }
        });
        let amounts = vectors * shared;
        let place = |port: usize| acting.iter().position(|own| *own == port);
        Some(Mat::from_fn(
            count + n - n_b,
            columns.ncols(),
            |i, j| match (i < count).then(|| place(i)) {
                None => scaled[(n_b + i - count, j)],
                Some(Some(k)) => amounts[(k, j)],
                Some(None) => 0.0,
            },
        ))
    }

    /// Displacements of the rows by further columns, (n_b, n_x), scaled from both sides.
    pub(super) fn scaled_further(&self, shapes: &Mat<f64>) -> Mat<f64> {
        let n_b = shapes.nrows();
        let scaled = Mat::from_fn(n_b, shapes.ncols(), |i, j| {
            self.file_scale[i] * shapes[(i, j)] * self.file_scale[n_b + j]
        });
        match &self.ports {
            Some(ports) => ports.over(n_b).transpose() * scaled,
            None => scaled,
        }
    }
}
