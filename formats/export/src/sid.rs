//! Standard input data (SID_FEM): the Taylor coefficients of a flexible body as Wallrapp's form names them.
//!
//! ```text
//! mdCM: m c, m1 = L1     J: m0 = J, m1 = I1     Ct = L1ᵀ     Cr = I3ᵀ, m1(i,k,a) = L3[a,k,i]     Me = 1
//! Gr = 2 N_k, mode after mode     Ge(i, (a,j)) = 2 L3[a,j,i], direction after direction
//! Oe, columns xx yy zz xy yz xz:  m0 = −½ I1 on the diagonal, −I1 off it;  m1 = −I2 or −2 I2, and the geometric stiffness by spin
//! ```
//! Two dialects differ in J: a column xx yy zz xy xz yz (`vector`), or a symmetric 3 x 3 matrix (`matrix`).

use std::fmt::Write as _;

use dcb_formats::Error;
use dcb_formats::units::hertz;

use crate::Request;
use crate::files::product::{Content, Product};
use crate::part::basis::{Basis, PAIRS};
use crate::part::frames::Frame;
use crate::part::left_out::{Holds, left_out, unit_note};
use crate::part::{Part, Source};

/// Components of J in its column; unlike the columns of Oe.
const TENSOR: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// A part as standard input data.
pub(crate) fn product(source: &Source, request: &Request<'_>) -> Result<Product, Error> {
    let part = Part::spatial(source, request)?;
    let (frames, notes) = part.nodes()?;
    let text = file(&part, &frames, request.dialect);
    let summary = format!(
        "{} nodes, {} modes: {}; J as a {}",
        frames.len(),
        part.basis.count(),
        part.coordinates(),
        match request.dialect {
            "matrix" => "3 x 3 matrix",
            _ => "column of six (--dialect matrix: 3 x 3)",
        }
    );
    let mut product = Product::new(Content::Bytes(text.into_bytes()), summary);
    product.notes = notes;
    product
        .notes
        .push("numbers have 12 digits, as the format prints them".to_owned());
    let names = frames.iter().enumerate();
    let names: Vec<String> = names
        .map(|(index, frame)| format!("{} = {:?}", index + 1, frame.name))
        .collect();
    product.notes.push(format!("nodes: {}", names.join(", ")));
    product.notes.extend(unit_note(&part));
    let by_forces = part.basis.interface.len();
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
    if by_forces > 0 {
        product.left_out.push(format!(
            "geometric stiffness by interface forces: {by_forces} matrices; that by spin is in Oe"
        ));
    }
    Ok(product)
}

/// The coefficient of a mode in an entry: row, mode, column.
type Slope<'a> = Box<dyn Fn(usize, usize, usize) -> f64 + 'a>;

/// A matrix with its constant and linear coefficients; `value(i, j)` and `slope(i, k, j)`, all from 0.
struct Taylor<'a> {
    rows: usize,
    columns: usize,
    value: Box<dyn Fn(usize, usize) -> f64 + 'a>,
    slope: Option<Slope<'a>>,
    /// Where the form has a name for it: 1 diagonal, 2 symmetric, 4 unit.
    structure: usize,
}

impl<'a> Taylor<'a> {
    fn constant(rows: usize, columns: usize, value: impl Fn(usize, usize) -> f64 + 'a) -> Self {
        Self {
            rows,
            columns,
            value: Box::new(value),
            slope: None,
            structure: 3,
        }
    }

    fn with_slope(self, slope: impl Fn(usize, usize, usize) -> f64 + 'a) -> Self {
        Self {
            slope: Some(Box::new(slope)),
            ..self
        }
    }

    fn of_structure(self, structure: usize) -> Self {
        Self { structure, ..self }
    }
}

/// Lines at depths of nesting.
struct Lines {
    text: String,
    count: usize,
}

impl Lines {
    fn line(&mut self, depth: usize, text: &str) {
        let _ = writeln!(self.text, "{:depth$}{text}", "");
    }

    fn field(&mut self, depth: usize, name: &str, value: &str) {
        let width = 48_usize.saturating_sub(depth);
        self.line(depth, &format!("{name:<width$}={value}"));
    }

    fn matrix(&mut self, depth: usize, name: &str, of: &Taylor<'_>) {
        let q = self.count;
        let mut entries = Vec::new();
        for j in 0..of.columns {
            for i in 0..of.rows {
                let value = (of.value)(i, j);
                if value != 0.0 {
                    entries.push((format!("m0({:2},{:2})", i + 1, j + 1), value));
                }
            }
        }
        if let Some(slope) = &of.slope {
            for j in 0..of.columns {
                for i in 0..of.rows {
                    for k in 0..q {
                        let value = slope(i, k, j);
                        if value != 0.0 {
                            entries
                                .push((format!("m1({:2},{:2},{:2})", i + 1, k + 1, j + 1), value));
                        }
                    }
                }
            }
        }
        let is_unit =
            of.structure == 4 && !entries.iter().any(|(place, _)| place.starts_with("m1"));
        let structure = match of.structure {
            _ if entries.is_empty() => 0,
            4 if !is_unit => 3,
            structure => structure,
        };
        self.line(depth, name);
        let inside = 26;
        for (field, value) in [
            ("order", usize::from(of.slope.is_some())),
            ("nrow", of.rows),
            ("ncol", of.columns),
            ("nq", q),
            ("nqn", 0),
            ("structure", structure),
        ] {
            self.field(inside, field, &format!("{value:5}"));
        }
        if !is_unit {
            for (place, value) in entries {
                self.field(inside, &place, &number(value));
            }
        }
        self.line(depth, &format!("end {name}"));
    }
}

