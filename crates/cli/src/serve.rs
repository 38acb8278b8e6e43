//! `mmsim`: serve a maze.

use mmsim_server::{Server, Simulation};
use mmsim_solvers::MazeFacts;

use crate::args::ServeArgs;
use crate::interrupt::Interrupt;
use crate::selection::{Collection, Selected};
use crate::{Outcome, counted};

pub(crate) fn run(args: &ServeArgs) -> Outcome {
    let selected = Collection::at(args.mazes.as_deref())?.select(&args.maze.words.join(" "))?;
    let server = bind(&args.host, args.port)?;
    let (interrupt, stop) = (Interrupt::catch()?, server.stop_handle()?);
    eprintln!("{}", announce(&selected, server.address()));
    let mut simulation = Simulation::new(&selected.name, selected.maze);
    std::thread::spawn(move || {
        interrupt.wait();
        stop.stop();
    });
    server.run(&mut simulation)?;
    Ok(true)
}

/// Listens, or says what to try where that fails.
pub(crate) fn bind(host: &str, port: u16) -> Result<Server, String> {
    Server::bind(host, port).map_err(|error| match error {
        mmsim_server::BindError::InUse { .. } => format!("{error} Try another --port"),
        error => error.to_string(),
    })
}

/// What is served and where.
pub(crate) fn announce(selected: &Selected, address: &str) -> String {
    let Selected { path, maze, .. } = selected;
    let goal = match MazeFacts::of(maze).shortest_path {
        Some(steps) => format!("goal {} away", counted(steps, "step")),
        None => "whose goal cannot be reached".into(),
    };
    format!("serving {} ({}, {goal}) at {address}; Ctrl-C ends it", path.display(), maze.size())
}
