//! Parts reduced for a scene: is the error of their responses, over the scene's frequencies, forces and places, within the tolerance? Against
//! the whole matrices, solved at every frequency.
//!
//! Rows of the table in `docs/scene-driven.md` are compared with `docs/data/scene_reduction.jsonl`. Its lines are what is printed here:
//! `cargo test --release -p dcb-tests --test reduction scene_driven:: -- --nocapture --test-threads 1 | grep '^{"part"'`.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use dcb_formats::Component;
use dcb_formats::component::{InterfaceKind, Role};
use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::mesh::Direction;
use dcb_formats::superelement::Superelement;
use dcb_reducer::quality::scene_fit::{Omission, SceneFit};
use dcb_reducer::{EnrichmentSource, Error, Reduced, Reduction, reduce};
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::{SolidElement, connecting_rod};
use dcb_tests::dense::{dense, solve};
use dcb_tests::localization::localization;
use dcb_tests::oracle::{Oracle, centre_of_mass, rigid_motions};
use dcb_tests::pages::scene_reduction;
use dcb_tests::{lowest, parts};
use dcb_workflow::scene::{
    ComponentDemand, Extent, Fitted, Limits, PartInScene, Search, SpinColumns,
};
use faer::linalg::solvers::Solve as _;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, c64};
use serde_json::{Value, json};

const LOSS_FACTOR: f64 = 0.02;
/// Name of the part's superelement in the scenes here.
const FILE: &str = "part.dcb.h5";

struct Outcome {
    asked: ComponentDemand,
    fitted: Fitted,
    fit: SceneFit,
}

fn limits(tolerance: f64) -> Limits {
    Limits {
        tolerance,
        most_modes: None,
        default_modes: 20,
        extent: Extent::Needed,
    }
}

fn asked(component: &Component, scene: &Value) -> (ComponentDemand, PartInScene) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.json");
    fs::write(&path, scene.to_string()).unwrap();
    let output = folder.path().join(FILE);
    let part = PartInScene::find(&path, &[], &output, &output).unwrap();
    (ComponentDemand::of(&part, component.clone()).unwrap(), part)
}

fn try_to_fit(component: &Component, scene: &Value, limits: &Limits) -> Result<Outcome, Error> {
    let (asked, part) = asked(component, scene);
    let options = Reduction::lowest(0);
    let search = Search {
        asked: &asked,
        options: &options,
        limits,
        cached: None,
    };
    let whole = search.whole(&mut ())?;
    let fitted = Fitted::of(whole, &part, &asked, limits)?;
    let fit = fitted.quality.scene.clone().unwrap();
    println!("{}", fit.text());
    Ok(Outcome { asked, fitted, fit })
}

fn fitted(component: &Component, scene: &Value, tolerance: f64) -> Outcome {
    try_to_fit(component, scene, &limits(tolerance)).unwrap()
}

fn coordinates(of: &Superelement) -> usize {
    of.mode_count() + of.residual.sigma_squared.len()
}

fn names(of: &Superelement) -> Vec<&str> {
    let interfaces = of.interfaces.iter();
    interfaces
        .map(|interface| interface.name.as_str())
        .collect()
}

fn bytes(of: &Superelement, fields: Option<&Fitted>, whole: Option<(&Reduced, &Component)>) -> u64 {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.dcb.h5");
    let own = fields.and_then(|fitted| fitted.fields.as_ref());
    let contents = Contents {
        superelement: of,
        recovery: own
            .map(|own| &own.0)
            .or(whole.map(|whole| &whole.0.recovery)),
        mesh: own.map(|own| &own.1).or(whole.map(|whole| &whole.1.mesh)),
    };
    write_superelement(&path, &contents, &WriteOptions::default()).unwrap();
    fs::metadata(&path).unwrap().len()
}

/// Places and forces of a part: rows of its interfaces that are in use, and translations of nodes that are looked at.
struct Places {
    /// Over all dofs, (places, n_e), scaled by the root of their flexibility as studies scale rows.
    seen: Mat<f64>,
    /// Interface of each; nodes count as one more.
    groups: Vec<usize>,
    /// Forces over the places, (places, forces), in the same scale.
    forces: Mat<f64>,
    force_groups: Vec<usize>,
    scale: Vec<f64>,
    /// How many of the places are rows.
    rows: usize,
    nodes: BTreeSet<u32>,
}

