use super::*;

#[test]
fn the_section_tells_what_the_choices_change() {
    let started = std::time::Instant::now();
    let section = section(&Context { quick: true, reference: None }).unwrap();
    if let Ok(folder) = std::env::var("SHOW") {
        println!("TIME choices {:?}", started.elapsed());
        for figure in &section.figures {
            std::fs::write(format!("{folder}/{}.png", figure.name), &figure.picture.png).unwrap();
        }
        for text in &section.text { println!("{text}\n"); }
        for (caption, table) in &section.tables { println!("{caption}\n\n{}", table.markdown()); }
    }
    assert_eq!((section.figures.len(), section.tables.len(), section.numbers.len()), (2, 4, 5));
}
