//! The elements of a `.vtu` file, and where its arrays are.

use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::super::fields::shown;
use super::data_array::{Compression, Data, DataArray, Kind, Layout};
use crate::binary::file::ByteOrder;

/// Names of point arrays that hold labels, in small letters without signs between.
const LABELS: [&str; 11] = [
    "label",
    "labels",
    "nodelabel",
    "nodelabels",
    "nodeid",
    "nodeids",
    "nodenumber",
    "nodenumbers",
    "globalnodeid",
    "globalnodeids",
    "nid",
];
const CONVERT: &str = "convert it: meshio convert FILE part.vtu, or in Python pyvista.read(\"FILE\").cast_to_unstructured_grid().save(\"part.vtu\")";

/// What the file says of its only piece.
pub(super) struct Document<'a> {
    pub layout: Layout,
    pub point_count: usize,
    pub cell_count: usize,
    pub points: Option<DataArray<'a>>,
    pub connectivity: Option<DataArray<'a>>,
    pub offsets: Option<DataArray<'a>>,
    pub types: Option<DataArray<'a>>,
    /// A point array whose name says that it has labels.
    pub labels: Option<(String, DataArray<'a>)>,
    /// The data behind the elements.
    appended: Option<Appended<'a>>,
    pieces: usize,
}

/// Data behind the underscore of `AppendedData`.
#[derive(Clone, Copy)]
struct Appended<'a> {
    bytes: &'a [u8],
    is_raw: bool,
}

/// Where in the document a data array stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    Other,
    Points,
    Cells,
    PointData,
}

/// A data array by its attributes.
struct ArrayHead {
    name: String,
    kind: Option<Kind>,
    kind_name: String,
    components: String,
    format: String,
    offset: String,
}

impl<'a> Document<'a> {
    /// Takes the elements apart.
    ///
    /// # Errors
    /// What isn't XML, isn't an unstructured grid, or is compressed otherwise.
    pub fn of(bytes: &'a [u8]) -> Result<Self, String> {
        let (elements, appended) = parts(bytes)?;
        let text = std::str::from_utf8(elements).map_err(|_| "isn't UTF-8 text, as XML is")?;
        let mut document = Self {
            layout: Layout {
                order: ByteOrder::Little,
                header: 4,
                compression: Compression::None,
            },
            point_count: 0,
            cell_count: 0,
            points: None,
            connectivity: None,
            offsets: None,
            types: None,
            labels: None,
            appended,
            pieces: 0,
        };
        document.read(text)?;
        Ok(document)
    }

    fn read(&mut self, text: &'a str) -> Result<(), String> {
        let mut reader = Reader::from_str(text);
        let mut section = Section::Other;
        let mut open: Option<(Section, ArrayHead)> = None;
        // Text of the array itself, not of the information keys in it.
        let (mut content, mut depth) = ("", 0);
        let mut is_closed = false;
        loop {
            let before = reader.buffer_position() as usize;
            let event = reader.read_event();
            let event = event.map_err(|error| format!("at byte {before}: isn't XML: {error}"))?;
            match event {
                Event::Eof => break,
                Event::Start(_) if open.is_some() => depth += 1,
                Event::End(_) if depth > 0 => depth -= 1,
                Event::Start(element) if element.local_name().as_ref() == "DataArray" => {
                    open = Some((section, array_head(&element)?));
                    content = "";
                }
                Event::Start(element) => section = self.begin(&element, section)?,
                Event::Empty(element) if element.local_name().as_ref() == "DataArray" => {
                    self.array(section, array_head(&element)?, "")?;
                }
                Event::Empty(element) if open.is_none() => {
                    self.begin(&element, section)?;
                }
                Event::Text(_) if open.is_some() && depth == 0 => {
                    let here = text.get(before..reader.buffer_position() as usize);
                    let here = here.unwrap_or_default().trim_ascii();
                    if !here.is_empty() {
                        content = here;
                    }
                }
                Event::End(element) => match element.local_name().as_ref() {
                    "DataArray" => {
                        if let Some((section, head)) = open.take() {
                            self.array(section, head, content)?;
                        }
                    }
                    "VTKFile" => is_closed = true,
                    "Points" | "Cells" | "PointData" | "CellData" | "FieldData" => {
                        section = Section::Other;
                    }
                    _ => {}
                },
                _ => {}
            }
        }
        match (is_closed || self.appended.is_some(), self.pieces) {
            (false, _) => Err("ends before </VTKFile>; it is cut off".into()),
            (_, 0) => Err("has no piece with points".into()),
            _ => Ok(()),
        }
    }

    /// An element that isn't a data array; tells the section that begins.
    fn begin(&mut self, element: &BytesStart, section: Section) -> Result<Section, String> {
        match element.local_name().as_ref() {
            "VTKFile" => self.file(element)?,
            "Piece" => {
                let number = |name: &str| -> Result<usize, String> {
                    let text = attribute(element, name)?.unwrap_or_default();
                    text.trim()
                        .parse()
                        .map_err(|_| format!("Piece has {name} {}", shown(text.as_bytes())))
                };
                let points = number("NumberOfPoints")?;
                if points > 0 {
                    self.pieces += 1;
                    (self.point_count, self.cell_count) = (points, number("NumberOfCells")?);
                }
                if self.pieces > 1 {
                    return Err("has several pieces, which share no points; write it as one piece (in ParaView: Merge Blocks, then save)".into());
                }
            }
            "Points" => return Ok(Section::Points),
            "Cells" => return Ok(Section::Cells),
            "PointData" => return Ok(Section::PointData),
            "CellData" | "FieldData" => return Ok(Section::Other),
            _ => {}
        }
        Ok(section)
    }

