//! Maze files of any content. See `mmsim_fuzz::mazes`.
#![no_main]

libfuzzer_sys::fuzz_target!(|content: &[u8]| mmsim_fuzz::mazes::run(content));
