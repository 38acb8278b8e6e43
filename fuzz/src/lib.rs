//! What the fuzz targets try, and the laws that they hold their findings against. Each module is a
//! target: `run` takes the bytes that the fuzzer made up and panics where a law is broken.
//!
//! `CONTRIBUTING.md` says how to run them and what to do with a finding.

pub mod mazes;
pub mod recordings;
pub mod requests;
