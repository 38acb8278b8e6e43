//! The fuzz targets and the properties that they check. Each module is a target: its function `run`
//! takes bytes from the fuzzer and panics if a property is violated.
//!
//! `CONTRIBUTING.md` describes how to run the targets and what to do with a finding.

pub mod mazes;
pub mod recordings;
pub mod requests;
pub mod zmtp;
