//! Nastran bulk data: one GRID a frame, SPOINTs for the coordinates behind them, and the primal form as DMIG or in an OUTPUT4 file.
//!
//! A large field has 16 characters: eleven or twelve digits of a number. What is lost of K and M that way is said; OUTPUT4 loses nothing.

use std::fmt::Write as _;

use dcb_formats::Error;
use faer::Mat;

use crate::Request;
use crate::files::op4;
use crate::files::product::{Content, Product};
use crate::part::left_out::{Holds, left_out, unit_note};
use crate::part::primal::Primal;
use crate::part::{Part, Source};

/// Largest number of a GRID or SPOINT in a field of eight characters.
const MOST_POINTS: usize = 99_999_999;

/// A part's primal form as bulk data.
pub(crate) fn product(source: &Source, request: &Request<'_>) -> Result<Product, Error> {
    let part = Part::spatial(source, request)?;
    let primal = Primal::of(&part)?;
    if primal.count() > MOST_POINTS {
        return Err(part.refused(format!(
            "has {} coordinates: too many to number",
            primal.count()
        )));
    }
    let mut text = head(&part, request);
    points(&mut text, &primal);
    let mut product = match request.dialect {
        "op4" => op4_files(text, &primal, request),
        _ => dmig_file(text, &primal),
    };
    product.notes.extend(unit_note(&part));
    product.left_out = left_out(
        &part,
        Holds {
            damping: true,
            ..Holds::default()
        },
    )?;
    Ok(product)
}

fn head(part: &Part<'_>, request: &Request<'_>) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "$ {}", part.source.origin_line());
    let _ = writeln!(
        text,
        "$ coordinates: GRID 1, 2, ... with six components each, then SPOINTs: six of inertia relief, then modes"
    );
    let _ = writeln!(
        text,
        "$ positions from the {}; displacements along the component's axes",
        match request.axes {
            crate::Axes::Body => "centre of mass",
            crate::Axes::Component => "component's origin",
        }
    );
    text
}

/// GRIDs and SPOINTs.
fn points(text: &mut String, primal: &Primal) {
    for (index, frame) in primal.frames.iter().enumerate() {
        let [x, y, z] = [0, 1, 2].map(|a| real16(frame.position[a]));
        let id = index + 1;
        let _ = writeln!(text, "$ GRID {id}: {}", frame.safe_name);
        let _ = writeln!(text, "{:<8}{id:>16}{:>16}{x:>16}{y:>16}", "GRID*", 0);
        let _ = writeln!(text, "{:<8}{z:>16}{:>16}", "*", 0);
    }
    let first = primal.frames.len() + 1;
    let last = primal.frames.len() + primal.modal_count;
    let _ = writeln!(text, "{:<8}{first:>8}{:>8}{last:>8}", "SPOINT", "THRU");
}

/// Point and component of each coordinate.
fn places(primal: &Primal) -> Vec<(usize, usize)> {
    let boundary = primal.boundary_count();
    let place = |i: usize| match i < boundary {
        true => (i / 6 + 1, i % 6 + 1),
        false => (primal.frames.len() + 1 + i - boundary, 0),
    };
    (0..primal.count()).map(place).collect()
}

/// The matrices with the names that case control, or a superelement's assembly, gives them.
fn matrices<'p>(primal: &'p Primal, names: [&'static str; 3]) -> Vec<(&'static str, &'p Mat<f64>)> {
    let mut all = vec![(names[0], &primal.stiffness), (names[1], &primal.mass)];
    all.extend(primal.damping.as_ref().map(|damping| (names[2], damping)));
    all
}

fn dmig_file(mut text: String, primal: &Primal) -> Product {
    let all = matrices(primal, ["KAAX", "MAAX", "BAAX"]);
    let mut control = String::new();
    let places = places(primal);
    let mut printed = Vec::new();
    for ((name, of), command) in all.into_iter().zip(["K2GG", "M2GG", "B2GG"]) {
        let _ = writeln!(control, "{command} = {name}");
        printed.push((name, dmig(&mut text, name, of, &places), of));
    }
    let rounded = printed.iter().map(|(name, printed, of)| {
        let off = (printed - *of).norm_max() / of.norm_max();
        format!("{name} {off:.0e}")
    });
    let rounded: Vec<String> = rounded.collect();
    let note = format!(
        "DMIG has 11 to 12 digits a number: off by, relative to the largest entry, {}; K R is {:.0e} of K as printed, {:.0e} before; --dialect op4 loses nothing",
        rounded.join(", "),
        primal.rigid_residual(&printed[0].1),
        primal.rigid_residual(&primal.stiffness)
    );
    let mut product = Product::new(Content::Bytes(text.into_bytes()), primal.summary());
    product.notes.push(note);
    product.paste = Some(("case control, with this file in the bulk data:", control));
    product
}

