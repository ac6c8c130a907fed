//! Pages of runs: what a browser would draw is where the results say that the bodies are.

mod bodies;
mod gltf;
mod reader;

use std::fs;

use serde_json::json;

use bodies::with;
use reader::Page;

use crate::support::Folder;

/// The slider-crank with the place of the rod's middle node recorded.
fn recorded(compatibility: &str) -> Folder {
    let folder = Folder::slider_crank();
    let mut scene = folder.json("scene.json");
    scene["outputs"]["middle"] = json!({"node_position": {"body": "rod", "node": 2}});
    scene["compatibility"] = json!(compatibility);
    folder.write("scene.json", scene.to_string());
    folder.done("scene.json --end 0.01");
    folder
}

#[test]
fn nodes_of_a_page_are_where_the_outputs_say() {
    for compatibility in ["strong", "static"] {
        let folder = recorded(compatibility);
        folder.done("animate scene.h5");
        let page = Page::read(&folder, "scene.html");
        let expected = folder.results().history("middle").unwrap();
        let times = page.numbers(&page.description["times"]);
        assert_eq!(times.len(), expected.nrows());
        let rod = page.body("rod");
        let shape = &page.description["shapes"][0];
        let error = shape["error"].as_f64().unwrap();
        let mut bends = 0.0_f64;
        for frame in 0..times.len() {
            let (found, deflection) = page.node(rod, 2, frame);
            bends = bends.max(deflection);
            for axis in 0..2 {
                // Single precision of half a metre, and what the page says of the deflection.
                let allowed = 1e-7 + 2.0 * error * 0.02;
                let off = (found[axis] - expected[(frame, axis)]).abs();
                assert!(off < allowed, "{compatibility}, frame {frame}: {off:.1e}");
            }
        }
        assert!(bends > 1e-4, "{bends}");
        assert!(error < 1e-3, "{error}");
    }
}

#[test]
fn pages_need_nothing_from_elsewhere() {
    let folder = recorded("strong");
    folder.done("report scene.h5");
    let page = Page::read(&folder, "scene.report.html");
    for forbidden in ["src=\"", "href=\"http", "@import", "url(http"] {
        assert!(!page.html.contains(forbidden), "{forbidden}");
    }
    for said in [
        "The run is complete",
        "energy balance is good",
        "SHA-256",
        "generalized alpha",
    ] {
        assert!(page.html.contains(said), "{said}");
    }
    let titles = page.description["histories"].as_array().unwrap();
    assert!(titles.iter().any(|one| one["name"] == "outputs/middle"));
    assert!(
        titles
            .iter()
            .all(|one| !one["name"].as_str().unwrap().starts_with("motion/"))
    );
}

#[test]
fn names_of_strangers_stay_text() {
    let folder = Folder::slider_crank();
    let hostile = "</script><img src=x onerror=alert(1)>".replace('/', "");
    let mut scene = folder.json("scene.json");
    let text = scene.to_string().replace("crank/", &format!("{hostile}/"));
    scene = serde_json::from_str(&text).unwrap();
    let bodies = scene["bodies"].as_object_mut().unwrap();
    let crank = bodies.remove("crank").unwrap();
    bodies.insert(hostile.clone(), crank);
    folder.write("scene.json", scene.to_string());
    folder.done("scene.json --end 0.001");
    folder.done("report scene.h5");
    let page = Page::read(&folder, "scene.report.html");
    assert!(!page.html.contains("<img src=x"));
    assert_eq!(page.body(&hostile)["name"], json!(hostile));
}

#[test]
fn a_page_is_of_the_superelements_of_the_run() {
    let folder = Folder::slider_crank();
    folder.done("scene.json --end 0.001");
    folder.done("animate scene.h5");
    // A page can be made again, another file is not lost.
    folder.done("animate scene.h5");
    folder.write("other.html", "<!DOCTYPE html>");
    folder.refused(
        "animate scene.h5 -o other.html",
        &["other.html: exists already; use --force"],
    );
    folder.refused(
        "animate scene.h5 -o scene.h5 --force",
        &["scene.h5: is the file of the results"],
    );
    fs::rename(folder.path("rod.dcb.h5"), folder.path("kept.h5")).unwrap();
    folder.refused(
        "animate scene.h5 --force",
        &["rod.dcb.h5", "is not there", "--scene"],
    );
    fs::create_dir(folder.path("elsewhere")).unwrap();
    fs::rename(folder.path("kept.h5"), folder.path("elsewhere/rod.dcb.h5")).unwrap();
    folder.done("animate scene.h5 --force --scene elsewhere/scene.json");
    // The same name with other contents.
    let other = Folder::slider_crank();
    let rod = other.path("rod.dcb.h5");
    let mut element = dcb_formats::dcb::read_superelement(&rod).unwrap();
    element.modes.residual_damping += 0.01;
    folder.store_superelement("rod.dcb.h5", &element);
    folder.refused(
        "animate scene.h5 --force",
        &[
            "rod.dcb.h5",
            "is not the file that the run of",
            "run the scene again",
        ],
    );
}

