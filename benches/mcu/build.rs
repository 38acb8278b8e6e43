//! Compiles the queue in C and writes the linker script.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap());
    // The memory of the smallest chip that QEMU simulates, the nRF51822. The size of the feature
    // `half-size` needs more.
    let (flash, ram) = if env::var_os("CARGO_FEATURE_HALF_SIZE").is_some() {
        ("1024K", "256K")
    } else {
        ("256K", "16K")
    };
    let memory = format!(
        "MEMORY {{\n  FLASH : ORIGIN = 0x00000000, LENGTH = {flash}\n  \
         RAM : ORIGIN = 0x20000000, LENGTH = {ram}\n}}\n"
    );
    fs::write(out.join("memory.x"), memory).unwrap();
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg=-Tlink.x");
    println!("cargo:rerun-if-changed=queue.c");
    cc::Build::new().compiler("clang").file("queue.c").opt_level(3).compile("queue");
}
