use super::*;
use method::Kind;

#[test]
fn the_comparison() {
    let section = section(&Context { quick: true, ..Context::default() }).unwrap();
    for (caption, table) in &section.tables {
        println!("{caption}\n{}", table.markdown());
    }
    for p in &section.text {
        println!("{p}\n");
    }
    println!("{:#}", section.json);
    if let Ok(dir) = std::env::var("PICTURES") {
        for f in &section.figures {
            std::fs::write(format!("{dir}/{}.png", f.name), &f.picture.png).unwrap();
            println!("{}", f.picture.left_out);
        }
    }
    let _ = Kind::ALL;
}
