//! Stress and strain fields from a file.

use faer::Mat;

use super::{basis_count, point};
use crate::component::{StressComponent, StressPoint, StressQuantity};
use crate::dcb::read::SuperelementFile;
use crate::hdf5_files::inventory::Finding;
use crate::superelement::StressField;
use crate::terminal::shortened;

/// The fields, their places and rows in order.
pub(super) fn stresses(file: &SuperelementFile) -> Result<Vec<StressField>, Finding> {
    if !file.has("/stress/names") {
        return Ok(Vec::new());
    }
    let names = file.texts("/stress/names")?;
    let quantities = file.texts("/stress/quantities")?;
    let mut fields = Vec::with_capacity(names.len());
    for (name, word) in names.into_iter().zip(&quantities) {
        let quantity = (StressQuantity::ALL.into_iter()).find(|known| known.name() == word);
        fields.push(StressField {
            name,
            quantity: quantity.ok_or_else(|| {
                Finding::at(
                    "/stress/quantities",
                    format!("{:?} is neither \"stress\" nor \"strain\"", shortened(word)),
                )
            })?,
            components: Vec::new(),
            points: Vec::new(),
            shapes: Mat::zeros(0, 0),
            omitted: None,
        });
    }
    let first_places = places(file, &mut fields)?;
    rows(file, &mut fields, &first_places)?;
    shapes(file, &mut fields)?;
    Ok(fields)
}

/// Fills in the places; returns where those of each field begin.
fn places(file: &SuperelementFile, fields: &mut [StressField]) -> Result<Vec<usize>, Finding> {
    let path = "/stress/point_fields";
    let positions = file.reals("/stress/points")?;
    let owners = file.integers(path)?;
    let d = file.counts().dimension.coordinate_count();
    let (owners, _) = owners.as_chunks::<2>();
    let mut last = 0;
    for (place, (&[field, node], position)) in
        owners.iter().zip(positions.chunks_exact(d)).enumerate()
    {
        let index = usize::try_from(field).ok().filter(|index| *index >= last);
        let Some(of) = index.and_then(|index| fields.get_mut(index)) else {
            return Err(Finding::at(
                path,
                format!("place {place} is of field {field}; places must stand field after field"),
            ));
        };
        last = index.unwrap_or(last);
        of.points.push(StressPoint {
            position: point(position),
            node: match node {
                -1 => None,
                node => {
                    Some(u32::try_from(node).map_err(|_| {
                        Finding::at(path, format!("place {place} is at node {node}"))
                    })?)
                }
            },
        });
    }
    let mut first = 0;
    let mut starts = Vec::with_capacity(fields.len());
    for field in fields {
        starts.push(first);
        first += field.points.len();
    }
    Ok(starts)
}

/// Fills in the components: those of a field's first place, and the same at all others.
fn rows(
    file: &SuperelementFile,
    fields: &mut [StressField],
    first_places: &[usize],
) -> Result<(), Finding> {
    let path = "/stress/rows";
    let rows = file.integers(path)?;
    let (rows, _) = rows.as_chunks::<2>();
    let mut next = rows.iter();
    for (field, first) in fields.iter_mut().zip(first_places) {
        let own = rows.iter().filter(|[place, _]| *place == *first as i64);
        for [_, component] in own {
            let known = usize::try_from(*component)
                .ok()
                .and_then(StressComponent::from_index);
            field.components.push(known.ok_or_else(|| {
                Finding::at(
                    path,
                    format!("names component {component}; expected 0 to 5"),
                )
            })?);
        }
        for place in *first..first + field.points.len() {
            for component in &field.components {
                if next.next() != Some(&[place as i64, component.index() as i64]) {
                    return Err(Finding::at(
                        path,
                        format!(
                            "place {place} doesn't have the components of the first place of {:?} in the same order",
                            shortened(&field.name)
                        ),
                    ));
                }
            }
        }
    }
    match next.next() {
        None => Ok(()),
        Some([place, _]) => Err(Finding::at(
            path,
            format!("has a row of place {place} after the last place"),
        )),
    }
}

fn shapes(file: &SuperelementFile, fields: &mut [StressField]) -> Result<(), Finding> {
    let n = basis_count(file);
    let shapes = file.reals("/stress/shapes")?;
    let omitted = match file.has("/stress/omitted") {
        true => Some(file.reals("/stress/omitted")?),
        false => None,
    };
    let mut first = 0;
    for field in fields {
        let count = field.points.len() * field.components.len();
        field.shapes = Mat::from_fn(count, n, |i, j| shapes[(first + i) * n + j]);
        field.omitted = (omitted.as_ref()).map(|all| all[first..first + count].to_vec());
        first += count;
    }
    Ok(())
}
