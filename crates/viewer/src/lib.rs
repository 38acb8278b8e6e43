//! A web page for watching a micromouse search. The page shows the maze and the mouse, and has a
//! slider to select any state of the search.
//!
//! [`Viewer`] is a small web server with the page's files built in. An event stream reports the
//! number of states, and the page fetches only the states it draws. A search never waits for a
//! page, and a page can fetch every state.
//!
//! [`export_html`] writes the page of a recording as one HTML file, which needs no server.
//!
//! Other web sites in the same browser can neither read nor control the page. The server requires a
//! token unless it listens on a loopback address.
#![forbid(unsafe_code)]

mod access;
mod api;
mod api_error;
mod app_state;
mod assets;
mod config;
mod events;
mod export;
mod fast_runs;
mod find;
mod jobs;
mod limits;
mod live;
mod log_view;
mod mazes;
mod mouse;
mod mouse_api;
mod page_info;
mod pictures;
mod recording_api;
mod recordings;
mod source;
mod source_info;
mod state_view;
mod stream;
mod transfer;
mod vehicles;
mod viewer;

pub use config::ViewerConfig;
pub use export::export_html;
pub use limits::{Limits, MAX_VIEWER_CONNECTIONS};
pub use vehicles::{SameName, Vehicles};
pub use viewer::{Viewer, ViewerHandle};

/// The default port on which the page is served.
pub const DEFAULT_VIEWER_PORT: u16 = 6575;

/// Compiles and runs the example in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
