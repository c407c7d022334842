//! The page itself: style, pictures and tables inside it, nothing fetched.

use std::fmt::Write as _;

use super::section::{Findings, Page, Section};
use super::table::{Table, duration};
use crate::charts::plot::Figure;
use chaincell_host::picture::chart::pen::escape;
use chaincell_host::words::counted;

const STYLE: &str = include_str!("style.css");

/// The whole page.
pub(super) fn page(findings: &Findings) -> String {
    let Page { title, intro, .. } = findings.page;
    let title = escape(title);
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n"
    );
    text += &paragraph(intro);
    text += &origin(findings);
    let results = || findings.sections.iter().flat_map(|section| &section.results);
    if results().next().is_some() {
        let rows = Table::of(results())
            .column("the paper", |(result, _)| result)
            .column("computed here", |(_, ours)| ours);
        text += &table("The paper's results and ours, in short", &rows.table());
    }
    text += "<nav aria-label=\"Contents\">\n<ol>\n";
    for section in &findings.sections {
        let (key, title) = (escape(section.key), escape(&section.title));
        let _ = writeln!(text, "<li><a href=\"#{key}\">{title}</a></li>");
    }
    text += "</ol>\n</nav>\n";
    for section in &findings.sections {
        text += &body(findings.page, section);
    }
    text + "</main>\n</body>\n</html>\n"
}

/// How the page was made: command, bodies, machine, time.
fn origin(findings: &Findings) -> String {
    let (machine, context) = (&findings.machine, &findings.context);
    let bodies = match context.reference {
        Some(_) => "The liver is that of the reference data.",
        None => "No reference data was given: the generated organ stands for the liver.",
    };
    let quick = if context.quick { " Quick: fewer ticks, sizes and repetitions." } else { "" };
    let build =
        if machine.optimised { "" } else { " Built without optimisation: no time below counts." };
    let stopped = if findings.interrupted { " Interrupted: sections are missing." } else { "" };
    format!(
        "<p class=\"note\"><code>{}</code>, version {}. {bodies}{quick}{build}{stopped} Machine: {}, \
         {} for this process, {}, AVX2 {}, load {} at the start. Computed in {}.</p>\n",
        escape(&findings.command()),
        env!("CARGO_PKG_VERSION"),
        escape(&machine.processor),
        counted(machine.cores, "core"),
        escape(&machine.system),
        if machine.avx2 { "found" } else { "absent" },
        escape(&machine.load),
        duration(findings.seconds.values().sum())
    )
}

fn body(page: &Page, section: &Section) -> String {
    let mut text =
        format!("<section id=\"{}\">\n<h2>{}</h2>\n", escape(section.key), escape(&section.title));
    section.text.iter().for_each(|line| text += &paragraph(line));
    section.figures.iter().for_each(|shown| text += &figure(page, shown));
    section.tables.iter().for_each(|(caption, rows)| text += &table(caption, rows));
    if !section.numbers.is_empty() {
        let link = |name: &String| format!("<a href=\"{0}.csv\">{0}.csv</a>", escape(name));
        let names = section.numbers.iter().map(|numbers| link(&page.file_name(&numbers.name)));
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
fn figure(page: &Page, figure: &Figure) -> String {
    // A document within the page has no declaration of its own.
    let svg = figure.picture.svg.find("<svg").map_or("", |at| &figure.picture.svg[at..]);
    let name = escape(&page.file_name(&figure.name));
    format!(
        "<figure>\n{}\n<figcaption>{} <span class=\"files\"><a href=\"{name}.svg\">SVG</a> \
         <a href=\"{name}.png\">PNG</a></span></figcaption>\n</figure>\n",
        svg.trim(),
        escape(&figure.caption)
    )
}

/// A table; columns of numbers are set to the right.
fn table(caption: &str, table: &Table) -> String {
    let is_right: Vec<bool> = (0..table.head().len())
        .map(|at| table.rows().iter().all(|row| row.get(at).is_some_and(|cell| is_number(cell))))
        .collect();
    let row = |cells: &[String], tag: &str| {
        let cells = cells.iter().zip(&is_right).map(|(cell, is_right)| {
            let class = if *is_right { " class=\"number\"" } else { "" };
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

/// Whether a cell of a table is a number, of percent or not, or stands for none.
fn is_number(cell: &str) -> bool {
    cell == "-" || cell.trim_end_matches(" %").parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charts::plot::{Axis, Chart, Picture, Style};
    use crate::experiments::page::Context;

    #[test]
    fn a_page_holds_its_sections_and_asks_for_nothing() {
        static PAGE: Page = Page { name: "one", title: "Title", intro: "Intro.", experiments: &[] };
        let rows = Table::of(["1 mm deep", "-1.5"]).column("a<b", |_| "-1.5").column("c", |c| c);
        let chart = Chart::new("t", Axis::linear("x"), Axis::linear("y"));
        let chart = chart.series("s", Style::Line, &[[0.0, 1.0], [1.0, 2.0]]);
        let picture = Picture::of(&chart).unwrap();
        let section = Section {
            key: "one",
            title: "One <script>".into(),
            results: vec![("Fig. 1", "ours > theirs".into())],
            text: vec!["if a < b".into()],
            figures: vec![Figure::new("one_one", "what & why", picture)],
            tables: vec![("rows".into(), rows.table())],
            ..Section::default()
        };
        let mut findings = Findings::new(&PAGE, Context::default());
        findings.sections.push(section);
        let page = page(&findings);
        assert!(page.contains("<h2>One &lt;script&gt;</h2>") && page.contains("if a &lt; b"));
        // A column is set to the right where all of it are numbers.
        assert!(page.contains("<th class=\"number\">a&lt;b</th><th>c</th>"), "{page}");
        assert!(page.contains("<td class=\"number\">-1.5</td><td>1 mm deep</td>"), "{page}");
        assert!(page.contains("<td>ours &gt; theirs</td>"));
        assert!(page.contains("<a href=\"#one\">") && page.contains("what &amp; why"));
        assert!(!page.contains("<script") && !page.contains("href=\"http"));
    }
}