impl Places {
    /// Forces are those along coordinate axes that are named: interface, direction.
    fn of(outcome: &Outcome, component: &Component, forces: &[(&str, Direction)]) -> Self {
        let element = &outcome.fitted.superelement;
        let used: BTreeSet<&str> = names(element).into_iter().collect();
        let nodes: BTreeSet<u32> = match &outcome.fitted.fields {
            Some((basis, _)) => basis.dofs.iter().map(|dof| dof.node).collect(),
            None => BTreeSet::new(),
        };
        // Nodes with attachments of their own, so that their flexibility is known.
        let mut whole = component.clone().into_draft();
        if !nodes.is_empty() {
            let mut watched = parts::interface(
                "nodes",
                InterfaceKind::Nodes,
                nodes.iter().copied().collect(),
            );
            let d = component.dimension().coordinate_count();
            watched.directions = Some(Direction::ALL[..d].to_vec());
            whole.interfaces.push(watched);
        }
        let whole = Component::checked(whole).unwrap();
        let reference = lowest(&whole, 0).superelement;
        let all = localization(&whole);
        let rigid = rigid_motions(component, centre_of_mass(component).1);
        let rigid = normalised(component, &rigid);
        let first = reference.modes.first_omitted_eigenvalue;
        let (mut places, mut groups, mut named) = (Vec::new(), Vec::new(), Vec::new());
        for (row, of_row) in reference.rows.iter().enumerate() {
            let name = reference.interfaces[of_row.interface].name.as_str();
            if used.contains(name) || of_row.interface == component.interfaces.len() {
                places.push(row);
                groups.push(of_row.interface);
                named.push((name.to_owned(), of_row.direction));
            }
        }
        let scale: Vec<f64> = (places.iter())
            .map(|row| {
                let motion = all.row(*row) * &rigid;
                let moved: f64 = motion.iter().map(|part| part * part).sum();
                (reference.residual.flexibility[(*row, *row)] + moved / first)
                    .sqrt()
                    .recip()
            })
            .collect();
        let forced: Vec<usize> = (forces.iter())
            .map(|(name, direction)| {
                let index = direction.index() as i64;
                let mut all = named.iter();
                all.position(|(known, along)| known == name && *along == index)
                    .unwrap()
            })
            .collect();
        Self {
            seen: Mat::from_fn(places.len(), all.ncols(), |i, j| {
                scale[i] * all[(places[i], j)]
            }),
            forces: Mat::from_fn(places.len(), forced.len(), |i, j| {
                f64::from(u8::from(i == forced[j]))
            }),
            force_groups: forced.iter().map(|place| groups[*place]).collect(),
            groups,
            scale,
            rows: element.rows.len(),
            nodes,
        }
    }

    /// Of the whole part at ω².
    fn whole(&self, component: &Component, square: f64) -> Mat<c64> {
        let lambda = c64::new(square, 0.0) / c64::new(1.0, LOSS_FACTOR);
        let mut entries: Vec<Triplet<usize, usize, c64>> = Vec::new();
        for (matrix, factor) in [
            (&component.stiffness, c64::new(1.0, 0.0)),
            (&component.mass, -lambda),
        ] {
            for column in 0..matrix.ncols() {
                let rows = matrix.row_idx_of_col_raw(column).iter();
                for (row, value) in rows.zip(matrix.val_of_col(column)) {
                    entries.push(Triplet::new(*row as usize, column, factor * *value));
                }
            }
        }
        let n = component.dofs.len();
        let matrix = SparseColMat::try_new_from_triplets(n, n, &entries).unwrap();
        let forces = self.seen.transpose() * &self.forces;
        let forces = Mat::from_fn(n, forces.ncols(), |i, j| c64::new(forces[(i, j)], 0.0));
        let moved = matrix.sp_lu().unwrap().solve(&forces);
        let seen = Mat::from_fn(self.seen.nrows(), n, |i, j| {
            c64::new(self.seen[(i, j)], 0.0)
        });
        seen * moved
    }