/// As `%18.11E`, with a D.
fn number(value: f64) -> String {
    let text = format!("{value:.11e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or_default();
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{:>18}", format!("{digits}D{sign}{:02}", exponent.abs()))
}

fn file(part: &Part<'_>, frames: &[&Frame], dialect: &str) -> String {
    let basis = &part.basis;
    let q = basis.count();
    let mut all = Lines {
        text: format!(
            "{:5}{q:4}    :No. nodes, No. modes: {}\n",
            frames.len(),
            part.source.origin_line()
        ),
        count: q,
    };
    all.line(1, "part");
    all.line(6, "new modal                                 =");
    all.line(11, "refmod");
    all.field(16, "mass", &number(basis.mass));
    all.field(16, "nelastq", &format!("{q:6}"));
    let time = &part.superelement.units.time;
    for (k, square) in basis.stiffness.iter().enumerate() {
        let name = format!("ielastq ({:4})", k + 1);
        all.field(
            16,
            &name,
            &format!(" Eigen Mode {:4} : {:12.3} Hz", k + 1, hertz(*square, time)),
        );
    }
    all.line(11, "end refmod");
    all.line(11, "frame");
    for (index, frame) in frames.iter().enumerate() {
        node(&mut all, index + 1, frame, basis);
    }
    all.line(11, "end frame");
    integrals(&mut all, basis, dialect);
    all.line(6, "end modal");
    all.line(1, "end part");
    all.text
}

fn node(all: &mut Lines, number: usize, frame: &Frame, basis: &Basis) {
    let q = basis.count();
    let motion: Vec<[f64; 6]> = (0..q)
        .map(|k| frame.motion(|row| basis.rows[(row, k)]))
        .collect();
    let turn = |k: usize| nalgebra::Vector3::from_column_slice(&motion[k][3..]).cross_matrix();
    all.field(16, "new node", &format!("{number:8}"));
    all.field(21, "rframe", "    body ref");
    let origin =
        Taylor::constant(3, 1, |a, _| frame.position[a]).with_slope(|a, k, _| motion[k][a]);
    all.matrix(21, "origin", &origin);
    all.matrix(21, "phi", &Taylor::constant(3, q, |a, k| motion[k][a]));
    all.matrix(21, "psi", &Taylor::constant(3, q, |a, k| motion[k][3 + a]));
    let axes = Taylor::constant(3, 3, |a, b| f64::from(u8::from(a == b)));
    let axes = axes.with_slope(|a, k, b| turn(k)[(a, b)]).of_structure(4);
    all.matrix(21, "AP", &axes);
    all.line(16, "end node");
}

fn integrals(all: &mut Lines, basis: &Basis, dialect: &str) {
    let q = basis.count();
    let first_moment = basis.centre * basis.mass;
    let moment =
        Taylor::constant(3, 1, |a, _| first_moment[a]).with_slope(|a, k, _| basis.l1[(a, k)]);
    all.matrix(11, "mdCM", &moment);
    let tensor = basis.tensor_about_origin();
    let inertia = match dialect {
        "matrix" => Taylor::constant(3, 3, |a, b| tensor[(a, b)])
            .with_slope(|a, k, b| basis.i1[k][(a, b)])
            .of_structure(2),
        _ => Taylor::constant(6, 1, |i, _| tensor[TENSOR[i]])
            .with_slope(|i, k, _| basis.i1[k][TENSOR[i]]),
    };
    all.matrix(11, "J", &inertia);
    all.matrix(11, "Ct", &Taylor::constant(q, 3, |i, a| basis.l1[(a, i)]));
    let coupling = Taylor::constant(q, 3, |i, a| basis.i3[(a, i)]);
    all.matrix(
        11,
        "Cr",
        &coupling.with_slope(|i, k, a| basis.l3[a][(k, i)]),
    );
    let unit = Taylor::constant(q, q, |i, j| f64::from(u8::from(i == j)));
    all.matrix(11, "Me", &unit.of_structure(4));
    all.matrix(
        11,
        "Gr",
        &Taylor::constant(3, 3 * q, |a, j| 2.0 * basis.first(j / 3)[(a, j % 3)]),
    );
    all.matrix(
        11,
        "Ge",
        &Taylor::constant(q, 3 * q, |i, j| 2.0 * basis.l3[j / q][(j % q, i)]),
    );
    // The products of spins off the diagonal stand for two entries of the tensor.
    let twice = |pair: usize| if pair < 3 { 1.0 } else { 2.0 };
    let stiffness =
        |pair: usize, i: usize, k: usize| basis.centrifugal.get(pair).map_or(0.0, |of| of[(i, k)]);
    let spin = Taylor::constant(q, 6, |i, pair| {
        -0.5 * twice(pair) * basis.i1[i][PAIRS[pair]]
    });
    let spin =
        spin.with_slope(|i, k, pair| stiffness(pair, i, k) - twice(pair) * basis.i2[pair][(i, k)]);
    all.matrix(11, "Oe", &spin);
    all.matrix(11, "ksigma", &Taylor::constant(q, 1, |_, _| 0.0));
    let diagonal = |of: &'_ [f64], i: usize, j: usize| if i == j { of[i] } else { 0.0 };
    let stiffness = Taylor::constant(q, q, |i, j| diagonal(&basis.stiffness, i, j));
    all.matrix(11, "Ke", &stiffness.of_structure(1));
    let damping = Taylor::constant(q, q, |i, j| diagonal(&basis.damping, i, j));
    all.matrix(11, "De", &damping.of_structure(1));
}
