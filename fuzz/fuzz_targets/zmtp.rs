//! Sends arbitrary bytes to a connection of the ZMTP server. See `mmsim_fuzz::zmtp`.
#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| mmsim_fuzz::zmtp::run(input));