    /// Of the superelement as a simulation uses it.
    fn reduced(&self, outcome: &Outcome, component: &Component) -> impl Fn(f64) -> Mat<c64> {
        let element = &outcome.fitted.superelement;
        let body = FlexibleBody::from_superelement(element, Compatibility::Strong).unwrap();
        let (n, rows) = (body.coordinate_count(), self.rows);
        let mut shapes = Mat::zeros(self.scale.len(), n);
        shapes
            .as_mut()
            .subrows_mut(0, rows)
            .copy_from(&body.interface_shapes);
        if let Some((basis, _)) = &outcome.fitted.fields {
            let mut unit = vec![0.0; n];
            let mut original = vec![0.0; body.original_coordinate_count()];
            let mut at = rows;
            for (row, dof) in basis.dofs.iter().enumerate() {
                if dof.direction.is_rotation() {
                    continue;
                }
                for k in 0..n {
                    unit.fill(0.0);
                    unit[k] = 1.0;
                    body.original_coordinates(&unit, &mut original);
                    let mut values = original.iter();
                    let fields = [
                        Some(&basis.modes),
                        Some(&basis.residual),
                        basis.enrichment.as_ref(),
                    ];
                    shapes[(at, k)] = fields
                        .into_iter()
                        .flatten()
                        .flat_map(|block| (0..block.ncols()).map(move |j| block[(row, j)]))
                        .zip(values.by_ref())
                        .map(|(shape, value)| shape * value)
                        .sum();
                }
                at += 1;
            }
            assert_eq!(at, self.scale.len());
        }
        let rigid = rigid_motions(component, centre_of_mass(component).1);
        let rigid = &self.seen * normalised(component, &rigid);
        let scaled = Mat::from_fn(self.scale.len(), n, |i, j| self.scale[i] * shapes[(i, j)]);
        let flexibility = body.residual_flexibility.as_ref().map(|flexibility| {
            Mat::from_fn(self.scale.len(), self.scale.len(), |i, j| {
                match i.max(j) < rows {
                    true => self.scale[i] * flexibility[(i, j)] * self.scale[j],
                    false => 0.0,
                }
            })
        });
        let poles: Vec<f64> = std::iter::repeat_n(0.0, rigid.ncols())
            .chain(body.stiffness.iter().copied())
            .collect();
        let all = Mat::from_fn(self.scale.len(), poles.len(), |i, p| {
            match p.checked_sub(rigid.ncols()) {
                None => rigid[(i, p)],
                Some(k) => scaled[(i, k)],
            }
        });
        let driven = all.transpose() * &self.forces;
        let constant = flexibility.map(|flexibility| flexibility * &self.forces);
        move |square: f64| {
            let lambda = c64::new(square, 0.0) / c64::new(1.0, LOSS_FACTOR);
            Mat::from_fn(all.nrows(), driven.ncols(), |i, j| {
                let of_poles =
                    poles
                        .iter()
                        .enumerate()
                        .fold(c64::new(0.0, 0.0), |sum, (p, pole)| {
                            sum + c64::new(all[(i, p)] * driven[(p, j)], 0.0)
                                / (c64::new(*pole, 0.0) - lambda)
                        });
                of_poles + constant.as_ref().map_or(0.0, |constant| constant[(i, j)])
            })
        }
    }

    /// Largest ‖H - H_ref‖ / ‖H_ref‖ of the frequencies, within interfaces and between them.
    fn error(&self, outcome: &Outcome, component: &Component, squares: &[f64]) -> f64 {
        let reduced = self.reduced(outcome, component);
        let mut largest = 0.0_f64;
        for square in squares {
            let (exact, found) = (self.whole(component, *square), reduced(*square));
            let (mut apart, mut all) = ([0.0; 2], [0.0; 2]);
            for (j, of_force) in self.force_groups.iter().enumerate() {
                for (i, of_place) in self.groups.iter().enumerate() {
                    let kind = usize::from(of_force != of_place);
                    apart[kind] += (found[(i, j)] - exact[(i, j)]).norm_sqr();
                    all[kind] += exact[(i, j)].norm_sqr();
                }
            }
            for kind in 0..2 {
                if all[kind] > 0.0 {
                    largest = largest.max((apart[kind] / all[kind]).sqrt());
                }
            }
        }
        println!("true error {largest:.2e} at {} frequencies", squares.len());
        largest
    }
}

