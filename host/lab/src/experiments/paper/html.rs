//! The report as one HTML page: style, pictures and tables inside it, nothing fetched.

use std::fmt::Write as _;

use super::section::Section;
use super::write::{PaperReport, file_name};
use crate::charts::plot::Figure;
use crate::experiments::report::tables::{Table, duration};
use chaincell_host::words::counted;

const STYLE: &str = include_str!("style.css");

/// The whole page.
pub(super) fn page(report: &PaperReport) -> String {
    let title = "The paper's results, computed anew";
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n"
    );
    text += &head(report);
    text += &table("The paper's results and ours, in short", &results(report));
    text += "<nav aria-label=\"Contents\">\n<ol>\n";
    for section in &report.sections {
        let _ = writeln!(
            text,
            "<li><a href=\"#{}\">{}</a></li>",
            escape(section.key),
            escape(&section.title)
        );
    }
    text += "</ol>\n</nav>\n";
    for section in &report.sections {
        text += &body(section);
    }
    text + "</main>\n</body>\n</html>\n"
}

/// A row for each result of the paper.
fn results(report: &PaperReport) -> Table {
    Table::of(report.sections.iter().flat_map(|section| &section.results))
        .column("the paper", |(result, _)| result)
        .column("computed here", |(_, ours)| ours)
        .table()
}

fn head(report: &PaperReport) -> String {
    let machine = &report.machine;
    let mut text = paragraph(
        "J. Zhang, Y. Zhong, J. Smith, C. Gu: ChainMail based neural dynamics modeling of soft \
         tissue deformation for surgical simulation, Technology and Health Care, 2017. Every \
         picture, table and figure below was computed by the command named here. The other method is \
         traditional ChainMail (Gibson's lattice form, Li and Brodlie's generalised form). The numbers \
         of the pictures are files in the folder of this page.",
    );
    let bodies = if report.reference {
        "The liver is that of the reference data."
    } else {
        "No reference data was given: the generated organ stands for the liver."
    };
    let quick = if report.quick { " Quick: fewer ticks, sizes and repetitions." } else { "" };
    let build =
        if machine.optimised { "" } else { " Built without optimisation: no time below counts." };
    let stopped = if report.interrupted { " Interrupted: sections are missing." } else { "" };
    let _ = writeln!(
        text,
        "<p class=\"note\"><code>{}</code>, version {}. {bodies}{quick}{build}{stopped} Machine: {}, \
         {} for this process, {}, AVX2 {}, load {} at the start. Computed in {}.</p>",
        escape(&report.command),
        escape(report.version),
        escape(&machine.processor),
        counted(machine.cores, "core"),
        escape(&machine.system),
        if machine.avx2 { "found" } else { "absent" },
        escape(&machine.load),
        duration(report.seconds.values().sum())
    );
    text
}

fn body(section: &Section) -> String {
    let mut text =
        format!("<section id=\"{}\">\n<h2>{}</h2>\n", escape(section.key), escape(&section.title));
    section.text.iter().for_each(|line| text += &paragraph(line));
    section.figures.iter().for_each(|shown| text += &figure(shown));
    section.tables.iter().for_each(|(caption, rows)| text += &table(caption, rows));
    if !section.numbers.is_empty() {
        let link = |name: &String| format!("<a href=\"{0}.csv\">{0}.csv</a>", escape(name));
        let names = section.numbers.iter().map(|numbers| link(&file_name(&numbers.name)));
        let names: Vec<String> = names.collect();
        let _ = writeln!(text, "<p class=\"note\">Numbers: {}</p>", names.join(", "));
    }
    text + "</section>\n"
}

/// Escaped, with the parts between backticks as code.
fn paragraph(text: &str) -> String {
    let part = |(at, part): (usize, &str)| match at % 2 {
        0 => escape(part),
        _ => format!("<code>{}</code>", escape(part)),
    };
    let text: String = text.split('`').enumerate().map(part).collect();
    format!("<p>{text}</p>\n")
}

/// A picture with its caption and the way to its files.
fn figure(figure: &Figure) -> String {
    // A document within the page has no declaration of its own.
    let svg = figure.picture.svg.find("<svg").map_or("", |at| &figure.picture.svg[at..]);
    let name = escape(&file_name(&figure.name));
    format!(
        "<figure>\n{}\n<figcaption>{} <span class=\"files\"><a href=\"{name}.svg\">SVG</a> \
         <a href=\"{name}.png\">PNG</a></span></figcaption>\n</figure>\n",
        svg.trim(),
        escape(&figure.caption)
    )
}

fn table(caption: &str, table: &Table) -> String {
    let row = |cells: &[String], tag: &str| {
        let cells = cells.iter().map(|cell| {
            let class = if is_number(cell) { " class=\"number\"" } else { "" };
            format!("<{tag}{class}>{}</{tag}>", escape(cell))
        });
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let rows: String = table.rows().iter().map(|cells| row(cells, "td")).collect();
    format!(
        "<div class=\"wide\"><table>\n<caption>{}</caption>\n<thead>{}</thead>\n\
         <tbody>\n{rows}</tbody>\n</table></div>\n",
        escape(caption),
        row(table.head(), "th").trim_end()
    )
}

/// Whether a cell of a table is set to the right.
fn is_number(cell: &str) -> bool {
    cell.starts_with(|c: char| c.is_ascii_digit() || "-+<>".contains(c))
        && cell.contains(|c: char| c.is_ascii_digit())
}

/// A text that means itself between tags and in attributes.
pub(super) fn escape(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    text.replace('"', "&quot;").replace('\'', "&#39;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charts::plot::{Axis, Chart, Style};

    #[test]
    fn a_page_holds_its_sections_and_asks_for_nothing() {
        let rows = Table::of([()]).column("a<b", |()| "-1.5").column("c", |()| "x & y").table();
        let chart = Chart::new("t", Axis::linear("x"), Axis::linear("y"));
        let picture = chart.series("s", Style::Line, &[[0.0, 1.0], [1.0, 2.0]]).draw().unwrap();
        let name = "paper_one".to_owned();
        let section = Section {
            key: "one",
            title: "One <script>".into(),
            results: vec![("Fig. 1", "ours > theirs".into())],
            text: vec!["if a < b".into()],
            figures: vec![Figure { name, caption: "what & why".into(), picture }],
            tables: vec![("rows".into(), rows)],
            numbers: vec![],
            json: serde_json::Value::Null,
        };
        let report = PaperReport { sections: vec![section], ..PaperReport::default() };
        let page = page(&report);
        assert!(page.contains("<h2>One &lt;script&gt;</h2>") && page.contains("if a &lt; b"));
        assert!(
            page.contains("<th>a&lt;b</th>") && page.contains("<td class=\"number\">-1.5</td>")
        );
        assert!(page.contains("<td>ours &gt; theirs</td>"));
        assert!(page.contains("<a href=\"#one\">") && page.contains("what &amp; why"));
        assert!(!page.contains("<script") && !page.contains("href=\"http"));
    }
}
