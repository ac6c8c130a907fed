//! Every dataset of the format but those under `/mesh`: where it is, its axes, symbol, unit and meaning.
//! `docs/format.md` has the same table in words.

use super::contract::Axis::{
    Basis, Coordinates, FieldDofs, Fixed, Forces, Interfaces, Modes, Rank, Residual, Rigid, Rows,
};
use super::contract::Presence::{Enriched, Estimated, Fields, Loaded, Optional, Required, Spatial};
use super::contract::{Axis, Dataset, Presence};
use super::units::{
    FIRST_MOMENT, FORCE, Factor, INERTIA, LENGTH, MASS, MODAL, MOMENT, ONE, PER_MODAL, Rule, SAME,
    TIME,
};
use crate::hdf5_files::element::Element;
use crate::hdf5_files::element::Element::{Integer, Real, Text};

/// The dataset at a path, if the contract has one there.
pub(super) fn dataset(path: &str) -> Option<&'static Dataset> {
    DATASETS.iter().find(|dataset| dataset.path == path)
}

const PLAIN: Rule = Rule::Text("1");
const LENGTHS: Rule = Rule::Product(&[Factor::Uniform(LENGTH)]);
const PER_BASIS_INERTIA: Rule = Rule::Product(&[Factor::PerCoordinate(INERTIA)]);
const BASIS_MASS: Rule = Rule::Product(&[Factor::MassPerCoordinate, Factor::MassPerCoordinate]);
const BASIS_MASS_LAYERS: Rule =
    Rule::Product(&[SAME, Factor::MassPerCoordinate, Factor::MassPerCoordinate]);
const PER_TIME: Rule = Rule::Product(&[
    Factor::PerResidual(MODAL.over(TIME)),
    Factor::PerResidual(MODAL.over(TIME)),
]);
const FLEXIBILITY: Rule = Rule::Product(&[Factor::Displacement, Factor::PerForce]);

/// M_j in √mass·length·time^(j-2) over both coordinates.
const fn moment(
    path: &'static str,
    symbol: &'static str,
    units: Rule,
    description: &'static str,
) -> Dataset {
    same(
        path,
        Real,
        &[Residual, Residual],
        Estimated,
        symbol,
        units,
        description,
    )
}

/// A dataset with the same axes and units in planar and spatial files.
const fn same(
    path: &'static str,
    element: Element,
    axes: &'static [Axis],
    presence: Presence,
    symbol: &'static str,
    units: Rule,
    description: &'static str,
) -> Dataset {
    Dataset {
        path,
        element,
        planar: axes,
        spatial: axes,
        presence,
        symbol,
        planar_units: units,
        spatial_units: units,
        description,
    }
}

