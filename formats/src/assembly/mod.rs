//! Assemblies: superelements and rigid bodies that are joined for good, and where the whole is joined to others.
//!
//! An [`Assembly`] is read from a JSON file ([`Assembly::read`]); `docs/assemblies.md` describes it, [`assembly_schema`] is its JSON schema. Bodies,
//! joints and springs are those of a scene at rest, so what is known of scenes is known of assemblies.

mod body;
mod file;

use std::path::Path;

use crate::Error;
use crate::component::Role;
use crate::named::Named;
use crate::scene::{Analysis, Joint, Scene, Spring, check_name};

pub use body::Mirror;
pub use file::assembly_schema;

/// Parts that are joined for good.
#[derive(Clone, Debug, PartialEq)]
pub struct Assembly {
    /// Name of the whole.
    pub name: String,
    /// Bodies where they stay, the joints and springs between them. Nothing of it moves.
    pub scene: Scene,
    /// Bodies that are mirror images of their components, by name.
    pub mirrors: Named<Mirror>,
    /// Interfaces of the whole, by their new names, in row order.
    pub interfaces: Named<ChosenInterface>,
    /// Places that are joined may be this far apart; they are then joined by a rigid link.
    pub allow_gap: Option<f64>,
}

/// An interface of a part that the whole keeps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChosenInterface {
    /// `body/interface` or `body/point`.
    pub at: String,
    /// Whether forces act on it; what the part says where `None`.
    pub role: Option<Role>,
}

impl Assembly {
    /// Reads and checks an assembly file of at most 64 MiB.
    ///
    /// # Errors
    /// [`Error::File`] if it can't be read, with line and column where the JSON or a key is wrong, with a path of keys where a value doesn't fit the others.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::parse(&file::text(path)?, path)
    }

    /// Reads and checks an assembly from JSON; `path` names it in errors, and relative paths start at its folder.
    ///
    /// # Errors
    /// As [`Assembly::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, Error> {
        let assembly = file::assembly(text, path)?;
        assembly.check().map_err(|error| error.in_file(path))?;
        Ok(assembly)
    }

    /// Checks everything that can be known before superelements are loaded.
    ///
    /// # Errors
    /// [`Error::Description`] with the path of keys, what was found and what would be right.
    pub fn check(&self) -> Result<(), Error> {
        debug_assert_eq!(self.scene.analysis, Analysis::Static);
        self.scene.check()?;
        if self.scene.bodies.is_empty() {
            return Err(Error::described(
                "bodies",
                "is empty; expected at least one, for example \"bodies\": {\"arm\": {\"superelement\": \"arm.dcb.h5\"}}",
            ));
        }
        if let Some(gap) = self.allow_gap
            && !(gap >= 0.0 && gap.is_finite())
        {
            return Err(Error::described(
                "allow_gap",
                format!("is {gap}, expected a length that is not negative"),
            ));
        }
        for (name, joint) in &self.scene.joints {
            if matches!(joint, Joint::Gear(_) | Joint::Rack(_)) {
                return Err(Error::described(
                    format!("joints.{name}.{}", joint.kind()),
                    "couples two joints, which moves with the mechanism; an assembly has joints between places only: keep its bodies apart in a scene",
                ));
            }
        }
        for (name, spring) in &self.scene.springs {
            check_linear(&format!("springs.{name}"), spring)?;
        }
        self.check_interfaces()
    }

    fn check_interfaces(&self) -> Result<(), Error> {
        if self.interfaces.is_empty() {
            return Err(Error::described(
                "interfaces",
                "is empty; an assembly without interface can't be joined to anything. Name at least one, for example \"interfaces\": {\"tool\": \"arm/flange\"}",
            ));
        }
        let mut seen: Vec<(&str, &str)> = Vec::new();
        for (name, chosen) in &self.interfaces {
            let location = format!("interfaces.{name}");
            check_name(&location, name)?;
            if chosen.at == "ground" || chosen.at.starts_with("ground/") {
                return Err(Error::described(
                    location,
                    "is on the ground, which doesn't move; expected \"body/interface\" or \"body/point\"",
                ));
            }
            self.scene.check_place(&location, &chosen.at)?;
            if let Some((_, other)) = seen.iter().find(|(at, _)| *at == chosen.at) {
                return Err(Error::described(
                    location,
                    format!(
                        "{:?} is interface {other:?} already; its rows would depend on each other",
                        chosen.at
                    ),
                ));
            }
            seen.push((&chosen.at, name));
        }
        Ok(())
    }
}

/// An assembly is linear: a spring has one stiffness, and no force as placed.
fn check_linear(location: &str, spring: &Spring) -> Result<(), Error> {
    use crate::scene::Characteristic;
    let refused =
        |key: &str, message: &str| Err(Error::described(format!("{location}.{key}"), message));
    let linear = |of: &Characteristic| matches!(of, Characteristic::Linear(_));
    const TABLE: &str = "is a table; an assembly is linear: give the stiffness or damping about its rest as a number";
    match spring {
        Spring::Spring(of) if of.free_length.is_some() => refused(
            "spring.free_length",
            "loads the spring as placed; an assembly is at rest as placed: leave it out, or keep the spring in a scene",
        ),
        Spring::TorsionSpring(of) if of.free_angle.is_some() => refused(
            "torsion_spring.free_angle",
            "loads the spring as placed; an assembly is at rest as placed: leave it out, or keep the spring in a scene",
        ),
        Spring::Spring(of) if !linear(&of.stiffness) || !linear(&of.damping) => {
            refused("spring", TABLE)
        }
        Spring::TorsionSpring(of) if !linear(&of.stiffness) || !linear(&of.damping) => {
            refused("torsion_spring", TABLE)
        }
        Spring::Bushing(of) => {
            let lists = [
                &of.translation,
                &of.rotation,
                &of.translation_damping,
                &of.rotation_damping,
            ];
            match lists.into_iter().flatten().flatten().all(linear) {
                true => Ok(()),
                false => refused("bushing", TABLE),
            }
        }
        _ => Ok(()),
    }
}
