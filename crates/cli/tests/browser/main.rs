//! The page in a real browser, against real simulators and real searches.
//!
//! They need Chromium or Chrome and its chromedriver (Debian: chromium, chromium-driver). Without,
//! they say that they are skipped and pass; with `MMSIM_BROWSER=required` they fail.

#[path = "../harness/mod.rs"]
mod harness;

mod browser;
mod drawing;
mod driver;
mod elsewhere;
mod hostile;
mod http;
mod keyboard;
mod live;
mod load;
mod map;
mod mazes;
mod measure;
mod page;
mod policy;
mod recordings;
mod run;
mod simulator;
mod timeline;
mod told;