    fn file(&mut self, element: &BytesStart) -> Result<(), String> {
        let get = |name: &str| attribute(element, name);
        let kind = get("type")?.unwrap_or_default();
        if kind != "UnstructuredGrid" {
            return Err(format!(
                "is a VTK file of type {}, which isn't read; {CONVERT}",
                shown(kind.as_bytes())
            ));
        }
        self.layout.order = match get("byte_order")?.as_deref() {
            Some("BigEndian") => ByteOrder::Big,
            _ => ByteOrder::Little,
        };
        self.layout.header = match get("header_type")?.as_deref() {
            None | Some("UInt32") => 4,
            Some("UInt64") => 8,
            Some(other) => {
                return Err(format!(
                    "has header_type {}; expected UInt32 or UInt64",
                    shown(other.as_bytes())
                ));
            }
        };
        self.layout.compression = match get("compressor")?.as_deref() {
            None | Some("") => Compression::None,
            Some("vtkZLibDataCompressor") => Compression::Zlib,
            Some(other) => {
                return Err(format!(
                    "is compressed by {}; only zlib is read; {CONVERT}",
                    shown(other.as_bytes())
                ));
            }
        };
        Ok(())
    }

    fn array(&mut self, section: Section, head: ArrayHead, inner: &'a str) -> Result<(), String> {
        let name = head.name.to_ascii_lowercase();
        let plain: String = name.chars().filter(char::is_ascii_alphanumeric).collect();
        let is_label = section == Section::PointData && LABELS.contains(&plain.as_str());
        let is_wanted = match section {
            Section::Points => true,
            Section::Cells => matches!(name.as_str(), "connectivity" | "offsets" | "types"),
            Section::PointData => {
                is_label && self.labels.is_none() && matches!(head.components.as_str(), "" | "1")
            }
            Section::Other => false,
        };
        if !is_wanted {
            return Ok(());
        }
        let said = |message: &str| format!("DataArray {}: {message}", shown(head.name.as_bytes()));
        let kind = head.kind.ok_or_else(|| {
            said(&format!(
                "has the type {}",
                shown(head.kind_name.as_bytes())
            ))
        })?;
        if section == Section::Points && head.components != "3" {
            return Err(said("has no three components"));
        }
        let data = match head.format.as_str() {
            "ascii" => Data::Text(inner),
            "binary" => Data::Base64(inner.as_bytes()),
            "appended" => {
                let appended = self
                    .appended
                    .ok_or_else(|| said("is appended, but the file has no AppendedData"))?;
                let offset = head.offset.trim().parse().ok();
                let bytes = offset.and_then(|offset: usize| appended.bytes.get(offset..));
                let bytes =
                    bytes.ok_or_else(|| said("has an offset beyond the file; it is cut off"))?;
                match appended.is_raw {
                    true => Data::Raw(bytes),
                    false => Data::Base64(bytes),
                }
            }
            other => return Err(said(&format!("has the format {}", shown(other.as_bytes())))),
        };
        let array = DataArray { kind, data };
        let slot = match (section, name.as_str()) {
            (Section::Points, _) => &mut self.points,
            (Section::Cells, "connectivity") => &mut self.connectivity,
            (Section::Cells, "offsets") => &mut self.offsets,
            (Section::Cells, _) => &mut self.types,
            _ => {
                self.labels = Some((head.name, array));
                return Ok(());
            }
        };
        match slot.replace(array) {
            None => Ok(()),
            Some(_) => Err(format!(
                "DataArray {} stands twice",
                shown(head.name.as_bytes())
            )),
        }
    }
}

/// The value of an attribute.
fn attribute(element: &BytesStart, name: &str) -> Result<Option<String>, String> {
    let found = element.try_get_attribute(name);
    let found = found.map_err(|error| format!("has a damaged element: {error}"))?;
    Ok(found.map(|attribute| attribute.value.into_owned()))
}

fn array_head(element: &BytesStart) -> Result<ArrayHead, String> {
    let get = |name: &str| Ok::<_, String>(attribute(element, name)?.unwrap_or_default());
    let kind_name = get("type")?;
    Ok(ArrayHead {
        name: get("Name")?,
        kind: Kind::of(&kind_name),
        kind_name,
        components: get("NumberOfComponents")?,
        format: get("format")?,
        offset: get("offset")?,
    })
}

/// The elements, and the appended data, which need not be text.
fn parts(bytes: &[u8]) -> Result<(&[u8], Option<Appended<'_>>), String> {
    let tag = b"<AppendedData";
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let Some(at) = bytes.windows(tag.len()).position(|window| window == tag) else {
        return Ok((bytes, None));
    };
    let (elements, rest) = bytes.split_at(at);
    let end = rest.iter().position(|byte| *byte == b'>');
    let (head, data) = rest.split_at(end.ok_or("ends in AppendedData; it is cut off")?);
    let is_raw = String::from_utf8_lossy(head).contains("\"raw\"");
    let start = data.iter().position(|byte| *byte == b'_');
    let data = &data[start.ok_or("has no _ before its appended data")? + 1..];
    let data = match is_raw {
        true => data,
        // Text up to the end of the element.
        false => data.split(|byte| *byte == b'<').next().unwrap_or_default(),
    };
    Ok((
        elements,
        Some(Appended {
            bytes: data,
            is_raw,
        }),
    ))
}
