//! VTK's unstructured grids.

use std::collections::BTreeSet;

use dcb_import::mesh::MeshFormat;

use crate::cell_shapes::assert_middles_are_in_place;
use crate::samples::{read, read_text, sample};

const ENCODINGS: [&str; 7] = [
    "ascii",
    "inline",
    "inline_zlib",
    "appended_raw",
    "appended_raw_zlib",
    "appended_base64",
    "appended_base64_zlib",
];

#[test]
fn every_encoding_of_vtk_is_the_same_mesh() {
    let plain = read("mesh/cells/edges_41.msh").mesh;
    let mut first = None;
    for name in ENCODINGS {
        let read = read(&format!("mesh/cells/edges_{name}.vtu"));
        assert_eq!(read.format, MeshFormat::Vtu);
        let mut mesh = read.mesh;
        assert_eq!(
            mesh.notes,
            ["labels of the nodes are those of the point array `Node_ID`"]
        );
        let places = |points: &[[f64; 3]]| -> BTreeSet<[u64; 3]> {
            points.iter().map(|point| point.map(f64::to_bits)).collect()
        };
        assert_eq!(places(&mesh.points), places(&plain.points), "{name}");
        assert_eq!(mesh.labels.as_ref().unwrap()[..3], [11, 18, 25]);
        let kinds: Vec<&str> = mesh
            .cells
            .iter()
            .map(|cells| cells.cell_type.as_str())
            .collect();
        let known = [
            "vertex",
            "line3",
            "triangle6",
            "quad8",
            "tetra10",
            "hexahedron20",
            "wedge15",
            "pyramid13",
            "wedge",
            "quad",
            "hexahedron",
            "vtk_type_4",
        ];
        assert_eq!(BTreeSet::from_iter(kinds), BTreeSet::from(known), "{name}");
        mesh.cells
            .retain(|cells| !cells.cell_type.starts_with("vtk"));
        assert_middles_are_in_place(&mesh);
        let corners = |kind: &str| -> Vec<[f64; 3]> {
            let block = mesh
                .cells
                .iter()
                .find(|cells| cells.cell_type == kind)
                .unwrap();
            block
                .nodes
                .iter()
                .map(|node| mesh.points[*node as usize])
                .collect()
        };
        // VTK's own wedge has its normal outwards, meshio's inwards; pixels and voxels count along the axes.
        assert_eq!(
            corners("wedge")[..3],
            [[2.0, 0.0, 0.0], [4.0, 0.0, 0.0], [2.0, 1.0, 0.0]],
            "{name}"
        );
        assert_eq!(
            corners("quad"),
            [
                [0.0, 0.0, 0.0],
                [2.0, 0.0, 0.0],
                [2.0, 1.0, 0.0],
                [0.0, 1.0, 0.0]
            ],
            "{name}"
        );
        assert_eq!(corners("hexahedron")[..4], corners("quad"), "{name}");
        assert_eq!(corners("hexahedron")[6], [2.0, 1.0, 3.0], "{name}");
        let first = first.get_or_insert_with(|| mesh.clone());
        assert_eq!(mesh, *first, "{name}");
    }
}

#[test]
fn other_compressors_and_kinds_are_refused_with_what_converts_them() {
    let error = dcb_import::mesh::read_mesh(&sample("mesh/cells/edges_lz4.vtu"))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains(
            "is compressed by `vtkLZ4DataCompressor`; only zlib is read; convert it: meshio convert"
        ),
        "{error}"
    );
    let error =
        read_text("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\"></VTKFile>").unwrap_err();
    assert!(
        error.contains("part: is a VTK file of type `PolyData`, which isn't read"),
        "{error}"
    );
}

/// A grid with one triangle, or what is put in its place.
fn grid(points: &str, cells: &str, more: &str) -> String {
    format!(
        "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"3\" NumberOfCells=\"1\">\
         <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">{points}</DataArray></Points><Cells>{cells}</Cells>{more}\
         </Piece></UnstructuredGrid></VTKFile>"
    )
}

const POINTS: &str = "0 0 0 1 0 0 0 1 0";

