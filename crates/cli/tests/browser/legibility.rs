//! Long numbers, contrast themes, and what screen readers and the keyboard find.

use mmsim_solvers::BundledStrategy;
use mmsim_tests::wait_for;
use serde_json::json;

use crate::browser::{Browser, with_browser, with_page};
use crate::layout::{LAPTOP, PHONE, SMALL, resize};
use crate::page::Panel;
use crate::simulator::{Simulator, bundled};

/// A script that makes the figures of each state as long as they can be.
const LONG_NUMBERS: &str = "
    const original = window.fetch;
    window.fetch = async (url, ...rest) => {
        const response = await original(url, ...rest);
        if (!String(url).includes('/moment')) return response;
        const { phases, ...view } = await response.json();
        const run = { steps: 999_999, turns: 9_999_999, time_s: 3_599_999, wall_time_s: 3_599_999 };
        for (const name of ['search_run', 'return_run', 'fast_run', 'best_run', 'total']) phases[name] = run;
        return new Response(JSON.stringify({ ...view, phases: { ...phases, fast_runs: 99_999 } }));
    };";

/// Returns the texts of the panel that are cut or that overlap their left neighbour.
fn cut_texts(browser: &Browser) -> Vec<String> {
    let script = "
        const range = new Range();
        const box = (element) => (range.selectNodeContents(element), range.getBoundingClientRect());
        const panel = document.querySelector('.panel');
        const fields = panel.querySelectorAll('.history *, .details *');
        return [...fields].filter((field) => {
            if (field.children.length > 0 || !field.textContent.trim() || !field.checkVisibility()) return false;
            if (field.closest('.announcement, select, .plot')) return false;
            const { left, right } = box(field);
            const before = field.previousElementSibling;
            if (field.tagName === 'TD' && before?.textContent && box(before).right > left) return true;
            for (let area = field; area !== panel; area = area.parentElement) {
                const { overflowX, contain } = getComputedStyle(area);
                const isCut = overflowX !== 'visible' || /strict|content|paint/.test(contain);
                const bounds = area.getBoundingClientRect();
                if (isCut && (left < bounds.left - 1 || right > bounds.right + 1)) return true;
            }
            return false;
        }).map((field) => field.outerHTML);";
    browser.run(script, &[])
}

#[test]
fn long_numbers_are_shown_whole() {
    with_browser(|browser| {
        let source = json!({ "source": LONG_NUMBERS });
        browser.devtools("Page.addScriptToEvaluateOnNewDocument", &source);
        let simulator = Simulator::start(&["harbour"]);
        browser.open(&simulator.page);
        let live = Panel::live(browser);
        let states = simulator.search(&bundled("01-harbour.txt"), BundledStrategy::FloodFill);
        live.wait_for_state(states.len() - 1);
        assert_eq!([".steps dd", ".turns dd"].map(|it| live.text(it)), ["999,999", "10M"]);
        assert_eq!(live.text(".fast-run th"), "Fast run 99,999");
        for size in [LAPTOP, SMALL, PHONE] {
            resize(browser, size);
            assert_eq!(cut_texts(browser), [""; 0], "{size:?}");
        }
        browser.leave();
    });
}

#[test]
fn weights_are_hidden_in_cells_that_are_too_small() {
    with_page(&["old-quarter"], |browser, simulator| {
        let live = Panel::live(browser);
        let states =
            simulator.search(&bundled("half-size-old-quarter.txt"), BundledStrategy::FloodFill);
        live.wait_for_state(states.len() - 1);
        let script = "return getComputedStyle(document.querySelector(arguments[0])).display";
        let wait_for_display = |expected: &str| {
            let display = || browser.run::<String>(script, &[json!(live.part(".map .numbers"))]);
            wait_for(expected, || (display() == expected).then_some(()));
        };
        resize(browser, PHONE);
        wait_for_display("none");
        (0..3).for_each(|_| live.click("[name=zoom-in]"));
        wait_for_display("inline");
    });
}

/// A contrast theme of Windows replaces most colours.
#[test]
fn a_contrast_theme_hides_no_control() {
    with_page(&["harbour"], |browser, simulator| {
        let live = Panel::live(browser);
        let states = simulator.search(&bundled("01-harbour.txt"), BundledStrategy::FloodFill);
        live.wait_for_state(states.len() - 1);
        let theme = json!({ "features": [{ "name": "forced-colors", "value": "active" }] });
        browser.devtools("Emulation.setEmulatedMedia", &theme);
        // Each pair must look different.
        let script = "
            const style = (selector, part) => getComputedStyle(document.querySelector(selector), part);
            const canvas = style('body').backgroundColor;
            return [
                ['slider', style('.slider input').backgroundImage, 'none'],
                ['cursor', style('.axis .cursor').backgroundColor, canvas],
                ['distances', ...['optimistic', 'pessimistic'].map((name) => style(`.bounds .${name} dt`, '::before').borderTopColor)],
                ['curves', ...['optimistic', 'pessimistic'].map((name) => style(`.plot .${name}`).stroke)],
                ['pressed', ...['follow', 'play'].map((name) => style(`.controls [name=${name}]`).backgroundColor)],
                ['text of Run', style('[name=run]').color, style('[name=run]').backgroundColor],
            ].filter(([, one, other]) => one === other).map(([name]) => name);";
        let is_active = "return matchMedia('(forced-colors: active)').matches";
        wait_for("the theme", || browser.run::<bool>(is_active, &[]).then_some(()));
        assert_eq!(browser.run::<Vec<String>>(script, &[]), [""; 0]);
        browser.devtools("Emulation.setEmulatedMedia", &json!({ "features": [] }));
    });
}

#[test]
fn headings_have_text_and_scrolled_areas_receive_the_focus() {
    with_page(&["harbour"], |browser, simulator| {
        let live = Panel::live(browser);
        live.wait_until_empty();
        live.click("[name=legend]");
        let script = "
            const seen = [...document.querySelectorAll('*')].filter((element) => element.checkVisibility());
            const nothing = seen.filter((element) => element.matches('h1, h2, h3, th') && !element.textContent.trim());
            const scrolled = seen.filter((element) => /auto|scroll/.test(getComputedStyle(element).overflowY)
                && element.scrollHeight > element.clientHeight
                && ![element, ...element.querySelectorAll('*')].some(({ tabIndex }) => tabIndex >= 0));
            return [...nothing, ...scrolled].map((element) => element.outerHTML.slice(0, 80));";
        let faults = || browser.run::<Vec<String>>(script, &[]);
        assert_eq!(faults(), [""; 0]);
        let states = simulator.search(&bundled("01-harbour.txt"), BundledStrategy::FloodFill);
        live.wait_for_state(states.len() - 1);
        for size in [(1280, 400), PHONE] {
            resize(browser, size);
            assert_eq!(faults(), [""; 0], "{size:?}");
        }
    });
}
