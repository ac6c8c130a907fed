//! Superelements with one dataset changed: which changes are noticed, and by whom.
//!
//! Each dataset is set to zero, negated, made 10 and a million times as large, permuted, transposed, and changed by 1 % in its largest entry (and
//! the one that mirrors it). The file is written and read as any other; then the identities of a load and of `reduce verify` are
//! asked.

use dcb_formats::Superelement;
use dcb_formats::dcb::{Contents, SuperelementFile, WriteOptions, write_superelement};
use dcb_formats::identities;
use faer::{Mat, Scale};

/// What is done to a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// All entries are zero.
    Zero,
    /// All signs are turned.
    Negated,
    /// Ten times as large.
    Tenfold,
    /// A million times as large.
    Millionfold,
    /// Entries, or columns, moved on by one place.
    Permuted,
    /// Rows and columns exchanged.
    Transposed,
    /// The largest entry is 1 % larger.
    OneEntry,
}

impl Change {
    /// All of them, with what the page calls them.
    pub const ALL: [(Self, &'static str); 7] = [
        (Self::Zero, "zero"),
        (Self::Negated, "negated"),
        (Self::Tenfold, "×10"),
        (Self::Millionfold, "×10⁶"),
        (Self::Permuted, "permuted"),
        (Self::Transposed, "transposed"),
        (Self::OneEntry, "one entry"),
    ];

    fn of(self, layers: &[Mat<f64>]) -> Vec<Mat<f64>> {
        let scaled = |by: f64| layers.iter().map(|layer| layer * Scale(by)).collect();
        match self {
            Self::Zero => scaled(0.0),
            Self::Negated => scaled(-1.0),
            Self::Tenfold => scaled(10.0),
            Self::Millionfold => scaled(1e6),
            Self::Permuted => layers.iter().map(rotated).collect(),
            Self::Transposed => layers
                .iter()
                .map(|layer| match layer.nrows() == layer.ncols() {
                    true => layer.transpose().to_owned(),
                    false => layer.clone(),
                })
                .collect(),
            Self::OneEntry => one_entry(layers),
        }
    }
}

/// Columns, or the entries of a single one, moved on by one place.
fn rotated(layer: &Mat<f64>) -> Mat<f64> {
    let (rows, columns) = (layer.nrows(), layer.ncols());
    Mat::from_fn(rows, columns, |i, j| match columns {
        1 => layer[((i + 1) % rows, 0)],
        _ => layer[(i, (j + 1) % columns)],
    })
}

fn one_entry(layers: &[Mat<f64>]) -> Vec<Mat<f64>> {
    let mut changed = layers.to_vec();
    let entries = layers.iter().enumerate().flat_map(|(index, layer)| {
        let places = (0..layer.ncols()).flat_map(move |j| (0..layer.nrows()).map(move |i| (i, j)));
        places.map(move |place| (index, place, layer[place].abs()))
    });
    let largest = entries.max_by(|a, b| a.2.total_cmp(&b.2));
    if let Some((index, (i, j), _)) = largest {
        let layer = &mut changed[index];
        let mirrors =
            layer.nrows() == layer.ncols() && layer[(i, j)].abs() == layer[(j, i)].abs() && i != j;
        layer[(i, j)] *= 1.01;
        if mirrors {
            layer[(j, i)] *= 1.01;
        }
    }
    changed
}

type Layers = Vec<Mat<f64>>;

/// A dataset as matrices.
pub struct Dataset {
    /// Path in the file.
    pub path: &'static str,
    take: fn(&Superelement) -> Layers,
    put: fn(&mut Superelement, Layers),
}

fn column(values: &[f64]) -> Layers {
    vec![Mat::from_fn(values.len(), 1, |i, _| values[i])]
}

fn values(layers: &[Mat<f64>]) -> Vec<f64> {
    layers
        .iter()
        .flat_map(|layer| layer.col_as_slice(0).to_vec())
        .collect()
}

fn block(block: &[[f64; 3]; 3]) -> Mat<f64> {
    Mat::from_fn(3, 3, |a, b| block[a][b])
}

fn array(layer: &Mat<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|a| std::array::from_fn(|b| layer[(a, b)]))
}

fn point(layer: &Mat<f64>, row: usize) -> [f64; 3] {
    std::array::from_fn(|axis| layer[(row, axis)])
}

macro_rules! matrices {
    ($path:literal, $it:ident, $place:expr) => {
        Dataset {
            path: $path,
            take: |$it| vec![$place.clone()],
            put: |$it, mut layers| $place = layers.remove(0),
        }
    };
}

