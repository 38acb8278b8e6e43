//! Sends arbitrary requests to one simulation. See `mmsim_fuzz::requests`.
#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| mmsim_fuzz::requests::run(input));
