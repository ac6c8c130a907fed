//! Why a part is no free elastic body in one piece.

use super::Places;

/// A part that stands otherwise than as a free elastic body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BodyRefusal {
    /// No more degrees of freedom than rigid motions.
    #[error(
        "nothing elastic is left: {dofs} dofs remain for {motions} rigid motions, because every node belongs to a rigid interface (or there is but one node); leave nodes out of the rigid interfaces, or use a rigid body"
    )]
    NothingElastic {
        /// Degrees of freedom of the model.
        dofs: usize,
        /// Rigid motions.
        motions: usize,
    },
    /// Degrees of freedom without stiffness.
    #[error(
        "{count} dof(s) have no stiffness at all: {places}; remove them from the matrices and the dof table (unused nodes, rotations of solid elements), or connect them"
    )]
    NoStiffness {
        /// How many.
        count: usize,
        /// Which.
        places: Places,
    },
    /// Rigid motions cost energy because K was printed with few digits.
    #[error(
        "the stiffness matrix has too few digits for this part: K times a rigid motion is {force:.1e} of K's row sum, at {nodes} of {all_nodes} nodes, which is {softness}; export at least 15 digits"
    )]
    FewDigits {
        /// Largest |K r| over K's largest row sum.
        force: f64,
        /// Nodes where it shows.
        nodes: usize,
        /// Nodes of the model.
        all_nodes: usize,
        /// Energy of the rigid motions.
        softness: Softness,
    },
    /// Rigid motions are not free.
    #[error(
        "the part is held: only {free} of {expected} rigid motions are free; K times a rigid motion is largest at {places} ({dofs} dofs above a thousandth of that). Export the free part without supports and hold it by a joint in the scene (or allow it with --allow-grounded)"
    )]
    Held {
        /// Rigid motions that are free.
        free: usize,
        /// Rigid motions of a free body.
        expected: usize,
        /// Where they are resisted most.
        places: Places,
        /// Degrees of freedom above a thousandth of the largest resistance.
        dofs: usize,
    },
    /// Rigid motions are resisted a little.
    #[error(
        "the part is held by something weak at {places}: K times a rigid motion is {force:.1e} of K's row sum there, which is {softness}. Remove the weak springs and hold the part by a joint in the scene (or allow them with --allow-grounded)"
    )]
    HeldWeakly {
        /// Where.
        places: Places,
        /// Largest |K r| over K's largest row sum.
        force: f64,
        /// Energy of the rigid motions.
        softness: Softness,
    },
    /// K has the right number of motions without energy, and they aren't the rigid motions of the nodes.
    #[error(
        "the mesh and the matrices don't belong together: the stiffness has {motions} motions without energy, as a free part should, but they are not the rigid motions of these node positions (max|K r| is {force:.1e} of K's row sum, expected below {tolerance:.0e}). Usually the dof table is in another node order than the matrices; worst at {places}"
    )]
    ForeignMesh {
        /// Motions without energy.
        motions: usize,
        /// Largest |K r| over K's largest row sum.
        force: f64,
        /// Expected at most.
        tolerance: f64,
        /// Where it is largest.
        places: Places,
    },
    /// Pieces that no stiffness connects.
    #[error(
        "the part is in {} pieces that no stiffness connects: {}; reduce them one by one, or connect them (or allow it with --allow-loose)",
        pieces.len(),
        described(pieces)
    )]
    InPieces {
        /// Nodes of each, and the first of them.
        pieces: Vec<PieceSize>,
    },
    /// Motions without energy beyond the rigid ones.
    #[error(
        "the part is a mechanism: {motions} motion(s) beyond the rigid ones cost no energy{}; look for hinges, cells joined at an edge or a node only, and missing rotational stiffness (or allow it with --allow-loose)",
        moving.as_ref().map_or(String::new(), |places| format!("; they move most at {places}"))
    )]
    Mechanism {
        /// How many.
        motions: usize,
        /// Where they move most, if they are known.
        moving: Option<Places>,
    },
}

/// A piece of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PieceSize {
    /// Its nodes.
    pub nodes: usize,
    /// The first of them.
    pub first_node: u32,
}

/// Energy of rigid motions against that of the first elastic one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softness {
    /// Their eigenvalue over the first elastic one; infinite if there is none.
    pub ratio: f64,
    /// Allowed.
    pub limit: f64,
}

impl std::fmt::Display for Softness {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.ratio.is_finite() {
            true => write!(
                f,
                "{:.1e} of the first elastic eigenvalue (at most {:.0e} would do)",
                self.ratio, self.limit
            ),
            false => f.write_str("more than the first elastic eigenvalue"),
        }
    }
}

fn described(pieces: &[PieceSize]) -> Places {
    Places::of(pieces.iter().enumerate().map(|(i, piece)| {
        format!(
            "piece {} of {} node(s), from node {}",
            i + 1,
            piece.nodes,
            piece.first_node
        )
    }))
}
