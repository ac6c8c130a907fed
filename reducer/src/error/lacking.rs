//! Missing properties of a component.

/// Something that isn't there to be studied, or answered to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Lacking {
    /// Interfaces of a component that is to be studied.
    #[error(
        "interfaces where forces act are what a study compares, and the component has none; describe one in its JSON"
    )]
    Interfaces,
    /// Forces through the interfaces.
    #[error(
        "the component has no interface where forces act, so there is nothing to compare; give it one in its description"
    )]
    Forces,
    /// Elastic modes.
    #[error("the part has no elastic mode to study; ask for at least one with --modes")]
    ElasticModes,
    /// Named loads.
    #[error(
        "there are no load vectors to enrich the basis with; put PART.load.NAME.mtx, one column of as many entries as there are dofs, beside the stiffness matrix"
    )]
    Loads,
}
