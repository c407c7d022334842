//! The table, and what it is meant to keep.

use std::fmt::Write;

use super::{DEPTHS, Reference, Row};

/// Spheres of a size against the edges, and how far their force may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Class {
    /// In words.
    pub name: &'static str,
    /// Radii from here on [edges].
    pub from: f64,
    /// To below here [edges].
    pub to: f64,
    /// Largest error of the force between the depths of [`JUDGED`].
    pub limit: f64,
}

/// The classes.
pub const CLASSES: [Class; 3] = [
    Class { name: "R of 2 h and more", from: 2.0, to: f64::INFINITY, limit: 0.08 },
    Class { name: "R of 1 to 2 h", from: 1.0, to: 2.0, limit: 0.3 },
    Class { name: "R below 1 h", from: 0.0, to: 1.0, limit: 0.3 },
];
/// The depth from which on the bars count \[radii\].
pub const JUDGED: f64 = 0.25;

/// A class with its largest error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// Which spheres.
    pub class: Class,
    /// Largest error of the force; 0 without such a sphere.
    pub worst: f64,
}

impl Bar {
    /// Whether the class keeps its limit.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.worst <= self.class.limit
    }
}

impl Class {
    fn of<'a>(&self, rows: &'a [Row]) -> impl Iterator<Item = &'a Row> {
        let range = self.from..self.to;
        rows.iter().filter(move |row| range.contains(&row.edges()))
    }
}

/// The bars beside what was found.
#[must_use]
pub fn bars(rows: &[Row]) -> Vec<Bar> {
    let bar = |class: Class| {
        let judged = |row: &Row| {
            let depths = row.ratios.iter().zip(DEPTHS).filter(|(_, depth)| *depth >= JUDGED);
            depths.flat_map(|(ratios, _)| ratios.clone()).collect::<Vec<f64>>()
        };
        let errors = class.of(rows).flat_map(judged).map(|ratio| (ratio - 1.0).abs());
        Bar { class, worst: errors.fold(0.0, f64::max) }
    };
    CLASSES.map(bar).into()
}

/// Least and largest.
fn range(ratios: impl IntoIterator<Item = f64>) -> String {
    let (low, high) =
        ratios.into_iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
    if low > high { "-".to_owned() } else { format!("{low:.2}-{high:.2}") }
}

/// The reference, the ratios and the bars as Markdown.
#[must_use]
pub fn markdown(references: &[Reference], rows: &[Row]) -> String {
    let mut text = String::new();
    let depths = DEPTHS.map(|depth| format!("{depth} R")).join(" | ");
    let line = "|---".repeat(DEPTHS.len());
    let mut put = |line: String| {
        let _ = writeln!(text, "{line}");
    };
    put(format!(
        "Finite elements: force [mN] (halved elements, elements of 1.25 mm, small strain, the law of nodal \
         shapes: over it)\n\n\
         | R [mm] | {depths} |\n|---{line}|"
    ));
    for of in references {
        let cells = (0..DEPTHS.len()).map(|at| {
            let force = of.press[at].force_n;
            let [fine, coarse, linear, nodal] = [&of.fine, &of.coarse, &of.linear, &of.nodal]
                .map(|other| other[at].force_n / force);
            format!("{:.3} ({fine:.4}, {coarse:.3}, {linear:.3}, {nodal:.3})", 1000.0 * force)
        });
        let cells = cells.collect::<Vec<_>>().join(" | ");
        put(format!("| {:.0} | {cells} |", 1000.0 * of.sphere_m));
    }
    put(format!("\nForce over that\n\n| h [mm], R [mm], R / h | {depths} |\n|---{line}|"));
    for row in rows {
        let cells: Vec<String> = row.ratios.iter().map(|ratios| range(ratios.clone())).collect();
        let (h, r) = (1000.0 * row.edge_m, 1000.0 * row.sphere_m);
        put(format!("| {h:.1}, {r:.0}, {:.2} | {} |", row.edges(), cells.join(" | ")));
    }
    put(format!("\n| | {depths} | largest error from {JUDGED} R on, bar |\n|---{line}|---|"));
    for bar in bars(rows) {
        let cell = |at: usize| range(bar.class.of(rows).flat_map(|row| row.ratios[at].clone()));
        let cells: Vec<String> = (0..DEPTHS.len()).map(cell).collect();
        let verdict = if bar.holds() { "holds" } else { "missed" };
        put(format!(
            "| {} | {} | {:.1} %, {:.0} %: {verdict} |",
            bar.class.name,
            cells.join(" | "),
            100.0 * bar.worst,
            100.0 * bar.class.limit
        ));
    }
    text
}
