//! `mmsim mazes check`: find problems in maze files.

use std::error::Error;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser};
use mmsim_formats::{
    Encoding, Entry, Location, Note, NoteKind, ParseError, ParseErrorKind, ParsedMaze, ReadError,
};
use mmsim_maze::{Cell, Escaped, Maze, Symmetry, Wall, counted};
use mmsim_solvers::{MazeFacts, MazeRules, MazeViolation};
use serde::Serialize;

use super::EncodingArgs;
use super::index::{MazeIndex, real_path};
use super::row::MazeRow;
use crate::args::{CommandResult, one_of};
use crate::grid::wrapped;
use crate::output::{drawn_readings, print_report};
use crate::selection::{MAZES_HELP, Selection};

/// A maze file and the problems found in it. The field names are JSON keys.
#[derive(Serialize)]
struct Checked {
    #[serde(flatten)]
    row: MazeRow,
    notation: Option<&'static str>,
    findings: Vec<Finding>,
    /// The mazes that the file could mean, drawn as text.
    #[serde(skip)]
    drawn_readings: String,
}

#[derive(Debug, Args)]
pub(super) struct CheckArgs {
    #[arg(
        required = true,
        value_name = "MAZE",
        help = format!("{MAZES_HELP}; hidden files, and files that look like no maze, are skipped \
                        in folders")
    )]
    mazes: Vec<PathBuf>,
    #[command(flatten)]
    encoding: EncodingArgs,
    /// Contest rules for walls, start and goal [default: classic for square mazes of 5x5 to 16x16
    /// cells, half-size for larger square mazes; for all other mazes, only posts without a wall and
    /// unreachable cells are reported]
    #[arg(long, value_parser = rules())]
    rules: Option<Rules>,
    /// Exit with code 1 if there are warnings, too
    #[arg(long)]
    strict: bool,
    /// Print a JSON array
    #[arg(long)]
    json: bool,
}

/// The contest rules for a maze, or `None` for no rules.
type Rules = Option<MazeRules>;

fn rules() -> impl TypedValueParser<Value = Rules> {
    const NAMES: [(Rules, &str, &str); 3] = [
        (Some(MazeRules::Classic), "classic", "central goal with one entrance"),
        (Some(MazeRules::HalfSize), "half-size", "rectangular goal anywhere"),
        (None, "none", "no contest rules, for training mazes"),
    ];
    one_of(NAMES, |(_, name, help)| PossibleValue::new(name).help(help)).map(|(rules, ..)| rules)
}

pub(super) fn run(args: &CheckArgs) -> CommandResult {
    let mut seen = MazeIndex::default();
    let mut files = Vec::new();
    for maze in &args.mazes {
        let selection = Selection::encoded(maze.as_os_str(), args.encoding.choice());
        match selection.and_then(|selection| selection.matching()) {
            Ok(entries) => {
                files.extend(entries.iter().map(|entry| Checked::new(entry, args, &mut seen)));
            }
            Err(error) => files.push(Checked::unread(maze, &error)),
        }
    }
    print_report(args.json, &files, || files.iter().map(Checked::text).collect())?;
    let mut findings = files.iter().flat_map(|file| &file.findings);
    Ok(!findings.any(|it| it.severity == "error" || args.strict && it.severity == "warning"))
}

impl Checked {
    /// Checks a file. `seen` contains each maze found so far, with the first file that contains it.
    fn new(entry: &Entry, args: &CheckArgs, seen: &mut MazeIndex) -> Self {
        let path = entry.path();
        let parsed = match entry.parsed() {
            Ok(parsed) => parsed,
            Err(error) => return Self::unread(path, error),
        };
        let row = MazeRow::from_maze(path, &parsed.maze);
        let mut findings = Finding::from_parsed(parsed, args.rules);
        let mut equal = seen.find(&parsed.maze).into_iter();
        match equal.find(|first| first.same_start && first.same_goals) {
            Some(first) if real_path(first.path) == real_path(path) => {}
            Some(first) => findings.push(Finding::duplicate(first.path, first.symmetry)),
            None => seen.add(path, &parsed.maze),
        }
        let notation = Some(parsed.notation.name());
        Self { row, notation, findings, drawn_readings: String::new() }
    }