/// Prints the row of a part in the table of the documentation, and compares it with the one that stands there.
fn compare_with_the_table(
    part: &str,
    component: &Component,
    outcome: &Outcome,
    tolerance: f64,
    error: f64,
) {
    let row = json!({
        "part": part,
        "dofs": component.dofs.len(),
        "tolerance": tolerance,
        "coordinates": coordinates(&outcome.fitted.superelement),
        "bound": outcome.fit.total,
        "true_error": error,
    });
    println!("{row}");
    let table = scene_reduction::PAGE.lines();
    let known = (table.iter())
        .find(|line| line["part"] == part && line["tolerance"] == row["tolerance"])
        .expect("a row of the table");
    for exact in ["dofs", "coordinates"] {
        assert_eq!(known[exact], row[exact], "{exact}");
    }
    for rounded in ["bound", "true_error"] {
        let [known, row] = [known, &row].map(|line| line[rounded].as_f64().unwrap());
        assert!(
            (row / known - 1.0).abs() < 0.05,
            "{rounded}: {row:e}, in the table {known:e}"
        );
    }
}

/// Rᵀ M R = I.
fn normalised(component: &Component, rigid: &Mat<f64>) -> Mat<f64> {
    let gram = rigid.transpose() * dcb_tests::dense::times(&component.mass, rigid.as_ref());
    let (values, vectors) = dcb_tests::dense::eigen(&dcb_tests::dense::symmetric(&gram));
    let turned = rigid * vectors;
    Mat::from_fn(turned.nrows(), turned.ncols(), |i, k| {
        turned[(i, k)] / values[k].sqrt()
    })
}

/// ω² from a thousandth of the scene's highest frequency on, and at the part's resonances.
fn frequencies(outcome: &Outcome, count: usize) -> Vec<f64> {
    let end = (TAU * outcome.asked.demand.band.frequency.unwrap()).powi(2);
    let spread = (1..=count).map(|i| end * (i as f64 / count as f64).powi(2));
    let modes = outcome
        .fitted
        .superelement
        .modes
        .eigenvalues
        .iter()
        .copied();
    spread
        .chain(modes.filter(|square| *square > 0.0 && *square < end))
        .collect()
}

fn planar_rod_and_scene() -> (Component, Value) {
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("../samples/slider-crank/scene.json");
    let mut scene: Value = serde_json::from_str(&fs::read_to_string(sample).unwrap()).unwrap();
    scene["bodies"]["rod"]["superelement"] = json!(FILE);
    (parts::rod(16), scene)
}

const PINS: [(&str, Direction); 4] = [
    ("a", Direction::Ux),
    ("a", Direction::Uy),
    ("b", Direction::Ux),
    ("b", Direction::Uy),
];

#[test]
fn the_rod_of_the_slider_crank() {
    let (rod, scene) = planar_rod_and_scene();
    for tolerance in [1e-2, 1e-3, 1e-5] {
        let found = fitted(&rod, &scene, tolerance);
        let total = found.fit.total.unwrap();
        assert!(total <= tolerance, "{total:e}");
        assert!(found.fit.certified.unwrap() <= 0.5 * tolerance);
        let places = Places::of(&found, &rod, &PINS);
        assert_eq!(places.nodes, BTreeSet::from([2]));
        let error = places.error(&found, &rod, &frequencies(&found, 150));
        assert!(error <= tolerance, "{error:e} above {tolerance:e}");
        let name = "rod of 16 elements in the slider-crank, with its node 2";
        compare_with_the_table(name, &rod, &found, tolerance, error);
        let (basis, mesh) = found.fitted.fields.unwrap();
        assert!(
            basis.dofs.iter().all(|dof| dof.node == 2),
            "only the node that is named"
        );
        assert_eq!(
            (mesh.node_count(), mesh.cells.len(), mesh.point_sets.len()),
            (17, 0, 0)
        );
    }
}

#[test]
fn looser_tolerances_take_no_more_coordinates() {
    let (rod, scene) = planar_rod_and_scene();
    let counts: Vec<usize> = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 0.5]
        .iter()
        .map(|tolerance| coordinates(&fitted(&rod, &scene, *tolerance).fitted.superelement))
        .collect();
    println!("{counts:?}");
    assert!(
        counts.windows(2).all(|pair| pair[0] >= pair[1]),
        "{counts:?}"
    );
    assert!(counts[0] > counts[counts.len() - 1] + 3, "{counts:?}");
}

