//! Traces of every version that was ever written, and of another revision of the arithmetic.

use super::*;
use crate::stage::{Device, StageSettings};
use crate::tick::choices::{Arithmetic, Scheme};

static TRACK: &[u8] = include_bytes!("../../../../tests/data/traces/version1-track.trace");
static CURRENT: &[u8] =
    include_bytes!("../../../../tests/data/traces/version1-euler-fixed-current.trace");
static FALCON: &[u8] = include_bytes!("../../../../tests/data/traces/version2-falcon.trace");

#[test]
fn every_version_is_read() {
    let before = Origin { revision: 1, release: [0, 1, 0] };
    for (trace, scheme, number, drive, origin) in [
        (TRACK, Scheme::Track, Arithmetic::F32, Drive::Position, before),
        (CURRENT, Scheme::Euler, Arithmetic::Fixed, Drive::Current, before),
        (FALCON, Scheme::Rkl2, Arithmetic::F32, Drive::Position, before),
        (&trace(), Scheme::Track, Arithmetic::F32, Drive::Position, Origin::HERE),
    ] {
        let header = *Reader::open(trace).unwrap().header();
        assert_eq!((header.scheme, header.number), (scheme, number));
        assert_eq!((header.origin, header.settings.drive), (origin, drive));
        let (records, end) = read(trace).unwrap();
        assert_eq!(end, End::Complete);
        assert!(records.len() >= 30 && records.iter().all(|record| record.1[2] != 0));
        let damaged = [&trace[..trace.len() - 50], &[1], &trace[trace.len() - 49..]].concat();
        let damage = read(&damaged).unwrap().1;
        assert!(matches!(damage, End::Damaged(at) if at as usize + 2 >= records.len()), "{damage}");
    }
    let stage = |trace| Reader::open(trace).unwrap().header().stage;
    assert_eq!((stage(TRACK), stage(CURRENT)), (None, None));
    // It knew no limit of the hand's speed.
    let falcon = StageSettings {
        watchdog_ticks: 0,
        max_speed_m_per_s: f32::INFINITY,
        ..StageSettings::for_device(Device::Falcon)
    };
    assert_eq!(stage(FALCON), Some(falcon));
}

#[test]
fn another_revision_is_named_with_its_release_and_nothing_is_played() {
    let origin = Origin { revision: REVISION + 1, release: [7, 8, 9] };
    let trace = written(&Header { origin, ..header() }, &held().0, &session());
    let reader = Reader::open(&trace).unwrap();
    let refused = reader.header().network(model()).err();
    assert_eq!(refused, Some(TraceError::Revision(origin)));
    let told = refused.unwrap().to_string();
    assert!(told.contains("revision 4") && told.ends_with("with chaincell 7.8.9"), "{told}");
}
