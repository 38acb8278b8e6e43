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

mod app;
mod export;
mod http;
mod live;
mod source;

pub use app::ViewerConfig;
pub use export::export_html;
pub use http::limits::{Limits, MAX_VIEWER_CONNECTIONS};
pub use http::{Viewer, ViewerHandle, routes};
pub use source::fast_runs::{SameName, Vehicles};

/// The default port on which the page is served.
pub const DEFAULT_VIEWER_PORT: u16 = 6575;

/// Compiles and runs the example in the README of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
