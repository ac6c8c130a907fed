//! Whether a component is symmetric about a plane, as far as its interfaces and its inertia can tell.

use dcb_formats::superelement::Superelement;
use faer::Mat;

use super::Normal;
use super::parity::{Norms, Parities, Parity, cosine};
use crate::Asymmetry;

/// The largest coupling found, and between what.
struct Largest {
    coupling: f64,
    between: Option<(String, String)>,
}

impl Largest {
    fn note(&mut self, value: f64, between: impl FnOnce() -> (String, String)) {
        let size = if value.is_nan() {
            f64::INFINITY
        } else {
            value.abs()
        };
        if size > self.coupling {
            self.coupling = size;
            self.between = Some(between());
        }
    }
}

/// Checks that coordinates in the plane and out of it don't couple.
///
/// # Errors
/// The largest coupling, if that is more than the tolerance.
pub(super) fn refuse_asymmetric(
    whole: &Superelement,
    normal: Normal,
    norms: &Norms,
    parities: &Parities,
    tolerance: f64,
) -> Result<(), Asymmetry> {
    let mut largest = Largest {
        coupling: 0.0,
        between: None,
    };
    let check = Check {
        whole,
        normal,
        norms,
        parities,
        all: parities.of_basis(),
    };
    check.elastic(&mut largest);
    check.inertia(&mut largest);
    check.stiffening(&mut largest);
    match largest.between {
        Some((first, second)) if largest.coupling > tolerance => Err(Asymmetry {
            body: whole.name.clone(),
            normal: normal.name(),
            coupling: largest.coupling,
            tolerance,
            first,
            second,
        }),
        _ => Ok(()),
    }
}

struct Check<'a> {
    whole: &'a Superelement,
    normal: Normal,
    norms: &'a Norms,
    parities: &'a Parities,
    /// Of every coordinate.
    all: Vec<Parity>,
}

