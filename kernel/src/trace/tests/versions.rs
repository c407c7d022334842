//! Traces of other versions of the format, and of another revision of the arithmetic.

use super::*;

#[test]
fn other_versions_name_the_releases_that_read_them() {
    for version in [0, 1, 2, 3, 4, VERSION + 1] {
        let refused = read(&reworded(8, version)).unwrap_err();
        assert_eq!(refused, TraceError::Version(version));
        let told = refused.to_string();
        assert!(told.contains("1 and 2: chaincell 0.1; 3 and 4: 0.2"), "{told}");
    }
}

#[test]
fn another_revision_is_named_with_its_release_and_nothing_is_played() {
    let origin = Origin { revision: REVISION + 1, release: [7, 8, 9] };
    let trace = written(&Header { origin, ..header() }, &held().0, &session());
    let reader = Reader::open(&trace).unwrap();
    let refused = reader.header().network(model()).err();
    assert_eq!(refused, Some(TraceError::Revision(origin)));
    let told = refused.unwrap().to_string();
    assert!(told.contains("revision 5") && told.ends_with("with chaincell 7.8.9"), "{told}");
}