/// The lower triangle, column after column; returns the matrix as it was printed.
fn dmig(text: &mut String, name: &str, of: &Mat<f64>, places: &[(usize, usize)]) -> Mat<f64> {
    let n = of.nrows();
    let mut printed = Mat::zeros(n, n);
    let _ = writeln!(
        text,
        "{:<8}{name:<8}{:>8}{:>8}{:>8}{:>8}",
        "DMIG", 0, 6, 2, 0
    );
    for j in 0..n {
        let (grid, component) = places[j];
        let mut is_first = true;
        for i in j..n {
            if of[(i, j)] == 0.0 {
                continue;
            }
            if is_first {
                let _ = writeln!(text, "{:<8}{name:<16}{grid:>16}{component:>16}", "DMIG*");
                is_first = false;
            }
            let value = real16(of[(i, j)]);
            let read: f64 = value.replace('D', "e").parse().unwrap_or(f64::NAN);
            printed[(i, j)] = read;
            printed[(j, i)] = read;
            let (grid, component) = places[i];
            let _ = writeln!(text, "{:<8}{grid:>16}{component:>16}{value:>16}", "*");
        }
    }
    printed
}

/// Bulk data with the order of the rows, and the matrices beside it.
fn op4_files(mut text: String, primal: &Primal, request: &Request<'_>) -> Product {
    let mut fields: Vec<String> = Vec::new();
    for frame in 1..=primal.frames.len() {
        fields.extend([format!("{frame:>8}"), format!("{:>8}", 123_456)]);
    }
    for point in 0..primal.modal_count {
        let point = primal.frames.len() + 1 + point;
        fields.extend([format!("{point:>8}"), format!("{:>8}", 0)]);
    }
    let _ = writeln!(text, "$ rows of the matrices");
    for (line, fields) in fields.chunks(8).enumerate() {
        let keyword = if line == 0 { "EXTRN" } else { "" };
        let _ = writeln!(text, "{keyword:<8}{}", fields.concat());
    }
    let all = matrices(primal, ["KXX", "MXX", "BXX"]);
    let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
    let bytes = op4::file(&all);
    let mut product = Product::new(
        Content::Bytes(text.into_bytes()),
        format!(
            "{}; {} in the OUTPUT4 file",
            primal.summary(),
            names.join(", ")
        ),
    );
    product.beside = Some(("op4", bytes));
    product.notes.push(primal.rigid_note());
    let stem = request
        .file_name
        .rsplit_once('.')
        .map_or(request.file_name, |(stem, _)| stem);
    product.paste = Some((
        "file management, for an external superelement (rows by the EXTRN entry):",
        format!("ASSIGN INPUTT4='{stem}.op4',UNIT=31,FORM=UNFORMATTED\n"),
    ));
    product
}

/// A number in 16 characters, with as many digits as fit.
fn real16(value: f64) -> String {
    let with_point = |text: String| -> String {
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let point = if digits.contains('.') { "" } else { "." };
        format!("{digits}{point}D{exponent}")
    };
    let shortest = with_point(format!("{value:e}"));
    let rounded = (0..=13)
        .rev()
        .map(|digits| with_point(format!("{value:.digits$e}")));
    std::iter::once(shortest)
        .chain(rounded)
        .find(|text| text.len() <= 16)
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::real16;

    #[test]
    fn sixteen_characters_hold_eleven_digits_of_any_number() {
        for value in [
            1.0 / 3.0,
            -2.0 / 3.0e5,
            1.25,
            0.0,
            -1e300 / 3.0,
            1e-300 / 7.0,
            6.02e23,
        ] {
            let text = real16(value);
            assert!(text.len() <= 16 && text.contains('.'), "{text}");
            let read: f64 = text.replace('D', "e").parse().unwrap_or(f64::NAN);
            assert!((read - value).abs() <= 1e-9 * value.abs(), "{text}");
        }
        assert_eq!(real16(1.25), "1.25D0");
        assert_eq!(real16(-1.0), "-1.D0");
        assert_eq!(real16(1.0 / 3.0), "3.33333333333D-1");
    }
}
