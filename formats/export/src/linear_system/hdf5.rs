//! A linear system as HDF5.
//!
//! ```text
//! /A (n, n)   /B (n, n_u)   /C (n_y, n)   /D (n_y, n_u)
//! /states, /inputs, /outputs      name, unit: texts; at: value at the operating point
//! /poles                          real, imaginary, frequency, damping_ratio (n)
//! /truncation                     hankel, bounds (n_y, n_u); attributes full_order, kept_apart, bound
//! ```
//! Attributes of the root: `format`, `generator`, `length`, `mass`, `time_unit`, `time`, `is_equilibrium`.

use std::path::Path;

use dcb_formats::linear_system::{LinearSystem, Pole, Variable};
use dcb_formats::output::Replace;
use dcb_formats::{Error, write_hdf5};
use faer::Mat;
use hdf5::types::VarLenUnicode;
use hdf5::{File, Group, Location};

pub(super) fn write(system: &LinearSystem, path: &Path, replace: Replace) -> Result<(), Error> {
    let (n, rows) = (system.order(), system.c.nrows());
    let numbers = (n + rows) * (n + system.b.ncols());
    let needed = 8 * numbers as u64 + (1 << 16);
    write_hdf5(path, replace, needed, |file| fill(file, system))
}

fn fill(file: &File, system: &LinearSystem) -> hdf5::Result<()> {
    let units = &system.units;
    for (name, value) in [
        ("format", "dcb-linear-system 1"),
        ("generator", concat!("dcb ", env!("CARGO_PKG_VERSION"))),
        ("length", &units.length),
        ("mass", &units.mass),
        ("time_unit", &units.time),
    ] {
        let attribute = file.new_attr::<VarLenUnicode>().create(name)?;
        attribute.write_scalar(&text(value)?)?;
    }
    number(file, "time", &system.time)?;
    number(file, "is_equilibrium", &i64::from(system.is_equilibrium))?;
    for (name, of) in [
        ("A", &system.a),
        ("B", &system.b),
        ("C", &system.c),
        ("D", &system.d),
    ] {
        matrix(file, name, of)?;
    }
    for (name, of) in [
        ("states", &system.states),
        ("inputs", &system.inputs),
        ("outputs", &system.outputs),
    ] {
        variables(&file.create_group(name)?, of)?;
    }
    let poles = file.create_group("poles")?;
    let of_poles = |of: fn(&Pole) -> f64| system.poles.iter().map(of).collect::<Vec<f64>>();
    list(&poles, "real", &of_poles(|pole| pole.growth))?;
    list(
        &poles,
        "imaginary",
        &of_poles(|pole| pole.angular_frequency),
    )?;
    list(&poles, "frequency", &of_poles(Pole::frequency))?;
    list(&poles, "damping_ratio", &of_poles(Pole::damping_ratio))?;
    if let Some(truncation) = &system.truncation {
        let group = file.create_group("truncation")?;
        list(&group, "hankel", &truncation.hankel)?;
        matrix(&group, "bounds", &truncation.bounds)?;
        number(&group, "bound", &truncation.bound)?;
        number(&group, "full_order", &(truncation.full_order as i64))?;
        number(&group, "kept_apart", &(truncation.kept_apart as i64))?;
    }
    Ok(())
}

fn variables(group: &Group, of: &[Variable]) -> hdf5::Result<()> {
    texts(group, "name", &super::names(of))?;
    texts(group, "unit", &super::units(of))?;
    list(group, "at", &super::values(of))
}

fn matrix(group: &Group, name: &str, of: &Mat<f64>) -> hdf5::Result<()> {
    let dataset = group
        .new_dataset::<f64>()
        .no_chunk()
        .shape([of.nrows(), of.ncols()])
        .create(name)?;
    let rows = (0..of.nrows()).flat_map(|i| (0..of.ncols()).map(move |j| of[(i, j)]));
    let values: Vec<f64> = rows.collect();
    match values.is_empty() {
        true => Ok(()),
        false => dataset.write_raw(&values),
    }
}

fn list(group: &Group, name: &str, values: &[f64]) -> hdf5::Result<()> {
    let dataset = group
        .new_dataset::<f64>()
        .no_chunk()
        .shape(values.len())
        .create(name)?;
    match values.is_empty() {
        true => Ok(()),
        false => dataset.write_raw(values),
    }
}

fn texts(group: &Group, name: &str, values: &[&str]) -> hdf5::Result<()> {
    let texts: Vec<VarLenUnicode> = values
        .iter()
        .map(|value| text(value))
        .collect::<hdf5::Result<_>>()?;
    let dataset = group
        .new_dataset::<VarLenUnicode>()
        .shape(texts.len())
        .create(name)?;
    match texts.is_empty() {
        true => Ok(()),
        false => dataset.write_raw(&texts),
    }
}

fn number<T: hdf5::H5Type>(object: &Location, name: &str, value: &T) -> hdf5::Result<()> {
    object.new_attr::<T>().create(name)?.write_scalar(value)
}

fn text(value: &str) -> hdf5::Result<VarLenUnicode> {
    value
        .parse()
        .map_err(|_| hdf5::Error::from(format!("{value:?} has a zero byte")))
}