/// A crank, a flexible rod and a piston in space; the crank turns about z at a given speed.
fn slider_crank_in_space(rod: &str, step: f64, node: Option<u32>) -> Value {
    let mut scene = json!({
        "dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
        "bodies": {
            "crank": {"rigid": {"mass": 1, "inertia": [1e-3, 1e-3, 1e-3], "points": {"axle": [0, 0, 0], "pin": [0.04, 0, 0]}}},
            rod: {"superelement": FILE, "position": [0.04, 0, 0]},
            "piston": {"rigid": {"mass": 0.3, "inertia": [1e-4, 1e-4, 1e-4], "points": {"pin": [0, 0, 0]}}, "position": [0.22, 0, 0]},
        },
        "joints": {
            "axle": {"revolute": {"a": "ground", "b": "crank/axle", "axis": [0, 0, 1]}},
            "big": {"revolute": {"a": "crank/pin", "b": format!("{rod}/big-end"), "axis": [0, 0, 1]}},
            "small": {"revolute": {"a": format!("{rod}/small-end"), "b": "piston/pin", "axis": [0, 0, 1]}},
            "guide": {"prismatic": {"a": "ground", "b": "piston/pin", "axis": [1, 0, 0]}},
        },
        "drives": {"motor": {"speed": {"joint": "axle", "constant": 400}}},
        "integrator": {"generalized_alpha": {"step": step, "end": 0.02}},
    });
    if let Some(node) = node {
        scene["outputs"] = json!({"bending": {"node_displacement": {"body": rod, "node": node}}});
    }
    scene
}

#[test]
fn a_connecting_rod_in_space_moves_in_its_plane() {
    let rod = connecting_rod(0);
    let middle = (0..rod.mesh.node_count() as u32)
        .min_by(|a, b| {
            let apart = |node: &u32| {
                let [x, y, z] = rod.mesh.position(*node);
                (x - 0.09).hypot(y - 0.01).hypot(z - 0.006)
            };
            apart(a).total_cmp(&apart(b))
        })
        .unwrap();
    let scene = slider_crank_in_space("rod", 1e-5, Some(middle));
    let tolerance = 1e-3;
    let found = fitted(&rod, &scene, tolerance);
    let forces = [
        ("big-end", Direction::Ux),
        ("big-end", Direction::Uy),
        ("small-end", Direction::Ux),
        ("small-end", Direction::Uy),
    ];
    let places = Places::of(&found, &rod, &forces);
    let error = places.error(&found, &rod, &frequencies(&found, 3));
    assert!(error <= tolerance, "{error:e}");
    let name = "connecting rod in a slider-crank in space, with a node";
    compare_with_the_table(name, &rod, &found, tolerance, error);
    // Neither what leads out of the plane nor the moments of the pins.
    let element = &found.fitted.superelement;
    assert!(element.residual.sigma_squared.len() <= 4);
    assert!(
        found
            .fit
            .left_out
            .iter()
            .any(|one| one.what.contains("out of the plane"))
    );
    let plain = lowest(&rod, 20);
    assert!(coordinates(element) < coordinates(&plain.superelement) / 2);
    let small = bytes(element, Some(&found.fitted), None);
    let large = bytes(&plain.superelement, None, Some((&plain, &rod)));
    println!("{small} bytes, plainly {large}");
    assert!(small < large / 10);
}

/// A box with averaged frames at both ends, `left` and `right`, and two nodes between them, `top`.
fn box_with_places() -> Component {
    let part = parts::steel_box([5, 2, 2], SolidElement::Hexahedron);
    let ends = ["x_min", "x_max"].map(|set| part.mesh.point_sets[set].clone());
    let interfaces = vec![
        parts::interface("left", InterfaceKind::Average, ends[0].clone()),
        parts::interface("top", InterfaceKind::Nodes, vec![26, 44]),
        parts::interface("right", InterfaceKind::Average, ends[1].clone()),
    ];
    parts::with_interfaces(&part, interfaces)
}

fn clamped(loads: Value, outputs: Value) -> Value {
    json!({
        "dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
        "bodies": {"arm": {"superelement": FILE}},
        "joints": {"root": {"fixed": {"a": "ground", "b": "arm/left"}}},
        "loads": loads,
        "outputs": outputs,
        "integrator": {"generalized_alpha": {"step": 2e-5, "end": 0.1}},
    })
}

