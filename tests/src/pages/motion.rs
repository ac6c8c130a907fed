//! `docs/data/motion.jsonl` as the second generated part of `docs/accuracy.md`.

use serde_json::Value;

use super::{Page, machine, raw_lines, rows, table, text};
use crate::motion::pictures::pictures;

/// The second generated part of `docs/accuracy.md`, and its pictures.
pub const PAGE: Page = Page {
    page: "accuracy.md",
    data: "motion",
    markers: [
        "<!-- generated from data/motion.jsonl -->\n",
        "<!-- end of the generated part on motion -->\n",
    ],
    render,
    pictures,
};

fn render(raw: &str) -> String {
    let lines = raw_lines(raw);
    let of =
        |kind: &str| -> Vec<&Value> { lines.iter().filter(|line| line["kind"] == kind).collect() };
    let mut page = String::new();
    of("machine")
        .into_iter()
        .for_each(|line| page += &machine(line));
    page += &step_convergence(&of("steps"));
    page += &figures(&of("unreduced"), &of("classical"), &of("reduced"));
    page += &weak(&of("weak window"), &of("weak error"), &of("weak growth"));
    page += &test_set(&of("test set"), &of("element rod"));
    page += "\n### Rigid mechanisms\n\nProblems of the IFToMM library. Asserted by `tests/published/rigid_benchmarks.rs` and `flyball_governor.rs`. Exudyn publishes two places of the double\nfour-bar's first head; their limit of small steps is the equation of the angle's within 2e-8 m. Solutions submitted for the spatial slider-crank scatter by 1e-3 m.\n\n";
    page += &findings(&of("rigid"));
    page += "\n### Flexible bodies with closed forms\n\nAsserted by `tests/published/closed_form_motions.rs`.\n\n";
    page += &findings(&of("flexible"));
    page += &order(&of("order"));
    page += "\n### Equivalent descriptions\n\nThe same mechanism described in two ways; largest difference of place, angle and strain energy by their \
             largest values. Asserted by\n`tests/published/equivalent_models.rs`.\n\n";
    page += &table(
        &["what is different", "largest difference", "bound"],
        &rows(&of("invariance"), |line| {
            vec![text(line, "case"), short(line, "error"), bound(line)]
        }),
    );
    page
}

/// Two digits.
fn short(line: &Value, key: &str) -> String {
    line[key]
        .as_f64()
        .map_or("-".to_owned(), |value| format!("{value:.1e}"))
}

fn bound(line: &Value) -> String {
    line["bound"].as_f64().map_or(String::new(), limit)
}

/// One digit, or two where it has two.
fn limit(value: f64) -> String {
    let short = format!("{value:.0e}");
    match short.parse::<f64>() {
        Ok(same) if value == same => short,
        _ => format!("{value:.1e}"),
    }
}

fn long(value: &Value) -> String {
    let value = value.as_f64().expect("a number");
    if value.abs() < 1e-3 {
        format!("{value:.9e}")
    } else {
        format!("{value:.10}")
    }
}

fn picture(name: &str, what: &str) -> String {
    format!("\n![{what}](pictures/{name})\n")
}

fn step_convergence(lines: &[&Value]) -> String {
    let mut page = "\n### Convergence in the step\n\nError of the middle's deflection every 10° of two revolutions, by its largest value, against the \
        independent history. Generalized-alpha, ρ = 0.8, 4 elements.\nBounds are asserted by `tests/published/slider_crank.rs`. Between 1440 and 7200 steps the error falls slowly: ever higher modes that the rigid start excites come into the reach of\nthe step. What is left with 5 modes is the reduction.\n\n"
        .to_owned();
    let both: Vec<&[&Value]> = lines.chunks(2).collect();
    let cells: Vec<Vec<String>> = both
        .iter()
        .map(|pair| {
            let mut row = vec![pair[0]["steps"].to_string()];
            row.extend(
                pair.iter()
                    .flat_map(|line| [short(line, "error"), bound(line)]),
            );
            row
        })
        .collect();
    page += &table(
        &[
            "steps a revolution",
            "5 modes + 4 attachments",
            "bound",
            "all 12 modes",
            "bound",
        ],
        &cells,
    );
    page + &picture("step-convergence.svg", "error over steps a revolution")
}

