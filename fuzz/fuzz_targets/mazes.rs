//! Reads arbitrary bytes as maze files. See `mmsim_fuzz::mazes`.
#![no_main]

libfuzzer_sys::fuzz_target!(|content: &[u8]| mmsim_fuzz::mazes::run(content));
