//! The embedded files of the page.

use axum::Router;
use axum::http::header;
use axum::routing::get;
use mmsim_drawing::{page_json, stylesheet};

/// Expands to a list with the name, media type and content of each file.
macro_rules! files {
    ($($name:literal: $media_type:expr),+ $(,)?) => {
        &[$(($name, $media_type, include_str!(concat!("../../page/", $name)))),+]
    };
}

pub(crate) const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const JSON: &str = "application/json";
const HTML: &str = "text/html; charset=utf-8";

/// The name, media type and content of each file.
pub(crate) const FILES: &[(&str, &str, &str)] = files![
    "annotations.js": SCRIPT,
    "api.js": SCRIPT,
    "axis.js": SCRIPT,
    "chart.js": SCRIPT,
    "compare_bar.js": SCRIPT,
    "dom.js": SCRIPT,
    "embedded.js": SCRIPT,
    "events.js": SCRIPT,
    "fast_run.js": SCRIPT,
    "fast_run_chart.js": SCRIPT,
    "fast_run_map.js": SCRIPT,
    "fast_run_player.js": SCRIPT,
    "figures.js": SCRIPT,
    "ghost.js": SCRIPT,
    "index.html": HTML,
    "link.js": SCRIPT,
    "log.js": SCRIPT,
    "map.js": SCRIPT,
    "marks.js": SCRIPT,
    "mazes.js": SCRIPT,
    "overview.js": SCRIPT,
    "pace.js": SCRIPT,
    "page.css": STYLE,
    "page.js": SCRIPT,
    "panel.js": SCRIPT,
    "recordings.js": SCRIPT,
    "run.js": SCRIPT,
    "state.js": SCRIPT,
    "timeline.js": SCRIPT,
    "trajectory.js": SCRIPT,
    "viewport.js": SCRIPT,
];

/// Returns the content of a file, or an empty text if there is no file with this name.
pub(crate) fn file(name: &str) -> &'static str {
    FILES.iter().find(|file| file.0 == name).map_or("", |file| file.2)
}

/// Serves the files of the page.
pub(crate) fn router<S: Clone + Send + Sync + 'static>() -> Router<S> {
    let router = FILES.iter().fold(Router::new(), |router, &(name, media_type, content)| {
        let path = if name == "index.html" { "/".into() } else { format!("/{name}") };
        router.route(
            &path,
            get(move || async move { ([(header::CONTENT_TYPE, media_type)], content) }),
        )
    });
    router
        .route("/drawing.css", get(|| async { ([(header::CONTENT_TYPE, STYLE)], stylesheet()) }))
        .route("/drawing.json", get(|| async { ([(header::CONTENT_TYPE, JSON)], page_json()) }))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::Path;

    use super::*;

    #[test]
    fn all_files_of_the_page_are_served() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("page");
        let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
        let is_served = |name: &String| name != "tsconfig.json";
        let files: BTreeSet<_> =
            files.map(|name| name.into_string().unwrap()).filter(is_served).collect();
        assert_eq!(FILES.iter().map(|file| file.0.to_string()).collect::<BTreeSet<_>>(), files);
    }
}
