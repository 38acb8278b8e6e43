//! The embedded files of the page, served one by one or as the document of an exported page: the page
//! with its scripts and styles in one HTML file.

use std::fmt::Write as _;

use axum::Router;
use axum::http::header;
use axum::routing::{MethodRouter, get};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use mmsim_drawing::{page_json, stylesheet};
use ring::digest::{SHA256, digest};
use tower_http::compression::CompressionLayer;

use crate::http::jobs::{ApiError, ApiResult};

/// Expands to a list with the name, media type and content of each file.
macro_rules! files {
    ($($media_type:ident: $($name:literal),+;)+) => {
        &[$($(($name, $media_type, include_str!(concat!("../../page/", $name)))),+),+]
    };
}

const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";
const JSON: &str = "application/json";
const HTML: &str = "text/html; charset=utf-8";

/// The name, media type and content of each file.
const FILES: &[(&str, &str, &str)] = files! {
    HTML: "index.html";
    STYLE: "page.css";
    SCRIPT:
        "annotations.js",
        "api.js",
        "axis.js",
        "chart.js",
        "compare_bar.js",
        "dom.js",
        "embedded.js",
        "events.js",
        "events_worker.js",
        "fast_run.js",
        "fast_run_chart.js",
        "fast_run_map.js",
        "fast_run_player.js",
        "figures.js",
        "ghost.js",
        "link.js",
        "log.js",
        "map.js",
        "marks.js",
        "mazes.js",
        "overview.js",
        "page.js",
        "panel.js",
        "recordings.js",
        "run.js",
        "state.js",
        "timeline.js",
        "trajectory.js",
        "viewport.js";
};

/// Returns the content of a file, or an empty text if there is no file with this name.
fn file(name: &str) -> &'static str {
    FILES.iter().find(|file| file.0 == name).map_or("", |file| file.2)
}

/// Serves the files of the page, compressed if the client accepts it.
pub(crate) fn router<S: Clone + Send + Sync + 'static>() -> Router<S> {
    let add = |router: Router<S>, (path, methods): (String, _)| router.route(&path, methods);
    routes().fold(Router::new(), add).layer(CompressionLayer::new())
}

/// Returns the paths of the files.
pub(crate) fn paths() -> impl Iterator<Item = String> {
    routes::<()>().map(|(path, _)| path)
}

/// Returns the paths of the files and their handlers.
fn routes<S: Clone + Send + Sync + 'static>() -> impl Iterator<Item = (String, MethodRouter<S>)> {
    let files = FILES.iter().map(|&(name, media_type, content)| {
        let path = if name == "index.html" { "/".into() } else { format!("/{name}") };
        (path, get(move || async move { ([(header::CONTENT_TYPE, media_type)], content) }))
    });
    files.chain([
        ("/drawing.css".into(), get(|| async { ([(header::CONTENT_TYPE, STYLE)], stylesheet()) })),
        ("/drawing.json".into(), get(|| async { ([(header::CONTENT_TYPE, JSON)], page_json()) })),
    ])
}

/// Returns the parts of the document before and after the data.
pub(crate) fn document(title: &str) -> ApiResult<(String, String)> {
    let script = bundle();
    let styles = [stylesheet(), file("page.css").to_string()];
    let style_hashes = styles.each_ref().map(|style| hash(style)).join(" ");
    let policy = format!(
        "default-src 'none'; script-src {}; style-src {style_hashes}; img-src data:; \
         base-uri 'none'; form-action 'none'",
        hash(&script)
    );
    let version = env!("CARGO_PKG_VERSION");
    let mut page = file("index.html").to_string();
    for (old, new) in [
        ("<html lang=\"en\">", "<html lang=\"en\" class=\"exported\">".to_string()),
        (
            "<title>mmsim</title>",
            format!(
                "<meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
                 <meta name=\"generator\" content=\"mmsim {version}\">\n<title>{}</title>",
                escape(title)
            ),
        ),
        (
            "<link rel=\"stylesheet\" href=\"/drawing.css\">",
            format!("<style>{}</style>", styles[0]),
        ),
        ("<link rel=\"stylesheet\" href=\"/page.css\">", format!("<style>{}</style>", styles[1])),
        (
            "<script type=\"module\" src=\"/page.js\"></script>",
            format!("<script type=\"module\">{script}</script>"),
        ),
        (">Connecting…<", ">Opening… (this page needs JavaScript)<".to_string()),
    ] {
        page = replace(&page, old, &new)?;
    }
    let (head, tail) = page.split_at(page.rfind("</body>").unwrap_or(page.len()));
    Ok((head.into(), tail.into()))
}

