//! The paper command, on generated bodies.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failing helper fails its test")]

use std::path::Path;

use chaincell_tests::files;
use serde_json::Value;

use super::quick::{quick, real};

/// Nothing is missing: what is not finite would stand as null.
fn no_nulls(value: &Value, place: &str) {
    match value {
        Value::Null => panic!("{place} is null"),
        Value::Array(all) => all.iter().for_each(|value| no_nulls(value, place)),
        Value::Object(all) => {
            all.iter().for_each(|(key, value)| no_nulls(value, &format!("{place}/{key}")));
        }
        _ => {}
    }
}

/// The columns of a CSV file; every row has all its fields.
fn columns(path: &Path) -> Vec<(String, Vec<String>)> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let head = lines.next().unwrap().split(',').map(|name| (name.to_owned(), Vec::new()));
    let mut columns: Vec<(String, Vec<String>)> = head.collect();
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields.len(), columns.len(), "{}: {line}", path.display());
        columns.iter_mut().zip(fields).for_each(|((_, all), field)| all.push(field.to_owned()));
    }
    assert!(columns.iter().all(|(_, all)| !all.is_empty()), "{}", path.display());
    columns
}

fn numbers(columns: &[(String, Vec<String>)], name: &str) -> Vec<f64> {
    let (_, all) = columns.iter().find(|(column, _)| column == name).unwrap();
    all.iter().map(|field| field.parse().unwrap()).collect()
}

/// What the page fetches or leads to lies beside it.
fn asks_for_nothing(out: &Path) {
    let page = std::fs::read_to_string(out.join("paper.html")).unwrap();
    for outside in ["<script", "<link", "<iframe", "url(", "@import", "src=", "xlink:href"] {
        assert!(!page.contains(outside), "{outside}");
    }
    for target in page.split("href=\"").skip(1) {
        let target = target.split('"').next().unwrap();
        if target.starts_with("data:image/png;base64,") {
            continue;
        }
        match target.strip_prefix('#') {
            Some(key) => assert!(page.contains(&format!("id=\"{key}\"")), "{target}"),
            None => assert!(out.join(target).is_file(), "{target}"),
        }
    }
    // Pictures are base64, which has no colon.
    let addresses = page.matches("://").count();
    assert_eq!(addresses, page.matches("xmlns=\"http://www.w3.org/2000/svg\"").count());
}

#[test]
fn a_quick_paper_is_whole_and_its_files_agree() {
    let place = files::scratch();
    let out = place.path().join("paper");
    let found = quick("paper", &out).with(0).json();
    let written: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("paper.json")).unwrap()).unwrap();
    assert_eq!(found, written);
    for key in ["machine", "seconds", "plane", "liver"] {
        no_nulls(&found[key], key);
    }
    assert_eq!(found["quick"], true);
    assert_eq!(found["interrupted"], false);
    asks_for_nothing(&out);
    let mut seen = 0;
    for entry in std::fs::read_dir(&out).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let pages = ["paper.html", "paper.json", "paper.md"];
        assert!(name.starts_with("paper_") || pages.contains(&&*name), "{name}");
        match path.extension().unwrap().to_str().unwrap() {
            "csv" => drop(columns(&path)),
            "svg" => {
                assert!(path.with_extension("png").is_file(), "{name}");
                seen += 1;
            }
            _ => {}
        }
    }
    assert!(seen >= 6, "{seen} pictures");
    overview(&out);
    plane(&found, &out);
    tissue(&found, &out);
    liver(&found, &out);
    identified(&found, &out);
    // Refused with content, taken with --force.
    let again = quick("paper", &out).with(2);
    assert!(again.err.contains("--force"), "{}", again.err);
}

/// The table at the top has a row with figures for every result of the paper.
fn overview(out: &Path) {
    let page = std::fs::read_to_string(out.join("paper.html")).unwrap();
    let (_, table) = page.split_once("<table>").unwrap();
    let (table, _) = table.split_once("</table>").unwrap();
    for result in ["Fig. 4", "Fig. 5a", "Fig. 5b", "Fig. 5c", "Fig. 6", "elements", "parameters"] {
        assert!(table.contains(result), "{result} in {table}");
    }
    assert!(!table.contains("not computed"), "{table}");
}