#[test]
fn results_may_stand_elsewhere_than_their_scene() {
    let folder = Folder::slider_crank();
    fs::create_dir(folder.path("out")).unwrap();
    folder.done("scene.json --end 0.001 -o out/run.h5");
    folder.done("animate out/run.h5");
    assert!(folder.path("out/run.html").is_file());
}

#[test]
fn a_page_says_how_exact_it_is_without_its_script() {
    let folder = recorded("strong");
    folder.done("animate scene.h5");
    let page = Page::read(&folder, "scene.html");
    let shape = &page.description["shapes"][0];
    let rod = page.body("rod");
    let columns = shape["columns"].as_array().unwrap();
    let amplitudes = page.numbers(&rod["amplitudes"]);
    // What rounding alone can do in the worst frame, over the largest deflection of all.
    let (mut rounding, mut largest) = (0.0_f64, 0.0_f64);
    let values: Vec<Vec<f64>> = columns
        .iter()
        .map(|column| page.numbers(&column["values"]))
        .collect();
    let scales: Vec<f64> = columns
        .iter()
        .map(|column| column["scale"].as_f64().unwrap())
        .collect();
    for frame in amplitudes.chunks(columns.len()) {
        let each = frame.iter().zip(&scales);
        let off: f64 = each
            .clone()
            .map(|(amplitude, scale)| amplitude.abs() * scale)
            .sum();
        rounding = rounding.max(0.5 * 3.0_f64.sqrt() * off);
        for node in 0..values[0].len() / 3 {
            let along = |axis: usize| -> f64 {
                let each = each.clone().zip(&values);
                each.map(|((amplitude, scale), values)| amplitude * scale * values[3 * node + axis])
                    .sum()
            };
            largest = largest.max(along(0).hypot(along(1)).hypot(along(2)));
        }
    }
    let error = shape["error"].as_f64().unwrap();
    assert!(
        error >= 0.999 * rounding / largest,
        "{error} {}",
        rounding / largest
    );
    let text = &page.html[..page.html.find("id=\"description\"").unwrap()];
    let said = format!("within {:.2} %", (1e4 * error).ceil() / 100.0);
    assert!(text.contains(&said), "{said}");
}

#[test]
fn modes_go_one_after_another() {
    let folder = Folder::slider_crank();
    with(&folder, |scene| {
        scene["analysis"] = json!({"modes": {"count": 3}});
        scene["drives"] = json!({});
    });
    folder.done("scene.json");
    folder.done("animate scene.h5");
    let page = Page::read(&folder, "scene.html");
    let modes = folder.results().modes().unwrap().unwrap();
    let times = page.numbers(&page.description["times"]);
    let per_mode = times.len() / modes.frequency.len();
    assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
    assert!((times[per_mode] - 1.0).abs() < 1e-6);
    assert_eq!(page.description["histories"], json!([]));
    let text = &page.html[..page.html.find("id=\"description\"").unwrap()];
    assert!(text.contains("the modes one after another") && text.contains("from 1 to 2"));
    for (mode, shape) in (0..modes.frequency.len()).map(|mode| (mode, &modes.shapes)) {
        for of_body in shape {
            let frames = page.numbers(&page.body(&of_body.body)["frames"]);
            let origin = |phase: usize| {
                let at = 7 * (mode * per_mode + phase);
                [frames[at], frames[at + 1]]
            };
            // A quarter and three quarters of a period lie on both sides of the place at rest, as 0 and a half do.
            let half = per_mode / 2;
            for axis in 0..2 {
                let rest = [0, half / 2].map(|k| 0.5 * (origin(k)[axis] + origin(k + half)[axis]));
                assert!((rest[0] - rest[1]).abs() < 1e-6, "{rest:?}");
            }
        }
    }
}

#[test]
fn what_is_no_results_file_is_told_its_command() {
    let folder = Folder::slider_crank();
    folder.refused(
        "animate rod.dcb.h5",
        &["superelement", "reduce report rod.dcb.h5"],
    );
    folder.refused(
        "animate scene.json",
        &["is a scene", "simulate scene.json", "take scene.h5"],
    );
}
