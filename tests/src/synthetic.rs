//! Synthetic superelements: every number different, everything that the contract demands holds.
use std::collections::BTreeMap;
use std::path::Path;

use dcb_formats::Error;
use dcb_formats::component::{
    InterfaceKind, Role, Source, StressComponent, StressPoint, StressQuantity, Units,
};
use dcb_formats::dcb::{Compression, Contents, SuperelementFile, WriteOptions, write_superelement};
use dcb_formats::mesh::{CellBlock, Dimension, Direction, Dof, Mesh};
use dcb_formats::output::Replace;
use dcb_formats::superelement::{
    BoundaryRow, CouplingSource, Derivation, Enrichment, FrameKind, Inertia, InterfaceDirections,
    InterfaceFrame, LoadedForces, Modes, Moments, PartLoad, Provenance, RecoveryBasis, Residual,
    SelectionRecord, Stiffening, StressField, Superelement,
};
use faer::Mat;

/// A number for each seed and place, between -1 and 1, with all digits in use.
fn noise(seed: usize, i: usize, j: usize) -> f64 {
    let phase = 12.9898 * (i as f64 + 1.0) + 78.233 * (j as f64 + 1.0) + 3.7 * seed as f64;
    (phase * 0.618).sin()
}

fn matrix(seed: usize, rows: usize, columns: usize) -> Mat<f64> {
    Mat::from_fn(rows, columns, |i, j| noise(seed, i, j))
}

fn symmetric(seed: usize, n: usize) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| {
        noise(seed, i.min(j), i.max(j)) * 0.1 + if i == j { 2.0 } else { 0.0 }
    })
}

fn antisymmetric(seed: usize, n: usize) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| match i.cmp(&j) {
        std::cmp::Ordering::Less => noise(seed, i, j),
        std::cmp::Ordering::Equal => 0.0,
        std::cmp::Ordering::Greater => -noise(seed, j, i),
    })
}

fn turn(angle: f64) -> [[f64; 3]; 3] {
    let (sine, cosine) = angle.sin_cos();
    [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]
}

fn tensor(seed: usize) -> [[f64; 3]; 3] {
    let matrix = symmetric(seed, 3);
    std::array::from_fn(|a| std::array::from_fn(|b| matrix[(a, b)]))
}

