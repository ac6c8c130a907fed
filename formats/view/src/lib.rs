//! What a picture shows of a mesh, and pages in which it moves.
//!
//! A page is one HTML file that needs no other and no network: text, tables and charts, and for the 3-D view a [`Description`] with its
//! [`Arrays`], which a script in the page draws ([`MovingPage`]). Only shapes and histories are in it, never pictures of single moments.
//! The contract with the script is in `formats/view/web/README.md`.

mod arrays;
mod description;
mod drawing;
mod glb;
mod moving_glb;
mod page;
mod shape;
mod solid_triangles;
mod surface;
mod triangles;

pub use arrays::{Array, Arrays};
pub use description::{
    Band, Body, Chart, ChartAxis, Curve, Description, End, Form, History, HistoryColumn, Joint,
    Kind, Load, Mode, Place, Solid,
};
pub use drawing::Drawing;
pub use glb::{Glb, extras};
pub use page::MovingPage;
pub use shape::{Column, Pattern, Shape};
pub use surface::Surface;
pub use triangles::Triangles;
