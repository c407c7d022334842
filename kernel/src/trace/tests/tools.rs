//! Traces with tools: parts and poses of tools.

use super::*;
use crate::contact::pose::{ToolPart, ToolPose};

const TOOLS: RecordedTools = RecordedTools { count: 2, friction: 0.25 };

fn header_of_tools() -> Header {
    Header { tools: Some(TOOLS), ..header() }
}

fn parts() -> [PartRecord; 3] {
    let turned = ToolPart {
        centre_m: [0.001, -0.0, 0.002],
        orientation: [0.0, 0.6, 0.0, 0.8],
        ..ToolPart::rounded_box([0.01, 0.02, 0.03], 0.004)
    };
    [
        PartRecord { tool: 0, part: 0, shape: ToolPart::half_space(0.005) },
        PartRecord { tool: 0, part: 1, shape: turned },
        PartRecord { tool: 1, part: 0, shape: ToolPart::sphere(0.01) },
    ]
}

/// Tool 0 is open.
fn pose(tool: u8, z: f32) -> PoseRecord {
    let closed = ToolPose::at(Vector3::new(0.1, -0.0, z), 1);
    let opening_turns_q16 = if tool == 0 { 2608 } else { 0 };
    let orientation = [0.6, 0.0, 0.8, 0.0];
    PoseRecord { tool, pose: ToolPose { orientation, opening_turns_q16, ..closed } }
}

/// Returns the length of the header, and the whole trace.
fn written() -> (usize, Vec<u8>) {
    let mut trace = vec![0; 5 * HEADER_BYTES];
    let (mut writer, front) = Writer::begin(&header_of_tools(), &[], &mut trace).unwrap();
    trace.truncate(front);
    parts().iter().for_each(|part| trace.extend(writer.part(part).as_flattened()));
    for tick in 0..3 {
        trace.extend(writer.pose(&pose(0, tick as f32)));
        trace.extend(writer.pose(&pose(1, 10.0 + tick as f32)));
        trace.extend(writer.record(&session()[tick]));
    }
    let pause = CommandRecord { tick: 1, command: Command::Pause, state_hash: None };
    trace.extend(writer.command(&pause));
    (front, trace)
}

fn found(trace: &[u8]) -> (Vec<Entry>, End) {
    let mut found = Vec::new();
    let end = Reader::open(trace).unwrap().entries(|_, entry| {
        found.push(*entry);
        Ok::<(), ()>(())
    });
    (found, end.unwrap())
}

#[test]
fn parts_and_poses_are_read_as_written() {
    let (front, trace) = written();
    assert_eq!(trace.len(), front + (6 + 9 + 1) * RECORD_BYTES);
    let reader = Reader::open(&trace).unwrap();
    assert_eq!(reader.header(), &header_of_tools());
    assert_eq!(reader.contacts().len(), 0);
    assert_eq!(reader.contact_cells(&model(), &mut [0; 4]), Err(TraceError::Tools(2)));
    let (entries, end) = found(&trace);
    assert_eq!((entries.len(), end), (3 + 9 + 1, End::Complete));
    for (entry, part) in entries.iter().zip(parts()) {
        assert_eq!(*entry, Entry::Part(part));
    }
    assert_eq!(entries[3], Entry::Pose(pose(0, 0.0)));
    assert_eq!(entries[7], Entry::Pose(pose(1, 11.0)));
    let Entry::Tick(tick) = entries[8] else { panic!("{:?}", entries[8]) };
    assert_eq!(bits(&tick), bits(&session()[1]));
    // A reader of samples stops at once.
    assert_eq!(read(&trace).unwrap(), (Vec::new(), End::Kind(0, KIND_PART)));
}

