//! The document of an exported page: the page with its scripts and styles in one HTML file.

use std::collections::BTreeMap;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use mmsim_drawing::stylesheet;
use sha2::{Digest, Sha256};

use crate::api_error::ApiError;
use crate::assets;

/// The script that runs the page.
const MAIN: &str = "import \"page.js\";";

/// Returns the parts of the document before and after the data.
pub(super) fn parts(title: &str) -> Result<(String, String), ApiError> {
    let (modules, main) = (import_map(), MAIN);
    let styles = [stylesheet(), assets::file("page.css").to_string()];
    let scripts = [&modules, main].map(|script| hash(script)).join(" ");
    let style_hashes = styles.each_ref().map(|style| hash(style)).join(" ");
    // The modules are data URLs, whose hashes browsers do not check.
    let policy = format!(
        "default-src 'none'; script-src {scripts} data:; style-src {style_hashes}; img-src data:; \
         base-uri 'none'; form-action 'none'"
    );
    let version = env!("CARGO_PKG_VERSION");
    let mut page = assets::file("index.html").to_string();
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
            format!(
                "<script type=\"importmap\">{modules}</script>\n<script type=\"module\">{main}</script>"
            ),
        ),
    ] {
        page = replace(&page, old, &new)?;
    }
    let (head, tail) = page.split_at(page.rfind("</body>").unwrap_or(page.len()));
    Ok((head.into(), tail.into()))
}

/// Returns a map from the name of each script to its content as a data URL. Scripts in data URLs
/// cannot import other scripts by relative paths, but they can import them by the names in the map.
fn import_map() -> String {
    let scripts = assets::FILES.iter().filter(|(name, ..)| name.ends_with(".js"));
    let modules: BTreeMap<&str, String> = scripts
        .map(|&(name, _, content)| {
            let encoded = BASE64_STANDARD.encode(content.replace(" from \"./", " from \""));
            (name, format!("data:text/javascript;base64,{encoded}"))
        })
        .collect();
    serde_json::json!({ "imports": modules }).to_string()
}

/// Returns the source expression of a content security policy that allows a script or style.
fn hash(content: &str) -> String {
    format!("'sha256-{}'", BASE64_STANDARD.encode(Sha256::digest(content)))
}

/// Replaces the only occurrence of `old`.
fn replace(page: &str, old: &str, new: &str) -> Result<String, ApiError> {
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
