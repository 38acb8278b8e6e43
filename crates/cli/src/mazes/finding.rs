//! Problems in a maze file.

use mmsim_formats::{Location, ParseError, ParseErrorKind, ParsedMaze};
use mmsim_maze::{Cell, CellSet, Escaped, counted};
use mmsim_solvers::Distances;
use serde::Serialize;

/// A problem in a maze file. The field names are JSON keys.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Finding {
    severity: &'static str,
    kind: FindingKind,
    message: String,
    line: Option<usize>,
    column: Option<usize>,
    byte: Option<usize>,
    cell: Option<[u8; 2]>,
    /// The position of the problem as text, for a line that summarizes several findings.
    #[serde(skip)]
    place: String,
}

/// The kinds of problems in a maze file. Findings are printed in the order of these variants,
/// errors first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
enum FindingKind {
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

impl FindingKind {
    fn is_error(self) -> bool {
        self <= Self::GoalUnreachable
    }
}

impl Finding {
    fn new(kind: FindingKind, message: String) -> Self {
        let severity = if kind.is_error() { "error" } else { "warning" };
        let (line, column, byte, cell, place) = (None, None, None, None, String::new());
        Self { severity, kind, message, line, column, byte, cell, place }
    }

    /// Returns the finding for an unreadable file.
    pub(super) fn unreadable(message: String) -> Self {
        Self::new(FindingKind::Unreadable, message)
    }

    pub(super) fn is_error(&self) -> bool {
        self.kind.is_error()
    }

    pub(super) fn from_error(error: &ParseError) -> Self {
        let kind = match error.kind {
            ParseErrorKind::Contradiction => FindingKind::Contradiction,
            ParseErrorKind::OpenPerimeter => FindingKind::OpenPerimeter,
            _ => FindingKind::Unreadable,
        };
        let cell = error.cell.map(|cell| [cell.x, cell.y]);
        Self { cell, ..Self::new(kind, error.to_string()).at_place(error.location) }
    }

    /// Returns the finding for a maze that is also in an earlier file.
    pub(super) fn duplicate(path: &str) -> Self {
        let message = format!("the same walls, start and goal as {path}");
        Self::new(FindingKind::Duplicate, message)
    }

    /// Returns the problems in a maze and the assumptions made when reading it.
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
            let message = format!("goal {goal} unreachable from the start {start}");
            findings.push(Self::new(FindingKind::GoalUnreachable, message).at_cell(goal));
        }
        findings.extend(
            ambiguous_encoding.iter().map(|way| Self::new(FindingKind::Ambiguous, ambiguity(way))),
        );
        findings.extend(unknown_walls.iter().map(|&place| {
            let message = format!("{place}: unknown wall, assumed open");
            Self::new(FindingKind::UnknownWalls, message).at_place(place)
        }));
        findings.extend(maze.posts_without_wall().map(|cell| {
            let message = format!("no wall touches the post south-west of {cell}");
            Self::new(FindingKind::PostsWithoutWall, message).at_cell(cell)
        }));
        findings.extend(maze.size().cells().filter(is_cut_off).map(|cell| {
            let message = format!("cell {cell} is unreachable");
            Self::new(FindingKind::UnreachableCells, message).at_cell(cell)
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

/// Returns the message for a file whose encoding is ambiguous.
pub(super) fn ambiguity(way: &str) -> String {
    format!("the digits fit more than one maze; read as: {way}")
}

/// Formats the findings, one line per kind.
pub(super) fn lines(findings: &[Finding]) -> String {
    let mut findings = findings.to_vec();
    findings.sort_by_key(|finding| finding.kind);
    let same_kind = |a: &Finding, b: &Finding| a.kind == b.kind;
    let line = |group: &[Finding]| match group {
        [] => String::new(),
        [one] => format!("  {}: {}\n", one.severity, Escaped(&one.message)),
        [first, ..] => format!("  {}: {}\n", first.severity, summary(group, first.kind)),
    };
    findings.chunk_by(same_kind).map(line).collect()
}

/// Formats the number of findings of one kind, and the positions of the first three.
fn summary(group: &[Finding], kind: FindingKind) -> String {
    const SHOWN: usize = 3;
    let count = group.len();
    let what = match kind {
        FindingKind::PostsWithoutWall => format!("{count} posts without a wall, south-west of "),
        FindingKind::UnreachableCells => format!("{count} unreachable cells: "),
        FindingKind::UnknownWalls => format!("{count} unknown walls, assumed open, at "),
        FindingKind::Contradiction => format!("{count} more contradictions, at "),
        FindingKind::OpenPerimeter => format!("{count} more gaps in the outer wall, at "),
        FindingKind::Unreadable
        | FindingKind::GoalUnreachable
        | FindingKind::Ambiguous
        | FindingKind::Duplicate => format!("{}: ", counted(count, "finding")),
    };
    let places: Vec<&str> = group.iter().take(SHOWN).map(|finding| &finding.place[..]).collect();
    let text = what + &places.join("; ");
    if count > SHOWN { format!("{text} and {} more", count - SHOWN) } else { text }
}
