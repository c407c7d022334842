use super::*;
use crate::reference::Npz;

#[test]
fn the_section_holds_in_the_quick_context() {
    let section = section(&Context { quick: true, reference: None }).unwrap();
    if let Ok(folder) = std::env::var("SHOW") {
        for figure in &section.figures {
            std::fs::write(format!("{folder}/{}.png", figure.name), &figure.picture.png).unwrap();
        }
        println!("{:#}", section.json);
        for text in &section.text { println!("{text}\n"); }
        for (caption, table) in &section.tables { println!("{caption}\n\n{}", table.markdown()); }
    }
}