/// Returns the modules of the page as one script. Each module is a block that copies its exports to an
/// object, and follows the modules that it imports.
fn bundle() -> String {
    let mut script = String::new();
    bundle_module("page.js", &mut Vec::new(), &mut script);
    script
}

/// Appends a module and the modules that it imports to a script, except those that were `added` before.
fn bundle_module<'a>(name: &'a str, added: &mut Vec<&'a str>, script: &mut String) {
    if added.contains(&name) {
        return;
    }
    added.push(name);
    let object = |name: &str| name.replace('.', "_");
    let (mut block, mut exports) = (String::new(), Vec::new());
    for line in file(name).lines() {
        let import = line.strip_prefix("import ").and_then(|line| line.split_once(" from \"./"));
        if let Some((names, module)) = import {
            let module = module.trim_end_matches("\";");
            bundle_module(module, added, script);
            let names = names.trim_start_matches("* as ").replace(" as ", ": ");
            let _ = writeln!(block, "const {names} = {};", object(module));
            continue;
        }
        let declaration = line.strip_prefix("export ");
        let mut words = declaration.unwrap_or_default().split([' ', '(']);
        exports
            .extend(words.find(|word| !["", "async", "function", "class", "const"].contains(word)));
        block += declaration.unwrap_or(line);
        block.push('\n');
    }
    let (name, exports) = (object(name), exports.join(", "));
    let exports = format!("Object.assign({name}, {{ {exports} }});");
    let _ = writeln!(script, "const {name} = {{}};\n{{\n{block}{exports}\n}}");
}

/// Returns the source expression of a content security policy that allows a script or style.
fn hash(content: &str) -> String {
    format!("'sha256-{}'", BASE64_STANDARD.encode(digest(&SHA256, content.as_bytes())))
}

/// Replaces the only occurrence of `old`.
fn replace(page: &str, old: &str, new: &str) -> ApiResult<String> {
    match page.matches(old).count() {
        1 => Ok(page.replace(old, new)),
        count => {
            Err(ApiError::internal(format!("the page contains {old} {count} times, not once")))
        }
    }
}

/// Escapes a text for HTML.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
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

    /// After each change, browsers look for the elements whose `:has()` of descendants it may affect.
    /// That takes longer than drawing a state.
    #[test]
    fn styles_depend_on_children_but_not_on_other_descendants() {
        let mut conditions = file("page.css").split(":has(").skip(1);
        assert!(conditions.all(|condition| condition.starts_with("> ")));
    }

    #[test]
    fn a_script_contains_each_module_after_its_imports() {
        let script = bundle();
        for forbidden in
            ["</script", "<!--", " from \"./", "await import(", "\nexport ", "\nimport "]
        {
            assert!(!script.contains(forbidden), "{forbidden}");
        }
        let mut defined = BTreeSet::new();
        for line in script.lines() {
            if let Some(name) = line.strip_suffix(" = {};").and_then(|it| it.strip_prefix("const "))
            {
                defined.insert(name);
            } else if let Some((_, imported)) = line.rsplit_once(" = ") {
                let imported = imported.trim_end_matches(';');
                assert!(!imported.ends_with("_js") || defined.contains(imported), "{line}");
            }
        }
        // All modules except the worker.
        assert_eq!(defined.len(), FILES.iter().filter(|file| file.1 == SCRIPT).count() - 1);
    }

    #[test]
    fn the_title_is_escaped_and_no_file_is_referenced() {
        let (head, tail) = document("a</title><script>alert(1)</script>&\"").unwrap();
        let title =
            "<title>a&lt;/title&gt;&lt;script&gt;alert(1)&lt;/script&gt;&amp;&quot;</title>";
        assert!(head.contains(title));
        assert!(head.contains(&format!("; script-src {}; ", hash(&bundle()))));
        assert!(!head.contains("alert(1)</script>") && head.ends_with("</dialog>\n"));
        assert_eq!(tail, "</body>\n</html>\n");
        let without_scripts = replace(&head, &bundle(), "").unwrap();
        for reference in ["src=", "href=\"/", "url(", "@import"] {
            assert!(!without_scripts.contains(reference), "{reference}");
        }
    }

    #[test]
    fn only_one_occurrence_is_replaced() {
        assert_eq!(replace("a b c", "b", "x").unwrap(), "a x c");
        let error = replace("a b b", "b", "x").unwrap_err();
        assert_eq!(error.text, "the page contains b 2 times, not once");
    }
}
