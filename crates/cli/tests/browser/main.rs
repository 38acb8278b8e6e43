//! Tests of the page in a real browser, with real simulators and searches.
//!
//! The tests need Chromium or Chrome and chromedriver (Debian: chromium, chromium-driver). If the
//! browser or chromedriver is missing, the tests are skipped, or fail if `MMSIM_BROWSER=required`
//! is set.
#![cfg(unix)]

#[path = "../harness/mod.rs"]
mod harness;

mod access;
mod browser;
mod chart;
mod clock;
mod drawing;
mod driver;
mod events;
mod export;
mod fast_run;
mod foreign_site;
mod ghost;
mod http;
mod keyboard;
mod layout;
mod legibility;
mod link;
mod linked;
mod live;
mod load;
mod log;
mod map;
mod mazes;
mod measure;
mod notes;
mod offline;
mod own_mouse;
mod page;
mod phases;
mod picture;
mod policy;
mod recordings;
mod routes;
mod run;
mod side_by_side;
mod simulator;
mod test_state;
mod timeline;
mod trial;
mod viewport;
