//! Geometric stiffness by the names of what prestresses the component.

use std::fmt;

use super::{ComponentDraft, GeometricStiffness, Interface, RowStiffness};
use crate::SparseMatrix;
use crate::mesh::Direction;

/// A name that is neither a product of spins nor a row of an attached interface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownPrestress {
    /// The name.
    pub name: String,
    products: &'static [&'static str],
    interfaces: Vec<String>,
}

impl fmt::Display for UnknownPrestress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:?} is neither a product of spins ({}) nor INTERFACE.ux, .uy, … of an attached interface that moves as one ({})",
            self.name,
            self.products.join(", "),
            self.interfaces.join(", ")
        )
    }
}

impl ComponentDraft {
    /// Takes stiffness matrices, (n_e, n_e) each: per product of spins, `xx`, `yy`, `zz`, `xy`, `yz`, `zx` (planar `zz`), and per unit force along a
    /// row of an interface, such as `big-end.ux`. Products that are missing are zero; that is noted.
    ///
    /// # Errors
    /// The first name that is neither.
    pub fn stiffen(&mut self, named: Vec<(String, SparseMatrix)>) -> Result<(), UnknownPrestress> {
        let products = GeometricStiffness::spin_products(self.dimension());
        let mut spins: Vec<Option<SparseMatrix>> = products.iter().map(|_| None).collect();
        let mut rows = Vec::new();
        for (name, matrix) in named {
            match products.iter().position(|product| *product == name) {
                Some(product) => spins[product] = Some(matrix),
                None => rows.push(RowStiffness {
                    row: row_of(&name, &self.interfaces).ok_or_else(|| UnknownPrestress {
                        name: name.clone(),
                        products,
                        interfaces: self.interfaces.iter().map(|one| one.name.clone()).collect(),
                    })?,
                    matrix,
                }),
            }
        }
        let absent: Vec<&str> = (products.iter().zip(&spins))
            .filter(|(_, matrix)| matrix.is_none())
            .map(|(product, _)| *product)
            .collect();
        if absent.len() == products.len() {
            spins.clear();
        } else if !absent.is_empty() {
            self.notes.push(format!(
                "geometric stiffness: nothing is given for the spin products {}; taken as zero",
                absent.join(", ")
            ));
        }
        self.geometric_stiffness = Some(GeometricStiffness { spins, rows });
        Ok(())
    }
}

/// Interface and direction of a name such as `big-end.ux`; only attachments have rows that forces act on.
fn row_of(name: &str, interfaces: &[Interface]) -> Option<(usize, Direction)> {
    let (interface, direction) = name.rsplit_once('.')?;
    let index = interfaces.iter().position(|one| one.name == interface)?;
    let direction = Direction::from_name(direction)?;
    interfaces[index]
        .has_row_of_forces()
        .then_some((index, direction))
}
