//! A demand in words.

use std::fmt::{self, Display, Formatter};

use super::{Deflection, Demand, InterfaceDemand, Involvement, NodeDemand};
use dcb_formats::scene::InertiaChange;
use dcb_formats::units::{four_digits, written_frequency};

impl Display for Demand {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let involvement = match self.involvement {
            Involvement::Involved => "",
            Involvement::Locked => ", which is fixed to the ground and which nothing looks at",
            Involvement::Unused => ", which nothing refers to",
        };
        writeln!(f, "body {:?}{involvement}", self.body)?;
        let deflection = match self.deflection {
            Deflection::Rigid => "not followed",
            Deflection::Static => "equilibria",
            Deflection::Dynamic => "followed over time",
        };
        writeln!(f, "  deflection   {deflection}")?;
        for interface in &self.interfaces {
            write!(f, "{interface}")?;
        }
        write!(f, "{}", self.nodes)?;
        for by in &self.coordinates_shown_by {
            writeln!(f, "  coordinates  shown by {by}")?;
        }
        for by in &self.whole_shown_by {
            writeln!(f, "  whole body   shown by {by}")?;
        }
        for load in &self.part_loads {
            writeln!(f, "  load inside  {load:?}")?;
        }
        let gravity = if self.gravity { "acts" } else { "none" };
        writeln!(f, "  gravity      {gravity}")?;
        let inertia = match self.inertia_change {
            InertiaChange::Constant => "of the undeformed body",
            InertiaChange::FirstOrder => "follows the deflection to first order",
            InertiaChange::SecondOrder => "follows the deflection to second order",
        };
        writeln!(f, "  inertia      {inertia}")?;
        let bound = if self.spin.known { "at most" } else { "about" };
        let (rate, reason) = (self.spin.rate, &self.spin.reason);
        writeln!(
            f,
            "  spin         {bound} {} rad/{}: {reason}",
            four_digits(rate),
            self.time
        )?;
        match self.band.frequency {
            Some(frequency) => {
                let limit = written_frequency(frequency, &self.time);
                writeln!(f, "  frequencies  up to {limit}")?;
            }
            None => writeln!(f, "  frequencies  without a known limit")?,
        }
        for reason in &self.band.reasons {
            writeln!(f, "               {reason}")?;
        }
        for plane in &self.planes.planes {
            let [x, y, z] = plane.normal;
            writeln!(
                f,
                "  plane        across [{x:.4}, {y:.4}, {z:.4}] at {:.4e} (component), if every part is symmetric",
                plane.offset
            )?;
        }
        for why in &self.planes.refused {
            writeln!(f, "  no plane     {why}")?;
        }
        Ok(())
    }
}

impl Display for InterfaceDemand {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let name = &self.name;
        if !self.loaded_by.is_empty() {
            let wrenches: Vec<String> = self.wrenches.iter().map(in_words).collect();
            let by = self.loaded_by.join(", ");
            writeln!(
                f,
                "  interface    {name:?} takes {} from {by}",
                wrenches.join(" ")
            )?;
        }
        if !self.observed_by.is_empty() {
            let by = self.observed_by.join(", ");
            writeln!(f, "  interface    {name:?} is looked at by {by}")?;
        }
        Ok(())
    }
}

/// `fx`, or `f[0.6, 0.8, 0]`.
fn in_words(wrench: &[f64; 6]) -> String {
    const NAMES: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];
    if let Some(slot) = wrench.iter().position(|entry| *entry == 1.0) {
        return NAMES[slot].into();
    }
    let (force, moment) = wrench.split_at(3);
    let (letter, [x, y, z]) = match force.iter().any(|entry| *entry != 0.0) {
        true => ('f', [force[0], force[1], force[2]]),
        false => ('m', [moment[0], moment[1], moment[2]]),
    };
    format!("{letter}[{x:.4}, {y:.4}, {z:.4}]")
}

impl Display for NodeDemand {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Self::None => writeln!(f, "  nodes        none"),
            Self::Some(nodes) => {
                for (node, by) in nodes {
                    writeln!(f, "  node         {node} for {}", by.join(", "))?;
                }
                Ok(())
            }
            Self::All(by) => writeln!(f, "  nodes        all for {}", by.join(", ")),
        }
    }
}
