//! Common demand of several bodies of one component: whatever one of them asks.

use nalgebra::Vector3;

use super::part::PartInterface;
use super::wrench_space::{Half, WrenchSpace};
use super::{Band, Demand, InterfaceDemand, NodeDemand, PlaneOfMotion, PlanesOfMotion, Spin};

/// Sines of angles, and distances by the size of the part, below this are what seven written digits leave.
const ROUNDING: f64 = 1e-6;

impl Demand {
    /// Common demand of several bodies of one component, `interfaces` its own; `None` without a body. Wrenches of an interface span what
    /// those of the bodies span together, bands and spins are the largest, and planes of motion those that all bodies have.
    pub fn united(demands: &[Self], interfaces: &[PartInterface]) -> Option<Self> {
        let (first, others) = demands.split_first()?;
        if others.is_empty() {
            return Some(first.clone());
        }
        let all = || demands.iter();
        let bodies: Vec<&str> = all().map(|one| one.body.as_str()).collect();
        let involvements = all().map(|one| one.involvement);
        let deflections = all().map(|one| one.deflection);
        let inertia_changes = all().map(|one| one.inertia_change);
        Some(Self {
            body: bodies.join(", "),
            time: first.time.clone(),
            involvement: involvements.min_by_key(|one| *one as u8)?,
            deflection: deflections.max_by_key(|one| *one as u8)?,
            interfaces: (interfaces.iter())
                .filter_map(|interface| united_interface(demands, interface))
                .collect(),
            nodes: all().fold(NodeDemand::None, |nodes, one| nodes.and(&one.nodes)),
            coordinates_shown_by: together(all().map(|one| &one.coordinates_shown_by)),
            whole_shown_by: together(all().map(|one| &one.whole_shown_by)),
            part_loads: together(all().map(|one| &one.part_loads)),
            gravity: all().any(|one| one.gravity),
            inertia_change: inertia_changes.max_by_key(|one| *one as u8)?,
            spin: Spin::fastest(all().map(|one| &one.spin))?,
            band: Band::widest(all().map(|one| &one.band)),
            planes: common_planes(demands, &bodies, size(interfaces)),
        })
    }
}

/// Union of lists.
fn together<'a>(lists: impl Iterator<Item = &'a Vec<String>>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for entry in lists.flatten() {
        if !all.contains(entry) {
            all.push(entry.clone());
        }
    }
    all
}

/// `None` where no body uses it.
fn united_interface(demands: &[Demand], interface: &PartInterface) -> Option<InterfaceDemand> {
    let of = |demand: &'_ Demand| -> Option<InterfaceDemand> {
        let mut used = demand.interfaces.iter();
        used.find(|used| used.name == interface.name).cloned()
    };
    let uses: Vec<InterfaceDemand> = demands.iter().filter_map(of).collect();
    if uses.is_empty() {
        return None;
    }
    let mut space = WrenchSpace::reaching(interface.directions);
    for wrench in uses.iter().flat_map(|used| &used.wrenches) {
        let (force, moment) = wrench.split_at(3);
        for (half, components) in [(Half::Force, force), (Half::Moment, moment)] {
            let vector = Vector3::from_column_slice(components);
            if vector.norm() > 0.0 {
                space.add(half, &vector);
            }
        }
    }
    Some(InterfaceDemand {
        name: interface.name.clone(),
        wrenches: space.basis(),
        loaded_by: together(uses.iter().map(|used| &used.loaded_by)),
        observed_by: together(uses.iter().map(|used| &used.observed_by)),
    })
}

impl NodeDemand {
    /// Nodes of this demand and of another.
    fn and(self, other: &Self) -> Self {
        match (self, other) {
            (Self::All(mut by), Self::All(more)) => {
                by.extend(more.iter().cloned());
                Self::All(by)
            }
            (Self::All(by), _) => Self::All(by),
            (_, Self::All(by)) => Self::All(by.clone()),
            (Self::Some(nodes), Self::None) => Self::Some(nodes),
            (Self::None, other) => other.clone(),
            (Self::Some(mut nodes), Self::Some(more)) => {
                for (node, by) in more {
                    nodes.entry(*node).or_default().extend(by.iter().cloned());
                }
                Self::Some(nodes)
            }
        }
    }
}