/// Three interfaces: a frame, a node and an observed node.
pub fn superelement(dimension: Dimension) -> Superelement {
    let planar = dimension == Dimension::Planar;
    let z = |value: f64| if planar { 0.0 } else { value };
    let interface = |name: &str, kind, role, at: f64, angle: f64| InterfaceFrame {
        name: name.to_owned(),
        kind,
        role,
        position: [at, 0.25 * at, z(-0.5 * at)],
        orientation: turn(angle),
    };
    let interfaces = vec![
        interface(
            "big end",
            InterfaceKind::Average,
            Role::Attachment,
            -0.15,
            0.3,
        ),
        interface("Auge-ü", InterfaceKind::Nodes, Role::Attachment, 0.15, 0.0),
        interface("sensor", InterfaceKind::Nodes, Role::Output, 0.05, 0.0),
    ];
    let row = |interface: usize, direction: usize, node: i64| BoundaryRow {
        interface,
        direction: direction as i64,
        node,
        position: interfaces[interface].position,
    };
    let mut rows: Vec<_> = dimension
        .frame_directions()
        .iter()
        .map(|direction| row(0, direction.index(), -1))
        .collect();
    rows.extend([row(1, 0, 3), row(1, 1, 3), row(2, 1, 2)]);
    let n_b = rows.len();
    let attached = n_b - 1;
    let n_k = 4;
    let n = n_k + n_b;
    let zeroed = |of: Mat<f64>| {
        Mat::from_fn(
            n_b,
            of.ncols(),
            |i, j| if i < attached { of[(i, j)] } else { 0.0 },
        )
    };
    let both = |of: Mat<f64>| {
        Mat::from_fn(
            n_b,
            n_b,
            |i, j| if i.max(j) < attached { of[(i, j)] } else { 0.0 },
        )
    };
    let axes = if planar { 1 } else { 3 };
    let planar_only = |full: [[f64; 3]; 3]| {
        if planar {
            [[0.0; 3], [0.0; 3], [0.0, 0.0, full[2][2]]]
        } else {
            full
        }
    };
    Superelement {
        name: "rod".to_owned(),
        dimension,
        units: Units {
            length: "mm".to_owned(),
            mass: "t".to_owned(),
            time: "s".to_owned(),
        },
        origin: [0.1, -0.2, z(0.3)],
        frame_kind: FrameKind::MeanAxis,
        modes: Modes {
            eigenvalues: vec![0.0, 1.5e6, 1.5e6, 4.25e7],
            damping: vec![0.01, 0.02, 0.0, 0.03],
            residual_damping: 0.05,
            interface_shapes: matrix(1, n_b, n_k),
            first_omitted_eigenvalue: f64::INFINITY,
        },
        residual: Residual {
            flexibility: both(symmetric(2, n_b)),
            mass: both(symmetric(3, n_b)),
            mass_diagonal0: (0..n_b)
                .map(|b| if b < attached { 3.0 + b as f64 } else { 0.0 })
                .collect(),
            transform: zeroed(matrix(4, n_b, attached)),
            sigma_squared: (0..attached).map(|r| 1e8 * (r as f64 + 1.0)).collect(),
            tolerance: 1e-9,
            output_shapes: Some(Mat::from_fn(n_b, n_b, |i, j| {
                if j < attached { noise(5, i, j) } else { 0.0 }
            })),
        },
        inertia: Inertia {
            mass: 7.5,
            tensor: planar_only(tensor(6)),
            l1: Mat::from_fn(dimension.coordinate_count(), n, |i, j| {
                1e-17 * noise(7, i, j)
            }),
            i1: (0..n).map(|k| planar_only(tensor(8 + k))).collect(),
            i3: Mat::from_fn(axes, n, |i, j| 1e-17 * noise(9, i, j)),
            l3: (0..axes).map(|a| antisymmetric(10 + a, n)).collect(),
            i2: (0..if planar { 0 } else { 6 })
                .map(|c| symmetric(20 + c, n))
                .collect(),
        },
        stiffening: Stiffening::default(),
        enrichment: None,
        moments: None,
        loads: Vec::new(),
        stresses: Vec::new(),
        derivation: None,
        provenance: Provenance {
            generator: "reduce 0.1.0".to_owned(),
            inputs: vec![Source {
                role: "stiffness".to_owned(),
                file_name: "rod.mtx".to_owned(),
                sha256: "ab".repeat(32),
            }],
            options: serde_json::json!({ "modes": 4, "note": "Größe \"x\"" }),
            quality: serde_json::json!({ "orthogonality": 1e-15 }),
            warnings: vec!["one\nwarning".to_owned()],
        },
        interfaces,
        rows,
    }
}

