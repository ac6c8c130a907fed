//! XML as it is written.

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};

/// A document being written.
pub(crate) struct Document {
    writer: Writer<Vec<u8>>,
}

/// Names and values.
pub(crate) type Attributes<'a> = &'a [(&'a str, &'a str)];

impl Document {
    /// With its declaration.
    pub(crate) fn new() -> io::Result<Self> {
        let mut document = Self {
            writer: Writer::new_with_indent(Vec::new(), b' ', 2),
        };
        let declaration = BytesDecl::new("1.0", Some("UTF-8"), None);
        document.writer.write_event(Event::Decl(declaration))?;
        Ok(document)
    }

    /// Begins an element.
    pub(crate) fn open(&mut self, name: &str, attributes: Attributes<'_>) -> io::Result<()> {
        let start = BytesStart::new(name).with_attributes(attributes.iter().copied());
        self.writer.write_event(Event::Start(start))
    }

    /// Ends it.
    pub(crate) fn close(&mut self, name: &str) -> io::Result<()> {
        self.writer.write_event(Event::End(BytesEnd::new(name)))
    }

    /// An element with nothing in it.
    pub(crate) fn empty(&mut self, name: &str, attributes: Attributes<'_>) -> io::Result<()> {
        let element = BytesStart::new(name).with_attributes(attributes.iter().copied());
        self.writer.write_event(Event::Empty(element))
    }

    /// All of it.
    pub(crate) fn text(self) -> io::Result<String> {
        let text = String::from_utf8(self.writer.into_inner()).map_err(io::Error::other)?;
        Ok(text + "\n")
    }
}
