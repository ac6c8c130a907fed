//! The record of a study: rows that survive an interruption, tables, charts, and one page that shows them.
//!
//! A study does many runs with different options and asks what each costs and how far it is off. This module has what all
//! studies share and knows nothing of reductions or motions:
//!
//! - [`Ledger`]: rows as lines of JSON, each on disk before the next run starts; a later run goes on where it ended. Its file is one of [`SharedLines`];
//! - [`pareto_front`], [`cheapest_within`]: which rows are worth their cost; [`pareto_chart`] shows it; [`thinned`] rows of it have curves;
//! - [`Chart`], [`svg`], [`small_svg`], [`write_svg`]: line charts, linear or logarithmic;
//! - [`Table`]: for a CSV file and for a page;
//! - [`Page`]: one HTML file that needs no other.

mod axis;
mod chart;
mod curve;
mod drawing;
mod hover;
mod html;
mod label_places;
mod ledger;
mod legend;
mod look;
mod page;
mod pareto;
mod shared_lines;
mod svg;
mod table;

pub use chart::{Axis, Chart, Note, ReferenceSlope, Scale, Series, Style};
pub use html::escaped;
pub use ledger::{Ledger, Start};
pub use page::{PAGE_GENERATOR, Page};
pub use pareto::{Candidate, PARETO_FRONT, cheapest_within, pareto_chart, pareto_front, thinned};
pub use shared_lines::SharedLines;
pub use svg::{NotDrawn, small_svg, svg, write_svg};
pub use table::{Cell, Column, Table};