/// The same with two further columns and both stiffening arrays.
pub fn enriched(dimension: Dimension) -> Superelement {
    let mut of = superelement(dimension);
    let n_b = of.boundary_row_count();
    let n = of.basis_count() + 2;
    let axes = if dimension == Dimension::Planar { 1 } else { 3 };
    of.enrichment = Some(Enrichment {
        names: vec!["spin xx".to_owned(), "load \"wind\"".to_owned()],
        interface_shapes: matrix(30, n_b, 2),
        reduced_mass: symmetric(31, n),
        reduced_stiffness: symmetric(32, n),
    });
    of.stiffening = Stiffening {
        centrifugal: (0..if axes == 1 { 1 } else { 6 })
            .map(|c| symmetric(33 + c, n))
            .collect(),
        interface: (0..n_b).map(|b| symmetric(40 + b, n)).collect(),
    };
    of.loads = ["wind", "Gewicht"]
        .into_iter()
        .enumerate()
        .map(|(index, name)| PartLoad {
            name: name.to_owned(),
            force: [0.5 + index as f64, -2.0, if axes == 1 { 0.0 } else { 3.0 }],
            moment: if axes == 1 {
                [0.0, 0.0, 0.1]
            } else {
                [0.2, 0.3, -0.4]
            },
            work: (0..n).map(|k| noise(72 + index, k, 0)).collect(),
        })
        .collect();
    of.moments = Some(Moments {
        eigenvalue_bound: 4.5e7,
        eigenvalue_errors: vec![0.0, 1e-12, 1e-13, 1e-14],
        rigid_shapes: matrix(90, n_b, if axes == 1 { 3 } else { 6 }),
        shift: 1.25e2,
        first: symmetric(91, n_b + 2),
        second: symmetric(92, n_b + 2),
        third: symmetric(93, n_b + 2),
        fourth: symmetric(94, n_b + 2),
        rounding: (0..n_b + 2).map(|b| 1e-14 * (1.0 + b as f64)).collect(),
        loaded: Some(LoadedForces {
            forces: {
                let outputs =
                    |row: usize| of.interfaces[of.rows[row].interface].role == Role::Output;
                let noise = matrix(95, n_b, 2);
                Mat::from_fn(n_b, 2, |row, j| match outputs(row) {
                    true => 0.0,
                    false => noise[(row, j)],
                })
            },
            eigenvalue_bound: 6.25e7,
        }),
    });
    of.stresses = stresses(dimension, n);
    of.derivation = Some(derivation(&of));
    of.inertia.l1 = matrix(50, dimension.coordinate_count(), n);
    of.inertia.i1.resize(n, of.inertia.i1[0]);
    of.inertia.i3 = matrix(51, axes, n);
    of.inertia.l3 = (0..axes).map(|a| antisymmetric(52 + a, n)).collect();
    of.inertia.i2 = (0..if axes == 1 { 0 } else { 6 })
        .map(|c| symmetric(60 + c, n))
        .collect();
    of.frame_kind = FrameKind::Given;
    of
}

/// Stress at two nodes and strain at one place that is none.
fn stresses(dimension: Dimension, n: usize) -> Vec<StressField> {
    let d = dimension.coordinate_count();
    let point = |seed: usize, node| StressPoint {
        position: std::array::from_fn(|axis| if axis < d { noise(98, seed, axis) } else { 0.0 }),
        node,
    };
    let usual = StressComponent::usual(dimension);
    let fields = [
        (
            "fillet",
            StressQuantity::Stress,
            usual,
            vec![point(0, Some(2)), point(1, Some(0))],
        ),
        (
            "Dehnung \"7\"",
            StressQuantity::Strain,
            &[StressComponent::Xy],
            vec![point(2, None)],
        ),
    ];
    let made = fields.into_iter().enumerate();
    made.map(|(index, (name, quantity, components, points))| {
        let rows = points.len() * components.len();
        StressField {
            name: name.to_owned(),
            quantity,
            components: components.to_vec(),
            points,
            shapes: matrix(99 + index, rows, n),
            omitted: Some((0..rows).map(|row| noise(101, row, index).abs()).collect()),
        }
    })
    .collect()
}

/// Two selections: the first left modes out up to a frequency, the second loads the first interface along two forces.
fn derivation(of: &Superelement) -> Derivation {
    let rows = of.rows.iter().filter(|row| row.interface == 0).count();
    let force = |seed| (0..rows).map(|row| noise(seed, row, 0)).collect();
    Derivation {
        coupling_source: CouplingSource::Nodal,
        interface_directions: Some(InterfaceDirections {
            kept: 5,
            available: 7,
        }),
        left_out_columns: vec!["spin zz".to_owned(), "load \"Böe\"".to_owned()],
        internal_rows: 72,
        selections: vec![
            SelectionRecord {
                modes: vec![0, 1, 3, 4, 6],
                of_modes: 9,
                first_omitted_eigenvalue: Some(4.5e7),
                up_to: Some(812.5),
                ..SelectionRecord::default()
            },
            SelectionRecord {
                modes: vec![0, 1, 2, 4],
                of_modes: 5,
                loaded_along: BTreeMap::from([("big end".to_owned(), vec![force(96), force(97)])]),
                ..SelectionRecord::default()
            },
        ],
    }
}