    /// Returns the result for a file or folder that cannot be read.
    fn unread(path: &Path, error: &(dyn Error + 'static)) -> Self {
        let findings = match error.downcast_ref() {
            Some(ReadError::Parse { errors, .. }) => {
                errors.iter().map(Finding::from_error).collect()
            }
            _ => vec![Finding::new(FindingKind::Unreadable, error.to_string())],
        };
        let row = MazeRow::from_error(path, &error);
        Self { row, notation: None, findings, drawn_readings: drawn_readings(error) }
    }

    /// Formats one line with the properties of the maze, or with the first error if the file cannot
    /// be read. The remaining findings follow, one line per kind, and the readings of an ambiguous
    /// file.
    fn text(&self) -> String {
        let printed = usize::from(self.row.error.is_some()).min(self.findings.len());
        let findings = finding_lines(&self.findings[printed..]);
        format!("{}\n{findings}{}", self.row.line(), self.drawn_readings)
    }
}

/// A problem in a maze file. The field names are JSON keys.
#[derive(Clone, Debug, Serialize)]
struct Finding {
    severity: &'static str,
    kind: FindingKind,
    message: String,
    line: Option<usize>,
    column: Option<usize>,
    byte: Option<usize>,
    cell: Option<[u8; 2]>,
    /// The mazes that an ambiguous file could mean.
    readings: Vec<ReadingRow>,
    /// The position of the problem as text, for a line that summarizes several findings.
    #[serde(skip)]
    place: String,
}

/// A maze that an ambiguous file could mean, and the options that select it. The field names are JSON
/// keys.
#[derive(Clone, Debug, Serialize)]
struct ReadingRow {
    bits: String,
    rows: String,
    drawing: String,
}

impl ReadingRow {
    fn new(ParsedMaze { encodings, maze, .. }: &ParsedMaze) -> Self {
        let Encoding { bits, rows } = encodings[0];
        Self { bits: bits.to_string(), rows: rows.to_string(), drawing: maze.to_string() }
    }
}

/// The kinds of problems in a maze file. Findings are printed in the order of these variants,
/// errors first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
enum FindingKind {
    Unreadable,
    Contradiction,
    OpenPerimeter,
    Ambiguous,
    GoalUnreachable,
    UnknownWalls,
    StartNotInCorner,
    StartNotClosed,
    GoalNotCentral,
    GoalNotRectangular,
    GoalEntrances,
    WallsInGoal,
    GoalOnWallFollowerPath,
    PostsWithoutWall,
    UnreachableCells,
    Duplicate,
    Path,
    Ignored,
}

impl FindingKind {
    fn is_error(self) -> bool {
        self <= Self::GoalUnreachable
    }
}

impl Finding {
    fn new(kind: FindingKind, message: String) -> Self {
        let severity = match kind {
            _ if kind.is_error() => "error",
            FindingKind::Path | FindingKind::Ignored => "note",
            _ => "warning",
        };
        let (line, column, byte, cell) = (None, None, None, None);
        let (readings, place) = (Vec::new(), String::new());
        Self { severity, kind, message, line, column, byte, cell, readings, place }
    }

    fn from_error(error: &ParseError) -> Self {
        let kind = match error.kind {
            ParseErrorKind::Contradiction => FindingKind::Contradiction,
            ParseErrorKind::OpenPerimeter => FindingKind::OpenPerimeter,
            ParseErrorKind::Ambiguous => FindingKind::Ambiguous,
            _ => FindingKind::Unreadable,
        };
        let cell = error.cell.map(|cell| [cell.x, cell.y]);
        let readings = error.readings.iter().map(ReadingRow::new).collect();
        Self { cell, readings, ..Self::new(kind, error.to_string()).at_place(error.location) }
    }

    /// Returns the finding for a maze that is also in an earlier file, after a transformation.
    fn duplicate(path: &Path, symmetry: Symmetry) -> Self {
        let of = format!("the same walls, start and goal as {}", path.display());
        let message = match symmetry {
            Symmetry::Identity => of,
            _ => format!("{symmetry}, the maze has {of}"),
        };
        Self::new(FindingKind::Duplicate, message)
    }

