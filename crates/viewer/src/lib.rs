//! Watches a micromouse maze simulator in the browser: the maze, the mouse, and every state of its
//! search under a slider.
//!
//! [`Viewer`] is a small web server, all of whose page is part of the program. The page learns by a
//! stream of events how many states there are, and fetches those it draws, so a search at full
//! speed never waits for a watcher, and a watcher can have every state.
//!
//! It listens on loopback. A page elsewhere in the same browser can neither read nor steer it, and
//! if other machines can reach it, it asks for a token.
#![forbid(unsafe_code)]

mod access;
mod api;
mod api_error;
mod assets;
mod costs;
mod events;
mod limits;
mod mazes;
mod mouse;
mod pictures;
mod recordings;
mod source;
mod state;
mod state_view;
mod stream;
mod transfer;
mod viewer;
mod work;

pub use limits::{Limits, MAX_VIEWER_CONNECTIONS};
pub use state::ViewerConfig;
pub use viewer::{Serving, Viewer};

/// The port on which the page is, unless told otherwise.
pub const DEFAULT_VIEWER_PORT: u16 = 6575;

/// The code in the README of this crate runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
