//! NumPy: K, M and C of the primal form in a zip of arrays, without pickled objects.
//!
//! | array | shape | holds |
//! | --- | --- | --- |
//! | `K`, `M`, `C` | (N, N) | stiffness, mass, damping (`C` only where something is damped); coordinates: frames, then inertia relief and modes |
//! | `boundary` | (n_b, 2) | interface and direction (0 to 5: ux uy uz rx ry rz) of the first n_b coordinates |
//! | `names` | (n_i) | of the interfaces |
//! | `positions`, `orientations` | (n_i, 3), (n_i, 3, 3) | of the interfaces at rest; columns of a matrix are the frame's axes |
//! | `n_modes` | () | coordinates behind those of the frames |
//! | `rigid` | (n_b, 6) | rigid motions of the frames about the centre of mass |
//! | `mass`, `centre_of_mass`, `inertia` | (), (3), (3, 3) | of the whole part; `inertia` about the centre of mass |
//! | `units`, `source` | () | texts |

use dcb_formats::Error;

use crate::Request;
use crate::files::arrays::Arrays;
use crate::files::product::{Content, Product};
use crate::part::left_out::{Holds, left_out, unit_note};
use crate::part::primal::{Primal, boundary};
use crate::part::{Part, Source};

/// A part's primal form as NumPy arrays.
pub(crate) fn product(source: &Source, request: &Request<'_>) -> Result<Product, Error> {
    let part = Part::spatial(source, request)?;
    let primal = Primal::of(&part)?;
    let bytes = archive(&part, &primal)
        .map_err(|error| part.refused(format!("can't be written as npz: {error}")))?;
    let mut product = Product::new(Content::Bytes(bytes), primal.summary());
    product.notes.push(primal.rigid_note());
    product.notes.extend(unit_note(&part));
    product.left_out = left_out(
        &part,
        Holds {
            damping: true,
            axes: true,
            ..Holds::default()
        },
    )?;
    Ok(product)
}

fn archive(part: &Part<'_>, primal: &Primal) -> std::io::Result<Vec<u8>> {
    let frames = &primal.frames;
    let mut arrays = Arrays::new();
    arrays.matrix("K", &primal.stiffness)?;
    arrays.matrix("M", &primal.mass)?;
    if let Some(damping) = &primal.damping {
        arrays.matrix("C", damping)?;
    }
    let rows = boundary(frames).into_iter();
    let rows = rows.flat_map(|(frame, direction)| [frame as i64, direction.index() as i64]);
    arrays.integers(
        "boundary",
        &[6 * frames.len(), 2],
        &rows.collect::<Vec<_>>(),
    )?;
    let names: Vec<&str> = frames.iter().map(|frame| frame.name.as_str()).collect();
    arrays.texts("names", &[names.len()], &names)?;
    let positions = frames
        .iter()
        .flat_map(|frame| frame.position.iter().copied());
    arrays.reals(
        "positions",
        &[frames.len(), 3],
        &positions.collect::<Vec<_>>(),
    )?;
    let axes = frames.iter().flat_map(|frame| {
        frame
            .orientation
            .transpose()
            .iter()
            .copied()
            .collect::<Vec<_>>()
    });
    arrays.reals(
        "orientations",
        &[frames.len(), 3, 3],
        &axes.collect::<Vec<_>>(),
    )?;
    arrays.integers("n_modes", &[], &[primal.modal_count as i64])?;
    arrays.matrix("rigid", &primal.rigid)?;
    let basis = &part.basis;
    arrays.reals("mass", &[], &[basis.mass])?;
    arrays.reals("centre_of_mass", &[3], basis.centre.as_slice())?;
    arrays.reals("inertia", &[3, 3], basis.tensor.as_slice())?;
    let units = &part.superelement.units;
    arrays.texts("units", &[3], &[&units.length, &units.mass, &units.time])?;
    arrays.texts("source", &[], &[&part.source.origin_line()])?;
    arrays.finish()
}
