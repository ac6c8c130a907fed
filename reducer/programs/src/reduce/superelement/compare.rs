//! `reduce compare A B`: how far two superelements agree, in SI units where their unit names are known.

use std::fmt::Write as _;
use std::path::Path;

use dcb_formats::component::Units;
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::mesh::Dimension;
use dcb_formats::{RecoveryBasis, Superelement};
use dcb_sparse::block_algebra::{gram, largest_entry};
use faer::{Mat, MatRef};

use crate::outcome::Outcome;
use crate::program::Detail;
use dcb_formats::units::hertz;
use dcb_formats::units::si_factor;
use dcb_reducer::error::{CommandRefusal, Error};
use dcb_reducer::scientific::scientific;

pub fn run(a: &Path, b: &Path, detail: Detail) -> Result<Outcome, Error> {
    let (file_a, file_b) = (SuperelementFile::open(a)?, SuperelementFile::open(b)?);
    let (first, second) = (file_a.superelement()?, file_b.superelement()?);
    if first.dimension != second.dimension {
        let (a, b) = (a.to_owned(), b.to_owned());
        return Err(CommandRefusal::DimensionsDiffer { a, b }.into());
    }
    let mut tables = heading('A', a, &first) + &heading('B', b, &second);
    let mass = mass_table(&mut tables, &first, &second);
    let shapes = matching_shapes(&first, &second, file_a.recovery()?, file_b.recovery()?);
    let frequencies = frequency_table(&mut tables, &first, &second, shapes.as_ref());
    let flexibility = flexibility_table(&mut tables, &first, &second);
    let verdict = verdict(
        [a, b],
        mass,
        frequencies,
        flexibility,
        [first.mode_count(), second.mode_count()],
    );
    Ok(Outcome::done(match detail {
        Detail::Verdict => verdict + "-v lists mass, modes and flexibility of both\n",
        Detail::Tables => verdict + &tables,
    }))
}

/// Relative differences below this are rounding of a reduction.
const ROUNDING: f64 = 1e-9;

/// One line: how far apart the two are, by their largest relative differences. There is none of the flexibility where rows differ.
fn verdict(
    [a, b]: [&Path; 2],
    mass: f64,
    frequencies: f64,
    flexibility: Option<f64>,
    [modes_a, modes_b]: [usize; 2],
) -> String {
    let (a, b) = (a.display(), b.display());
    let shown = |value: f64| match value < ROUNDING {
        true => "rounding".to_owned(),
        false => scientific(value, 1),
    };
    let modes = match modes_a == modes_b {
        true => format!("{modes_a} modes each"),
        false => format!("{modes_a} and {modes_b} modes"),
    };
    let is_same_when_loaded = flexibility.is_some_and(|value| value < ROUNDING);
    let flexibility = match flexibility {
        Some(value) => format!("static flexibility by {}", shown(value)),
        None => "static flexibility not compared (other boundary rows)".to_owned(),
    };
    let largest = mass.max(frequencies);
    let is_same = largest < ROUNDING && modes_a == modes_b && is_same_when_loaded;
    match is_same {
        true => format!("{a} and {b} are the same to rounding ({modes})\n"),
        false => format!(
            "{a} and {b} differ ({modes}): mass and inertia by {}, frequencies of both by at most {}, {flexibility}\n",
            shown(mass),
            shown(frequencies)
        ),
    }
}

fn heading(letter: char, path: &Path, element: &Superelement) -> String {
    let Units { length, mass, time } = &element.units;
    let known = [length, mass, time]
        .into_iter()
        .all(|unit| si_factor(unit).is_some());
    let unknown = if known {
        ""
    } else {
        "; a unit not known by name counts as 1 SI unit"
    };
    format!(
        "{letter} {} ({}; {length} {mass} {time}{unknown})\n",
        path.display(),
        element.name
    )
}

/// Size of the element's length, mass and time units in SI, 1 where a name is not known.
fn si(element: &Superelement) -> [f64; 3] {
    let units = &element.units;
    [&units.length, &units.mass, &units.time].map(|unit| si_factor(unit).unwrap_or(1.0))
}

