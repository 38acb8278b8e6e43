//! The fuzz targets and the laws they check. Each module is a target: `run` takes the input of the
//! fuzzer and panics where a law is broken.
//!
//! `CONTRIBUTING.md` says how to run them and what to do with a finding.

pub mod mazes;
pub mod recordings;
pub mod requests;
pub mod zmtp;