macro_rules! lists {
    ($path:literal, $it:ident, $place:expr) => {
        Dataset {
            path: $path,
            take: |$it| column(&$place),
            put: |$it, layers| $place = values(&layers),
        }
    };
}

macro_rules! of_part {
    ($path:literal, $part:ident, $field:ident) => {
        Dataset {
            path: $path,
            take: |it| it.$part.iter().map(|part| part.$field.clone()).collect(),
            put: |it, mut layers| {
                if let Some(part) = &mut it.$part {
                    part.$field = layers.remove(0);
                }
            },
        }
    };
}

macro_rules! of_loads {
    ($path:literal, $field:ident) => {
        Dataset {
            path: $path,
            take: |it| {
                it.loads
                    .iter()
                    .flat_map(|load| column(&load.$field))
                    .collect()
            },
            put: |it, layers| {
                for (load, layer) in it.loads.iter_mut().zip(layers) {
                    let entries = values(&[layer]);
                    load.$field.copy_from_slice(&entries);
                }
            },
        }
    };
}

/// Every dataset of numbers that the dynamics reads.
pub fn datasets() -> Vec<Dataset> {
    vec![
        Dataset {
            path: "/interfaces/positions",
            take: |it| {
                let places = &it.interfaces;
                vec![Mat::from_fn(places.len(), 3, |i, axis| {
                    places[i].position[axis]
                })]
            },
            put: |it, layers| {
                for (index, interface) in it.interfaces.iter_mut().enumerate() {
                    interface.position = point(&layers[0], index);
                }
            },
        },
        Dataset {
            path: "/interfaces/orientations",
            take: |it| {
                it.interfaces
                    .iter()
                    .map(|frame| block(&frame.orientation))
                    .collect()
            },
            put: |it, layers| {
                for (interface, layer) in it.interfaces.iter_mut().zip(&layers) {
                    interface.orientation = array(layer);
                }
            },
        },
        Dataset {
            path: "/interfaces/row_positions",
            take: |it| {
                vec![Mat::from_fn(it.rows.len(), 3, |i, axis| {
                    it.rows[i].position[axis]
                })]
            },
            put: |it, layers| {
                for (index, row) in it.rows.iter_mut().enumerate() {
                    row.position = point(&layers[0], index);
                }
            },
        },
        lists!("/modes/eigenvalues", it, it.modes.eigenvalues),
        lists!("/modes/damping", it, it.modes.damping),
        matrices!("/modes/interface_shapes", it, it.modes.interface_shapes),
        matrices!("/residual/flexibility", it, it.residual.flexibility),
        matrices!("/residual/mass", it, it.residual.mass),
        lists!("/residual/mass_diagonal0", it, it.residual.mass_diagonal0),
        matrices!("/residual/transform", it, it.residual.transform),
        lists!("/residual/sigma2", it, it.residual.sigma_squared),
        Dataset {
            path: "/residual/output_shapes",
            take: |it| it.residual.output_shapes.iter().cloned().collect(),
            put: |it, layers| it.residual.output_shapes = layers.into_iter().next(),
        },
        Dataset {
            path: "/inertia/mass",
            take: |it| column(&[it.inertia.mass]),
            put: |it, layers| it.inertia.mass = values(&layers)[0],
        },
        Dataset {
            path: "/inertia/tensor",
            take: |it| vec![block(&it.inertia.tensor)],
            put: |it, layers| it.inertia.tensor = array(&layers[0]),
        },
        matrices!("/inertia/L1", it, it.inertia.l1),
        Dataset {
            path: "/inertia/I1",
            take: |it| {
                let flat = |i: usize, j: usize| it.inertia.i1[j][i / 3][i % 3];
                vec![Mat::from_fn(9, it.inertia.i1.len(), flat)]
            },
            put: |it, layers| {
                for (k, block) in it.inertia.i1.iter_mut().enumerate() {
                    *block =
                        std::array::from_fn(|a| std::array::from_fn(|b| layers[0][(3 * a + b, k)]));
                    // The tensor is symmetric, whichever entry was changed.
                    for (a, b) in [(1, 0), (2, 0), (2, 1)] {
                        let larger = match block[a][b].abs() > block[b][a].abs() {
                            true => block[a][b],
                            false => block[b][a],
                        };
                        (block[a][b], block[b][a]) = (larger, larger);
                    }
                }
            },
        },
        matrices!("/inertia/I3", it, it.inertia.i3),
        Dataset {
            path: "/inertia/L3",
            take: |it| it.inertia.l3.clone(),
            put: |it, layers| it.inertia.l3 = layers,
        },
        Dataset {
            path: "/inertia/I2",
            take: |it| it.inertia.i2.clone(),
            put: |it, layers| it.inertia.i2 = layers,
        },
        Dataset {
            path: "/stiffening/centrifugal",
            take: |it| it.stiffening.centrifugal.clone(),
            put: |it, layers| it.stiffening.centrifugal = layers,
        },
        Dataset {
            path: "/stiffening/interface",
            take: |it| it.stiffening.interface.clone(),
            put: |it, layers| it.stiffening.interface = layers,
        },
        of_part!("/enrichment/interface_shapes", enrichment, interface_shapes),
        of_part!("/reduced/mass", enrichment, reduced_mass),
        of_part!("/reduced/stiffness", enrichment, reduced_stiffness),
        of_loads!("/loads/forces", force),
        of_loads!("/loads/moments", moment),
        of_loads!("/loads/work", work),
        Dataset {
            path: "/error/eigenvalue_errors",
            take: |it| {
                it.moments
                    .iter()
                    .flat_map(|of| column(&of.eigenvalue_errors))
                    .collect()
            },
            put: |it, layers| {
                if let Some(moments) = &mut it.moments {
                    moments.eigenvalue_errors = values(&layers);
                }
            },
        },
        of_part!("/error/rigid_shapes", moments, rigid_shapes),
        of_part!("/error/moment_1", moments, first),
        of_part!("/error/moment_2", moments, second),
        of_part!("/error/moment_3", moments, third),
        of_part!("/error/moment_4", moments, fourth),
        Dataset {
            path: "/error/rounding",
            take: |it| {
                it.moments
                    .iter()
                    .flat_map(|of| column(&of.rounding))
                    .collect()
            },
            put: |it, layers| {
                if let Some(moments) = &mut it.moments {
                    moments.rounding = values(&layers);
                }
            },
        },
    ]
}

