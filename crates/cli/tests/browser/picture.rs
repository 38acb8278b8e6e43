//! The picture of the page in the documentation.

use std::path::Path;
use std::{env, fs};

use serde_json::json;

use crate::browser::with_page;
use crate::layout::{LAPTOP, assert_in_sight, resize};
use crate::page::Panel;

/// Set `MMSIM_UPDATE_PICTURES=1` to replace the picture.
#[test]
fn the_picture_of_the_page_shows_the_result_of_a_run() {
    with_page(&["two-roads"], |browser, _| {
        let live = Panel::live(browser);
        live.wait_until_empty();
        resize(browser, LAPTOP);
        let light = json!({ "features": [{ "name": "prefers-color-scheme", "value": "light" }] });
        browser.devtools("Emulation.setEmulatedMedia", &light);
        live.set_pace("no limit");
        live.click(".run [name=run]");
        browser.wait_for_text(&live.part(".outcome:not([hidden]) li:last-child"), "Fast run: ");
        assert_in_sight(browser, live, &[".run [name=run]", ".outcome li:last-child"]);
        resize(browser, (1280, 720));
        let script = "document.querySelector(arguments[0]).scrollIntoView({ block: 'nearest' })";
        browser.run::<()>(script, &[json!(live.part(".outcome"))]);
        assert_in_sight(browser, live, &[".outcome h3", ".outcome li:last-child"]);
        if env::var_os("MMSIM_UPDATE_PICTURES").is_some() {
            let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/page.png");
            fs::write(file, browser.picture()).unwrap();
        }
        browser.devtools("Emulation.setEmulatedMedia", &json!({ "features": [] }));
    });
}
