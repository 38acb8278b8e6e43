//! What is to be said against a maze file.

use mmsim_formats::{Location, ParseError, ParseErrorKind, ParsedMaze};
use mmsim_maze::{Cell, CellSet, Escaped};
use mmsim_solvers::Distances;
use serde::Serialize;

use crate::output::counted;

/// Something to be said against a maze file. The names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Finding {
    pub(super) severity: Severity,
    kind: Kind,
    message: String,
    line: Option<usize>,
    column: Option<usize>,
    byte: Option<usize>,
    cell: Option<[u8; 2]>,
    /// The place as it is told where there are many.
    #[serde(skip)]
    place: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Severity {
    Error,
    Warning,
}

/// In the order in which they are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Unreadable,
    Contradiction,
    OpenPerimeter,
    GoalUnreachable,
    Ambiguous,
    UnknownWalls,
    PostsWithoutWall,
    UnreachableCells,
    Duplicate,
}

impl Finding {
    /// A file of which nothing can be read.
    pub(super) fn unreadable(message: String) -> Self {
        let (severity, kind, place) = (Severity::Error, Kind::Unreadable, String::new());
        let (line, column, byte, cell) = (None, None, None, None);
        Self { severity, kind, message, line, column, byte, cell, place }
    }

    pub(super) fn from_error(error: &ParseError) -> Self {
        let kind = match error.kind {
            ParseErrorKind::Contradiction => Kind::Contradiction,
            ParseErrorKind::OpenPerimeter => Kind::OpenPerimeter,
            _ => Kind::Unreadable,
        };
        let cell = error.cell.map(|cell| [cell.x, cell.y]);
        let found = Self { kind, cell, ..Self::unreadable(error.to_string()) };
        found.at_place(error.location)
    }

    /// A maze that another file holds as well.
    pub(super) fn duplicate(path: &str) -> Self {
        let message = format!("the same walls, start and goal as {path}");
        Self { severity: Severity::Warning, kind: Kind::Duplicate, ..Self::unreadable(message) }
    }

    /// What is to be said against a maze and what its reader took for granted.
    pub(super) fn from_reading(reading: &ParsedMaze) -> Vec<Self> {
        let ParsedMaze { maze, unknown_walls, ambiguous_encoding, .. } = reading;
        let start = maze.start().cell;
        let from_start: CellSet = [start].into_iter().collect();
        let distances = Distances::flood(maze.walls(), &from_start);
        let is_cut_off = |cell: &Cell| distances.at(*cell).is_none();
        let mut findings = Vec::new();
        if maze.goals().iter().all(|goal| is_cut_off(&goal))
            && let Some(goal) = maze.goals().iter().next()
        {
            let message = format!("no way leads from the start {start} to the goal {goal}");
            let finding = Self { kind: Kind::GoalUnreachable, ..Self::unreadable(message) };
            findings.push(finding.at_cell(goal));
        }
        let warning =
            |kind, message| Self { severity: Severity::Warning, kind, ..Self::unreadable(message) };
        findings
            .extend(ambiguous_encoding.iter().map(|way| warning(Kind::Ambiguous, ambiguity(way))));
        findings.extend(unknown_walls.iter().map(|&place| {
            let message = format!("{place}: an unknown wall, taken as open");
            warning(Kind::UnknownWalls, message).at_place(place)
        }));
        findings.extend(maze.posts_without_wall().map(|cell| {
            let message = format!("no wall touches the post south-west of {cell}");
            warning(Kind::PostsWithoutWall, message).at_cell(cell)
        }));
        findings.extend(maze.size().cells().filter(is_cut_off).map(|cell| {
            let message = format!("the cell {cell} cannot be reached");
            warning(Kind::UnreachableCells, message).at_cell(cell)
        }));
        findings
    }

    fn at_cell(self, cell: Cell) -> Self {
        Self { cell: Some([cell.x, cell.y]), place: cell.to_string(), ..self }
    }

    fn at_place(self, place: Location) -> Self {
        let (line, column, byte) = match place {
            Location::Text { line, column } => (Some(line), Some(column), None),
            Location::Byte(byte) => (None, None, Some(byte)),
            _ => (None, None, None),
        };
        Self { line, column, byte, place: place.to_string(), ..self }
    }
}

/// That other mazes fit a file as well, which was read in this way.
pub(super) fn ambiguity(way: &str) -> String {
    format!("other mazes fit these digits too; taken is: {way}")
}

/// A line for each finding, but one for all of a kind.
pub(super) fn lines(findings: &[Finding]) -> String {
    let mut findings = findings.to_vec();
    findings.sort_by_key(|finding| finding.kind);
    let same_kind = |a: &Finding, b: &Finding| a.kind == b.kind;
    let line = |group: &[Finding]| match group {
        [] => String::new(),
        [one] => format!("  {}: {}\n", one.severity.name(), Escaped(&one.message)),
        [first, ..] => format!("  {}: {}\n", first.severity.name(), summary(group, first.kind)),
    };
    findings.chunk_by(same_kind).map(line).collect()
}

/// How many there are of a kind, and where the first few are.
fn summary(group: &[Finding], kind: Kind) -> String {
    const SHOWN: usize = 3;
    let count = group.len();
    let what = match kind {
        Kind::PostsWithoutWall => format!("{count} posts that no wall touches, south-west of "),
        Kind::UnreachableCells => format!("{count} cells that cannot be reached: "),
        Kind::UnknownWalls => format!("{count} unknown walls, taken as open, at "),
        Kind::Contradiction => format!("{count} more contradictions, at "),
        Kind::OpenPerimeter => format!("{count} more gaps in the outer wall, at "),
        Kind::Unreadable | Kind::GoalUnreachable | Kind::Ambiguous | Kind::Duplicate => {
            counted(count as u64, "finding") + ": "
        }
    };
    let places: Vec<&str> = group.iter().take(SHOWN).map(|finding| &finding.place[..]).collect();
    let more = match count.saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    what + &places.join("; ") + &more
}

impl Severity {
    const fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
        }
    }
}
