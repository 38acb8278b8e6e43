//! The clients in `examples/`, each against a simulator that records requests.
//!
//! The Python clients need python3 with pyzmq, the C clients a compiler `cc` and libzmq (Debian:
//! libzmq3-dev). Without them, the tests report that they are skipped, and pass; with
//! `MMSIM_CLIENTS=required` they fail.

#[path = "../harness/mod.rs"]
mod harness;

mod client;
mod codec;
mod searches;
mod simulator;
