//! Hard cases that have no right answer: the part is refused, and the message says what to mend.

use dcb_formats::Component;
use dcb_formats::component::ComponentDraft;
use dcb_samples::SolidElement;
use dcb_samples::hard::{self, Hinge};
use faer::Mat;

use crate::dense::{dense, solve, sparse, symmetric};
use crate::hard::case::HardCase;
use crate::hard::reduction::GROUP;
use crate::hard::reduction::plain_methods::{eigenpairs, modal_flexibility};
use crate::localization::localization;
use crate::oracle::Oracle;
use crate::{assert_says, parts, refusal};

/// The message up to its first semicolon or the end of its first sentence.
fn opening(message: &str) -> String {
    let end = [";", ". "]
        .into_iter()
        .filter_map(|stop| message.find(stop))
        .min();
    format!("refused: {}", &message[..end.unwrap_or(message.len())])
}

fn dense_pair(component: &Component) -> (Mat<f64>, Mat<f64>) {
    (dense(&component.stiffness), dense(&component.mass))
}

/// Largest entry of the modal flexibility when the first `skipped` eigenpairs are taken as rigid.
fn flexibility_beyond(component: &Component, skipped: usize) -> f64 {
    let (stiffness, mass) = dense_pair(component);
    let (values, shapes) = eigenpairs(&stiffness, &mass).expect("a positive mass");
    let n = values.len();
    let elastic = shapes.as_ref().subcols(skipped, n - skipped);
    modal_flexibility(&localization(component), elastic, &values[skipped..]).norm_max()
}

/// A part held at one face.
pub fn grounded() -> HardCase {
    let part = hard::grounded_block();
    let (stiffness, mass) = dense_pair(&part);
    let (values, _) = eigenpairs(&stiffness, &mass).expect("a positive mass");
    let ratio = (values[6] / values[0]).sqrt();
    assert!(ratio > 1.5, "{ratio}");

    let message = refusal(&part);
    assert_says(
        &message,
        &[
            "only 0 of 6 rigid motions are free",
            "27 dofs",
            "--allow-grounded",
        ],
    );
    HardCase {
        group: GROUP,
        name: "grounded",
        naive_method: "the first six eigenpairs taken as rigid",
        naive: format!("first frequency {ratio:.1} times too high"),
        ours: opening(&message),
        error: None,
    }
}

/// Two blocks hinged at an edge.
pub fn mechanism() -> HardCase {
    let part = hard::hinged_blocks(Hinge::Edge);
    let (plain, elastic) = (flexibility_beyond(&part, 6), flexibility_beyond(&part, 7));
    let ratio = plain / elastic;
    assert!(ratio > 1e3, "{ratio:e}");

    let message = refusal(&part);
    assert_says(
        &message,
        &[
            "mechanism",
            "1 motion(s) beyond the rigid ones",
            "they move most at node",
            "--allow-loose",
        ],
    );
    HardCase {
        group: GROUP,
        name: "mechanism",
        naive_method: "the first six eigenpairs taken as rigid, Σ φφᵀ/ω² over the others",
        naive: format!("flexibility {ratio:.0e} times that of the material"),
        ours: opening(&message),
        error: None,
    }
}

/// Two blocks that don't touch.
pub fn two_pieces() -> HardCase {
    let part = hard::two_loose_blocks();
    let (stiffness, mass) = dense_pair(&part);
    let (values, _) = eigenpairs(&stiffness, &mass).expect("a positive mass");
    let zeros = values[6..]
        .iter()
        .filter(|value| value.abs() < 1e-6 * values[12])
        .count();
    assert_eq!(zeros, 6);

    let message = refusal(&part);
    assert_says(
        &message,
        &[
            "in 2 pieces",
            "piece 1 of 45 node(s)",
            "piece 2 of 45 node(s)",
            "--allow-loose",
        ],
    );
    HardCase {
        group: GROUP,
        name: "two_pieces",
        naive_method: "the first six eigenpairs taken as rigid",
        naive: format!("{zeros} more zeros pass as elastic modes"),
        ours: opening(&message),
        error: None,
    }
}

/// A dof without stiffness or mass.
pub fn orphan_dof() -> HardCase {
    let part = hard::orphan_dof_block();
    let (stiffness, mass) = dense_pair(&part);
    let n = mass.nrows();
    let shifted = &stiffness + &mass * faer::Scale(1e4);
    let response = solve(&shifted, &localization(&part).transpose().to_owned());
    let entries = (0..response.ncols()).flat_map(|j| (0..n).map(move |i| (i, j)));
    let broken = entries.filter(|at| !response[*at].is_finite()).count();
    assert!(broken > 0);

    let message = refusal(&part);
    assert_says(
        &message,
        &["1 dof(s) have no stiffness", "node 45 ux", "remove them"],
    );
    HardCase {
        group: GROUP,
        name: "orphan_dof",
        naive_method: "(K + σM)⁻¹ by LU",
        naive: format!(
            "{broken} of {} entries are not finite",
            n * response.ncols()
        ),
        ours: opening(&message),
        error: None,
    }
}

/// The box with its first ω² turned to `-share` of itself.
fn with_negative_stiffness(part: &Component, oracle: &Oracle, share: f64) -> Component {
    let momentum = &oracle.mass * oracle.kept(1);
    let removed =
        &momentum * momentum.transpose() * faer::Scale((1.0 + share) * oracle.eigenvalues[0]);
    Component::checked(ComponentDraft {
        stiffness: sparse(&symmetric(&(&oracle.stiffness - removed))),
        ..part.clone().into_draft()
    })
    .expect("a component")
}

/// One eigenvalue of K a thousandth, or a ten-millionth, of the first one below zero.
pub fn slightly_indefinite_stiffness() -> HardCase {
    let part = parts::steel_box([3, 1, 1], SolidElement::Hexahedron);
    let oracle = Oracle::of(&part);
    let indefinite = with_negative_stiffness(&part, &oracle, 1e-3);
    let right = oracle.residual_flexibility(0).norm_max();
    let ratio = flexibility_beyond(&indefinite, 6) / right;
    assert!(ratio > 1e3, "{ratio:e}");

    let barely = refusal(&with_negative_stiffness(&part, &oracle, 1e-7));
    assert_says(
        &barely,
        &[
            "the stiffness matrix is indefinite",
            "negative beyond rounding",
            "largest at node ",
        ],
    );
    let message = refusal(&indefinite);
    assert_says(
        &message,
        &[
            "the stiffness matrix is indefinite",
            "1 negative pivot(s), at node ",
        ],
    );
    HardCase {
        group: GROUP,
        name: "slightly_indefinite_stiffness",
        naive_method: "the first six eigenpairs taken as rigid, Σ φφᵀ/ω² over the others",
        naive: format!(
            "a rigid motion passes as elastic, flexibility {ratio:.0e} times the true one"
        ),
        ours: opening(&message),
        error: None,
    }
}