/// A real dataset whose axes and units differ.
const fn split(
    path: &'static str,
    planar: (&'static [Axis], Rule),
    spatial: (&'static [Axis], Rule),
    presence: Presence,
    symbol: &'static str,
    description: &'static str,
) -> Dataset {
    let (planar, planar_units) = planar;
    let (spatial, spatial_units) = spatial;
    Dataset {
        path,
        element: Element::Real,
        planar,
        spatial,
        presence,
        symbol,
        planar_units,
        spatial_units,
        description,
    }
}

/// The contract, sorted by path within each group.
pub(super) const DATASETS: &[Dataset] = &[
    same(
        "/frame/origin",
        Real,
        &[Coordinates],
        Required,
        "c",
        LENGTHS,
        "centre of mass in component coordinates; the body frame is parallel to the component's axes",
    ),
    same(
        "/interfaces/names",
        Text,
        &[Interfaces],
        Required,
        "",
        PLAIN,
        "interface names, in row order",
    ),
    same(
        "/interfaces/kinds",
        Text,
        &[Interfaces],
        Required,
        "",
        PLAIN,
        "nodes, average, rigid or boundary",
    ),
    same(
        "/interfaces/roles",
        Text,
        &[Interfaces],
        Required,
        "",
        PLAIN,
        "attachment or output (observed only: no attachment column)",
    ),
    same(
        "/interfaces/positions",
        Real,
        &[Interfaces, Coordinates],
        Required,
        "r",
        LENGTHS,
        "reference positions, body frame",
    ),
    split(
        "/interfaces/orientations",
        (&[Interfaces], Rule::Text("rad")),
        (&[Interfaces, Fixed(3), Fixed(3)], PLAIN),
        Required,
        "A_i0",
        "rest axes of each interface, body frame: columns of a rotation matrix, or the planar angle",
    ),
    same(
        "/interfaces/dofs",
        Integer,
        &[Rows, Fixed(2)],
        Required,
        "",
        PLAIN,
        "per row of L_b: interface index; index in ux uy uz rx ry rz, or -1 for an explicit row",
    ),
    same(
        "/interfaces/row_nodes",
        Integer,
        &[Rows],
        Required,
        "",
        PLAIN,
        "0-based node of the row, or -1 for a frame or an explicit row",
    ),
    same(
        "/interfaces/row_positions",
        Real,
        &[Rows, Coordinates],
        Required,
        "r_b",
        LENGTHS,
        "reference position of the row, body frame",
    ),
    same(
        "/modes/eigenvalues",
        Real,
        &[Modes],
        Required,
        "omega^2",
        Rule::AngularFrequencySquared,
        "squared angular frequencies of the kept free-free elastic modes, ascending",
    ),
    same(
        "/modes/damping",
        Real,
        &[Modes],
        Required,
        "zeta",
        PLAIN,
        "damping ratio to critical per mode; attribute residual: the attachments' ratio",
    ),
    same(
        "/modes/interface_shapes",
        Real,
        &[Rows, Modes],
        Required,
        "L_b Phi",
        Rule::Product(&[Factor::Displacement, PER_MODAL]),
        "mass-normalized mode shapes at the boundary rows",
    ),
    same(
        "/modes/shapes",
        Real,
        &[Modes, FieldDofs],
        Fields,
        "Phi^T",
        Rule::Product(&[PER_MODAL, Factor::Field]),
        "nodal mode shapes, one mode a row, mass-normalized",
    ),
    same(
        "/fields/dofs",
        Integer,
        &[FieldDofs, Fixed(2)],
        Fields,
        "",
        PLAIN,
        "per field column: 0-based node, index in ux uy uz rx ry rz",
    ),
    same(
        "/residual/flexibility",
        Real,
        &[Rows, Rows],
        Required,
        "F_res",
        FLEXIBILITY,
        "residual flexibility at the boundary rows, symmetric",
    ),
    same(
        "/residual/mass",
        Real,
        &[Rows, Rows],
        Required,
        "M_res",
        Rule::Product(&[Factor::MassPerForce, Factor::MassPerForce]),
        "mass of the residual attachment shapes, symmetric",
    ),
    same(
        "/residual/mass_diagonal0",
        Real,
        &[Rows],
        Required,
        "diag M_res,0",
        Rule::Product(&[Factor::MassPerForceSquared]),
        "diagonal of M_res with no mode kept: scaling of the rank filter",
    ),
    same(
        "/residual/transform",
        Real,
        &[Rows, Rank],
        Required,
        "T_r",
        Rule::Product(&[Factor::Force, PER_MODAL]),
        "T_r^T M_res T_r = I, T_r^T F_res T_r = diag(sigma^2)",
    ),
    same(
        "/residual/sigma2",
        Real,
        &[Rank],
        Required,
        "sigma^2",
        Rule::AngularFrequencySquared,
        "residual flexibility in the coordinates of transform, ascending",
    ),
    same(
        "/residual/output_shapes",
        Real,
        &[Rows, Rows],
        Optional,
        "L_b G_res L_b^T",
        FLEXIBILITY,
        "attachment shapes at all boundary rows, output interfaces included; their columns are zero",
    ),
    same(
        "/residual/shapes",
        Real,
        &[Rows, FieldDofs],
        Fields,
        "(G_res L_b^T)^T",
        Rule::Product(&[Factor::PerForce, Factor::Field]),
        "nodal residual attachment shapes, one boundary row a row",
    ),
    same(
        "/inertia/mass",
        Real,
        &[],
        Required,
        "m",
        Rule::Product(&[Factor::Uniform(MASS)]),
        "total mass",
    ),
    split(
        "/inertia/tensor",
        (&[], Rule::Product(&[Factor::Uniform(INERTIA)])),
        (
            &[Fixed(3), Fixed(3)],
            Rule::Product(&[Factor::Uniform(INERTIA)]),
        ),
        Required,
        "I",
        "inertia about the centre of mass, body frame",
    ),
    same(
        "/inertia/L1",
        Real,
        &[Coordinates, Basis],
        Required,
        "L1",
        Rule::Product(&[SAME, Factor::PerCoordinate(FIRST_MOMENT)]),
        "linear momentum of the basis; zero to rounding in a mean-axis frame",
    ),
    split(
        "/inertia/I1",
        (&[Basis], PER_BASIS_INERTIA),
        (&[Basis, Fixed(3), Fixed(3)], PER_BASIS_INERTIA),
        Required,
        "I1",
        "first-order change of inertia: 2 I1 y planar, I1[k,a,b] y_k spatial",
    ),
    split(
        "/inertia/I3",
        (&[Basis], PER_BASIS_INERTIA),
        (
            &[Fixed(3), Basis],
            Rule::Product(&[SAME, Factor::PerCoordinate(INERTIA)]),
        ),
        Required,
        "I3",
        "angular momentum of the basis; zero to rounding in a mean-axis frame",
    ),
    split(
        "/inertia/L3",
        (&[Basis, Basis], BASIS_MASS),
        (&[Fixed(3), Basis, Basis], BASIS_MASS_LAYERS),
        Required,
        "L3",
        "L3[a,k,l] = int rho e_a . (psi_k x psi_l), antisymmetric in k, l; planar a = z",
    ),
    split(
        "/inertia/I2",
        (&[], PLAIN),
        (&[Basis, Basis, Fixed(3), Fixed(3)], BASIS_MASS),
        Spatial,
        "I2",
        "second-order change of inertia, I2[k,l,a,b] y_k y_l, symmetric in (k,l) and (a,b)",
    ),
    split(
        "/stiffening/centrifugal",
        (&[Fixed(1), Basis, Basis], BASIS_MASS_LAYERS),
        (&[Fixed(6), Basis, Basis], BASIS_MASS_LAYERS),
        Optional,
        "K_omega",
        "geometric stiffness per om_x^2, om_y^2, om_z^2, om_x om_y, om_y om_z, om_z om_x; planar per om^2",
    ),
    same(
        "/stiffening/interface",
        Real,
        &[Rows, Basis, Basis],
        Optional,
        "K_g",
        Rule::Product(&[
            Factor::PerForce,
            Factor::StiffnessPerCoordinate,
            Factor::StiffnessPerCoordinate,
        ]),
        "geometric stiffness per unit interface force",
    ),
    same(
        "/enrichment/interface_shapes",
        Real,
        &[Rows, Axis::Enrichment],
        Enriched,
        "L_b X",
        Rule::Product(&[Factor::Displacement, Factor::Uniform(ONE)]),
        "further basis columns at the boundary rows",
    ),
    same(
        "/enrichment/names",
        Text,
        &[Axis::Enrichment],
        Optional,
        "",
        PLAIN,
        "what each further column answers to (since 1.1)",
    ),
    same(
        "/enrichment/shapes",
        Real,
        &[Axis::Enrichment, FieldDofs],
        Optional,
        "X^T",
        Rule::Product(&[Factor::Uniform(ONE), Factor::Field]),
        "nodal shapes of the further columns, one a row (since 1.1)",
    ),
    same(
        "/loads/names",
        Text,
        &[Axis::Loads],
        Optional,
        "",
        PLAIN,
        "unique names of loads on the inside of the part (since 1.1)",
    ),
    same(
        "/loads/forces",
        Real,
        &[Axis::Loads, Coordinates],
        Loaded,
        "T^T f",
        Rule::Product(&[Factor::Uniform(FORCE)]),
        "resultant force of each load, body frame (since 1.1)",
    ),
    split(
        "/loads/moments",
        (&[Axis::Loads], Rule::Product(&[Factor::Uniform(MOMENT)])),
        (
            &[Axis::Loads, Fixed(3)],
            Rule::Product(&[Factor::Uniform(MOMENT)]),
        ),
        Loaded,
        "X_r^T f",
        "resultant moment of each load about the centre of mass, body frame; planar about z (since 1.1)",
    ),
    same(
        "/loads/work",
        Real,
        &[Axis::Loads, Basis],
        Loaded,
        "f^T Psi",
        Rule::Product(&[SAME, Factor::PerCoordinate(MOMENT)]),
        "work of each load on the columns of the basis (since 1.1)",
    ),
    same(
        "/reduced/mass",
        Real,
        &[Basis, Basis],
        Enriched,
        "M_f",
        BASIS_MASS,
        "reduced mass over the whole basis, symmetric",
    ),
    same(
        "/reduced/stiffness",
        Real,
        &[Basis, Basis],
        Enriched,
        "K_f",
        Rule::Product(&[
            Factor::StiffnessPerCoordinate,
            Factor::StiffnessPerCoordinate,
        ]),
        "reduced stiffness over the whole basis, symmetric",
    ),
    same(
        "/error/eigenvalue_errors",
        Real,
        &[Modes],
        Estimated,
        "",
        PLAIN,
        "bounds of the kept eigenvalues' relative errors (since 1.2)",
    ),
    same(
        "/error/rigid_shapes",
        Real,
        &[Rows, Rigid],
        Estimated,
        "L_b R",
        Rule::Product(&[Factor::Displacement, PER_MODAL]),
        "mass-normalized rigid motions at the boundary rows (since 1.2)",
    ),
    moment(
        "/error/moment_1",
        "L G L^T",
        PER_TIME,
        "flexibility beyond the modes, output interfaces and loads of further columns included (since 1.2)",
    ),
    moment(
        "/error/moment_2",
        "L G M G L^T",
        Rule::Product(&[Factor::PerResidual(MODAL), Factor::PerResidual(MODAL)]),
        "mass of the static shapes beyond the modes (since 1.2)",
    ),
    moment(
        "/error/moment_3",
        "L G M G_s M G L^T",
        Rule::Product(&[
            Factor::PerResidual(MODAL.times(TIME)),
            Factor::PerResidual(MODAL.times(TIME)),
        ]),
        "third power moment of what the modes leave out, G_s with the shift (since 1.2)",
    ),
    moment(
        "/error/moment_4",
        "L G M G_s M G_s M G L^T",
        Rule::Product(&[
            Factor::PerResidual(MODAL.times(TIME).times(TIME)),
            Factor::PerResidual(MODAL.times(TIME).times(TIME)),
        ]),
        "fourth power moment of what the modes leave out, G_s with the shift (since 1.2)",
    ),
    same(
        "/error/rounding",
        Real,
        &[Residual],
        Estimated,
        "",
        PLAIN,
        "relative rounding in the moments of each row (since 1.2)",
    ),
    same(
        "/error/forces",
        Real,
        &[Rows, Forces],
        Optional,
        "B",
        Rule::Product(&[Factor::Force, SAME]),
        "forces that the superelement is made for (since 1.3)",
    ),
];
