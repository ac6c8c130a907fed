//! The page of a superelement: its modes in motion, its responses with their bounds, and what its numbers are worth.

mod mac;
mod patterns;
mod responses;
mod text;

use std::path::Path;

use dcb_formats::RecoveryBasis;
use dcb_formats::Superelement;
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::mesh::{Dimension, Mesh};
use dcb_formats::units::si_factor;
use dcb_reducer::error::Error;
use dcb_report::Page;
use dcb_view::{Arrays, Body, Description, Drawing, Kind, Mode, MovingPage, Pattern, Shape};
use nalgebra::Vector3;

use crate::drawn_interfaces::{place, rods};
use crate::page_room;

/// The page of a superelement's file.
///
/// # Errors
/// [`Error`] for a file that can't be read.
pub fn part_page(path: &Path) -> Result<MovingPage, Error> {
    let file = SuperelementFile::open(path)?;
    let element = file.superelement()?;
    let mesh = file.mesh()?;
    let fields = file.recovery()?;
    let mut arrays = Arrays::default();
    let mut notes = Vec::new();
    let (shapes, modes) = match (&mesh, &fields) {
        (Some(mesh), Some(fields)) => shape(&element, mesh, fields, &mut notes, &mut arrays),
        _ => {
            notes.push(
                "The file has no nodal fields, so that no mode can be shown: the view has rods from the centre of mass to the interfaces. Reduce it with the fields of its nodes."
                    .into(),
            );
            (Vec::new(), Vec::new())
        }
    };
    let points: Vec<_> = element.interfaces.iter().map(place).collect();
    let solids = match shapes.is_empty() {
        true => vec![rods(&points)],
        false => Vec::new(),
    };
    let size = size(&element, mesh.as_ref());
    let responses = responses::of(&element, &mut arrays)?;
    let mut report = Page::new(&element.name);
    let found = text::Found {
        element: &element,
        path,
        notes: &notes,
        exactness: shapes.first().map(|shape| shape.error),
        mac: fields.as_ref().map(|fields| mac::picture(&element, fields)),
        responses: &responses,
    };
    text::write(&mut report, &found)?;
    let description = Description {
        kind: Kind::Part,
        title: element.name.clone(),
        units: serde_json::json!({"length": element.units.length, "mass": element.units.mass, "time": element.units.time}),
        dimension: element.dimension.coordinate_count(),
        up: match element.dimension {
            Dimension::Planar => [0.0, 1.0, 0.0],
            Dimension::Spatial => [0.0, 0.0, 1.0],
        },
        size,
        bodies: vec![Body {
            name: element.name.clone(),
            shape: (!shapes.is_empty()).then_some(0),
            solids,
            points,
            frames: None,
            rest: [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
            amplitudes: None,
        }],
        shapes,
        times: arrays.reals([]),
        joints: Vec::new(),
        loads: Vec::new(),
        histories: Vec::new(),
        modes,
        charts: responses.charts,
    };
    Ok(MovingPage {
        report,
        description,
        arrays,
    })
}

/// The mesh with modes and attachments: with as many nodes and then as many columns as a page has room for.
fn shape(
    element: &Superelement,
    mesh: &Mesh,
    fields: &RecoveryBasis,
    notes: &mut Vec<String>,
    arrays: &mut Arrays,
) -> (Vec<Shape>, Vec<Mode>) {
    let modes = element.mode_count();
    let mut attached: Vec<usize> = (0..element.boundary_row_count())
        .filter(|row| element.residual.flexibility[(*row, *row)] > 0.0)
        .collect();
    let has_room =
        |drawing: &Drawing, patterns: usize| patterns <= page_room::patterns(drawing.nodes.len());
    let mut drawing = Drawing::of(mesh);
    if !has_room(&drawing, modes + attached.len()) {
        let corners = Drawing::of_corners(mesh);
        if corners.nodes.len() < drawing.nodes.len() {
            notes.push(format!(
                "The view draws the {} corners of the surface, not all {} nodes on it: the page stays small.",
                corners.nodes.len(),
                drawing.nodes.len()
            ));
            drawing = corners;
        }
    }
    if !has_room(&drawing, modes + attached.len()) {
        notes.push("The view has no attachment shapes: the page stays small.".into());
        attached.clear();
    }
    let shown = modes.min(page_room::patterns(drawing.nodes.len()).max(1));
    if shown < modes {
        notes.push(format!(
            "The view shows the lowest {shown} of {modes} modes: the page stays small."
        ));
    }
    notes.extend(
        drawing
            .others
            .iter()
            .map(|kind| format!("Cells of type {kind} aren't drawn.")),
    );
    let basis = patterns::Displacements::of(fields, mesh, &drawing);
    let unit = si_factor(&element.units.time);
    let mut patterns: Vec<Pattern> = Vec::new();
    let mut listed = Vec::new();
    for mode in 0..shown {
        let eigenvalue = element.modes.eigenvalues[mode].max(0.0);
        listed.push(Mode {
            name: format!("Mode {}", mode + 1),
            frequency: unit.map(|unit| eigenvalue.sqrt() / (std::f64::consts::TAU * unit)),
            damping: element.modes.damping.get(mode).copied(),
            column: patterns.len(),
        });
        patterns.push(Pattern {
            name: format!("mode {}", mode + 1),
            displacements: basis.of_column(fields.modes.as_ref(), mode),
        });
    }
    for row in attached {
        let name = element.row_name(row);
        listed.push(Mode {
            name: format!("Attachment {name}"),
            frequency: None,
            damping: None,
            column: patterns.len(),
        });
        patterns.push(Pattern {
            name,
            displacements: basis.of_column(fields.residual.as_ref(), row),
        });
    }
    let origin = Vector3::from(element.origin);
    let positions = drawing.nodes.iter();
    let positions: Vec<[f64; 3]> = positions
        .map(|node| (Vector3::from(mesh.position(*node)) - origin).into())
        .collect();
    let shape = Shape::rounded(&element.name, &drawing, &positions, &patterns, arrays);
    (vec![shape], listed)
}

/// Diagonal of the box around the mesh, or around the interfaces.
fn size(element: &Superelement, mesh: Option<&Mesh>) -> f64 {
    let of_mesh = mesh.into_iter().flat_map(|mesh| {
        (0..mesh.node_count() as u32).map(|node| Vector3::from(mesh.position(node)))
    });
    let of_interfaces = element.interfaces.iter();
    let of_interfaces = of_interfaces
        .map(|interface| Vector3::from(interface.position) + Vector3::from(element.origin));
    let (mut low, mut high) = (Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN));
    for at in of_mesh.chain(of_interfaces) {
        (low, high) = (low.inf(&at), high.sup(&at));
    }
    let diagonal = (high - low).norm();
    match diagonal.is_finite() && diagonal > 0.0 {
        true => diagonal,
        false => 1.0,
    }
}