fn figures(unreduced: &[&Value], classical: &[&Value], reduced: &[&Value]) -> String {
    let mut page = "\n### Figures of the literature\n\nThe deflection of the rod's middle from the chord, over the crank's angle. The paper prints no numbers \
        with these figures and its text doesn't say which set of data\nbelongs to which of them, so both sets are shown, and what is compared is \
        independent of the paper. First set: 0.15 m, 0.30 m, 150 rad/s, 200 GPa, 7870 kg/m³;\nsecond: 0.152 m, 0.304 m, 124.8 rad/s, 206.8 GPa, 7830 kg/m³; \
        rod of 6 mm, slider of half its mass.\n\n**Unreduced (Figs 3 and 4).** The picture has two elements, ρ = 0.9, 3600 steps. The table has the first set \
        against the independent history, at 14400 steps.\n\n"
        .to_owned();
    page += &table(
        &["elements", "error / largest deflection", "bound"],
        &rows(unreduced, |line| {
            vec![
                line["elements"].to_string(),
                short(line, "error"),
                bound(line),
            ]
        }),
    );
    page += &picture(
        "unreduced.svg",
        "deflection of the unreduced rod over two revolutions",
    );
    page += "\n**Classical against four-field assembly (Fig 5).** The classical co-rotated equations in other code, integrated by extrapolation of order 10, \
        against the runtime with all modes,\nρ = 0.9, 14400 steps. Asserted by `tests/published/slider_crank.rs`, every 10°; here every 2°.\n\n";
    page += &table(
        &["case", "difference / largest deflection", "bound"],
        &rows(classical, |line| {
            vec![text(line, "case"), short(line, "error"), bound(line)]
        }),
    );
    page += &picture(
        "classical.svg",
        "deflection, and difference from the classical equations",
    );
    page += "\n**Reduced against unreduced (Figs 6 and 7).** 4 elements, ρ = 0.8, 3600 steps. The independent history is unreduced and converged in the step, so \
        its column has the error of the step\nin it. The paper's bounds are 1 % with 5 modes and better with 8. Asserted by `tests/dynamics/compatibility.rs`, against all modes by `tests/published/slider_crank.rs`.\n\n";
    page += &table(
        &[
            "compatibility",
            "modes",
            "against all modes, same steps",
            "against the history",
            "bound of that",
        ],
        &rows(reduced, |line| {
            vec![
                text(line, "compatibility"),
                line["modes"].to_string(),
                short(line, "against_all_modes"),
                short(line, "error"),
                bound(line),
            ]
        }),
    );
    page + &picture(
        "reduced.svg",
        "deflection of reduced rods, and difference from the unreduced",
    )
}

fn weak(windows: &[&Value], errors: &[&Value], growths: &[&Value]) -> String {
    let mut page = "\n**Weak compatibility.** With interface forces as coordinates, the paper's own form, motions grow that a step must be too long to see: \
        h σ_min > 2 √3 (1 + ρ)/(1 - ρ).\nρ = 0.8, compared with all modes and with `Static` at the same steps. The unreduced rod has axial modes that ring from the start on in so long a step; in `Static` and `Weak`\nthe joints' forces deflect the rod axially without inertia. At 72 steps, the last inside the window, 5 modes are within 1 %. Asserted by `tests/dynamics/compatibility.rs`.\n\n"
        .to_owned();
    let mut list: Vec<Vec<String>> = Vec::new();
    let mut add = |name: &str, value: String| list.push(vec![name.to_owned(), value]);
    for line in windows {
        add(
            "negative eigenvalues",
            line["negative_eigenvalues"].to_string(),
        );
        add("σ_min", format!("{:.0} 1/s", number(line, "sigma_min")));
        let step = format!(
            "{:.3e} s: at most {:.1} steps a revolution",
            number(line, "smallest_step"),
            number(line, "steps")
        );
        add("smallest step", step);
    }
    for line in errors {
        let (modes, steps) = (&line["modes"], &line["steps"]);
        let error = format!("{}, bound {}", short(line, "error"), bound(line));
        let from_static = format!(
            "{}, bound {}",
            short(line, "static_error"),
            limit(number(line, "static_bound"))
        );
        add(
            &format!("{steps} steps, {modes} modes: from all modes"),
            error,
        );
        add(
            &format!("{steps} steps, {modes} modes: from `Static`"),
            from_static,
        );
    }
    for line in growths {
        let after = format!("fails after {} steps", line["failed_after"]);
        add(
            &format!("{} steps a revolution, 5 modes", line["steps"]),
            after,
        );
    }
    page += &table(&["quantity", "value"], &list);
    page + &picture(
        "weak.svg",
        "deflection at 50 steps a revolution, and forces at the ends at 1000",
    )
}

