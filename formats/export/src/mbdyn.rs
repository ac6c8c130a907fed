//! MBDyn: the file of a modal joint, in blocks of text.
//!
//! | record | holds |
//! | --- | --- |
//! | 1, 2, 5 to 7 | sizes, labels of the frames, their places |
//! | 8 | displacements and rotations of the frames, mode after mode |
//! | 9, 10, 13 | 1, diag(ω², σ²), diag(2 ζ ω) |
//! | 12 | mass, centre of mass, inertia about it |
//! | 14 to 18 | L1; I3; N_k side by side; L3_kl and P_kl side by side, k outer, l inner |
//! | 19 | geometric stiffness, where the superelement has it: 1 to 6 by spin, 12 + 6 (i − 1) + d by force and moment d on the i-th interface of the joint |
//!
//! Nothing is written into 11 (masses of nodes): MBDyn would add it to 12. Records 7 to 12 of 19 (accelerations) stay out: forces on an interface come with
//! the inertia that balances them.

use std::fmt::Write as _;

use dcb_formats::Error;
use faer::Mat;
use nalgebra::Matrix3;

use crate::Request;
use crate::files::product::{Content, Product};
use crate::part::basis::Basis;
use crate::part::frames::Frame;
use crate::part::left_out::{Holds, left_out, unit_note};
use crate::part::{Part, Source};

/// A part as MBDyn reads it.
pub(crate) fn product(source: &Source, request: &Request<'_>) -> Result<Product, Error> {
    let part = Part::spatial(source, request)?;
    let (frames, notes) = part.nodes()?;
    let basis = &part.basis;
    let text = file(&part, &frames);
    let summary = format!(
        "{} nodes, {} modes: {}",
        frames.len(),
        basis.count(),
        part.coordinates()
    );
    let mut product = Product::new(Content::Bytes(text.into_bytes()), summary);
    product.notes = notes;
    let stiffened = !basis.centrifugal.is_empty() || !basis.interface.is_empty();
    if stiffened {
        product.notes.push("record 19 (geometric stiffness) acts only with `use automatic differentiation;` in MBDyn's control data, and only with all interfaces in the joint in the order below".to_owned());
    }
    product.notes.extend(unit_note(&part));
    product.left_out = left_out(
        &part,
        Holds {
            inertia_change: true,
            stiffening: true,
            damping: true,
            outputs: true,
            ..Holds::default()
        },
    )?;
    product.paste = Some((
        "in MBDyn's input, BODY a structural node of type modal, JOINT and NODE_i labels of yours:",
        joint(&frames, basis, request.file_name),
    ));
    Ok(product)
}

/// Text in records.
struct Records {
    text: String,
}

impl Records {
    fn begin(&mut self, number: usize, what: &str) {
        let _ = writeln!(self.text, "**\n** RECORD GROUP {number}, {what}");
    }

    fn line(&mut self, values: impl IntoIterator<Item = f64>) {
        let words: Vec<String> = values
            .into_iter()
            .map(|value| format!("{value:e}"))
            .collect();
        self.text += &words.join(" ");
        self.text.push('\n');
    }

    fn matrix(&mut self, of: &Mat<f64>) {
        for i in 0..of.nrows() {
            self.line((0..of.ncols()).map(|j| of[(i, j)]));
        }
    }

    fn diagonal(&mut self, of: &[f64]) {
        for (i, value) in of.iter().enumerate() {
            self.line((0..of.len()).map(|j| if i == j { *value } else { 0.0 }));
        }
    }

    /// Blocks of three rows, side by side.
    fn blocks(&mut self, of: impl Iterator<Item = Matrix3<f64>>) {
        let blocks: Vec<Matrix3<f64>> = of.collect();
        for a in 0..3 {
            self.line(
                blocks
                    .iter()
                    .flat_map(|block| (0..3).map(move |b| block[(a, b)])),
            );
        }
    }
}

