//! Simscape Multibody, block Reduced Order Flexible Solid: K, M and C of the primal form, frames and centre of mass, as a MATLAB file.
//!
//! | variable | size | parameter of the block |
//! | --- | --- | --- |
//! | `origins`, `quaternions` | n x 3, n x 4 (w x y z) | interface frames in the common frame |
//! | `K`, `M`, `C` | N x N | stiffness, mass, damping matrix: Tx Ty Tz Rx Ry Rz of each frame along the common axes, then modal coordinates |
//! | `centre_of_mass`, `mass`, `inertia` | 1 x 3, 1 x 1, 3 x 3 | of the whole part; the block takes the centre of mass |
//! | `names`, `units`, `source` | | for people |

use dcb_formats::Error;
use faer::Mat;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

use crate::Request;
use crate::files::mat5::MatFile;
use crate::files::product::{Content, Product};
use crate::part::left_out::{Holds, left_out, unit_note};
use crate::part::primal::Primal;
use crate::part::{Part, Source};

/// Elements of a MATLAB file have 32-bit lengths.
const MOST_COORDINATES: usize = 16_000;

/// A part's primal form as a MATLAB file.
pub(crate) fn product(source: &Source, request: &Request<'_>) -> Result<Product, Error> {
    let part = Part::spatial(source, request)?;
    let primal = Primal::of(&part)?;
    if primal.count() > MOST_COORDINATES {
        return Err(part.refused(format!(
            "has {} coordinates, and a matrix in a MATLAB file of version 5 has at most {MOST_COORDINATES}; use --to npz",
            primal.count()
        )));
    }
    let bytes = file(&part, &primal);
    let mut product = Product::new(Content::Bytes(bytes), primal.summary());
    product.notes.push(primal.rigid_note());
    if primal.damping.is_none() {
        product
            .notes
            .push("no damping in the superelement: C is zero".to_owned());
    }
    product.notes.extend(unit_note(&part));
    product.left_out = left_out(
        &part,
        Holds {
            damping: true,
            axes: true,
            ..Holds::default()
        },
    )?;
    product.paste = Some((
        "parameters of the block Reduced Order Flexible Solid, after load in MATLAB:",
        parameters(request.file_name),
    ));
    Ok(product)
}

fn parameters(file_name: &str) -> String {
    format!(
        "part = load('{}');\n\
         % Interface Frames > Origins          part.origins\n\
         % Interface Frames > Orientations     part.quaternions   (quaternion, scalar first)\n\
         % Stiffness Matrix                    part.K\n\
         % Mass Matrix                         part.M\n\
         % Center of Mass                      part.centre_of_mass\n\
         % Damping Matrix                      part.C\n",
        file_name.replace('\'', "''")
    )
}

fn file(part: &Part<'_>, primal: &Primal) -> Vec<u8> {
    let frames = &primal.frames;
    let mut file = MatFile::new(&format!("MATLAB 5.0 MAT-file: {}", part.superelement.name));
    file.matrix("K", &primal.stiffness);
    file.matrix("M", &primal.mass);
    match &primal.damping {
        Some(damping) => file.matrix("C", damping),
        None => file.matrix("C", &Mat::zeros(primal.count(), primal.count())),
    }
    file.matrix(
        "origins",
        &Mat::from_fn(frames.len(), 3, |i, a| frames[i].position[a]),
    );
    let quaternions: Vec<[f64; 4]> = frames
        .iter()
        .map(|frame| quaternion(&frame.orientation))
        .collect();
    file.matrix(
        "quaternions",
        &Mat::from_fn(frames.len(), 4, |i, a| quaternions[i][a]),
    );
    let basis = &part.basis;
    file.matrix(
        "centre_of_mass",
        &Mat::from_fn(1, 3, |_, a| basis.centre[a]),
    );
    file.matrix("mass", &Mat::from_fn(1, 1, |_, _| basis.mass));
    file.matrix("inertia", &Mat::from_fn(3, 3, |a, b| basis.tensor[(a, b)]));
    let names: Vec<&str> = frames.iter().map(|frame| frame.name.as_str()).collect();
    file.texts("names", &names);
    let units = &part.superelement.units;
    file.texts("units", &[&units.length, &units.mass, &units.time]);
    file.text("source", &part.source.origin_line());
    file.finish()
}

/// w, x, y, z.
fn quaternion(of: &Matrix3<f64>) -> [f64; 4] {
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*of));
    [turn.w, turn.i, turn.j, turn.k]
}