/// A part of a whole; 0 of nothing.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// Writes mass and inertia of both; their largest difference.
fn mass_table(text: &mut String, a: &Superelement, b: &Superelement) -> f64 {
    let mut largest = 0.0_f64;
    let ([la, ma, _], [lb, mb, _]) = (si(a), si(b));
    let _ = writeln!(
        text,
        "{:<22} {:>18} {:>18}   difference",
        "in SI units", "A", "B"
    );
    let mut line = |what: &str, x: f64, y: f64, scale: f64| {
        let difference = share((x - y).abs(), scale);
        largest = largest.max(difference);
        let difference = apart(difference);
        let (x, y) = (scientific(x, 9), scientific(y, 9));
        let _ = writeln!(text, "{what:<22} {x:>18} {y:>18}   {difference:>10}");
    };
    let (mass_a, mass_b) = (a.inertia.mass * ma, b.inertia.mass * mb);
    line("mass [kg]", mass_a, mass_b, mass_a.max(mass_b));
    // Coordinates of the centre and products of inertia may be zero: what they are small against is the part.
    let moments = |element: &Superelement| {
        (0..3)
            .map(|axis| element.inertia.tensor[axis][axis])
            .fold(0.0, f64::max)
    };
    let moment = (moments(a) * ma * la * la).max(moments(b) * mb * lb * lb);
    let gyration = (moment / mass_a.min(mass_b)).sqrt();
    for (axis, name) in ["centre x [m]", "centre y [m]", "centre z [m]"]
        .iter()
        .enumerate()
        .take(a.dimension.coordinate_count())
    {
        line(name, a.origin[axis] * la, b.origin[axis] * lb, gyration);
    }
    let entries = [
        ("xx", 0, 0),
        ("yy", 1, 1),
        ("zz", 2, 2),
        ("xy", 0, 1),
        ("yz", 1, 2),
        ("zx", 2, 0),
    ];
    for (name, i, j) in entries {
        if a.dimension == Dimension::Spatial || name == "zz" {
            let (x, y) = (
                a.inertia.tensor[i][j] * ma * la * la,
                b.inertia.tensor[i][j] * mb * lb * lb,
            );
            line(&format!("inertia {name} [kg·m²]"), x, y, moment);
        }
    }
    largest
}

/// A relative difference for people: what is smaller than the rounding of one number is none.
fn apart(difference: f64) -> String {
    match difference < f64::EPSILON {
        true => "0".to_owned(),
        false => scientific(difference, 1),
    }
}

/// Shapes of both at the same places: the full fields where both have the same dofs, else the interface rows.
fn matching_shapes(
    a: &Superelement,
    b: &Superelement,
    fields_a: Option<RecoveryBasis>,
    fields_b: Option<RecoveryBasis>,
) -> Option<(Mat<f64>, Mat<f64>)> {
    if let (Some(x), Some(y)) = (fields_a, fields_b)
        && x.dofs == y.dofs
    {
        let translates = |i: usize| x.dofs[i].direction.index() < 3;
        return Some((
            in_si(&x.modes, a, translates),
            in_si(&y.modes, b, translates),
        ));
    }
    let places = |of: &Superelement| -> Vec<_> {
        let rows = of.rows.iter();
        rows.map(|row| (row.interface, row.direction)).collect()
    };
    let same_rows = places(a) == places(b);
    let translates = |i: usize| a.rows[i].direction < 3;
    (same_rows && !a.rows.is_empty()).then(|| {
        (
            in_si(&a.modes.interface_shapes, a, translates),
            in_si(&b.modes.interface_shapes, b, translates),
        )
    })
}

/// Shapes with translations in metres beside rotations in radians, so that both weigh the same whatever the units.
fn in_si(
    shapes: &Mat<f64>,
    element: &Superelement,
    translates: impl Fn(usize) -> bool,
) -> Mat<f64> {
    let [length, ..] = si(element);
    Mat::from_fn(shapes.nrows(), shapes.ncols(), |i, k| {
        shapes[(i, k)] * if translates(i) { length } else { 1.0 }
    })
}

/// Modal assurance criterion (x·y)² / (x·x)(y·y).
fn modal_assurance(x: MatRef<'_, f64>, y: MatRef<'_, f64>) -> Mat<f64> {
    let (xy, xx, yy) = (gram(x, y), gram(x, x), gram(y, y));
    Mat::from_fn(x.ncols(), y.ncols(), |i, j| {
        share(xy[(i, j)] * xy[(i, j)], xx[(i, i)] * yy[(j, j)])
    })
}

