//! A reader with a planted defect: a run that does not find it proves nothing about the others.

use chaincell_host::files::path::{Rules, parse};

/// Takes `engaged` of a recorded session for 0 or 1, which only the strict rules see to.
///
/// # Panics
/// On the first path that says otherwise.
pub fn canary(data: &[u8]) {
    const NAMES: [&str; 2] = ["released", "engaged"];
    let paths = parse(data, "canary.csv", Rules::Recorded).unwrap_or_default();
    for pose in paths.poses.iter().flatten() {
        assert!(!NAMES[pose.engaged as usize].is_empty());
    }
}
