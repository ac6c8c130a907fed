//! Dimension scales: the axes of channels by name, with times and names of columns, as netCDF, xarray and h5netcdf read them.
//!
//! `/time` is the scale of the first axis of every channel, and has another name, a hard link, in every group that has channels: readers of one
//! group find the times there. The second axis has a scale in the group, of strings, which channels with the same columns share; that of
//! a number alone is `/single`, which has no values. A scale and what it belongs to refer to each other by attributes that the specification of
//! HDF5's dimension scales names; they are written here with what the library itself has, since the high-level library isn't linked.

use std::collections::{BTreeMap, BTreeSet};

use hdf5::types::{FixedAscii, VarLenArray, VarLenUnicode};
use hdf5::{Dataset, Datatype, File, H5Type, Location, ObjectReference, ObjectReference1};

use super::channel::Channel;
use crate::hdf5_files::attributes::hdf5_text;

/// Name of the second axis of a channel of one number.
pub(super) const SINGLE: &str = "single";
/// Longest name that is made of the names of the columns.
const LONGEST_NAME: usize = 24;
/// Bytes of `DIMENSION_SCALE` and the zero behind it.
const CLASS_BYTES: usize = 16;
/// Bytes of the name of a scale, at most.
const NAME_BYTES: usize = 128;
/// References of one attribute, at most: HDF5 keeps 64 KiB of them. Scales that more refer to don't list who does.
const MOST_REFERENCES: usize = 4000;

/// A reference from a scale back to an axis.
#[derive(Clone, Copy, Debug, H5Type)]
#[repr(C)]
struct BackReference {
    dataset: ObjectReference1,
    dimension: u32,
}

/// Scales of a file, and who belongs to them.
pub(super) struct Scales<'a> {
    file: &'a File,
    /// Paths of groups and datasets that channels have.
    taken: BTreeSet<String>,
    /// Names of `/time` in the groups.
    times: Vec<String>,
    /// Of a group's columns: path of their scale.
    columns: BTreeMap<(String, Vec<&'a str>), String>,
    ties: Ties,
}

/// References between datasets and the scales of their axes.
#[derive(Default)]
pub(super) struct Ties {
    /// By path of the scale.
    users: BTreeMap<String, Vec<BackReference>>,
}

impl Ties {
    /// Ties the axes of the dataset at a path to scales, by their paths.
    pub(super) fn tie(&mut self, file: &File, path: &str, scales: &[String]) -> hdf5::Result<()> {
        let own = ObjectReference1::create(file, path)?;
        let mut axes = Vec::new();
        for (scale, dimension) in scales.iter().zip(0..) {
            let reference = ObjectReference1::create(file, scale)?;
            axes.push(VarLenArray::from_slice(&[reference]));
            let users = self.users.entry(scale.clone()).or_default();
            users.push(BackReference {
                dataset: own,
                dimension,
            });
        }
        let list = file
            .dataset(path)?
            .new_attr::<VarLenArray<ObjectReference1>>();
        list.shape(axes.len())
            .create("DIMENSION_LIST")?
            .write_raw(&axes)
    }

    /// Tells the scales who belongs to them.
    pub(super) fn finish(self, file: &File) -> hdf5::Result<()> {
        for (scale, users) in &self.users {
            if users.len() <= MOST_REFERENCES {
                let list = file.dataset(scale)?.new_attr::<BackReference>();
                list.shape(users.len())
                    .create("REFERENCE_LIST")?
                    .write_raw(users)?;
            }
        }
        Ok(())
    }
}

/// Writes a scale of strings.
pub(super) fn write_names(file: &File, path: &str, names: &[&str]) -> hdf5::Result<()> {
    let texts = names.iter().map(|name| hdf5_text(name));
    let texts = texts.collect::<hdf5::Result<Vec<VarLenUnicode>>>()?;
    let scale = file.new_dataset::<VarLenUnicode>();
    let scale = scale.shape(texts.len()).create(path)?;
    scale.write_raw(&texts)?;
    make_scale(&scale, path.rsplit('/').next().unwrap_or_default())
}

impl<'a> Scales<'a> {
    /// Makes `/time` a scale.
    pub(super) fn begin(
        file: &'a File,
        time: &Dataset,
        channels: &[Channel],
    ) -> hdf5::Result<Self> {
        let mut taken = BTreeSet::new();
        for channel in channels {
            let path = channel.path.as_str();
            taken.extend(path.match_indices('/').map(|(at, _)| path[..at].to_owned()));
            taken.insert(path.to_owned());
        }
        make_scale(time, "time")?;
        let groups: BTreeSet<&str> = channels.iter().map(group_of).collect();
        let times = groups.into_iter().map(|group| format!("{group}/time"));
        let times: Vec<String> = times.filter(|path| !taken.contains(path)).collect();
        taken.extend(times.iter().cloned());
        Ok(Self {
            file,
            taken,
            times,
            columns: BTreeMap::new(),
            ties: Ties::default(),
        })
    }

