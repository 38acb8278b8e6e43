//! Progress bars.

use std::io;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};

use crate::output::is_quiet;
use crate::terminal::can_redraw;

/// The time between two updates of a bar on which nothing else happens.
const TICK: Duration = Duration::from_millis(100);

/// Shows a progress bar on stderr until it is dropped, if stderr is a terminal and `--quiet` is not
/// set. `text` is the template of the text beside the bar. Work of unknown length has only a text.
pub(crate) fn progress_bar(length: Option<u64>, text: &str) -> ProgressBar {
    let is_shown = can_redraw(&io::stderr()) && !is_quiet();
    let target = if is_shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = if length.is_some() { "{wide_bar} " } else { "" };
    let style = ProgressStyle::with_template(&format!("{bar}{text}"));
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("█░");
    let progress = ProgressBar::with_draw_target(length, target)
        .with_style(style)
        .with_finish(ProgressFinish::AndClear);
    if is_shown {
        progress.enable_steady_tick(TICK);
    }
    progress
}
