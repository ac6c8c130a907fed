//! How the format describes a dataset: element type, what its axes count, when it is there.
//!
//! The reader checks files against these descriptions, the writer takes shapes and attributes from them. The table
//! is in `datasets.rs`; `/mesh` has names that depend on the component and is described where it is written.

use super::units::Rule;
use crate::hdf5_files::element::Element;
use crate::mesh::Dimension;

/// Items that an axis counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    /// A fixed number.
    Fixed(usize),
    /// d, 2 or 3.
    Coordinates,
    /// n_i.
    Interfaces,
    /// n_b.
    Rows,
    /// n_k.
    Modes,
    /// n_x.
    Enrichment,
    /// n.
    Basis,
    /// Columns of `transform`.
    Rank,
    /// n_f.
    FieldDofs,
    /// n_l.
    Loads,
    /// n_b + n_x.
    Residual,
    /// n_r.
    Rigid,
    /// n_p.
    Forces,
    /// n_o.
    LeftOutColumns,
    /// n_s.
    Selections,
    /// n_m.
    SelectedModes,
    /// n_v.
    SelectedForces,
    /// Stress fields.
    StressFields,
    /// Places of all stress fields.
    StressPoints,
    /// Rows of all stress fields.
    StressRows,
}

/// The numbers that all shapes follow from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) dimension: Dimension,
    pub(super) interfaces: usize,
    pub(super) rows: usize,
    pub(super) modes: usize,
    pub(super) enrichment: usize,
    pub(super) rank: usize,
    pub(super) field_dofs: usize,
    pub(super) loads: usize,
    pub(super) rigid: usize,
    pub(super) forces: usize,
    pub(super) left_out_columns: usize,
    pub(super) selections: usize,
    pub(super) selected_modes: usize,
    pub(super) selected_forces: usize,
    pub(super) stress_fields: usize,
    pub(super) stress_points: usize,
    pub(super) stress_rows: usize,
}

impl Counts {
    /// Length of an axis.
    pub(super) fn length(&self, axis: Axis) -> usize {
        match axis {
            Axis::Fixed(length) => length,
            Axis::Coordinates => self.dimension.coordinate_count(),
            Axis::Interfaces => self.interfaces,
            Axis::Rows => self.rows,
            Axis::Modes => self.modes,
            Axis::Enrichment => self.enrichment,
            Axis::Basis => self
                .modes
                .saturating_add(self.rows)
                .saturating_add(self.enrichment),
            Axis::Rank => self.rank,
            Axis::FieldDofs => self.field_dofs,
            Axis::Loads => self.loads,
            Axis::Residual => self.rows.saturating_add(self.enrichment),
            Axis::Rigid => self.rigid,
            Axis::Forces => self.forces,
            Axis::LeftOutColumns => self.left_out_columns,
            Axis::Selections => self.selections,
            Axis::SelectedModes => self.selected_modes,
            Axis::SelectedForces => self.selected_forces,
            Axis::StressFields => self.stress_fields,
            Axis::StressPoints => self.stress_points,
            Axis::StressRows => self.stress_rows,
        }
    }

    /// Shape of a dataset.
    pub(super) fn shape(&self, dataset: &Dataset) -> Vec<usize> {
        dataset
            .axes(self.dimension)
            .iter()
            .map(|&axis| self.length(axis))
            .collect()
    }
}

/// When a dataset is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Presence {
    /// Always.
    Required,
    /// In spatial files, always; in planar ones never.
    Spatial,
    /// All or none of the datasets with this mark.
    Fields,
    /// Where there are further basis columns.
    Enriched,
    /// Where there are named loads.
    Loaded,
    /// All or none of the datasets with this mark.
    Stressed,
    /// All or none of the datasets with this mark.
    Estimated,
    /// Where the file says how it was made.
    Derived,
    /// All or none of the datasets with this mark.
    Selected,
    /// By itself or not.
    Optional,
}

/// One dataset of the contract.
#[derive(Debug)]
pub(super) struct Dataset {
    pub(super) path: &'static str,
    pub(super) element: Element,
    pub(super) planar: &'static [Axis],
    pub(super) spatial: &'static [Axis],
    pub(super) presence: Presence,
    pub(super) symbol: &'static str,
    pub(super) planar_units: Rule,
    pub(super) spatial_units: Rule,
    pub(super) description: &'static str,
}

impl Dataset {
    /// Axes in a planar or spatial file.
    pub(super) fn axes(&self, dimension: Dimension) -> &'static [Axis] {
        match dimension {
            Dimension::Planar => self.planar,
            Dimension::Spatial => self.spatial,
        }
    }

    /// Unit rule in a planar or spatial file.
    pub(super) fn units(&self, dimension: Dimension) -> Rule {
        match dimension {
            Dimension::Planar => self.planar_units,
            Dimension::Spatial => self.spatial_units,
        }
    }
}