fn cells(connectivity: &str, offsets: &str, types: &str) -> String {
    let array = |name: &str, data: &str| {
        format!("<DataArray type=\"Int32\" Name=\"{name}\" format=\"ascii\">{data}</DataArray>")
    };
    array("connectivity", connectivity) + &array("offsets", offsets) + &array("types", types)
}

#[test]
fn only_whole_numbers_that_differ_are_labels() {
    let labels = |kind: &str, data: &str| {
        format!(
            "<PointData><DataArray type=\"{kind}\" Name=\"node-id\" format=\"ascii\">{data}</DataArray></PointData>"
        )
    };
    let triangle = cells("0 1 2", "3", "5");
    let mesh = read_text(grid(POINTS, &triangle, &labels("Int64", "7 5 6"))).unwrap();
    assert_eq!(mesh.labels.as_deref(), Some(&[7, 5, 6][..]));
    for (kind, data, said) in [
        ("Float64", "7 5 6", "has real numbers, expected whole ones"),
        ("Int64", "7 5 7", "has 7 twice"),
        ("Int64", "0 1 2", "0 is no label"),
        ("Int64", "1 2 2147483648", "2147483648 is no label"),
        ("Int64", "1 2", "has 2 numbers, expected 3"),
    ] {
        let mesh = read_text(grid(POINTS, &triangle, &labels(kind, data))).unwrap();
        assert_eq!(mesh.labels, None);
        let note =
            format!("the point array `node-id` isn't taken for labels of the nodes: it {said}");
        assert!(mesh.notes[0].starts_with(&note), "{:?}", mesh.notes);
    }
}

#[test]
fn what_cannot_be_right_is_refused_with_its_place() {
    let triangle = cells("0 1 2", "3", "5");
    for (text, said) in [
        (
            grid("0 0 0 1 0 0 0 1", &triangle, ""),
            "part: Points: has 8 numbers, expected 9",
        ),
        (
            grid("0 0 0 1 0 0 0 1 nan", &triangle, ""),
            "part: Points: `nan` is not finite",
        ),
        (
            grid(POINTS, &cells("0 1 3", "3", "5"), ""),
            "part: connectivity: cell 0 names point 3, but there are 3 (from 0)",
        ),
        (
            grid(POINTS, &cells("0 1 -1", "3", "5"), ""),
            "part: connectivity: cell 0 names point -1",
        ),
        (
            grid(POINTS, &cells("0 1 2", "2", "5"), ""),
            "part: connectivity: has more than 2 numbers",
        ),
        (
            grid(POINTS, &cells("0 1", "2", "5"), ""),
            "part: offsets: cell 0 of VTK type 5 has 2 points, expected 3",
        ),
        (
            grid(POINTS, &cells("0 1 2", "-3", "5"), ""),
            "part: offsets: ends with -3",
        ),
        (grid(POINTS, "", ""), "part: types: isn't there"),
        (
            grid(POINTS, &triangle, "").replace(
                "\"3\" NumberOfCells",
                "\"99999999999999999999\" NumberOfCells",
            ),
            "part: Piece has NumberOfPoints",
        ),
        (
            grid(POINTS, &triangle, "").replace(
                "\"3\" NumberOfCells",
                "\"9999999999999999999\" NumberOfCells",
            ),
            "part: Points: are more than any file has",
        ),
        (
            grid(POINTS, &triangle, "")
                .replace("\"3\" NumberOfCells", "\"1000000000000\" NumberOfCells"),
            "part: Points: has 9 numbers, expected 3000000000000",
        ),
        (
            grid(POINTS, &triangle, "").replace("</VTKFile>", ""),
            "part: ends before </VTKFile>; it is cut off",
        ),
        (
            grid(POINTS, &triangle, "<PointData></Cells>"),
            "part: at byte",
        ),
        (
            grid(
                POINTS,
                &triangle,
                "</Piece><Piece NumberOfPoints=\"1\" NumberOfCells=\"0\">",
            ),
            "part: has several pieces",
        ),
        (
            grid(POINTS, &triangle, "").replace("ascii", "appended"),
            "part: DataArray ``: is appended, but the file has no AppendedData",
        ),
    ] {
        let error = read_text(&text).unwrap_err();
        assert!(error.starts_with(said), "{error}\nexpected {said}");
    }
}
