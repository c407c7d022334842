//! The text of `--version` after the number of the release.

use std::sync::LazyLock;

use iceoryx2_bb_elementary::package_version::PackageVersion;

/// The release, and what it was built from and for.
#[must_use]
pub fn long() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        format!(
            "{}\ncommit: {}\nkernel features: {}\nshared memory: iceoryx2 {}\ntarget: {}",
            env!("CARGO_PKG_VERSION"),
            env!("CHAINCELL_BUILD_COMMIT"),
            chaincell_kernel::FEATURES.join(", "),
            PackageVersion::get(),
            env!("CHAINCELL_BUILD_TARGET"),
        )
    });
    &TEXT
}
