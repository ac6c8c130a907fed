//! How the displacement of the interfaces enters the dynamics.

/// How the displacement of the interfaces enters the dynamics (Rubin, MacNeal, dual Craig–Bampton).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compatibility {
    /// y = (η, ζ) with u_Γ = L_b Ψ_r y: attachments are dynamic coordinates with their mass. Positive energies whatever the
    /// body is joined to: the choice for general use.
    #[default]
    Strong,
    /// y = η with u_Γ = L_b Φ η + F_res g: attachments follow the interface forces without mass. Positive energies, the
    /// fewest coordinates.
    Static,
    /// y = (η, g) with the interface forces g as coordinates of mass M_res, and compatibility in the mean only: the
    /// literature's four-field form. It always has eigenvalues of growing motions.
    Weak,
}
