//! Stress and strain fields to a file: places and rows of all fields one after the other.

use super::{Writer, row_major};
use crate::component::StressQuantity;
use crate::superelement::Superelement;

/// The quantity of each row.
pub(super) fn quantities(of: &Superelement) -> Vec<StressQuantity> {
    (of.stresses.iter())
        .flat_map(|field| std::iter::repeat_n(field.quantity, field.shapes.nrows()))
        .collect()
}

impl Writer<'_> {
    /// All of `/stress`.
    pub(super) fn stresses(&mut self, of: &Superelement) -> hdf5::Result<()> {
        let d = of.dimension.coordinate_count();
        let (mut points, mut point_fields) = (Vec::new(), Vec::new());
        let (mut rows, mut shapes) = (Vec::<i64>::new(), Vec::new());
        for (index, field) in of.stresses.iter().enumerate() {
            for point in &field.points {
                let place = (point_fields.len() / 2) as i64;
                points.extend_from_slice(&point.position[..d]);
                point_fields.extend([index as i64, point.node.map_or(-1, i64::from)]);
                for component in &field.components {
                    rows.extend([place, component.index() as i64]);
                }
            }
            shapes.extend(row_major(&field.shapes));
        }
        let words = |word: fn(&crate::superelement::StressField) -> String| -> Vec<String> {
            of.stresses.iter().map(word).collect()
        };
        self.sink.group("stress")?;
        self.sink
            .texts("/stress/names", &words(|field| field.name.clone()))?;
        self.sink.texts(
            "/stress/quantities",
            &words(|field| field.quantity.name().to_owned()),
        )?;
        self.sink.reals("/stress/points", &points)?;
        self.sink.integers("/stress/point_fields", &point_fields)?;
        self.sink.integers("/stress/rows", &rows)?;
        self.sink.reals("/stress/shapes", &shapes)?;
        let omitted = of.stresses.iter().map(|field| field.omitted.as_deref());
        match omitted.collect::<Option<Vec<_>>>() {
            Some(omitted) => self.sink.reals("/stress/omitted", &omitted.concat()),
            None => Ok(()),
        }
    }
}
