//! The clients in `examples/`, each against a simulator that keeps what it is asked.
//!
//! Those in Python need python3 with pyzmq, those in C a compiler `cc` and libzmq (Debian:
//! libzmq3-dev). Without, their tests say that they are skipped and pass; with
//! `MMSIM_CLIENTS=required` they fail.

#[path = "../harness/mod.rs"]
mod harness;

mod client;
mod codec;
mod searches;
mod simulator;
