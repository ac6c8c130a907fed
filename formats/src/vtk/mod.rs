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
    /// Numbers at the nodes.
    pub numbers: &'a [Numbers<'a>],
    /// Marks at the nodes with their names, as many.
    pub marks: &'a [(&'a str, &'a [u8])],
}

/// Some numbers at each node: one, or six of a symmetric tensor in the order xx yy zz xy yz zx, which ParaView knows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers<'a> {
    /// Name.
    pub name: &'a str,
    /// How many at each node.
    pub count: usize,
    /// Node after node; NaN where there is none.
    pub values: &'a [f64],
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
                write_array(xml, name, "Float64", 3, &vectors(values))?;
            }
            for numbers in self.numbers {
                let values = numbers.values.iter();
                let bytes: Vec<u8> = values.flat_map(|value| value.to_le_bytes()).collect();
                write_array(xml, numbers.name, "Float64", numbers.count, &bytes)?;
            }
            for (name, values) in self.marks {
                write_array(xml, name, "UInt8", 1, values)?;
            }
            Ok(())
        })?;
        xml.create_element("Points").write_inner_content(|xml| {
            write_array(xml, "Points", "Float64", 3, &vectors(self.points))
        })?;
        xml.create_element("Cells").write_inner_content(|xml| {
            write_array(xml, "connectivity", "Int64", 1, &integers(&cells.nodes))?;
            write_array(xml, "offsets", "Int64", 1, &integers(&cells.ends))?;
            write_array(xml, "types", "UInt8", 1, &cells.types)
        })?;
        Ok(())
    }
}

/// One array: the number of its bytes and the bytes themselves, little-endian, coded together.
fn write_array<W: Write>(
    xml: &mut Writer<W>,
    name: &str,
    element: &str,
    components: usize,
    bytes: &[u8],
) -> io::Result<()> {
    let mut block = (bytes.len() as u64).to_le_bytes().to_vec();
    block.extend_from_slice(bytes);
    let count = components.to_string();
    let components = (components != 1).then_some(("NumberOfComponents", count.as_str()));
    xml.create_element("DataArray")
        .with_attributes([("type", element), ("Name", name), ("format", "binary")])
        .with_attributes(components)
        .write_text_content(BytesText::from_escaped(STANDARD.encode(block)))?;
    Ok(())
}
