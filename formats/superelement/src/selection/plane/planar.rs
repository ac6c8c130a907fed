//! A spatial superelement that moves in a plane only, as a planar one.

use dcb_formats::component::Role;
use dcb_formats::mesh::Dimension;
use dcb_formats::superelement::{
    BoundaryRow, Inertia, InterfaceFrame, Moments, PartLoad, Stiffening, StressField, Superelement,
};
use faer::Mat;

use super::Normal;
use crate::selection::rigid_motions::rigid_motions;

/// Axes that differ less than this are the same: the file's rule for rotation matrices.
const SAME_AXIS: f64 = 1e-9;
/// The inertia of the thickness counts from this fraction of the mass on.
const ROUNDING: f64 = 1e-12;

/// `spatial` has nothing but rows, modes and further columns in the plane.
pub(super) fn planar(spatial: &Superelement, normal: Normal, loads: &[usize]) -> Superelement {
    let [.., c] = normal.axes();
    let flat = |of: [f64; 3]| normal.flat(of);
    let flattened = Superelement {
        dimension: Dimension::Planar,
        origin: flat(spatial.origin),
        interfaces: (spatial.interfaces.iter())
            .map(|interface| InterfaceFrame {
                position: flat(interface.position),
                orientation: normal.flat_axes(&interface.orientation),
                ..interface.clone()
            })
            .collect(),
        rows: (spatial.rows.iter())
            .map(|row| BoundaryRow {
                direction: usize::try_from(row.direction)
                    .ok()
                    .and_then(|direction| normal.planar_direction(direction))
                    .map_or(-1, |direction| direction as i64),
                position: flat(row.position),
                ..*row
            })
            .collect(),
        inertia: inertia(&spatial.inertia, normal),
        stiffening: stiffening(spatial, c),
        loads: (loads.iter())
            .map(|place| &spatial.loads[*place])
            .map(|load| PartLoad {
                force: flat(load.force),
                moment: [0.0, 0.0, load.moment[c]],
                ..load.clone()
            })
            .collect(),
        stresses: (spatial.stresses.iter())
            .filter_map(|field| stress(field, normal))
            .collect(),
        ..spatial.clone()
    };
    Superelement {
        moments: (spatial.moments.as_ref()).map(|of| moments(&flattened, of)),
        ..flattened
    }
}

/// The field in the axes of the plane; components out of it stay, since they are there beside the plane of symmetry.
fn stress(field: &StressField, normal: Normal) -> Option<StressField> {
    let axes = normal.axes();
    let rows = axes.map(|own| std::array::from_fn(|axis| f64::from(u8::from(axis == own))));
    let mut turned = field.turned(rows)?;
    for point in &mut turned.points {
        point.position = normal.flat(point.position);
    }
    Some(turned)
}

/// Modes out of the plane aren't omitted, they don't take part. Nor do rigid motions out of it, which move rows off the plane within it.
fn moments(planar: &Superelement, of: &Moments) -> Moments {
    let role = |row: &BoundaryRow| planar.interfaces[row.interface].role;
    let rows = planar.rows.iter();
    let attached = rows.filter(|row| role(row) == Role::Attachment).count();
    let bound = (of.loaded.as_ref()).map(|loaded| loaded.eigenvalue_bound);
    Moments {
        eigenvalue_bound: bound.unwrap_or(of.eigenvalue_bound),
        rigid_shapes: match of.rigid_shapes.ncols() {
            0 => of.rigid_shapes.clone(),
            _ => rigid_motions(planar),
        },
        loaded: (of.loaded.clone()).filter(|loaded| loaded.forces.ncols() < attached),
        ..of.clone()
    }
}

impl Normal {
    /// Axes of a frame in the plane's: turned about the normal, if that is the frame's third axis, and parallel to the body's otherwise.
    pub fn flat_axes(self, of: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let [a, b, c] = self.axes();
        let (cosine, sine) = match of[c][2] > 1.0 - SAME_AXIS {
            true => {
                let size = of[a][0].hypot(of[b][0]);
                (of[a][0] / size, of[b][0] / size)
            }
            false => (1.0, 0.0),
        };
        [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]
    }
}

fn about_z(value: f64) -> [[f64; 3]; 3] {
    let mut block = [[0.0; 3]; 3];
    block[2][2] = value;
    block
}

fn inertia(spatial: &Inertia, normal: Normal) -> Inertia {
    let axes = normal.axes();
    let [.., c] = axes;
    let picked = |matrix: &Mat<f64>, rows: &[usize]| {
        Mat::from_fn(rows.len(), matrix.ncols(), |i, k| matrix[(rows[i], k)])
    };
    Inertia {
        mass: spatial.mass,
        tensor: about_z(spatial.tensor[c][c]),
        l1: picked(&spatial.l1, &axes[..2]),
        i1: (spatial.i1.iter())
            .map(|block| about_z(0.5 * block[c][c]))
            .collect(),
        i3: picked(&spatial.i3, &axes[2..]),
        l3: vec![spatial.l3[c].clone()],
        i2: Vec::new(),
    }
}

/// Planar files have I2 = Ψᵀ M Ψ, in which motions along the normal count as if they turned the component; they are taken back here.
fn stiffening(spatial: &Superelement, normal: usize) -> Stiffening {
    let count = spatial.basis_count();
    let mass = Mat::from_fn(count, count, |k, l| spatial.reduced_mass(k, l));
    let across = &mass - &spatial.inertia.i2[normal];
    let n = across.ncols();
    let matters = (0..n).any(|k| across[(k, k)].abs() > ROUNDING * mass[(k, k)]);
    let stored = spatial.stiffening.centrifugal.get(normal);
    let centrifugal = match stored {
        Some(stored) if matters => vec![stored + across],
        Some(stored) => vec![stored.clone()],
        None if matters => vec![across],
        None => Vec::new(),
    };
    Stiffening {
        centrifugal,
        interface: spatial.stiffening.interface.clone(),
    }
}
