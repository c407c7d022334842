//! Pages of experiments: runs them and writes page, figures, pictures and numbers.
//!
//! An experiment is a function from a [`Context`] to a [`Section`] and a row in the list of its
//! [`Page`].

mod html;
mod markdown;
mod section;
pub mod table;

use std::time::Instant;

use chaincell_host::error::Result;
use chaincell_host::files::output::Folder;
use chaincell_host::interrupt;
use chaincell_host::terminal::Progress;
pub use section::{Context, Findings, Numbers, Page, Section};

/// Runs every experiment of a page; those that are done stay in `findings` whatever ends the rest.
pub fn collect(findings: &mut Findings, bar: &Progress) -> Result<()> {
    for experiment in findings.page.experiments {
        let start = Instant::now();
        // Sections are missing, whatever the reason of an error.
        let section = interrupt::check().and_then(|()| experiment(&findings.context));
        findings.interrupted = section.is_err();
        let section = section?;
        findings.seconds.insert(section.key, start.elapsed().as_secs_f64());
        findings.sections.push(section);
        bar.step();
    }
    Ok(())
}

/// Writes the page, its figures as JSON, its tables as Markdown, pictures and CSV files.
pub fn write(findings: &Findings, folder: &Folder) -> Result<()> {
    let page = findings.page;
    for section in &findings.sections {
        for figure in &section.figures {
            figure.picture.write(folder, &page.file_name(&figure.name))?;
        }
        for numbers in &section.numbers {
            let name = format!("{}.csv", page.file_name(&numbers.name));
            folder.write(&name, numbers.csv.as_bytes())?;
        }
    }
    folder.write_json(&format!("{}.json", page.name), &findings.json())?;
    folder.write(&format!("{}.md", page.name), markdown::tables(findings).as_bytes())?;
    folder.write(&format!("{}.html", page.name), html::page(findings).as_bytes())
}