/// Writes the frequencies of both; the largest difference of those that both have.
fn frequency_table(
    text: &mut String,
    a: &Superelement,
    b: &Superelement,
    shapes: Option<&(Mat<f64>, Mat<f64>)>,
) -> f64 {
    let mut largest = 0.0_f64;
    let assurance = shapes.map(|(x, y)| modal_assurance(x.as_ref(), y.as_ref()));
    let _ = writeln!(
        text,
        "mode {:>17} {:>18}   difference   best MAC of A in B",
        "A [Hz]", "B [Hz]"
    );
    let rows = a.mode_count().max(b.mode_count());
    for i in 0..rows {
        let of = |element: &Superelement| {
            element
                .modes
                .eigenvalues
                .get(i)
                .map(|eigenvalue| hertz(*eigenvalue, &element.units.time))
        };
        let (x, y) = (of(a), of(b));
        let show = |value: Option<f64>| value.map_or("–".to_owned(), |hz| format!("{hz:.9}"));
        let difference = match (x, y) {
            (Some(x), Some(y)) => {
                let difference = share((x - y).abs(), x.abs().max(y.abs()));
                largest = largest.max(difference);
                apart(difference)
            }
            _ => String::new(),
        };
        let best = assurance
            .as_ref()
            .filter(|mac| i < mac.nrows() && mac.ncols() > 0)
            .map_or(String::new(), |mac| {
                let best = (0..mac.ncols())
                    .max_by(|j, k| mac[(i, *j)].total_cmp(&mac[(i, *k)]))
                    .unwrap_or(0);
                format!("{:.6} with {}", mac[(i, best)], best + 1)
            });
        let _ = writeln!(
            text,
            "{:4} {:>17} {:>18}   {difference:>10}   {best}",
            i + 1,
            show(x),
            show(y)
        );
    }
    if a.mode_count() != b.mode_count() {
        let _ = writeln!(
            text,
            "A keeps {} modes, B {}",
            a.mode_count(),
            b.mode_count()
        );
    }
    largest
}

/// Contribution of the kept modes to a flexibility.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ModalPart {
    Added,
    LeftOut,
}

/// F_res in SI units, with the kept modes' static part added back or not.
fn flexibility(element: &Superelement, modal_part: ModalPart) -> Mat<f64> {
    let [length, mass, time] = si(element);
    let force = mass * length / (time * time);
    let shapes = &element.modes.interface_shapes;
    let n_b = element.rows.len();
    let is_rotation = |i: usize| element.rows[i].direction >= 3;
    Mat::from_fn(n_b, n_b, |i, j| {
        let modal: f64 = match modal_part {
            ModalPart::LeftOut => 0.0,
            ModalPart::Added => (0..element.mode_count())
                .filter(|k| element.modes.eigenvalues[*k] > 0.0)
                .map(|k| shapes[(i, k)] * shapes[(j, k)] / element.modes.eigenvalues[k])
                .sum(),
        };
        let displacement = if is_rotation(i) { 1.0 } else { length };
        let load = if is_rotation(j) {
            force * length
        } else {
            force
        };
        (element.residual.flexibility[(i, j)] + modal) * displacement / load
    })
}

/// Writes how far the flexibilities are apart; the difference with the kept modes, `None` where rows differ.
fn flexibility_table(text: &mut String, a: &Superelement, b: &Superelement) -> Option<f64> {
    let directions =
        |of: &Superelement| -> Vec<_> { of.rows.iter().map(|row| row.direction).collect() };
    if directions(a) != directions(b) {
        let _ = writeln!(
            text,
            "flexibility not compared: A has {} boundary rows, B {} (or other directions)",
            a.rows.len(),
            b.rows.len()
        );
        return None;
    }
    // Both differences are scaled by the static flexibility, which does not depend on the modes kept.
    let whole = [
        flexibility(a, ModalPart::Added),
        flexibility(b, ModalPart::Added),
    ];
    let scale = |i: usize| {
        whole[0][(i, i)]
            .abs()
            .max(whole[1][(i, i)].abs())
            .max(f64::MIN_POSITIVE)
            .sqrt()
    };
    let difference = |x: &Mat<f64>, y: &Mat<f64>| {
        let scaled = Mat::from_fn(x.nrows(), x.ncols(), |i, j| {
            (x[(i, j)] - y[(i, j)]) / (scale(i) * scale(j))
        });
        largest_entry(scaled.as_ref())
    };
    let static_difference = difference(&whole[0], &whole[1]);
    let _ = writeln!(
        text,
        "F_res + kept modes, largest scaled difference  {}",
        apart(static_difference)
    );
    if a.mode_count() == b.mode_count() {
        let residual = [
            flexibility(a, ModalPart::LeftOut),
            flexibility(b, ModalPart::LeftOut),
        ];
        let _ = writeln!(
            text,
            "F_res, largest scaled difference               {}",
            apart(difference(&residual[0], &residual[1]))
        );
    }
    Some(static_difference)
}
