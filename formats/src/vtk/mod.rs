//! VTK's unstructured grids, `.vtu`, for ParaView and whatever else reads them.
//!
//! Numbers are stored as they are in memory, little-endian, base64-coded.

mod cells;

use std::io::{self, Write};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use nalgebra::Vector3;
use quick_xml::Writer;
use quick_xml::events::BytesText;

pub use cells::Cells;

/// A grid as one file holds it.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    /// Cells.
    pub cells: &'a Cells,
    /// Places of the nodes.
    pub points: &'a [Vector3<f64>],
    /// Vectors at the nodes with their names, as many as there are nodes.
    pub vectors: &'a [(&'a str, &'a [Vector3<f64>])],
    /// Marks at the nodes with their names, as many.
    pub marks: &'a [(&'a str, &'a [u8])],
}

impl Grid<'_> {
    /// Writes it.
    ///
    /// # Errors
    /// Those of the file.
    pub fn write(&self, file: &mut impl Write) -> io::Result<()> {
        file.write_all(b"<?xml version=\"1.0\"?>\n")?;
        let mut xml = Writer::new(file);
        let (node_count, cell_count) = (self.points.len(), self.cells.types.len());
        xml.create_element("VTKFile")
            .with_attributes([
                ("type", "UnstructuredGrid"),
                ("version", "1.0"),
                ("byte_order", "LittleEndian"),
                ("header_type", "UInt64"),
            ])
            .write_inner_content(|xml| {
                xml.create_element("UnstructuredGrid")
                    .write_inner_content(|xml| {
                        xml.create_element("Piece")
                            .with_attribute(("NumberOfPoints", node_count.to_string().as_str()))
                            .with_attribute(("NumberOfCells", cell_count.to_string().as_str()))
                            .write_inner_content(|xml| self.write_piece(xml))?;
                        Ok(())
                    })?;
                Ok(())
            })?;
        Ok(())
    }

    fn write_piece<W: Write>(&self, xml: &mut Writer<W>) -> io::Result<()> {
        let cells = self.cells;
        let vectors = |of: &[Vector3<f64>]| -> Vec<u8> {
            let values = of.iter().flat_map(|vector| vector.iter());
            values.flat_map(|value| value.to_le_bytes()).collect()
        };
        let integers =
            |of: &[i64]| -> Vec<u8> { of.iter().flat_map(|value| value.to_le_bytes()).collect() };
        xml.create_element("PointData").write_inner_content(|xml| {
            for (name, values) in self.vectors {
                write_array(xml, name, "Float64", Shape::Vectors, &vectors(values))?;
            }
            for (name, values) in self.marks {
                write_array(xml, name, "UInt8", Shape::Scalars, values)?;
            }
            Ok(())
        })?;
        xml.create_element("Points").write_inner_content(|xml| {
            write_array(
                xml,
                "Points",
                "Float64",
                Shape::Vectors,
                &vectors(self.points),
            )
        })?;
        xml.create_element("Cells").write_inner_content(|xml| {
            write_array(
                xml,
                "connectivity",
                "Int64",
                Shape::Scalars,
                &integers(&cells.nodes),
            )?;
            write_array(
                xml,
                "offsets",
                "Int64",
                Shape::Scalars,
                &integers(&cells.ends),
            )?;
            write_array(xml, "types", "UInt8", Shape::Scalars, &cells.types)
        })?;
        Ok(())
    }
}

/// Shape of an array's entry for each node or cell.
#[derive(Clone, Copy)]
enum Shape {
    Scalars,
    Vectors,
}

/// One array: the number of its bytes and the bytes themselves, little-endian, coded together.
fn write_array<W: Write>(
    xml: &mut Writer<W>,
    name: &str,
    element: &str,
    shape: Shape,
    bytes: &[u8],
) -> io::Result<()> {
    let mut block = (bytes.len() as u64).to_le_bytes().to_vec();
    block.extend_from_slice(bytes);
    let components = match shape {
        Shape::Scalars => None,
        Shape::Vectors => Some(("NumberOfComponents", "3")),
    };
    xml.create_element("DataArray")
        .with_attributes([("type", element), ("Name", name), ("format", "binary")])
        .with_attributes(components)
        .write_text_content(BytesText::from_escaped(STANDARD.encode(block)))?;
    Ok(())
}