#[test]
fn unused_interfaces_and_directions_without_force_are_left_out() {
    let part = box_with_places();
    let load = json!({"push": {"force": {"at": "arm/right", "axes": "follower", "components": [0, {"formula": "sin(500*t)"}, 0]}}});
    let scene = clamped(load, json!({}));
    let mut forces = vec![("right", Direction::Uy)];
    forces.extend(Direction::ALL.map(|direction| ("left", direction)));
    let mut told: Vec<String> = Vec::new();
    for tolerance in [1e-1, 1e-2, 1e-3, 1e-4] {
        let found = fitted(&part, &scene, tolerance);
        let element = &found.fitted.superelement;
        assert_eq!(names(element), ["left", "right"]);
        assert!(found.fitted.fields.is_none());
        let places = Places::of(&found, &part, &forces);
        let error = places.error(&found, &part, &frequencies(&found, 40));
        assert!(error <= tolerance, "{error:e} above {tolerance:e}");
        let name = "box fixed at one end, a force at the other, a third interface unused";
        compare_with_the_table(name, &part, &found, tolerance, error);
        let what = |one: &Omission| one.what.clone();
        told.extend(found.fit.left_out.iter().map(what));
    }
    assert_eq!(
        told.iter()
            .filter(|what| *what == "interface \"top\"")
            .count(),
        4
    );
    let directions = "5 of 6 directions of force on interface \"right\"";
    assert!(told.iter().any(|what| what == directions), "{told:?}");
}

#[test]
fn what_is_only_looked_at_has_no_attachments() {
    let part = box_with_places();
    let outputs = json!({"tip": {"displacement": {"at": "arm/right"}}, "node": {"node_position": {"body": "arm", "node": 30}}});
    let mut scene = clamped(json!({}), outputs);
    scene["gravity"] = json!([0, -9.81, 0]);
    scene["joints"] =
        json!({"root": {"revolute": {"a": "ground", "b": "arm/left", "axis": [0, 0, 1]}}});
    let found = fitted(&part, &scene, 1e-2);
    let element = &found.fitted.superelement;
    let roles: Vec<Role> = element.interfaces.iter().map(|one| one.role).collect();
    assert_eq!(roles, [Role::Attachment, Role::Output]);
    assert!(element.mode_count() > 0);
    // All but the moment about the pivot.
    let forces = [0, 1, 2, 3, 4].map(|index| ("left", Direction::ALL[index]));
    let places = Places::of(&found, &part, &forces);
    let error = places.error(&found, &part, &frequencies(&found, 40));
    assert!(error > 0.0 && error <= 1e-2, "{error:e}");
}

#[test]
fn a_part_that_nothing_moves_needs_no_modes() {
    let part = box_with_places();
    let found = fitted(&part, &clamped(json!({}), json!({})), 1e-3);
    assert!(found.asked.is_rigid());
    assert_eq!(coordinates(&found.fitted.superelement), 0);
    assert_eq!(names(&found.fitted.superelement), ["left"]);
    assert_eq!(found.fit.left_out[0].what, "all deflection");
}

#[test]
fn equilibria_need_no_modes_and_are_exact() {
    let part = box_with_places();
    let load = json!({"push": {"force": {"at": "arm/right", "components": [10, 0, 5]}}});
    let mut scene = clamped(load, json!({"tip": {"displacement": {"at": "arm/right"}}}));
    scene["analysis"] = json!("static");
    let found = fitted(&part, &scene, 1e-4);
    assert_eq!(found.fitted.superelement.mode_count(), 0);
    // What the load does statically, the inertia relieved, is that of the whole part: at the left and at the right.
    let oracle = Oracle::of(&part);
    let exact = &oracle.localization * &oracle.inverse * oracle.localization.transpose();
    let flexibility = &found.fitted.superelement.residual.flexibility;
    let moved = |matrix: &Mat<f64>, row: usize, first: usize| {
        10.0 * matrix[(row, first)] + 5.0 * matrix[(row, first + 2)]
    };
    let size = 10.0 * exact[(12, 12)] + 5.0 * exact[(14, 14)];
    for row in 0..12 {
        // Left, two nodes of three directions, right.
        let whole = if row < 6 { row } else { row + 6 };
        let (found, exact) = (moved(flexibility, row, 6), moved(&exact, whole, 12));
        assert!(
            (found - exact).abs() < 1e-9 * size,
            "row {row}: {found:e} {exact:e}"
        );
    }
}

#[test]
fn without_a_limit_of_the_frequencies_everything_stays() {
    let part = box_with_places();
    let mut scene = clamped(
        json!({}),
        json!({"tip": {"displacement": {"at": "arm/right"}}}),
    );
    scene["analysis"] = json!({"modes": {"count": 5}});
    let found = fitted(&part, &scene, 1e-3);
    assert_eq!(found.fitted.superelement.mode_count(), 20);
    assert_eq!((found.fit.total, found.fit.certified), (None, None));
    assert!(
        found.fit.text().contains("not known, without a limit"),
        "{}",
        found.fit.text()
    );
}

