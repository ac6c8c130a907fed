//! The motion of a rigid frame as its nodes see it, and back: the frame motion that a set of nodes determines.

use crate::error::InterfaceRefusal;
use dcb_formats::Component;
use dcb_formats::component::Interface;
use dcb_formats::mesh::Direction;
use nalgebra::{DMatrix, DVector};

/// A direction is undetermined when the scaled normal matrix has an eigenvalue below this fraction of its largest:
/// the square of a lever arm a millionth of the interface's size.
const UNDETERMINED: f64 = 1e-12;

/// Motion of a point at `offset` from a frame's reference (translations, then rotations) when the frame moves by one
/// unit in `direction`.
pub fn rigid_motion(direction: Direction, offset: [f64; 3]) -> [f64; 6] {
    let mut motion = [0.0; 6];
    let axis = direction.axis();
    if direction.is_rotation() {
        // e_axis × offset
        motion[(axis + 1) % 3] = -offset[(axis + 2) % 3];
        motion[(axis + 2) % 3] = offset[(axis + 1) % 3];
    }
    motion[direction.index()] += 1.0;
    motion
}

/// `a - b`.
pub fn offset(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Weighted mean of node positions.
pub fn weighted_centroid(component: &Component, nodes: &[u32], weights: &[f64]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    let mut total = 0.0;
    for (node, weight) in nodes.iter().zip(weights) {
        total += weight;
        for (s, x) in sum.iter_mut().zip(component.mesh.position(*node)) {
            *s += weight * x;
        }
    }
    sum.map(|s| s / total)
}

/// One nodal dof as an equation for the frame: `coefficients · frame motion = dof`, least-squares weight `weight`.
struct Equation {
    row: usize,
    coefficients: Vec<f64>,
    weight: f64,
}

/// How a frame follows from nodal dofs.
pub struct FrameFit {
    directions: &'static [Direction],
    equations: Vec<Equation>,
    /// Scaled unit motions that no equation sees, (directions, count).
    undetermined: DMatrix<f64>,
    /// Rotation columns are divided by this length, so that all columns have the same unit.
    length: f64,
}

/// Which nodal dofs a frame fit may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitDofs {
    /// Translations only.
    Translations,
    /// Translations and rotations.
    All,
}

impl FrameFit {
    /// Sets up the least-squares problem of a frame at `reference` and its nodes.
    pub fn new(
        component: &Component,
        nodes: &[u32],
        weights: &[f64],
        reference: [f64; 3],
        use_dofs: FitDofs,
    ) -> Self {
        let directions = component.dimension().frame_directions();
        let length = interface_length(component, nodes, reference);
        let mut equations = Vec::new();
        for (node, weight) in nodes.iter().zip(weights) {
            let arm = offset(component.mesh.position(*node), reference);
            for nodal in directions
                .iter()
                .filter(|d| use_dofs == FitDofs::All || !d.is_rotation())
            {
                if let Some(row) = component.dofs.row(*node, *nodal) {
                    equations.push(Equation {
                        row,
                        coefficients: directions
                            .iter()
                            .map(|d| rigid_motion(*d, arm)[nodal.index()])
                            .collect(),
                        weight: *weight,
                    });
                }
            }
        }
        let mut fit = Self {
            directions,
            equations,
            undetermined: DMatrix::zeros(directions.len(), 0),
            length,
        };
        fit.undetermined = fit.null_motions();
        fit
    }

    /// Lets nodal rotations decide the frame rotations that the positions leave open.
    pub fn with_nodal_rotations(
        mut self,
        component: &Component,
        nodes: &[u32],
        weights: &[f64],
    ) -> Self {
        let rotations: Vec<usize> = (0..self.directions.len())
            .filter(|i| self.directions[*i].is_rotation())
            .collect();
        for axis in open_axes(&self.undetermined, &rotations) {
            // axis · θ_node = axis · θ_frame, one equation for each rotation dof that the axis has a part of.
            let parts: Vec<usize> = (0..rotations.len())
                .filter(|i| axis[*i].abs() > 1e-12)
                .collect();
            for (node, weight) in nodes.iter().zip(weights) {
                let rows: Vec<_> = parts
                    .iter()
                    .map(|i| component.dofs.row(*node, self.directions[rotations[*i]]))
                    .collect();
                if rows.iter().any(Option::is_none) {
                    continue;
                }
                for (i, row) in parts.iter().zip(rows.into_iter().flatten()) {
                    let mut coefficients = vec![0.0; self.directions.len()];
                    for (j, other) in rotations.iter().enumerate() {
                        coefficients[*other] = axis[j] * axis[*i];
                    }
                    self.equations.push(Equation {
                        row,
                        coefficients,
                        weight: weight * self.length * self.length,
                    });
                }
            }
        }
        self.undetermined = self.null_motions();
        self
    }