/// A mesh of two cells, with node sets whose names HDF5 can't take.
pub fn mesh(dimension: Dimension) -> Mesh {
    let d = dimension.coordinate_count();
    Mesh {
        dimension,
        coordinates: (0..4 * d).map(|i| noise(70, i, 0)).collect(),
        cells: vec![
            CellBlock {
                cell_type: "line".to_owned(),
                nodes_per_cell: 2,
                nodes: vec![0, 1, 1, 2],
            },
            CellBlock {
                cell_type: "line3".to_owned(),
                nodes_per_cell: 3,
                nodes: vec![2, 3, 0],
            },
        ],
        point_sets: BTreeMap::from([
            ("big/end 1".to_owned(), vec![0, 3]),
            (String::new(), vec![]),
            ("ü.".to_owned(), vec![2]),
        ]),
    }
}

/// Nodal fields, of more dofs than the mesh has rows of.
pub fn recovery(of: &Superelement) -> RecoveryBasis {
    let dofs: Vec<Dof> = (0..4)
        .flat_map(|node| {
            of.dimension
                .frame_directions()
                .iter()
                .map(move |&direction| Dof { node, direction })
        })
        .filter(|dof| dof.node != 1 || dof.direction != Direction::Rz)
        .collect();
    RecoveryBasis {
        modes: matrix(80, dofs.len(), of.mode_count()),
        residual: matrix(81, dofs.len(), of.boundary_row_count()),
        enrichment: of
            .enrichment
            .as_ref()
            .map(|further| matrix(82, dofs.len(), further.interface_shapes.ncols())),
        dofs,
    }
}

/// What a frozen file must still say: sizes, names and numbers, with every digit (quantities in the file's own units).
pub fn summary(file: &SuperelementFile) -> Result<serde_json::Value, Error> {
    let of = file.superelement()?;
    let (recovery, mesh) = (file.recovery()?, file.mesh()?);
    let last = |matrix: &Mat<f64>| match (matrix.nrows(), matrix.ncols()) {
        (0, _) | (_, 0) => serde_json::Value::Null,
        (rows, columns) => matrix[(rows - 1, columns - 1)].into(),
    };
    let moments = of.moments.as_ref().map(|moments| {
        let matrices = [
            &moments.first,
            &moments.second,
            &moments.third,
            &moments.fourth,
            &moments.rigid_shapes,
        ];
        serde_json::json!([
            moments.eigenvalue_bound,
            matrices.map(last),
            moments.eigenvalue_errors,
            moments.rounding
        ])
    });
    let shift = of.moments.as_ref().map(|moments| moments.shift);
    let loaded = (of.moments.as_ref()).and_then(|moments| moments.loaded.as_ref());
    let loaded = loaded.map(|loaded| {
        let sum: f64 = loaded.forces.col_iter().map(|force| force.sum()).sum();
        serde_json::json!([loaded.eigenvalue_bound, loaded.forces.ncols(), sum])
    });
    let mut summary = serde_json::json!({
        "moments_shift": shift,
        // As the frozen files were first described.
        "source": "synthetic numbers of formats/tests/support/mod.rs; tolerance 0",
        "digest": file.digest(),
        "format_version": file.format_version().to_string(),
        "datasets": file.verify_digests()?,
        "name": of.name,
        "units": [of.units.length, of.units.mass, of.units.time],
        "origin": of.origin,
        "frame": of.frame_kind.name(),
        "interfaces": of.interfaces.iter().map(|one| (one.name.clone(), one.kind.name())).collect::<Vec<_>>(),
        "positions": of.interfaces.iter().map(|one| one.position).collect::<Vec<_>>(),
        "rows": of.rows.iter().map(|row| (row.interface, row.direction, row.node)).collect::<Vec<_>>(),
        "eigenvalues": of.modes.eigenvalues,
        "damping": of.modes.damping,
        "residual_damping": of.modes.residual_damping,
        "all_modes_kept": of.modes.first_omitted_eigenvalue.is_infinite(),
        "last_interface_shape": last(&of.modes.interface_shapes),
        "first_flexibility": of.residual.flexibility[(0, 0)],
        "last_output_shape": of.residual.output_shapes.as_ref().map(|shapes| shapes[(1, 0)]),
        "sigma_squared": of.residual.sigma_squared,
        "tolerance": of.residual.tolerance,
        "mass": of.inertia.mass,
        "tensor": of.inertia.tensor,
        "first_i1": of.inertia.i1.first(),
        "last_l1": last(&of.inertia.l1),
        "l3_12": of.inertia.l3.iter().map(|layer| layer[(1, 2)]).collect::<Vec<_>>(),
        "i2_12": of.inertia.i2.iter().map(|layer| layer[(1, 2)]).collect::<Vec<_>>(),
        "centrifugal_12": of.stiffening.centrifugal.iter().map(|layer| layer[(1, 2)]).collect::<Vec<_>>(),
        "interface_stiffening_12": of.stiffening.interface.iter().map(|layer| layer[(1, 2)]).collect::<Vec<_>>(),
        "loads": of.loads.iter().map(|load| (load.name.clone(), load.force, load.moment, load.work.last().copied())).collect::<Vec<_>>(),
        "last_reduced_stiffness": of.enrichment.as_ref().map(|enrichment| last(&enrichment.reduced_stiffness)),
        "moments": moments,
        "enrichment_names": of.enrichment.as_ref().map(|enrichment| enrichment.names.clone()),
        "last_enrichment_shape": recovery.as_ref().and_then(|recovery| recovery.enrichment.as_ref()).map(last),
        "field_dofs": recovery.as_ref().map(|recovery| recovery.dofs.len()),
        "last_mode_shape": recovery.as_ref().map(|recovery| last(&recovery.modes)),
        "last_residual_shape": recovery.as_ref().map(|recovery| last(&recovery.residual)),
        "coordinates": mesh.as_ref().map(|mesh| mesh.coordinates.clone()),
        "point_sets": mesh.as_ref().map(|mesh| mesh.point_sets.clone()),
        "options": of.provenance.options,
        "warnings": of.provenance.warnings,
    });
    let stresses = of.stresses.iter().map(|field| {
        let components: Vec<&str> = field.components.iter().map(|one| one.name()).collect();
        let points: Vec<_> = (field.points.iter())
            .map(|point| (point.position, point.node))
            .collect();
        serde_json::json!([
            field.name,
            field.quantity.name(),
            components,
            points,
            last(&field.shapes),
            field.omitted
        ])
    });
    summary["stresses"] = stresses.collect();
    summary["moments_loaded"] = loaded.into();
    let made = of.derivation.as_ref();
    summary["coupling_source"] = serde_json::json!(made.map(|made| made.coupling_source));
    let directions = made.and_then(|made| made.interface_directions);
    let directions = directions.map(|directions| [directions.kept, directions.available]);
    summary["interface_directions"] = serde_json::json!(directions);
    summary["left_out_columns"] = serde_json::json!(made.map(|made| &made.left_out_columns));
    summary["internal_rows"] = serde_json::json!(made.map(|made| made.internal_rows));
    summary["selections"] = serde_json::json!(of.selections());
    Ok(summary)
}

