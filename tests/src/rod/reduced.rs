//! A planar finite-element rod and its reduction, as the slider-crank benchmarks use it: the runtime's body, the same numbers for the
//! classical equations, and the deflection of the rod's middle.

use std::sync::Arc;

use dcb_formats::Component;
use dcb_formats::mesh::{Dimension, Direction};
use dcb_reducer::{Reduced, Reduction};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::{RodSection, planar_rod};
use faer::Mat;
use nalgebra::{DMatrix, RowDVector, Vector2};

use crate::mechanism::slider_crank::{ROD, SliderCrank, rod_coordinates};
use crate::rod::corotated::{CorotatedRod, CorotatedSliderCrank, RodEnd};
use crate::with;

/// Crank, speed and rod of a slider-crank; the slider has half of the rod's mass.
#[derive(Clone, Copy, Debug)]
pub struct Benchmark {
    /// Length of the crank.
    pub crank: f64,
    /// Its speed.
    pub speed: f64,
    /// The rod.
    pub section: RodSection,
}

impl Benchmark {
    /// The set that most published scripts of this benchmark use.
    pub fn first() -> Self {
        Self {
            crank: 0.15,
            speed: 150.0,
            section: RodSection::default(),
        }
    }

    /// The variant in those scripts' comments.
    pub fn second() -> Self {
        Self {
            crank: 0.152,
            speed: 124.8,
            section: RodSection::round(0.304, 0.006, 206.8e9, 7830.0),
        }
    }

    /// Time of one revolution.
    pub fn revolution(&self) -> f64 {
        std::f64::consts::TAU / self.speed
    }
}

/// A rod reduced to its lowest modes and the attachments that are left.
#[derive(Clone, Debug)]
pub struct ReducedRod {
    benchmark: Benchmark,
    reduced: Reduced,
    /// Rows of the deflections of the middle node and of both ends among the recovered fields.
    nodes: [usize; 3],
    /// As the runtime has it.
    pub body: Arc<FlexibleBody>,
}

impl ReducedRod {
    /// Of an even number of elements, with attachments as dynamic coordinates.
    pub fn new(benchmark: Benchmark, elements: usize, modes: usize) -> Self {
        Self::with(benchmark, elements, modes, Compatibility::Strong)
    }

    /// Of an even number of elements.
    pub fn with(
        benchmark: Benchmark,
        elements: usize,
        modes: usize,
        compatibility: Compatibility,
    ) -> Self {
        let component = planar_rod(elements, &benchmark.section);
        Self::of(
            benchmark,
            &component,
            &Reduction::lowest(modes),
            compatibility,
        )
    }

    /// Of a rod made for the benchmark, an even number of elements, reduced as asked for.
    pub fn of(
        benchmark: Benchmark,
        component: &Component,
        options: &Reduction,
        compatibility: Compatibility,
    ) -> Self {
        let elements = component.mesh.node_count() - 1;
        let reduced = with(component, options);
        let across = |node: usize| {
            let mut dofs = reduced.recovery.dofs.iter();
            dofs.position(|dof| dof.node as usize == node && dof.direction == Direction::Uy)
                .expect("a node")
        };
        let body = FlexibleBody::from_superelement(&reduced.superelement, compatibility);
        Self {
            benchmark,
            nodes: [across(elements / 2), across(0), across(elements)],
            body: Arc::new(body.expect("a body")),
            reduced,
        }
    }

    /// The mechanism with this rod.
    pub fn mechanism(&self) -> SliderCrank {
        SliderCrank {
            crank: self.benchmark.crank,
            speed: self.benchmark.speed,
            slider: 0.5 * self.body.inertia.mass(),
            rod: self.body.clone(),
            dimension: Dimension::Planar,
            rod_axes: 0.0,
        }
    }

    /// Time of one revolution of its crank.
    pub fn revolution(&self) -> f64 {
        self.benchmark.revolution()
    }

    /// (v_mid - (v_a + v_b) / 2) / L for the dynamic coordinates y of a rod with attachments among them.
    pub fn deflection(&self, y: &[f64]) -> f64 {
        let mut amplitudes = vec![0.0; self.body.original_coordinate_count()];
        self.body.original_coordinates(y, &mut amplitudes);
        let recovery = &self.reduced.recovery;
        let (modal, rest) = amplitudes.split_at(recovery.modes.ncols());
        let (attached, further) = rest.split_at(recovery.residual.ncols());
        self.recovered(modal, attached)
            + recovery.enrichment.as_ref().map_or(0.0, |fields| {
                self.across(|row| product(fields, row, further))
            })
    }

