//! Reads arbitrary bytes as recordings. See `mmsim_fuzz::recordings`.
#![no_main]

libfuzzer_sys::fuzz_target!(|content: &[u8]| mmsim_fuzz::recordings::run(content));