/// Compares the bytes with the format's table.
#[test]
fn the_bytes_of_parts_and_poses_are_those_of_the_table() {
    let (front, trace) = written();
    let word = |at: usize| u32::from_le_bytes(*trace[at..].first_chunk().unwrap());
    let bits = f32::to_bits;
    assert_eq!([8, 48, 52, 56, 76].map(word), [5, 0, 0, 2, bits(0.25)]);
    assert_eq!(trace[74..76], [2, 0]);
    let at = front + 2 * RECORD_BYTES;
    let first = [0.001, -0.0, 0.002, 0.004, 0.01, 0.02, 0.03].map(bits);
    assert_eq!([0, 4, 8, 12, 16, 20, 24].map(|by| word(at + by)), first);
    assert_eq!([28, 32, 36, 40].map(|by| word(at + by)), [0, 3, 1 << 8, 0]);
    let at = at + RECORD_BYTES;
    assert_eq!([0, 4, 8, 12].map(|by| word(at + by)), [0.0, 0.6, 0.0, 0.8].map(bits));
    assert_eq!([16, 28, 32, 36, 40].map(|by| word(at + by)), [0, 0, 3, 1 << 8 | 1 << 16, 0]);
    let at = front + 10 * RECORD_BYTES;
    let pose = [0, 4, 8].map(|by| word(at + by));
    assert_eq!((pose, word(at + 12)), ([0.1, -0.0, 11.0].map(bits), 1));
    assert_eq!([16, 20, 24, 28].map(|by| word(at + by)), [0.6, 0.0, 0.8, 0.0].map(bits));
    assert_eq!([32, 36, 40].map(|by| word(at + by)), [4, 1, 0]);
    assert_eq!(word(at - RECORD_BYTES + 12), 1 | 2608 << 16);
}

#[test]
fn a_cut_within_a_tick_or_a_part_is_told() {
    let (front, trace) = written();
    let ends = (0..=16).map(|records| found(&trace[..front + records * RECORD_BYTES]).1);
    for (records, end) in ends.enumerate() {
        // The trace is complete after a whole part, a whole tick and the command.
        let is_whole = [0, 2, 4, 6, 9, 12, 15, 16].contains(&records);
        let wanted = if is_whole { End::Complete } else { End::Cut(records as u32) };
        assert_eq!(end, wanted, "{records}");
    }
}

/// Each case has records in an order that the format does not allow.
#[test]
fn what_stands_in_another_order_is_refused() {
    let tick = |writer: &mut Writer| writer.record(&session()[0]).to_vec();
    let of = |record: PoseRecord| move |writer: &mut Writer| writer.pose(&record).to_vec();
    let pause = |writer: &mut Writer| {
        let command = Command::Pause;
        writer.command(&CommandRecord { tick: 0, command, state_hash: None }).to_vec()
    };
    let part = |writer: &mut Writer| writer.part(&parts()[0]).concat();
    let half = |writer: &mut Writer| {
        let first = writer.clone().part(&parts()[0])[0];
        // Advance the writer by one place.
        writer.pose(&pose(0, 0.0));
        first.to_vec()
    };
    let third = |writer: &mut Writer| writer.part(&PartRecord { tool: 2, ..parts()[0] }).concat();
    let (first, second) = (of(pose(0, 0.0)), of(pose(1, 0.0)));
    type Make<'a> = &'a dyn Fn(&mut Writer) -> Vec<u8>;
    // The records of each case, and index and kind of the first that is refused.
    let cases: [(&[Make<'_>], u32, u16); 8] = [
        (&[&tick], 0, KIND_SAMPLE),
        (&[&first, &tick], 1, KIND_SAMPLE),
        (&[&second], 0, KIND_POSE),
        (&[&first, &first], 1, KIND_POSE),
        (&[&first, &pause], 1, KIND_COMMAND),
        (&[&pause, &part], 1, KIND_PART),
        (&[&half, &first], 1, KIND_POSE),
        (&[&third], 0, KIND_PART),
    ];
    for (at, (records, place, kind)) in cases.into_iter().enumerate() {
        let mut trace = vec![0; 5 * HEADER_BYTES];
        let (mut writer, front) = Writer::begin(&header_of_tools(), &[], &mut trace).unwrap();
        trace.truncate(front);
        records.iter().for_each(|make| trace.extend(make(&mut writer)));
        assert_eq!(found(&trace).1, End::Kind(place, kind), "{at}");
    }
}

#[test]
fn a_header_has_tools_that_can_be_and_nothing_beside_them() {
    let mut room = [0; 4 * HEADER_BYTES];
    assert!(Writer::begin(&header_of_tools(), &[31], &mut room).is_none());
    for tools in [
        RecordedTools { count: 0, ..TOOLS },
        RecordedTools { count: 9, ..TOOLS },
        RecordedTools { friction: -1.0, ..TOOLS },
        RecordedTools { friction: f32::NAN, ..TOOLS },
    ] {
        let header = Header { tools: Some(tools), ..header() };
        Writer::begin(&header, &[], &mut room).unwrap();
        assert_eq!(Reader::open(&room).err(), Some(TraceError::Layout), "{tools:?}");
    }
}