    /// The same in a mechanism, whatever the rod's compatibility.
    pub fn deflection_in(&self, simulation: &mut Simulation) -> f64 {
        simulation.refresh();
        let forces = simulation.interface_forces(ROD);
        let y = rod_coordinates(simulation);
        let modes = self.reduced.recovery.modes.ncols();
        match self.body.compatibility {
            Compatibility::Strong => self.deflection(y),
            Compatibility::Static => self.recovered(y, &forces),
            Compatibility::Weak => self.recovered(&y[..modes], &y[modes..]),
        }
    }

    /// From amplitudes of modes and of G_res L_bᵀ.
    fn recovered(&self, modal: &[f64], attached: &[f64]) -> f64 {
        let recovery = &self.reduced.recovery;
        self.across(|row| {
            product(&recovery.modes, row, modal) + product(&recovery.residual, row, attached)
        })
    }

    /// Of the displacements across the rod at the rows of the three nodes.
    fn across(&self, displacement: impl Fn(usize) -> f64) -> f64 {
        let [middle, a, b] = self.nodes.map(displacement);
        (middle - 0.5 * (a + b)) / self.benchmark.section.length
    }

    /// The same for all modes kept, by the classical equations: the superelement's numbers as they are in the file.
    pub fn classical(&self) -> CorotatedSliderCrank {
        let modes = &self.reduced.superelement.modes;
        let (n_k, n_b) = (modes.eigenvalues.len(), modes.interface_shapes.nrows());
        self.classical_over(
            &DMatrix::identity(n_k + n_b, n_k),
            modes.eigenvalues.clone(),
        )
    }

    /// The same with the attachments among the coordinates: modes and G_res L_bᵀ T_r.
    pub fn classical_with_attachments(&self) -> CorotatedSliderCrank {
        let superelement = &self.reduced.superelement;
        let (modes, residual) = (&superelement.modes, &superelement.residual);
        let (n_k, n_b) = (modes.eigenvalues.len(), modes.interface_shapes.nrows());
        let rank = residual.sigma_squared.len();
        let columns = DMatrix::from_fn(n_k + n_b, n_k + rank, |i, j| match (i < n_k, j < n_k) {
            (true, true) if i == j => 1.0,
            (false, false) => residual.transform[(i - n_k, j - n_k)],
            _ => 0.0,
        });
        let squares = modes.eigenvalues.iter().chain(&residual.sigma_squared);
        self.classical_over(&columns, squares.copied().collect())
    }

    /// Over unit-mass coordinates y, of which the stored basis [Φ, G_res L_bᵀ] has `columns` times y.
    fn classical_over(&self, columns: &DMatrix<f64>, squares: Vec<f64>) -> CorotatedSliderCrank {
        let superelement = &self.reduced.superelement;
        let (n_all, n) = columns.shape();
        let n_k = superelement.modes.eigenvalues.len();
        let inertia = &superelement.inertia;
        let stored =
            |matrix: &Mat<f64>, rows: usize| DMatrix::from_fn(rows, n_all, |i, j| matrix[(i, j)]);
        let (modal, attached) = (
            &superelement.modes.interface_shapes,
            &superelement.residual.flexibility,
        );
        let end = |index: usize| {
            let position = superelement.interfaces[index].position;
            let [x, y, _] = match superelement.rows.iter().find(|row| row.interface == index) {
                Some(row) => row.position,
                None => position,
            };
            let shapes = DMatrix::from_fn(2, n_all, |i, j| match j < n_k {
                true => modal[(2 * index + i, j)],
                false => attached[(2 * index + i, j - n_k)],
            });
            RodEnd {
                position: Vector2::new(x, y),
                shapes: shapes * columns,
            }
        };
        let i1 = RowDVector::from_fn(n_all, |_, k| inertia.i1[k][2][2]);
        let i3 = RowDVector::from_fn(n_all, |_, k| inertia.i3[(0, k)]);
        CorotatedSliderCrank {
            rod: CorotatedRod {
                mass: inertia.mass,
                inertia: inertia.tensor[2][2],
                l1: stored(&inertia.l1, 2) * columns,
                i1: i1 * columns,
                i3: i3 * columns,
                l3: columns.transpose() * stored(&inertia.l3[0], n_all) * columns,
                reduced_mass: DMatrix::identity(n, n),
                stiffness: DMatrix::from_diagonal(&nalgebra::DVector::from_vec(squares)),
                ends: [end(0), end(1)],
            },
            crank: self.benchmark.crank,
            speed: self.benchmark.speed,
            slider: 0.5 * inertia.mass,
        }
    }
}

/// Row `row` of `matrix x`.
fn product(matrix: &Mat<f64>, row: usize, x: &[f64]) -> f64 {
    let entries = x.iter().enumerate();
    entries.map(|(k, x)| matrix[(row, k)] * x).sum()
}