/// Who notices a change, the earliest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Noticed {
    /// There is nothing to notice.
    Unchanged,
    /// No reader takes the file.
    Reading,
    /// A load for dynamics.
    Load,
    /// `reduce verify`.
    Verify,
    /// Nobody without the component.
    No,
}

impl Noticed {
    /// As the page says it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unchanged => "–",
            Self::Reading => "read",
            Self::Load => "load",
            Self::Verify => "verify",
            Self::No => "no",
        }
    }
}

/// Who notices that a dataset was changed.
pub fn noticed(whole: &Superelement, dataset: &Dataset, change: Change) -> Noticed {
    let layers = (dataset.take)(whole);
    let changed_layers = change.of(&layers);
    if layers.is_empty() || changed_layers == layers {
        return Noticed::Unchanged;
    }
    let mut changed = whole.clone();
    (dataset.put)(&mut changed, changed_layers);
    if changed == *whole {
        return Noticed::Unchanged;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("changed.dcb.h5");
    let contents = Contents {
        superelement: &changed,
        recovery: None,
        mesh: None,
    };
    let options = WriteOptions::default();
    // The writer refuses what no reader takes.
    if write_superelement(&path, &contents, &options).is_err() {
        return Noticed::Reading;
    }
    let file = SuperelementFile::open(&path).expect("a file with right digests");
    let read = file.superelement().expect("what the writer let pass");
    let breaks = |all: Vec<identities::Identity>| all.iter().any(|identity| !identity.holds());
    match (
        file.for_dynamics().is_err(),
        breaks(identities::in_full(&read)),
    ) {
        (true, _) => Noticed::Load,
        (false, true) => Noticed::Verify,
        (false, false) => Noticed::No,
    }
}

/// The table for some superelements: what is noticed of a change in all of them.
pub fn table(of: &[Superelement]) -> String {
    let names: Vec<&str> = Change::ALL.iter().map(|(_, name)| *name).collect();
    let mut text = format!(
        "| dataset | {} |\n|---|{}\n",
        names.join(" | "),
        "---|".repeat(names.len())
    );
    for dataset in datasets() {
        let cells: Vec<&str> = Change::ALL
            .iter()
            .map(|(change, _)| {
                let worst = of
                    .iter()
                    .map(|whole| noticed(whole, &dataset, *change))
                    .max();
                worst.unwrap_or(Noticed::Unchanged).name()
            })
            .collect();
        if cells.iter().any(|cell| *cell != Noticed::Unchanged.name()) {
            text += &format!("| `{}` | {} |\n", dataset.path, cells.join(" | "));
        }
    }
    text
}