fn number(line: &Value, key: &str) -> f64 {
    line[key].as_f64().expect(key)
}

fn test_set(lines: &[&Value], elements: &[&Value]) -> String {
    let mut page = "\n### Slider-crank of the IVP test set\n\nState and constraint forces at t = 0.1 s. \"Classical\" integrates the set's equations in other code; \"runtime\" is generalized-alpha, \
        ρ = 0.9, 200000 steps,\nwith the set's own mass. Asserted by `tests/published/ivp_slider_crank.rs`. The set's code has m [[8, 1], [1, 2]] for the axial mass, 15 times the integral; \
        the last\ntwo columns have the values with the consistent mass, and the runtime's difference from them.\n\n"
        .to_owned();
    page += &table(
        &[
            "quantity",
            "published",
            "runtime",
            "difference",
            "bound",
            "classical",
            "consistent mass",
            "runtime's difference",
        ],
        &rows(lines, |line| {
            vec![
                text(line, "quantity"),
                long(&line["published"]),
                long(&line["found"]),
                short(line, "error"),
                bound(line),
                short(line, "classical_error"),
                long(&line["consistent"]),
                short(line, "consistent_error"),
            ]
        }),
    );
    page += "\nThe same rod in finite elements through the reducer, from an undeformed start, ρ = 0.9, 10 µs, for 0.1 s: largest difference from two sines and a quadratic with the consistent mass. \
        What is left\nare the set's shapes, which lack a third sine, and the second order of the linear theory.\n\n";
    page += &table(
        &[
            "elements",
            "modes",
            "deflection, by its largest",
            "bound",
            "slider, by the rod's length",
            "bound",
        ],
        &rows(elements, |line| {
            vec![
                line["elements"].to_string(),
                line["modes"].to_string(),
                short(line, "error"),
                bound(line),
                short(line, "slider_error"),
                limit(number(line, "slider_bound")),
            ]
        }),
    );
    page
}

fn findings(lines: &[&Value]) -> String {
    table(
        &["problem", "error of", "against", "steps", "error", "bound"],
        &rows(lines, |line| {
            let named = ["problem", "quantity", "against", "steps"].map(|key| text(line, key));
            let mut row = named.to_vec();
            row.extend([short(line, "error"), bound(line)]);
            row
        }),
    )
}

fn order(lines: &[&Value]) -> String {
    let mut page = "\n### Order\n\nLargest errors of positions, velocities and joint forces over all steps, by the largest value (positions: by 1 m), against the same motion at steps 6 \
        times shorter than\nthe shortest here, ρ = 0.8. `tests/published/order.rs` asserts orders of 2 within 0.25, `tests/dynamics/steps/order.rs` on two more mechanisms.\n\n"
        .to_owned();
    page += &table(
        &[
            "mechanism",
            "formulation",
            "error of",
            "at the longest step",
            "at the shortest",
            "orders",
        ],
        &rows(lines, |line| {
            let errors = line["errors"].as_array().expect("errors");
            let end = |at: Option<&Value>| {
                format!("{:.1e}", at.and_then(Value::as_f64).expect("an error"))
            };
            let orders = line["orders"].as_array().expect("orders");
            let orders: Vec<String> = orders
                .iter()
                .map(|order| format!("{:.2}", order.as_f64().expect("an order")))
                .collect();
            vec![
                text(line, "problem"),
                text(line, "formulation"),
                text(line, "quantity"),
                end(errors.first()),
                end(errors.last()),
                orders.join(", "),
            ]
        }),
    );
    page + &picture("order.svg", "errors over the step")
}