impl Spin {
    fn fastest<'a>(spins: impl Iterator<Item = &'a Self> + Clone) -> Option<Self> {
        let known = spins.clone().all(|spin| spin.known);
        let fastest = spins.max_by(|a, b| a.rate.total_cmp(&b.rate))?;
        Some(Self {
            known,
            ..fastest.clone()
        })
    }
}

impl Band {
    fn widest<'a>(bands: impl Iterator<Item = &'a Self> + Clone) -> Self {
        let limits: Option<Vec<f64>> = bands.clone().map(|band| band.frequency).collect();
        Self {
            frequency: limits.map(|limits| limits.into_iter().fold(0.0, f64::max)),
            reasons: together(bands.map(|band| &band.reasons)),
        }
    }
}

/// Largest distance of two interfaces.
fn size(interfaces: &[PartInterface]) -> f64 {
    let distances = (interfaces.iter()).flat_map(|a| {
        let others = interfaces.iter();
        others.map(|b| (a.position - b.position).norm())
    });
    distances.fold(0.0, f64::max)
}

fn common_planes(demands: &[Demand], bodies: &[&str], size: f64) -> PlanesOfMotion {
    let has = |demand: &Demand, plane: &PlaneOfMotion| {
        let mut own = demand.planes.planes.iter();
        own.any(|own| is_same(own, plane, size))
    };
    let mut found = PlanesOfMotion {
        planes: Vec::new(),
        refused: together(demands.iter().map(|one| &one.planes.refused)),
    };
    for plane in demands.iter().flat_map(|one| &one.planes.planes) {
        if found.planes.iter().any(|known| is_same(known, plane, size)) {
            continue;
        }
        if demands.iter().all(|demand| has(demand, plane)) {
            found.planes.push(*plane);
            continue;
        }
        let [x, y, z] = plane.normal;
        let why = format!(
            "across [{x:.4}, {y:.4}, {z:.4}] of the component: not the same in {}",
            bodies.join(", ")
        );
        if !found.refused.contains(&why) {
            found.refused.push(why);
        }
    }
    found
}