fn file(part: &Part<'_>, frames: &[&Frame]) -> String {
    let basis = &part.basis;
    let q = basis.count();
    let mut all = Records {
        text: format!("** {}\n", part.source.origin_line()),
    };
    all.begin(1, "HEADER");
    let _ = writeln!(
        all.text,
        "** REVISION, NODE, NORMAL, ATTACHMENT, CONSTRAINT, REJECTED MODES.\nREV0 {} {q} 0 0 0",
        frames.len()
    );
    all.begin(2, "FINITE ELEMENT NODE LIST");
    let labels: Vec<&str> = frames
        .iter()
        .map(|frame| frame.safe_name.as_str())
        .collect();
    let _ = writeln!(all.text, "{}", labels.join(" "));
    for (axis, name) in ["X", "Y", "Z"].iter().enumerate() {
        all.begin(5 + axis, &format!("NODAL {name} COORDINATES"));
        for frame in frames {
            all.line([frame.position[axis]]);
        }
    }
    all.begin(8, "MODE SHAPES");
    for k in 0..q {
        let _ = writeln!(all.text, "** NORMAL MODE SHAPE # {}", k + 1);
        for frame in frames {
            all.line(frame.motion(|row| basis.rows[(row, k)]));
        }
    }
    all.begin(9, "MODAL MASS MATRIX");
    all.diagonal(&vec![1.0; q]);
    all.begin(10, "MODAL STIFFNESS MATRIX");
    all.diagonal(&basis.stiffness);
    all.begin(12, "GLOBAL INERTIA");
    all.line([basis.mass]);
    all.line(basis.centre.iter().copied());
    all.blocks(std::iter::once(basis.tensor));
    all.begin(13, "MODAL DAMPING MATRIX");
    all.diagonal(&basis.damping);
    all.begin(14, "INVARIANT 3");
    all.matrix(&basis.l1);
    all.begin(15, "INVARIANT 4");
    all.matrix(&basis.i3);
    all.begin(16, "INVARIANT 8");
    all.blocks((0..q).map(|k| basis.first(k)));
    all.begin(17, "INVARIANT 5");
    for of in &basis.l3 {
        all.line((0..q).flat_map(|k| (0..q).map(move |l| of[(k, l)])));
    }
    all.begin(18, "INVARIANT 9");
    all.blocks((0..q).flat_map(|k| (0..q).map(move |l| basis.second(k, l))));
    let stiffening = stiffening(basis, frames);
    if !stiffening.is_empty() {
        all.begin(19, "GEOMETRIC STIFFNESS");
        let _ = writeln!(all.text, "{}", stiffening.len());
        for (index, of) in stiffening {
            let _ = writeln!(all.text, "{index}");
            all.matrix(of);
        }
    }
    all.text += "** END OF FILE\n";
    all.text
}

/// Indices of record 19, and their matrices. Those of interfaces that are only observed are zero in the superelement.
fn stiffening<'b>(basis: &'b Basis, frames: &[&Frame]) -> Vec<(usize, &'b Mat<f64>)> {
    let spin = basis.centrifugal.iter().enumerate();
    let mut all: Vec<_> = spin.map(|(pair, of)| (pair + 1, of)).collect();
    for (place, frame) in frames.iter().enumerate() {
        for (direction, row) in frame.rows.iter().enumerate() {
            let of = row.and_then(|row| basis.interface.get(row));
            all.extend(of.map(|of| (13 + 6 * place + direction, of)));
        }
    }
    all
}

/// The joint, as MBDyn's input has it.
fn joint(frames: &[&Frame], basis: &Basis, file_name: &str) -> String {
    let mut text = format!(
        "joint: JOINT, modal, BODY,\n    {},\n    from file,\n    damping from file,\n    {file_name:?},\n    {}",
        basis.count(),
        frames.len()
    );
    for (index, frame) in frames.iter().enumerate() {
        let _ = write!(
            text,
            ",\n    {:?}, NODE_{}, null",
            frame.safe_name,
            index + 1
        );
    }
    text + ";\n"
}
