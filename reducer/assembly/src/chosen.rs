//! The interfaces of the whole: rows of the parts' interfaces, along the axes of the assembly.

use dcb_formats::assembly::{Assembly, ChosenInterface};
use dcb_formats::component::{InterfaceKind, Role};
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::Attachment;
use dcb_formats::superelement::{BoundaryRow, InterfaceFrame};
use nalgebra::{Matrix3, Vector3};

use crate::Error;
use crate::measure::Measure;
use crate::part::Part;
use crate::spot::{ALONG, Place, Spot};

/// Interfaces, rows and measures of the whole, about its centre of mass.
pub(crate) struct Chosen {
    pub interfaces: Vec<InterfaceFrame>,
    pub rows: Vec<BoundaryRow>,
    pub measures: Vec<Measure>,
}

impl Chosen {
    /// `first_nodes` are the numbers of each body's first node in the mesh of the whole, where it has one.
    ///
    /// # Errors
    /// [`Error::Place`] for a place that isn't there, or rows that can't be turned.
    pub fn of(
        assembly: &Assembly,
        parts: &[Part],
        first_nodes: &[Option<u32>],
        centre: Vector3<f64>,
    ) -> Result<Self, Error> {
        let mut all = Self {
            interfaces: Vec::new(),
            rows: Vec::new(),
            measures: Vec::new(),
        };
        for (name, chosen) in &assembly.interfaces {
            all.take(name, chosen, assembly, parts, first_nodes, centre)?;
        }
        Ok(all)
    }

    fn take(
        &mut self,
        name: &str,
        chosen: &ChosenInterface,
        assembly: &Assembly,
        parts: &[Part],
        first_nodes: &[Option<u32>],
        centre: Vector3<f64>,
    ) -> Result<(), Error> {
        let location = format!("interfaces.{name}");
        let place = Place::of(&location, &chosen.at, &assembly.scene, parts)?;
        let Some((body, own)) = source(&chosen.at, parts) else {
            return Err(Error::place(
                location,
                format!("{:?} is no place on a body", chosen.at),
            ));
        };
        let part = &parts[body];
        let given = own.as_ref().map(|own| own.frame);
        let role = match (chosen.role, given.map(|frame| frame.role)) {
            (Some(Role::Attachment), Some(Role::Output)) => {
                return Err(Error::place(
                    location,
                    format!(
                        "{:?} is an output of its part, which has no attachment there; reduce the part with this interface as an attachment, or give it the role \"output\"",
                        chosen.at
                    ),
                ));
            }
            (Some(role), _) | (None, Some(role)) => role,
            (None, None) => Role::Attachment,
        };
        let spot = place
            .spots
            .first()
            .ok_or_else(|| Error::place(&location, "has no rows"))?;
        let interface = self.interfaces.len();
        self.interfaces.push(InterfaceFrame {
            name: name.to_owned(),
            kind: given.map_or(InterfaceKind::Rigid, |frame| frame.kind),
            role,
            position: match given {
                Some(frame) => (part.place(frame.position) - centre).into(),
                None => (spot.position - centre).into(),
            },
            orientation: columns(spot.axes),
        });
        let nodes: Vec<i64> = own.map_or_else(|| vec![-1], |own| own.nodes.clone());
        for (spot, node) in place.spots.iter().zip(nodes) {
            let node = match (u32::try_from(node), first_nodes[body]) {
                (Ok(node), Some(first)) => i64::from(first) + i64::from(node),
                _ => -1,
            };
            self.rows_of(&location, interface, spot, node, part, own, centre)?;
        }
        Ok(())
    }

    /// Rows of one spot: all that its part has.
    #[expect(clippy::too_many_arguments, reason = "one row has that many facts")]
    fn rows_of(
        &mut self,
        location: &str,
        interface: usize,
        spot: &Spot,
        node: i64,
        part: &Part,
        own: Option<Own<'_>>,
        centre: Vector3<f64>,
    ) -> Result<(), Error> {
        let wanted = match own {
            Some(own) => own.directions(part, location)?,
            None => match part.dimension {
                Dimension::Planar => vec![0, 1, 5],
                Dimension::Spatial => (0..6).collect(),
            },
        };
        for direction in wanted {
            let measures = if direction < 3 {
                &spot.translation
            } else {
                &spot.rotation
            };
            let Some(measure) = &measures[direction % 3] else {
                // A point mass has no rotation.
                continue;
            };
            self.rows.push(BoundaryRow {
                interface,
                direction: direction as i64,
                node,
                position: (spot.position - centre).into(),
            });
            self.measures.push(measure.clone());
        }
        Ok(())
    }
}

/// An interface of a part.
#[derive(Clone, Copy)]
struct Own<'a> {
    frame: &'a InterfaceFrame,
    index: usize,
    rows: &'a [BoundaryRow],
    nodes: &'a Vec<i64>,
}

impl Own<'_> {
    /// Directions of its rows along axes of the assembly.
    fn directions(&self, part: &Part, location: &str) -> Result<Vec<usize>, Error> {
        let mut own: Vec<usize> = (self.rows.iter())
            .filter(|row| row.interface == self.index)
            .filter_map(|row| usize::try_from(row.direction).ok())
            .collect();
        own.sort_unstable();
        own.dedup();
        let mut wanted = Vec::new();
        for first in [0, 3] {
            let kind: Vec<usize> = own
                .iter()
                .copied()
                .filter(|d| (first..first + 3).contains(d))
                .collect();
            // Axes of the assembly that these directions have a part in.
            let touched: Vec<usize> = (0..3)
                .filter(|axis| {
                    kind.iter()
                        .any(|d| part.axes[(*axis, d - first)].abs() > ALONG)
                })
                .collect();
            if touched.len() > kind.len() {
                return Err(Error::place(
                    location,
                    format!(
                        "{:?} of {:?} has not all its directions, and the body is turned so that they aren't along axes of the assembly; reduce the part with all directions of this interface",
                        self.frame.name, part.name
                    ),
                ));
            }
            wanted.extend(touched.into_iter().map(|axis| first + axis));
        }
        Ok(wanted)
    }
}

/// The body, and its interface if it is a superelement.
fn source<'a>(at: &str, parts: &'a [Part]) -> Option<(usize, Option<Own<'a>>)> {
    let Some(Attachment::Body { body, point }) = Attachment::parse(at) else {
        return None;
    };
    let index = parts.iter().position(|part| part.name == body)?;
    let Some(flexible) = parts[index].flexible() else {
        return Some((index, None));
    };
    let element = &flexible.element;
    let place = element.interfaces.iter().position(|of| of.name == point)?;
    Some((
        index,
        Some(Own {
            frame: &element.interfaces[place],
            index: place,
            rows: &element.rows,
            nodes: &flexible.interface_nodes[place],
        }),
    ))
}

fn columns(axes: Matrix3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|a| std::array::from_fn(|b| axes[(a, b)]))
}
