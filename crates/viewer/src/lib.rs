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
mod assets;
mod costs;
mod desk;
mod events;
mod limits;
mod mazes;
mod moment;
mod mouse;
mod pictures;
mod recordings;
mod refusal;
mod source;
mod stream;
mod transfer;
mod viewer;
mod work;

pub use desk::Show;
pub use limits::{Limits, MAX_VIEWER_CONNECTIONS};
pub use viewer::{Serving, Viewer};

/// The port on which the page is, unless told otherwise.
pub const DEFAULT_VIEWER_PORT: u16 = 6575;

/// The code in the README of this crate runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