/// A planar superelement with so many modes and an L3 of zeros.
pub fn with_modes(count: usize) -> Superelement {
    let mut of = superelement(Dimension::Planar);
    let n_b = of.boundary_row_count();
    let n = count + n_b;
    of.interfaces[0].orientation = turn(0.0);
    of.modes.eigenvalues = (0..count).map(|k| k as f64).collect();
    of.modes.damping = vec![0.01; count];
    of.modes.interface_shapes = matrix(1, n_b, count);
    of.inertia.l1 = Mat::zeros(2, n);
    of.inertia.i1.resize(n, of.inertia.i1[0]);
    of.inertia.i3 = Mat::zeros(1, n);
    of.inertia.l3 = vec![Mat::zeros(n, n)];
    of
}

/// Writes a superelement of these over whatever is there, with [`recovery`] and [`mesh`].
///
/// # Errors
/// The file can't be written.
pub fn write(
    path: &Path,
    superelement: &Superelement,
    compression: Compression,
) -> Result<(), Error> {
    let (recovery, mesh) = (recovery(superelement), mesh(superelement.dimension));
    let contents = Contents {
        superelement,
        recovery: Some(&recovery),
        mesh: Some(&mesh),
    };
    let options = WriteOptions {
        replace_existing: Replace::Overwrite,
        compression,
    };
    write_superelement(path, &contents, &options)
}