/// Traditional `ChainMail`'s pyramid is straighter than the network's surface, and the profiles in
/// the CSV files are those the measure was taken of.
fn plane(found: &Value, out: &Path) {
    let depth_m = real(found, "/plane/depth_m");
    for neighbours in [4, 8] {
        let measure =
            |key: &str| real(found, &format!("/plane/neighbours_{neighbours}/{key}/nonlinearity"));
        let profile = columns(&out.join(format!("paper_profile_{neighbours}.csv")));
        for key in ["network", "network_t1", "chainmail"] {
            let heights = numbers(&profile, &format!("{key}_z_m"));
            let along = numbers(&profile, &format!("{key}_x_m"));
            assert_eq!(heights.len(), 21);
            assert!((heights[10] - depth_m).abs() < 1e-6 && heights[0] == 0.0);
            let square = |at: usize| {
                let end = if at < 10 { along[0] } else { along[20] };
                (heights[at] - heights[10] * (1.0 - along[at] / end)).powi(2)
            };
            let sum: f64 = (1..20).filter(|&at| at != 10).map(square).sum();
            let off = (sum / 18.0).sqrt() / heights[10];
            assert!((off - measure(key)).abs() < 1e-9, "{key}: {off} {}", measure(key));
        }
        // A spike that spreads.
        assert!(measure("network_t1") > measure("network_t100"));
        assert!(measure("network_t100") > measure("network"));
    }
    let four = |key: &str| real(found, &format!("/plane/neighbours_4/{key}/nonlinearity"));
    assert!(four("chainmail") < 1e-12 && four("network") > 0.1, "{found}");
}

/// Tissue that relaxes keeps work in every loop, and is drawn without reference data too.
fn tissue(found: &Value, out: &Path) {
    let cycles = found["tissue"]["cycles"].as_array().unwrap();
    assert_eq!(cycles.len(), 6);
    for cycle in cycles {
        assert!((0.2..0.8).contains(&real(cycle, "/loop_area_of_loading_work")), "{cycle}");
    }
    let points = columns(&out.join("paper_tissue.csv"));
    assert_eq!(numbers(&points, "measured").len(), 4);
    for name in ["fig5b_tissue", "fig5c_tissue", "tissue_muscle", "tissue_cervix"] {
        assert!(out.join(format!("paper_{name}.svg")).is_file(), "{name}");
    }
    let tables = std::fs::read_to_string(out.join("paper.md")).unwrap();
    let date = found["date"].as_str().unwrap();
    assert!(
        tables.contains(date) && tables.contains("| human cervix | storage modulus"),
        "{tables}"
    );
}

/// The press in CSV is the one of the figures.
fn liver(found: &Value, out: &Path) {
    let press = columns(&out.join("paper_liver_press.csv"));
    let force = numbers(&press, "force_n");
    assert_eq!(force.len() as f64, real(found, "/liver/ticks"));
    let largest = force.iter().copied().fold(0.0, f64::max);
    let told = real(found, "/liver/force_max_n");
    assert!(largest > 0.05 && (largest / told - 1.0).abs() < 1e-12, "{largest} {told}");
    let shown = real(found, "/liver/shown_tick") as usize;
    let contacts = numbers(&press, "network_contacts")[shown];
    assert!(contacts >= 3.0 && contacts == real(found, "/liver/network/contacts"));
    // The probe pushes the surface before it, by about its depth, and folds few tetrahedra; links
    // that fold carry a node of the network farther.
    let depth_mm = 1e3 * real(found, "/liver/depth_m");
    for (method, most) in [("network", 2.0), ("chainmail", 1.2)] {
        let way = real(found, &format!("/liver/{method}/displacement_max_mm"));
        assert!((0.9..most).contains(&(way / depth_mm)), "{method}: {way} of {depth_mm}");
        let folded = real(found, &format!("/liver/{method}/inverted"));
        assert!(folded < 0.005 * real(found, "/liver/tetrahedra"), "{method}: {folded}");
    }
}

/// What is determined comes back, and most is.
fn identified(found: &Value, out: &Path) {
    let rows = found["identified"]["curves_and_field"].as_array().unwrap();
    assert_eq!(rows.len(), 5);
    let determined: Vec<&Value> = rows.iter().filter(|row| row["determined"] == true).collect();
    assert!(determined.len() >= 3, "{rows:#?}");
    for row in determined {
        assert!(real(row, "/error_percent").abs() < 5.0, "{row}");
    }
    let residuals = columns(&out.join("paper_identified_residuals.csv"));
    assert!(residuals[0].1.len() > 99, "{}", residuals[0].1.len());
    let names = std::fs::read_dir(out).unwrap().map(|entry| entry.unwrap().file_name());
    let is_picture = |name: &str| name.starts_with("paper_identified_") && name.ends_with(".svg");
    assert_eq!(names.filter(|name| is_picture(name.to_str().unwrap())).count(), 6);
}