    fn scaled(&self, equation: &Equation) -> DVector<f64> {
        DVector::from_iterator(
            self.directions.len(),
            self.directions.iter().zip(&equation.coefficients).map(
                |(direction, c)| match direction.is_rotation() {
                    true => c / self.length,
                    false => *c,
                },
            ),
        )
    }

    fn normal_matrix(&self) -> DMatrix<f64> {
        let mut normal = DMatrix::zeros(self.directions.len(), self.directions.len());
        for equation in &self.equations {
            let a = self.scaled(equation);
            normal += &a * a.transpose() * equation.weight;
        }
        normal
    }

    fn null_motions(&self) -> DMatrix<f64> {
        let eigen = self.normal_matrix().symmetric_eigen();
        let largest = eigen.eigenvalues.max().max(f64::MIN_POSITIVE);
        let null: Vec<_> = (0..self.directions.len())
            .filter(|i| eigen.eigenvalues[*i] < UNDETERMINED * largest)
            .map(|i| eigen.eigenvectors.column(i).into_owned())
            .collect();
        match null.is_empty() {
            true => DMatrix::zeros(self.directions.len(), 0),
            false => DMatrix::from_columns(&null),
        }
    }

    /// Whether the nodes leave this motion of the frame open.
    pub fn leaves_open(&self, direction: Direction) -> bool {
        let Some(i) = self.directions.iter().position(|d| *d == direction) else {
            return true;
        };
        self.undetermined
            .row(i)
            .iter()
            .any(|entry| entry.abs() > 1e-6)
    }

    /// Directions of the frame that the nodes determine.
    pub fn determined(&self) -> Vec<Direction> {
        self.directions
            .iter()
            .copied()
            .filter(|direction| !self.leaves_open(*direction))
            .collect()
    }

    /// Whether any motion of the frame is left open.
    pub fn is_deficient(&self) -> bool {
        self.undetermined.ncols() > 0
    }

    /// A largest set of frame directions that the nodes determine, the others taken as zero.
    pub fn independent_directions(&self) -> Vec<Direction> {
        let mut kept = Vec::new();
        let mut basis: Vec<DVector<f64>> = Vec::new();
        // A direction is kept if it is independent of those kept modulo the open motions.
        for column in self.undetermined.column_iter() {
            basis.push(column.into_owned());
        }
        for (i, direction) in self.directions.iter().enumerate() {
            let mut unit = DVector::zeros(self.directions.len());
            unit[i] = 1.0;
            for _ in 0..2 {
                for known in &basis {
                    let along = known.dot(&unit);
                    unit -= known * along;
                }
            }
            if unit.norm() > 1e-6 {
                basis.push(unit.normalize());
                kept.push(*direction);
            }
        }
        kept
    }

    /// The frame's motion in `direction` as a linear combination of nodal dofs: (matrix row, coefficient), by weighted
    /// least squares. Meaningless for a direction that the nodes leave open.
    pub fn row(&self, direction: Direction) -> Vec<(u32, f64)> {
        let Some(i) = self.directions.iter().position(|d| *d == direction) else {
            return Vec::new();
        };
        // row = e_iᵀ A⁺ Σ a w, in scaled columns; the open motions are projected out by adding them back as unit terms.
        let scale = self
            .normal_matrix()
            .symmetric_eigen()
            .eigenvalues
            .max()
            .max(f64::MIN_POSITIVE);
        let normal =
            self.normal_matrix() + &self.undetermined * self.undetermined.transpose() * scale;
        let mut unit = DVector::zeros(self.directions.len());
        unit[i] = if direction.is_rotation() {
            1.0 / self.length
        } else {
            1.0
        };
        let Some(solution) = normal.lu().solve(&unit) else {
            return Vec::new();
        };
        let mut entries: Vec<(u32, f64)> = Vec::new();
        for equation in &self.equations {
            let value = self.scaled(equation).dot(&solution) * equation.weight;
            entries.push((equation.row as u32, value));
        }
        merge_entries(entries)
    }
}

