//! Bytes of one client, received by the ZMTP server. See `mmsim_fuzz::zmtp`.
#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| mmsim_fuzz::zmtp::run(input));
