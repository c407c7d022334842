//! Names the shared library.

/// Its name, with the interface's number, not the release's: another one is another library.
const SONAME: &str = "libchaincell_client.so.0";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,{SONAME}");
}