fn is_same(a: &PlaneOfMotion, b: &PlaneOfMotion, size: f64) -> bool {
    let (normal, other) = (Vector3::from(a.normal), Vector3::from(b.normal));
    let side = normal.dot(&other).signum();
    let apart = (a.offset - side * b.offset).abs();
    normal.cross(&other).norm() <= ROUNDING
        && apart <= ROUNDING * size.max(a.offset.abs()).max(b.offset.abs())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
mod tests {
    use nalgebra::Matrix3;

    use super::super::{Deflection, Involvement};
    use super::*;
    use dcb_formats::scene::InertiaChange;

    fn interface(name: &str, x: f64) -> PartInterface {
        PartInterface {
            name: name.into(),
            position: Vector3::new(x, 0.0, 0.0),
            orientation: Matrix3::identity(),
            directions: [true; 6],
        }
    }

    fn used(name: &str, wrenches: &[[f64; 6]], by: &str) -> InterfaceDemand {
        InterfaceDemand {
            name: name.into(),
            wrenches: wrenches.to_vec(),
            loaded_by: vec![by.into()],
            observed_by: Vec::new(),
        }
    }

    fn demand(body: &str, interfaces: Vec<InterfaceDemand>) -> Demand {
        Demand {
            body: body.into(),
            time: "s".into(),
            involvement: Involvement::Involved,
            deflection: Deflection::Dynamic,
            interfaces,
            nodes: NodeDemand::None,
            coordinates_shown_by: Vec::new(),
            whole_shown_by: Vec::new(),
            part_loads: Vec::new(),
            gravity: false,
            inertia_change: InertiaChange::FirstOrder,
            spin: Spin {
                rate: 1.0,
                known: true,
                falls: None,
                reason: "driven".into(),
            },
            band: Band {
                frequency: Some(100.0),
                reasons: vec!["steps".into()],
            },
            planes: PlanesOfMotion {
                planes: vec![PlaneOfMotion {
                    normal: [0.0, 0.0, 1.0],
                    offset: 0.1,
                    is_along_frames: true,
                }],
                refused: Vec::new(),
            },
        }
    }

    const X: [f64; 6] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    const OBLIQUE: [f64; 6] = [0.6, 0.8, 0.0, 0.0, 0.0, 0.0];
    const ABOUT_Z: [f64; 6] = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

    fn part() -> [PartInterface; 3] {
        [
            interface("a", 0.0),
            interface("b", 0.3),
            interface("c", 0.2),
        ]
    }

    #[test]
    fn interfaces_are_those_of_all_bodies_in_the_order_of_the_part() {
        let one = demand(
            "one",
            vec![used("c", &[X], "joints.c"), used("b", &[X], "joints.b")],
        );
        let two = demand("two", vec![used("b", &[OBLIQUE, ABOUT_Z], "joints.d")]);
        let all = Demand::united(&[one, two], &part()).unwrap();
        let names: Vec<&str> = all.interfaces.iter().map(|one| one.name.as_str()).collect();
        assert_eq!((all.body.as_str(), names), ("one, two", vec!["b", "c"]));
        let b = &all.interfaces[0];
        assert_eq!(b.loaded_by, ["joints.b", "joints.d"]);
        // x and an oblique direction in the plane x, y span that plane; the moment isn't mixed with them.
        assert_eq!(b.wrenches.len(), 3);
        assert!(b.wrenches[..2].iter().all(|wrench| wrench[2..] == [0.0; 4]));
        assert_eq!(b.wrenches[2], ABOUT_Z);
    }

    #[test]
    fn the_largest_of_everything_else() {
        let one = demand("one", Vec::new());
        let mut two = demand("two", Vec::new());
        two.band.frequency = Some(250.0);
        two.spin = Spin {
            rate: 5.0,
            known: false,
            falls: None,
            reason: "guessed".into(),
        };
        two.nodes = NodeDemand::Some([(3, vec!["outputs.p".into()])].into());
        two.involvement = Involvement::Unused;
        two.inertia_change = InertiaChange::SecondOrder;
        let mut all = Demand::united(&[one.clone(), two.clone()], &part()).unwrap();
        assert_eq!(all.band.frequency, Some(250.0));
        assert_eq!((all.spin.rate, all.spin.known), (5.0, false));
        assert_eq!(all.involvement, Involvement::Involved);
        assert_eq!(all.inertia_change, InertiaChange::SecondOrder);
        assert_eq!(all.nodes, two.nodes);

        let mut three = demand("three", Vec::new());
        three.nodes = NodeDemand::All(vec!["fields[0]".into()]);
        three.band.frequency = None;
        three.spin.rate = 9.0;
        all = Demand::united(&[one, two, three], &part()).unwrap();
        assert_eq!(all.band.frequency, None);
        assert_eq!(all.nodes, NodeDemand::All(vec!["fields[0]".into()]));
        // One is guessed, even though another is faster.
        assert_eq!((all.spin.rate, all.spin.known), (9.0, false));
    }

    #[test]
    fn planes_are_those_of_every_body() {
        let one = demand("one", Vec::new());
        let mut two = one.clone();
        // The same from the other side.
        two.planes.planes[0] = PlaneOfMotion {
            normal: [0.0, 0.0, -1.0],
            offset: -0.1,
            is_along_frames: true,
        };
        let all = Demand::united(&[one.clone(), two.clone()], &part()).unwrap();
        assert_eq!(all.planes, one.planes);
        two.planes.planes[0].offset = 0.1;
        let none = Demand::united(&[one, two], &part()).unwrap();
        assert!(none.planes.planes.is_empty());
        assert!(none.planes.refused[0].contains("not the same in"));
    }

    #[test]
    fn one_body_is_itself_and_none_is_nothing() {
        let one = demand("one", vec![used("a", &[X], "joints.a")]);
        assert_eq!(
            Demand::united(std::slice::from_ref(&one), &part()),
            Some(one)
        );
        assert_eq!(Demand::united(&[], &part()), None);
    }
}