/// Orthonormal axes of the open rotations; the coordinate axes where every rotation is open.
fn open_axes(undetermined: &DMatrix<f64>, rotations: &[usize]) -> Vec<DVector<f64>> {
    if undetermined.ncols() >= rotations.len() {
        let unit = |i| DVector::from_fn(rotations.len(), |j, _| if i == j { 1.0 } else { 0.0 });
        return (0..rotations.len()).map(unit).collect();
    }
    let axes = DMatrix::from_fn(rotations.len(), undetermined.ncols(), |i, j| {
        undetermined[(rotations[i], j)]
    });
    axes.qr()
        .q()
        .column_iter()
        .map(|column| column.into_owned())
        .collect()
}

/// Sorts by index, adds repeats and drops exact zeros.
pub fn merge_entries(mut entries: Vec<(u32, f64)>) -> Vec<(u32, f64)> {
    entries.sort_by_key(|(index, _)| *index);
    let mut merged: Vec<(u32, f64)> = Vec::with_capacity(entries.len());
    for (index, value) in entries {
        match merged.last_mut() {
            Some(last) if last.0 == index => last.1 += value,
            _ => merged.push((index, value)),
        }
    }
    merged.retain(|(_, value)| *value != 0.0);
    merged
}

/// Root mean square distance of the nodes from the reference; the part's diagonal where that is zero.
fn interface_length(component: &Component, nodes: &[u32], reference: [f64; 3]) -> f64 {
    let squares: f64 = nodes
        .iter()
        .map(|node| {
            offset(component.mesh.position(*node), reference)
                .iter()
                .map(|x| x * x)
                .sum::<f64>()
        })
        .sum();
    let radius = (squares / nodes.len().max(1) as f64).sqrt();
    if radius > 0.0 {
        radius
    } else {
        part_size(component)
    }
}

/// Nodes with at least one dof, ascending. The others (reference points, leftovers of the mesh) say nothing about the
/// part's place or size.
pub fn nodes_with_dofs(component: &Component) -> Vec<u32> {
    let mut used = vec![false; component.mesh.node_count()];
    for (_, dof) in component.dofs.nodal() {
        used[dof.node as usize] = true;
    }
    (0..used.len() as u32)
        .filter(|node| used[*node as usize])
        .collect()
}

/// Sides of the box around the nodes with dofs.
pub fn box_sides(component: &Component) -> [f64; 3] {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for node in nodes_with_dofs(component) {
        for (axis, x) in component.mesh.position(node).into_iter().enumerate() {
            low[axis] = low[axis].min(x);
            high[axis] = high[axis].max(x);
        }
    }
    std::array::from_fn(|axis| high[axis] - low[axis])
}

/// Diagonal of the box around the nodes with dofs; 1 for a part without extent.
pub fn part_size(component: &Component) -> f64 {
    let size = box_sides(component)
        .iter()
        .map(|side| side.powi(2))
        .sum::<f64>()
        .sqrt();
    if size.is_finite() && size > 0.0 {
        size
    } else {
        1.0
    }
}

/// Directions that a frame interface offers: those asked for, in frame order, or all.
pub(crate) fn frame_directions(component: &Component, interface: &Interface) -> Vec<Direction> {
    let all = component.dimension().frame_directions();
    match &interface.directions {
        Some(wanted) => all
            .iter()
            .copied()
            .filter(|direction| wanted.contains(direction))
            .collect(),
        None => all.to_vec(),
    }
}

/// The message for a frame direction that the nodes leave open.
pub(crate) fn cannot_carry(
    component: &Component,
    interface: &Interface,
    direction: Direction,
    possible: &[Direction],
) -> InterfaceRefusal {
    InterfaceRefusal::CannotCarry {
        interface: interface.name.clone(),
        nodes: interface.nodes.len(),
        direction,
        possible: possible.to_vec(),
        dimension: component.dimension(),
    }
}
