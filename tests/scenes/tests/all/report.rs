//! Reports of a foreign target, checked on this one: what agrees, what differs and where, what is
//! damaged.
#![allow(clippy::unwrap_used, clippy::panic)]

use chaincell_kernel::{Dynamics, TissueMut};
use chaincell_scenes::report::{self, Fault, Wish};
use chaincell_scenes::{Act, Difference, FAULT, Run, Scene, Stepper, Tier, stage};

const SCENE: &str = "organ500_track";

/// A report of 60 ticks, with a fault in a cell after a tick and cells after a tick.
struct Emit(Option<(u32, usize)>, Option<u32>);

impl Act for Emit {
    type Output = String;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> String {
        let mut run = Run::new(scene, tissue).unwrap();
        if let Some((tick, cell)) = self.0 {
            run.fault(tick, cell);
        }
        let mut text = String::from("booted\n");
        let wish = Wish { tier: Tier::F32, ticks: 60, cells_after: self.1 };
        report::write(&mut text, &mut run, wish).unwrap();
        text
    }
}

fn emit(fault: Option<(u32, usize)>, cells_after: Option<u32>) -> String {
    stage(SCENE, Tier::F32, Emit(fault, cells_after)).unwrap()
}

#[test]
fn a_report_of_the_same_bits_agrees() {
    assert_eq!(report::check(&emit(None, None)), Ok(60));
    let two = emit(None, Some(17)) + &emit(None, None).replace('\n', "\r\n");
    assert_eq!(report::check(&two), Ok(120));
}

#[test]
fn a_fault_is_named_by_its_tick_and_with_cells_by_its_cell() {
    let text = emit(Some((41, 123)), None);
    let fault = report::check(&text).unwrap_err();
    let difference = Difference { tick: 41, cell: None };
    assert_eq!(fault, Fault::Differs { scene: SCENE, difference, with_cells: false });
    assert!(
        fault.to_string().ends_with("tick 41; report its cells too, CELLS_AFTER 41"),
        "{fault}"
    );

    let text = emit(Some((41, 123)), Some(41));
    let fault = report::check(&text).unwrap_err();
    let Fault::Differs { difference: Difference { tick: 41, cell: Some(found) }, .. } = fault
    else {
        panic!("{fault}");
    };
    let (cell, _, [right, faulty]) = found;
    let moved = (f32::from_bits(right[0] as u32) + FAULT).to_bits();
    assert_eq!((cell, faulty), (123, [moved.into(), right[1], right[2]]));
    assert!(fault.to_string().contains("first difference at tick 41: cell 123 (node "), "{fault}");
}

#[test]
fn another_force_on_the_same_state_is_told_apart() {
    let text = emit(None, Some(9));
    let line = text.lines().find(|line| line.starts_with("tick 9 ")).unwrap();
    let other = text.replace(line, &(line[..line.len() - 4].to_owned() + "0000"));
    let fault = report::check(&other).unwrap_err();
    let difference = Difference { tick: 9, cell: None };
    assert_eq!(fault, Fault::Differs { scene: SCENE, difference, with_cells: true });
    assert!(fault.to_string().contains("the states agree"), "{fault}");
}

#[test]
fn damaged_reports_are_refused() {
    let text = emit(None, None);
    assert_eq!(report::check(""), Err(Fault::Nothing));
    assert_eq!(report::check("booted\n"), Err(Fault::Nothing));
    let end = text.find("end ").unwrap();
    assert_eq!(report::check(&text[..end]), Err(Fault::Cut(SCENE)));
    for (from, to) in [(" f32", " f16"), (SCENE, "no_such_scene"), (" f32", "")] {
        let other = text.replace(from, to);
        assert!(matches!(report::check(&other), Err(Fault::Scene(_))), "{from}");
    }
    let lost: String =
        text.lines().filter(|l| !l.starts_with("tick 7 ")).flat_map(|l| [l, "\n"]).collect();
    for other in [&lost, &text.replace("end 60", "end 61"), &text.replace("tick 7 ", "tack 7 ")] {
        let refused = report::check(other);
        assert!(matches!(refused, Err(Fault::Line(SCENE, _))), "{refused:?}");
    }
}