impl Check<'_> {
    /// Rows against modes and further columns, rows against rows.
    fn elastic(&self, largest: &mut Largest) {
        let Self {
            whole,
            norms,
            parities,
            ..
        } = self;
        let (n_k, n_b) = (whole.mode_count(), whole.rows.len());
        for (row, of_row) in parities.rows.iter().enumerate() {
            let mut note = |coordinate: usize, shape: f64| {
                if *of_row != self.all[coordinate] {
                    let value = cosine(shape, norms.rows[row], norms.energy[coordinate]);
                    largest.note(value, || (self.row_name(row), self.name(coordinate)));
                }
            };
            for k in 0..n_k {
                note(k, whole.modes.interface_shapes[(row, k)]);
            }
            for column in 0..n_b {
                note(n_k + column, whole.residual.flexibility[(row, column)]);
            }
            if let Some(enrichment) = &whole.enrichment {
                for j in 0..enrichment.interface_shapes.ncols() {
                    note(n_k + n_b + j, enrichment.interface_shapes[(row, j)]);
                }
            }
        }
        match &whole.enrichment {
            Some(enrichment) => {
                self.unlike(&enrichment.reduced_mass, &norms.mass, largest);
                self.unlike(&enrichment.reduced_stiffness, &norms.energy, largest);
            }
            None => {
                let mass = &whole.residual.mass;
                for i in 0..n_b {
                    for j in 0..n_b {
                        if parities.rows[i] != parities.rows[j] {
                            let of = |row: usize| norms.mass[n_k + row];
                            largest.note(cosine(mass[(i, j)], of(i), of(j)), || {
                                (self.row_name(i), self.row_name(j))
                            });
                        }
                    }
                }
            }
        }
    }

    fn inertia(&self, largest: &mut Largest) {
        let inertia = &self.whole.inertia;
        let masses = &self.norms.mass;
        let [a, b, c] = self.normal.axes();
        let trace: f64 = (0..3).map(|axis| inertia.tensor[axis][axis]).sum();
        for axis in [a, b] {
            largest.note(cosine(inertia.tensor[axis][c], trace, 1.0), || {
                (
                    "the axes in it".to_owned(),
                    "its normal by products of inertia".to_owned(),
                )
            });
        }
        for (k, parity) in self.all.iter().enumerate() {
            let mut note = |value: f64, size: f64, with: &str| {
                let value = cosine(value, masses[k], size);
                largest.note(value, || (self.name(k), with.to_owned()));
            };
            let first = &inertia.i1[k];
            let (mass, moment) = (inertia.mass.sqrt(), trace.sqrt());
            match parity {
                Parity::In => {
                    for axis in [a, b] {
                        note(
                            first[axis][c],
                            moment,
                            "the products of inertia across the plane",
                        );
                        note(inertia.i3[(axis, k)], moment, "rotation out of the plane");
                    }
                    note(inertia.l1[(c, k)], mass, "translation out of the plane");
                }
                Parity::Out => {
                    note(first[c][c], moment, "the inertia about the normal");
                    note(inertia.i3[(c, k)], moment, "rotation in the plane");
                    for axis in [a, b] {
                        note(inertia.l1[(axis, k)], mass, "translation in the plane");
                    }
                }
            }
        }
        // xx, yy, zz, xy, yz, zx: products with the normal are those of c and the axis after it, and of the one before it and c.
        let with_normal = [3 + c, 3 + (c + 2) % 3];
        self.unlike(&inertia.l3[c], masses, largest);
        self.unlike(&inertia.i2[c], masses, largest);
        for axis in [a, b] {
            self.both_in(&inertia.l3[axis], masses, largest);
        }
        for pair in with_normal {
            self.both_in(&inertia.i2[pair], masses, largest);
        }
    }

    fn stiffening(&self, largest: &mut Largest) {
        let stiffening = &self.whole.stiffening;
        let [.., c] = self.normal.axes();
        let sizes = &self.norms.energy;
        let relative = |layers: &[Mat<f64>]| -> Vec<Mat<f64>> {
            let scaled = |layer: &Mat<f64>| {
                Mat::from_fn(layer.nrows(), layer.ncols(), |k, l| {
                    cosine(layer[(k, l)], sizes[k], sizes[l])
                })
            };
            let layers: Vec<Mat<f64>> = layers.iter().map(scaled).collect();
            let most = layers
                .iter()
                .map(|layer| layer.norm_max())
                .fold(0.0, f64::max);
            let unit = if most > 0.0 { most } else { 1.0 };
            layers
                .iter()
                .map(|layer| faer::Scale(1.0 / unit) * layer)
                .collect()
        };
        let ones = vec![1.0; sizes.len()];
        if let Some(layer) = relative(&stiffening.centrifugal).get(c) {
            self.unlike(layer, &ones, largest);
        }
        for (layer, parity) in relative(&stiffening.interface)
            .iter()
            .zip(&self.parities.rows)
        {
            match parity {
                Parity::In => self.unlike(layer, &ones, largest),
                Parity::Out => self.both_in(layer, &ones, largest),
            }
        }
    }

    /// Entries between coordinates in the plane and out of it.
    fn unlike(&self, matrix: &Mat<f64>, sizes: &[f64], largest: &mut Largest) {
        self.entries(matrix, sizes, largest, |one, other| one != other);
    }

    /// Entries between coordinates in the plane.
    fn both_in(&self, matrix: &Mat<f64>, sizes: &[f64], largest: &mut Largest) {
        self.entries(matrix, sizes, largest, |one, other| {
            one == Parity::In && other == Parity::In
        });
    }

    fn entries(
        &self,
        matrix: &Mat<f64>,
        sizes: &[f64],
        largest: &mut Largest,
        counts: fn(Parity, Parity) -> bool,
    ) {
        for k in 0..matrix.ncols() {
            for l in 0..matrix.nrows() {
                if counts(self.all[k], self.all[l]) {
                    largest.note(cosine(matrix[(l, k)], sizes[k], sizes[l]), || {
                        (self.name(l), self.name(k))
                    });
                }
            }
        }
    }

    /// Name of a coordinate.
    fn name(&self, coordinate: usize) -> String {
        let n_k = self.whole.mode_count();
        match coordinate.checked_sub(n_k) {
            None => format!("mode {}", coordinate + 1),
            Some(row) if row < self.whole.rows.len() => self.row_name(row),
            Some(place) => {
                let place = place - self.whole.rows.len();
                let names = self.whole.enrichment.iter().map(|further| &further.names);
                let name = names.flatten().nth(place);
                name.map_or_else(
                    || format!("further column {}", place + 1),
                    |name| format!("further column {name:?}"),
                )
            }
        }
    }

    fn row_name(&self, row: usize) -> String {
        let of = &self.whole.rows[row];
        let direction = usize::try_from(of.direction).ok();
        let direction = direction.and_then(dcb_formats::mesh::Direction::from_index);
        let interface = &self.whole.interfaces[of.interface].name;
        match (direction, of.node) {
            (Some(direction), node) if node >= 0 => {
                format!("{interface}/{} at node {node}", direction.name())
            }
            (Some(direction), _) => format!("{interface}/{}", direction.name()),
            (None, _) => format!("row {} of {interface}", row + 1),
        }
    }
}
