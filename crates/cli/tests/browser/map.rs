//! The map shows what the server holds and what a client believes, element by element.

use mmsim_maze::Maze;

use crate::browser::browse;
use crate::page::Panel;
use crate::simulator::{Simulator, bundled};

#[test]
fn every_wall_of_a_maze_is_on_the_map() {
    browse(|browser| {
        let simulator = Simulator::start(&["--maze", "harbour"]);
        let maze: Maze = bundled("01-harbour.txt");
        browser.open(&simulator.page);
        let live = Panel::live(browser);
        live.wait_empty();
        live.assert_shows(&maze, &[]);
    });
}
