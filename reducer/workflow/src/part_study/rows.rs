//! The rows of L_b on which forces act, scaled so that translations and rotations can be compared.

use std::ops::Range;

use faer::{Mat, MatRef};

use dcb_reducer::model::localization::Localization;

/// Rows that forces act on, interface by interface, each in units of its own flexibility.
#[derive(Clone, Debug)]
pub struct InterfaceRows {
    /// Their places among all rows of L_b.
    pub places: Vec<usize>,
    /// Factor of each row: one over the root of its flexibility, zero for a row that nothing moves.
    pub scale: Vec<f64>,
    /// M-orthonormal rigid motions at the rows, scaled, (m, r).
    pub rigid: Mat<f64>,
    /// Names of the interfaces that have such rows.
    pub interfaces: Vec<String>,
    /// The rows of each of them.
    pub groups: Vec<Range<usize>>,
}

impl InterfaceRows {
    /// The rows of a part. `flexibility` is that of every row of L_b, with inertia relieved and no scale, (n_b, n_b);
    /// `rigid` the M-orthonormal rigid motions at every row, (n_b, r), which count as much as a spring of `eigenvalue` times the mass.
    pub fn of(
        localization: &Localization,
        flexibility: MatRef<'_, f64>,
        rigid: MatRef<'_, f64>,
        eigenvalue: f64,
    ) -> Self {
        let places: Vec<usize> = (0..localization.len())
            .filter(|row| localization.is_attachment(*row))
            .collect();
        let scale: Vec<f64> = (places.iter())
            .map(|row| {
                let moved: f64 = (0..rigid.ncols()).map(|k| rigid[(*row, k)].powi(2)).sum();
                match flexibility[(*row, *row)] + moved / eigenvalue {
                    whole if whole > 0.0 => 1.0 / whole.sqrt(),
                    _ => 0.0,
                }
            })
            .collect();
        let (mut interfaces, mut groups) = (Vec::new(), Vec::new());
        let interface = |row: usize| localization.rows[places[row]].interface;
        let mut first = 0;
        while first < places.len() {
            let end = (first..places.len())
                .find(|row| interface(*row) != interface(first))
                .unwrap_or(places.len());
            interfaces.push(localization.interfaces[interface(first)].name.clone());
            groups.push(first..end);
            first = end;
        }
        let mut rows = Self {
            places,
            scale,
            rigid: Mat::zeros(0, 0),
            interfaces,
            groups,
        };
        rows.rigid = rows.scaled(rigid);
        rows
    }

    /// m, the number of rows.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// These rows of columns over all rows of L_b, scaled, (m, k).
    pub fn scaled(&self, columns: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(self.len(), columns.ncols(), |i, j| {
            self.scale[i] * columns[(self.places[i], j)]
        })
    }

    /// These rows and columns of a matrix over all rows of L_b, scaled from both sides, (m, m).
    pub fn scaled_square(&self, matrix: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(self.len(), self.len(), |i, j| {
            self.scale[i] * matrix[(self.places[i], self.places[j])] * self.scale[j]
        })
    }

    /// These rows of columns of forces over all rows of L_b in the units that belong to the scale, (m, k).
    pub fn unscaled_forces(&self, columns: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(self.len(), columns.ncols(), |i, j| match self.scale[i] {
            0.0 => 0.0,
            scale => columns[(self.places[i], j)] / scale,
        })
    }
}