#[test]
fn a_limit_of_the_modes_that_is_too_low_is_an_error_with_numbers() {
    let (rod, scene) = planar_rod_and_scene();
    for (most, says) in [
        (2, "don't reach its highest frequency"),
        (6, "certified to be between"),
    ] {
        let limits = Limits {
            most_modes: Some(most),
            ..limits(1e-5)
        };
        let Err(error) = try_to_fit(&rod, &scene, &limits) else {
            panic!("{most} modes were enough");
        };
        let told = error.to_string();
        for words in [
            &format!("with {most} modes"),
            says,
            &format!("--modes {most}"),
            "5.0e-6",
        ] {
            assert!(told.contains(words), "{words} is missing: {told}");
        }
        assert!(!error.is_unusable_input());
    }
}

/// The displacement under centrifugal forces that modes and attachments lack, from dense solutions.
#[test]
fn columns_for_centrifugal_forces_where_displacements_inside_need_them() {
    let part = box_with_places();
    let node = 31;
    let scene = |speed: f64| {
        let mut scene = clamped(
            json!({}),
            json!({"p": {"node_displacement": {"body": "arm", "node": node}}}),
        );
        scene["joints"] =
            json!({"root": {"revolute": {"a": "ground", "b": "arm/left", "axis": [0, 0, 1]}}});
        scene["drives"] = json!({"motor": {"speed": {"joint": "root", "constant": speed}}});
        scene
    };
    let speed = 600.0;
    let (asked, _) = asked(&part, &scene(speed));
    let modes = 6;
    let enriched = Reduction {
        enrichment: vec![EnrichmentSource::Spin],
        ..Reduction::lowest(modes)
    };
    let reduced = reduce(&asked.component, &enriched, &mut ()).unwrap();
    let columns = SpinColumns::of(&asked, &reduced, 1e-3).unwrap();
    let told = columns.why();
    let number = told
        .split("lose ")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap();
    let found: f64 = number.parse().unwrap();

    let oracle = Oracle::of(&part);
    let (mass, centre) = centre_of_mass(&part);
    let dofs = part.dofs.nodal_dofs();
    let plain = lowest(&part, modes);
    let mut basis = Mat::zeros(dofs.len(), modes + plain.recovery.residual.ncols());
    basis
        .as_mut()
        .subcols_mut(0, modes)
        .copy_from(&plain.recovery.modes);
    let attached = plain.recovery.residual.ncols();
    let unit = Mat::from_fn(dofs.len(), attached, |i, j| {
        plain.recovery.residual[(i, j)] / plain.recovery.residual.col(j).norm_l2()
    });
    basis.as_mut().subcols_mut(modes, attached).copy_from(&unit);
    let stiffness = basis.transpose() * dense(&part.stiffness) * &basis;
    let whole_mass = dense(&part.mass);
    let mut worst = 0.0_f64;
    for about in spin_axes() {
        // ρ (1 - n nᵀ) r.
        let across = Mat::from_fn(dofs.len(), 1, |i, _| {
            let position = part.mesh.position(dofs[i].node);
            let r: Vec<f64> = (0..3).map(|a| position[a] - centre[a]).collect();
            let along: f64 = (0..3).map(|a| about[a] * r[a]).sum();
            r[dofs[i].direction.axis()] - along * about[dofs[i].direction.axis()]
        });
        let forces = &whole_mass * &across;
        let exact = &oracle.inverse * &forces;
        let amounts = solve(&stiffness, &(basis.transpose() * &forces));
        let lost = &exact - &basis * amounts;
        for direction in &Direction::ALL[..3] {
            let row = part.dofs.row(node, *direction).unwrap();
            worst = worst.max(lost[(row, 0)].abs());
        }
    }
    let tensor = plain.superelement.inertia.tensor;
    let size = ((tensor[0][0] + tensor[1][1] + tensor[2][2]) / mass).sqrt();
    let expected = speed * speed * worst / (0.01 * size);
    println!("{told}; expected {expected:e}");
    // Axes were sampled, and two digits are told.
    assert!(
        (found / expected - 1.0).abs() < 0.07,
        "{found:e} {expected:e}"
    );

    let slow = fitted(&part, &scene(1.0), 1e-3);
    assert!(slow.fit.spin.starts_with("no columns"), "{}", slow.fit.spin);
    assert!(slow.fitted.superelement.enrichment.is_none());
    let needed = columns.are_needed();
    let fast = fitted(&part, &scene(speed), 1e-3);
    println!("{}", fast.fit.spin);
    assert_eq!(needed, found > 1e-3);
    // With more modes than six, so the decision may be another one; what is said is what was done.
    let has_columns = fast.fitted.superelement.enrichment.is_some();
    assert_eq!(has_columns, !fast.fit.spin.starts_with("no columns"));
}