    /// Names both axes of a channel's dataset.
    pub(super) fn attach(&mut self, channel: &'a Channel) -> hdf5::Result<()> {
        let names: Vec<&str> = channel
            .columns
            .iter()
            .map(|one| one.name.as_str())
            .collect();
        let columns = match names[..] {
            [""] => self.single()?,
            _ => self.columns(channel, names)?,
        };
        let scales = ["time".to_owned(), columns];
        self.ties.tie(self.file, &channel.path, &scales)
    }

    /// Tells the scales who belongs to them, and gives `/time` its names in the groups, which are there by now.
    pub(super) fn finish(self) -> hdf5::Result<()> {
        for path in &self.times {
            self.file.link_hard("/time", path)?;
        }
        self.ties.finish(self.file)
    }

    /// The axis of a number alone: it has a size and no values.
    fn single(&mut self) -> hdf5::Result<String> {
        if !self.taken.contains(SINGLE) {
            let scale = self.file.new_dataset::<f64>().shape(1).create(SINGLE)?;
            // What netCDF calls such a dimension, size behind it.
            make_scale(
                &scale,
                "This is a netCDF dimension but not a netCDF variable.         1",
            )?;
            self.taken.insert(SINGLE.to_owned());
        }
        Ok(SINGLE.to_owned())
    }

    /// The scale of a channel's columns, in its group.
    fn columns(&mut self, channel: &Channel, names: Vec<&'a str>) -> hdf5::Result<String> {
        let key = (group_of(channel).to_owned(), names);
        if let Some(path) = self.columns.get(&key) {
            return Ok(path.clone());
        }
        let (group, names) = (&key.0, &key.1[..]);
        let joined = names.join("_");
        let numbered = names.iter().any(|name| name.parse::<u32>().is_ok());
        let is_name = joined.len() <= LONGEST_NAME && !joined.contains(['/', '.']) && !numbered;
        let mut path = match is_name && !names.contains(&"") {
            true => format!("{group}/{joined}"),
            false => format!("{}_columns", channel.path),
        };
        while self.taken.contains(&path) {
            path.push('_');
        }
        write_names(self.file, &path, names)?;
        self.taken.insert(path.clone());
        self.columns.insert(key, path.clone());
        Ok(path)
    }
}

fn group_of(channel: &Channel) -> &str {
    let path = channel.path.as_str();
    path.rsplit_once('/').map_or("", |(group, _)| group)
}

/// Writes the attributes that make a dataset a scale. Where the name is too long or not ASCII, the dataset's own is its name alone.
pub(super) fn make_scale(dataset: &Dataset, name: &str) -> hdf5::Result<()> {
    write_fixed::<CLASS_BYTES>(dataset, "CLASS", "DIMENSION_SCALE")?;
    match name.is_ascii() && name.len() < NAME_BYTES {
        true => write_fixed::<NAME_BYTES>(dataset, "NAME", name),
        false => Ok(()),
    }
}

fn write_fixed<const N: usize>(object: &Location, name: &str, text: &str) -> hdf5::Result<()> {
    let text =
        FixedAscii::<N>::from_ascii(text).map_err(|error| hdf5::Error::from(error.to_string()))?;
    let attribute = object.new_attr_builder();
    attribute
        .empty_as(zero_terminated(N)?)
        .create(name)?
        .write_scalar(&text)
}

/// The type of ASCII strings that end with a zero, of a fixed number of bytes: HDF5 takes no other for the class of a scale.
fn zero_terminated(bytes: usize) -> hdf5::Result<Datatype> {
    use hdf5_sys::h5t::{H5T_C_S1, H5Tcopy, H5Tset_size};
    hdf5::sync::sync(|| {
        // SAFETY: the library is initialized and locked by `sync`; the type copied is one of its own, strings that end with a zero. The
        // copy belongs to the `Datatype`, which closes it.
        unsafe {
            let id = H5Tcopy(*H5T_C_S1);
            let datatype: Datatype = hdf5::from_id(id)?;
            match H5Tset_size(id, bytes) {
                0.. => Ok(datatype),
                _ => Err(hdf5::Error::from("HDF5 refused a string type")),
            }
        }
    })
}