    /// Returns the problems in a maze and the notes about its file. Without `rules`, the size of the
    /// maze selects the contest rules.
    fn from_parsed(ParsedMaze { maze, notes, .. }: &ParsedMaze, rules: Option<Rules>) -> Vec<Self> {
        let mut findings: Vec<Self> = notes.iter().map(Self::from_note).collect();
        if MazeFacts::new(maze).shortest_path.is_none()
            && let Some(goal) = maze.goals().iter().next()
        {
            let message = format!("goal {goal} unreachable from the start {}", maze.start().cell);
            findings.push(Self::new(FindingKind::GoalUnreachable, message).at_cell(goal));
        }
        let rules = rules.unwrap_or_else(|| Some(MazeRules::for_size(maze.size())));
        let violations = rules.map(|rules| rules.violations(maze)).unwrap_or_default();
        findings.extend(violations.iter().map(|violation| Self::from_violation(violation, maze)));
        findings
    }

    fn from_note(note: &Note) -> Self {
        let kind = match note.kind {
            NoteKind::UnknownWall => FindingKind::UnknownWalls,
            NoteKind::Path => FindingKind::Path,
            _ => FindingKind::Ignored,
        };
        Self::new(kind, note.to_string()).at_place(note.location)
    }

    fn from_violation(violation: &MazeViolation, maze: &Maze) -> Self {
        let start = Some(maze.start().cell);
        let (kind, cell) = match *violation {
            MazeViolation::StartNotInCorner => (FindingKind::StartNotInCorner, start),
            MazeViolation::StartNotClosed(_) => (FindingKind::StartNotClosed, start),
            MazeViolation::GoalNotCentral => (FindingKind::GoalNotCentral, None),
            MazeViolation::GoalNotRectangular => (FindingKind::GoalNotRectangular, None),
            MazeViolation::GoalEntrances(_) => (FindingKind::GoalEntrances, None),
            MazeViolation::WallInGoal(Wall { cell, .. }) => (FindingKind::WallsInGoal, Some(cell)),
            MazeViolation::GoalOnWallFollowerPath => (FindingKind::GoalOnWallFollowerPath, None),
            MazeViolation::PostWithoutWall(cell) => (FindingKind::PostsWithoutWall, Some(cell)),
            MazeViolation::UnreachableCell(cell) => (FindingKind::UnreachableCells, Some(cell)),
        };
        let finding = Self::new(kind, violation.to_string());
        match cell {
            Some(cell) => finding.at_cell(cell),
            None => finding,
        }
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

/// Formats the findings, one line per kind.
fn finding_lines(findings: &[Finding]) -> String {
    let mut findings = findings.to_vec();
    findings.sort_by_key(|finding| finding.kind);
    let same_kind = |a: &Finding, b: &Finding| a.kind == b.kind;
    let line = |group: &[Finding]| match group {
        [] => String::new(),
        [one] => format!("  {}: {}", one.severity, Escaped(&one.message)),
        [first, ..] => format!("  {}: {}", first.severity, summary(group, first.kind)),
    };
    findings.chunk_by(same_kind).map(|group| wrapped(&line(group), " ", 4) + "\n").collect()
}

/// Formats the number of findings of one kind, and the positions of the first three.
fn summary(group: &[Finding], kind: FindingKind) -> String {
    const SHOWN: usize = 3;
    let count = group.len();
    let what = match kind {
        FindingKind::PostsWithoutWall => format!("{count} posts without a wall, south-west of "),
        FindingKind::UnreachableCells => format!("{count} unreachable cells: "),
        FindingKind::WallsInGoal => format!("{count} walls inside the goal, at "),
        FindingKind::UnknownWalls => format!("{count} unknown walls, read as open, at "),
        FindingKind::Contradiction => format!("{count} more contradictions, at "),
        FindingKind::OpenPerimeter => format!("{count} more gaps in the outer wall, at "),
        FindingKind::Ignored => format!("{count} ignored texts, at "),
        _ => format!("{}: ", counted(count, "finding")),
    };
    let places: Vec<&str> = group.iter().take(SHOWN).map(|finding| &finding.place[..]).collect();
    let text = what + &places.join("; ");
    if count > SHOWN { format!("{text} and {} more", count - SHOWN) } else { text }
}