/// Axes over half a sphere.
fn spin_axes() -> Vec<[f64; 3]> {
    let steps = 24;
    let angles = (0..steps).flat_map(|i| (0..=steps).map(move |j| (i, j)));
    let axis = |(i, j): (u32, u32)| {
        let (turn, tilt) = (f64::from(i), f64::from(j));
        let (turn, tilt) = (
            TAU * turn / f64::from(steps),
            0.25 * TAU * tilt / f64::from(steps),
        );
        [turn.cos() * tilt.sin(), turn.sin() * tilt.sin(), tilt.cos()]
    };
    angles.map(axis).collect()
}

#[test]
fn two_bodies_of_one_part_share_a_superelement() {
    let rod = parts::rod(8);
    let scene = json!({
        "dimension": 2, "units": {"length": "m", "mass": "kg", "time": "s"}, "gravity": [0, -9.81],
        "bodies": {
            "upper": {"superelement": FILE},
            "lower": {"superelement": FILE, "position": [0.3, 0]},
        },
        "joints": {
            "pivot": {"revolute": {"a": "ground", "b": "upper/a"}},
            "elbow": {"revolute": {"a": "upper/b", "b": "lower/a"}},
        },
        "outputs": {"end": {"position": {"at": "lower/b"}}, "middle": {"node_position": {"body": "upper", "node": 4}}},
        "integrator": {"generalized_alpha": {"step": 5e-5, "end": 1}},
    });
    let found = fitted(&rod, &scene, 1e-3);
    assert_eq!(found.fit.bodies, ["lower", "upper"]);
    let b = &found.asked.demand.interfaces[1];
    assert_eq!(
        (b.loaded_by.as_slice(), b.observed_by.as_slice()),
        (
            &["joints.elbow".to_owned()][..],
            &["outputs.end".to_owned()][..]
        )
    );
    let places = Places::of(&found, &rod, &PINS);
    assert_eq!(places.nodes, BTreeSet::from([4]));
    let error = places.error(&found, &rod, &frequencies(&found, 100));
    assert!(error <= 1e-3, "{error:e}");
}

#[test]
fn a_plane_counts_only_if_other_parts_have_it_too() {
    let rod = parts::steel_box([5, 2, 2], SolidElement::Hexahedron);
    let interfaces = ["x_min", "x_max"].map(|set| {
        let name = if set == "x_min" {
            "big-end"
        } else {
            "small-end"
        };
        parts::interface(
            name,
            InterfaceKind::Average,
            rod.mesh.point_sets[set].clone(),
        )
    });
    let rod = parts::with_interfaces(&rod, interfaces.into());
    let mut scene = slider_crank_in_space("rod", 2e-5, None);
    // Its ends are drawn in the plane of the crank.
    let [_, y, z] = rod.mesh.position(rod.mesh.point_sets["x_min"][4]);
    assert!(
        (y - 0.05).abs() < 1e-12 && (z - 0.03).abs() < 1e-12,
        "the middle of the end: {y} {z}"
    );
    scene["bodies"]["rod"]["position"] = json!([0.04, -y, -z]);
    let alone = fitted(&rod, &scene, 1e-3);
    let leads_out = |outcome: &Outcome| {
        let mut left_out = outcome.fit.left_out.iter();
        left_out.any(|one| one.what.contains("out of the plane"))
    };
    println!("{:?}", alone.asked.demand.planes);
    let is_symmetric = leads_out(&alone);
    // A flexible crank whose file isn't there.
    scene["bodies"]["crank"] = json!({"superelement": "crank.dcb.h5"});
    let unknown = fitted(&rod, &scene, 1e-3);
    assert!(!leads_out(&unknown));
    assert!(
        unknown
            .fit
            .notes
            .iter()
            .any(|note| note.contains("crank.dcb.h5")),
        "{:?}",
        unknown.fit.notes
    );
    assert!(coordinates(&unknown.fitted.superelement) >= coordinates(&alone.fitted.superelement));
    assert!(is_symmetric);
}
