//! Interfaces of a component as a scene sees them, before there is a superelement.

use dcb_demand::demand::PartInterface;
use dcb_formats::Component;
use nalgebra::{Matrix3, Vector3};

use dcb_reducer::error::Error;
use dcb_reducer::model::condensation::Model;
use dcb_reducer::model::localization::Localization;

/// The interfaces that the component's superelement will have, in its order.
///
/// # Errors
/// Those of [`Model::of`] and [`Localization::of`].
pub fn part_interfaces(component: &Component) -> Result<Vec<PartInterface>, Error> {
    let model = Model::of(component)?;
    let localization = Localization::of(component, &model)?;
    let placed = localization.interfaces.iter().enumerate();
    let interfaces = placed.map(|(index, interface)| {
        let own = || {
            localization
                .rows
                .iter()
                .filter(|row| row.interface == index)
        };
        let mut directions = [false; 6];
        for direction in own().filter_map(|row| row.direction) {
            directions[direction.index()] = true;
        }
        // Several nodes are taken hold of at the first one.
        let position = match own().next() {
            Some(row) if row.node.is_some() => row.position,
            _ => interface.position,
        };
        PartInterface {
            name: interface.name.clone(),
            position: Vector3::from(position),
            orientation: Matrix3::from_fn(|i, j| interface.orientation[i][j]),
            directions,
        }
    });
    Ok(interfaces.collect())
}
