//! The tables of a page as Markdown, to be taken into a page of one's own.

use super::section::{Findings, today};
use super::table::Table;
use chaincell_host::words::counted;

/// All tables with the command, the date and the machine.
pub(super) fn tables(findings: &Findings) -> String {
    let machine = &findings.machine;
    let mut text = format!(
        "# {}\n\n`{}`, version {}, {}. Machine: {}, {} for this process, {}.\n",
        findings.page.title,
        findings.command(),
        env!("CARGO_PKG_VERSION"),
        today(),
        machine.processor,
        counted(machine.cores, "core"),
        machine.system,
    );
    for section in findings.sections.iter().filter(|section| !section.tables.is_empty()) {
        text += &format!("\n## {}\n", section.title);
        for (caption, rows) in &section.tables {
            text += &format!("\n{caption}:\n\n{}", table(rows));
        }
    }
    text
}

fn table(table: &Table) -> String {
    let row = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let rule = format!("|{}\n", "---|".repeat(table.head().len()));
    let rows: String = table.rows().iter().map(|cells| row(cells)).collect();
    row(table.head()) + &rule + &rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::page::{Context, Page, Section};

    #[test]
    fn a_table_has_its_date_and_machine() {
        static PAGE: Page = Page { name: "one", title: "Title", intro: "", experiments: &[] };
        let rows = Table::of([1.5]).column("a|b", |x| x).column("c", |_| "d").table();
        let tables = vec![("Rows".to_owned(), rows)];
        let mut findings = Findings::new(&PAGE, Context::default());
        findings.sections.push(Section { title: "Part".into(), tables, ..Section::default() });
        findings.sections.push(Section { title: "Empty".into(), ..Section::default() });
        let text = super::tables(&findings);
        let (head, rest) = text.split_once("\n## Part\n").unwrap();
        assert!(head.contains("`chaincell one`") && head.contains(&today()), "{head}");
        assert!(head.contains(&findings.machine.processor), "{head}");
        assert_eq!(rest, "\nRows:\n\n| a\\|b | c |\n|---|---|\n| 1.5 | d |\n");
    }
}
