//! Running the clients in `examples/` against a simulator that records requests.
//!
//! The Python clients need python3 with pyzmq, and reading recordings in Python also needs mcap and
//! jsonschema. The C clients need a C compiler (`cc`) and libzmq
//! (Debian: libzmq3-dev). If these tools are missing, the tests print a note and pass, or fail if
//! `MMSIM_CLIENTS=required` is set.

#[path = "../harness/mod.rs"]
mod harness;

mod client;
mod codec;
mod fast_run;
mod recording;
mod robots;
mod searches;
mod simulator;
mod tester;
