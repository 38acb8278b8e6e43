//! A server on a background thread.

use std::thread::{self, JoinHandle};

use crate::control::StopHandle;
use crate::server::{ServeError, Server};
use crate::simulation::Simulation;

/// A server on a background thread. It runs until it is stopped or the process ends.
///
/// ```
/// use mmsim_server::{Server, Simulation};
/// let maze = "o---o---o\n| S   G |\no---o---o\n".parse()?;
/// let server = Server::bind("127.0.0.1", 0)?.spawn(Simulation::new("small", maze));
/// println!("listening on {}", server.address());
/// let simulation = server.stop()?;
/// assert!(simulation.history().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Background {
    address: String,
    stop: StopHandle,
    thread: JoinHandle<Result<Simulation, ServeError>>,
}

impl Server {
    /// Serves the simulation on a background thread.
    pub fn spawn(self, mut simulation: Simulation) -> Background {
        let (address, stop) = (self.address().to_string(), self.stop_handle());
        let thread = thread::spawn(move || self.run(&mut simulation).map(|()| simulation));
        Background { address, stop, thread }
    }
}

impl Background {
    /// Returns the address for clients, such as `tcp://127.0.0.1:6574`.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Stops the server and returns the simulation with its history.
    ///
    /// # Errors
    /// The server had already failed.
    ///
    /// # Panics
    /// The server's thread panicked, which is a bug in this crate.
    pub fn stop(self) -> Result<Simulation, ServeError> {
        self.stop.stop();
        // Propagates a panic of the server's thread.
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}
