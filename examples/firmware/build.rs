//! Selects the board: the nRF51 for a Cortex-M0, otherwise Arm's MPS2 with the memory of an
//! STM32F103C8.

use std::path::PathBuf;
use std::{env, fs};

fn main() -> std::io::Result<()> {
    println!("cargo:rustc-check-cfg=cfg(nrf51)");
    println!("cargo:rerun-if-changed=memory");
    if env::var_os("CARGO_FEATURE_BOARD").is_none() {
        return Ok(());
    }
    let memory = if env::var("TARGET").is_ok_and(|target| target.starts_with("thumbv6m")) {
        println!("cargo:rustc-cfg=nrf51");
        "memory/nrf51822.x"
    } else {
        "memory/stm32f103.x"
    };
    let folder = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    // The linker script of cortex-m-rt includes this file.
    fs::copy(memory, folder.join("memory.x"))?;
    println!("cargo:rustc-link-search={}", folder.display());
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    Ok(())
}
