"""The native part of the package. All public names are in `micromouse_sim`."""

from collections.abc import Iterable, Iterator, Sequence
from os import PathLike
from typing import Any, Final, Literal, Union, final, overload

import numpy as np
import numpy.typing as npt
from typing_extensions import disjoint_base

from ._types import Heading, Pose, Walls

_Heading = Union[Heading, Literal["N", "E", "S", "W"]]
_Path = Union[str, PathLike[str]]
_Cell = tuple[int, int]
_Grid = Union[npt.NDArray[np.integer[Any]], Sequence[Sequence[int]]]
_Format = Literal["text", "trial", "maz", "num"]
_Unknown = Literal["open", "closed"]
_Bytes8 = npt.NDArray[np.uint8]
_Distances = npt.NDArray[np.uint16]
_Flags = npt.NDArray[np.bool_]
_Observation = tuple[_Bytes8, _Bytes8, _Bytes8, npt.NDArray[np.int64]]

__all__ = [
    "Client",
    "compare",
    "load_folder",
    "trial",
    "Connection",
    "FastRun",
    "History",
    "State",
    "KnownMaze",
    "Maze",
    "bundled_mazes",
    "flood",
    "Recording",
    "load_recording",
    "Search",
    "SearchBatch",
    "search",
    "Simulator",
    "Strategy",
    "ROBOTS",
    "STRATEGIES",
]

ROBOTS: Final[tuple[str, ...]]
"""The names of the bundled robots of the two-run trial."""
STRATEGIES: Final[tuple[str, ...]]
"""The names of the bundled strategies."""

@final
class Maze:
    """A maze and its name. Mazes with the same cells, walls, start and goal are equal."""

    @staticmethod
    def load(path: _Path, *, bits: str | None = None, rows: str | None = None) -> Maze:
        """Reads a maze file. The format is detected from the content.

        If a file of numbers could mean several mazes, `bits` and `rows` select one, as the options of
        `mmsim mazes convert` do.

        Raises `MazeError` if the content is not a maze, or a subclass of `OSError`.
        """

    @staticmethod
    def parse(
        content: str | bytes,
        name: str = "maze",
        *,
        bits: str | None = None,
        rows: str | None = None,
    ) -> Maze:
        """Reads a maze from the content of a maze file, like `load`."""

    @staticmethod
    def bundled(name: str) -> Maze:
        """Returns the first bundled maze whose name contains every word of `name`."""

    @staticmethod
    def generate(
        seed: int | None = None,
        size: _Cell | None = None,
        style: Literal["contest", "perfect", "open"] = "contest",
    ) -> Maze:
        """Generates a maze, by default of 16x16 cells. The same seed gives the same maze.

        The name contains the seed, which is random by default.
        """

    def save(self, path: _Path, format: _Format | None = None) -> None:
        """Writes a maze file. The extension determines the format: text without one."""

    def write(self, format: _Format = "text") -> bytes:
        """Returns the content of a maze file."""

    @property
    def name(self) -> str:
        """The name of the maze."""

    @property
    def width(self) -> int:
        """The number of cells from west to east."""

    @property
    def height(self) -> int:
        """The number of cells from south to north."""

    @property
    def start(self) -> Pose:
        """The pose in which a mouse starts."""

    @property
    def goals(self) -> tuple[_Cell, ...]:
        """The goal cells."""

    @property
    def walls(self) -> _Bytes8:
        """The walls of each cell: the sum of 2 (east), 4 (south), 8 (west) and 16 (north)."""

    def has_wall(self, x: int, y: int, heading: _Heading) -> bool:
        """Returns true if there is a wall on this side of the cell."""

    def distances(self) -> _Distances:
        """Returns the number of steps from each cell to the goal, or 65535 if there is no path."""

    def shortest_path(self) -> list[_Cell] | None:
        """Returns the cells of a shortest path to the goal, or None if there is none."""

    def fastest_run(self, vehicle: str | None = None) -> FastRun:
        """Plans the fastest run of a vehicle, in seconds.

        `vehicle` is ukmars, ares, expert, kerise, or the path of a TOML file. The default is expert,
        and kerise in mazes larger than 16×16.
        Raises `SearchError` if the goal is unreachable.
        """

    def __eq__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def _repr_svg_(self) -> str: ...

@final
class KnownMaze:
    """The map of a mouse: visited cells, and walls that are present, absent or unknown."""

    def __new__(
        cls,
        size: _Cell | None = None,
        goals: Iterable[_Cell] | None = None,
        start: _Cell | None = None,
    ) -> KnownMaze:
        """Creates the map of an unexplored maze.

        By default, it has 16x16 cells, the start is (0, 0), and the goal is in the centre.
        """

    @staticmethod
    def unexplored(maze: Maze) -> KnownMaze:
        """Creates the map of an unexplored maze with the size, the start and the goal of `maze`."""

    @property
    def width(self) -> int:
        """The number of cells from west to east."""

    @property
    def height(self) -> int:
        """The number of cells from south to north."""

    @property
    def start(self) -> Pose:
        """The pose in which the mouse starts."""

    @property
    def goals(self) -> tuple[_Cell, ...]:
        """The goal cells."""

    @property
    def visited(self) -> tuple[_Cell, ...]:
        """The visited cells, from south to north."""

    @property
    def walls(self) -> _Bytes8:
        """The flags of each cell, as in a state.

        A flag is the sum of 1 (visited) and of 2, 4, 8 and 16 for known walls to the east, south,
        west and north.
        """

    def observe(self, x: int, y: int, heading: _Heading, walls: Walls | Sequence[object]) -> None:
        """Records the walls to the left, ahead and to the right, and marks the cell as visited.

        Raises `Contradiction` if the map contains different walls.
        """

    def wall(self, x: int, y: int, heading: _Heading) -> bool | None:
        """Returns whether there is a wall on this side of the cell, or None if it is unknown."""

    def is_visited(self, x: int, y: int) -> bool:
        """Returns true if the mouse has visited the cell."""

    def is_goal(self, x: int, y: int) -> bool:
        """Returns true if the cell belongs to the goal."""

    def distances(self, unknown: _Unknown = "open") -> _Distances:
        """Returns the number of steps from each cell to the goal, or 65535 if there is no path.

        Unknown walls count as open (optimistic) or as closed (pessimistic).
        """

    def open_poses(self, x: int, y: int, heading: _Heading) -> list[Pose]:
        """Returns the poses after a step through a side that is known to be open.

        The order is front, left, right, back, in which strategies prefer equally good steps.
        """

    @property
    def optimistic_distance(self) -> int | None:
        """The distance from the start to the goal if all unknown walls are open."""

    @property
    def pessimistic_distance(self) -> int | None:
        """The distance from the start to the goal if all unknown walls are closed."""

    @property
    def proven(self) -> bool:
        """True if a path is known, and no unknown wall can hide a shorter one."""

    def copy(self) -> KnownMaze:
        """Returns a copy of the map."""

    def __copy__(self) -> KnownMaze: ...
    def __deepcopy__(self, _memo: object) -> KnownMaze: ...
    def __eq__(self, value: object, /) -> bool: ...
    __hash__: None  # type: ignore[assignment]
    def _repr_svg_(self) -> str: ...

@final
class Strategy:
    """A bundled strategy during one search."""

    def __new__(cls, name: str) -> Strategy:
        """Creates the strategy with this name, which is one of `STRATEGIES`."""

    @property
    def name(self) -> str:
        """The name of the strategy."""

    def next_move(self, known: KnownMaze, x: int, y: int, heading: _Heading) -> Pose | None:
        """Returns the pose after the next step, or None if the search is over.

        Call this method once for each reading, after the map contains the walls around the mouse.
        Raises `SearchError` if the strategy cannot continue.
        """

    def weights(self) -> _Distances:
        """Returns the weight of each cell after the last move, or 65535 for none."""

@disjoint_base
class Connection:
    """The requests of a mouse to a simulator: the methods of both `Simulator` and `Client`.

    `text`, `colour`, `wall`, `log`, `name`, `restart`, `clear_texts`, `clear_colours` and
    `clear_walls` annotate the next state. The next call of `state` sends them. If it raises
    `Refused`, the annotations that the simulator has not accepted are dropped. Those after the last
    state are sent by `Client.close`, when a `Client` is deleted or the program ends, and by
    `Simulator.history` and `Simulator.save`.
    """

    @property
    def start(self) -> Pose:
        """The pose in which a mouse starts. A `Client` asks `mmsim` for it with `info`."""

    def request(self, request: bytes) -> bytes:
        """Sends the bytes of a request and returns the bytes of the reply."""

    def ping(self) -> None:
        """Checks that the simulator replies."""

    def reset(self) -> None:
        """Deletes all states in the simulator and begins a new search."""

    def walls(self, x: int, y: int, heading: _Heading) -> Walls:
        """Returns the walls around a mouse in this pose."""

    def state(
        self,
        x: int,
        y: int,
        heading: _Heading,
        weights: _Grid,
        walls: _Grid | KnownMaze,
    ) -> None:
        """Reports the state of the mouse, for the history, the viewer and recordings.

        `weights` holds a number for each cell, such as the distance to the goal; numbers above 255
        are sent as 255. `walls` is the map of the mouse, or the flags of each cell (see
        `KnownMaze.walls`).
        """

    def text(self, x: int, y: int, text: object) -> None:
        """Sets the text of a cell, at most 10 characters. An empty text clears it."""

    def colour(self, x: int, y: int, letter: str | None) -> None:
        """Sets the colour of a cell, one of the letters kbacgorwyBCAGORVY of mms, or clears it."""

    def wall(self, x: int, y: int, heading: _Heading, state: Literal["1", "0", "?", "-"]) -> None:
        """Declares a wall of a cell, whatever the flags of the states say.

        `state` is "1" for present, "0" for absent, "?" for unknown, or "-" as in the states.
        """

    def clear_texts(self) -> None:
        """Clears all texts."""

    def clear_colours(self) -> None:
        """Clears all colours."""

    def clear_walls(self) -> None:
        """Withdraws all declared walls."""

    def log(self, text: object) -> None:
        """Logs one or more lines. Lines are cut after 1000 bytes."""

    def name(self, mouse: str, strategy: str = "") -> None:
        """Names the mouse and its strategy, in at most 100 bytes each."""

    def restart(self) -> None:
        """Reports that the mouse was put back at the start by hand."""

@final
class Simulator(Connection):
    """A simulation in this process, with the rules and messages of `mmsim`."""

    def __new__(cls, maze: Maze, max_states: int | None = None) -> Simulator:
        """Creates the simulation of a maze. It refuses states after the first `max_states`."""

    @property
    def maze(self) -> Maze:
        """The true maze."""

    def unexplored(self) -> KnownMaze:
        """Returns the map of a mouse that has not read any walls yet."""

    @property
    def history(self) -> History:
        """The states since the last reset. They change while the mouse runs."""

    def save(self, path: _Path) -> None:
        """Writes the states to a recording, which `mmsim replay` shows."""

@final
class Client(Connection):
    """A connection to a simulator. The simulator may be started later.

    Ctrl-C interrupts the wait for a reply.
    """

    def __new__(
        cls,
        endpoint: str | None = None,
        timeout: float | None = ...,
        annotations: bool | None = None,
    ) -> Client:
        """Connects to a simulator.

        The default endpoint is the environment variable MMSIM_ENDPOINT, which `mmsim run` sets, or
        tcp://127.0.0.1:6574. A request raises `NoReply` after `timeout` seconds, by default 5 s, or
        waits without limit if it is None. With `mmsim run`, which holds replies while the mouse is
        paused, there is no limit by default.

        `annotations` says whether annotations are sent. The default is True with `mmsim run`, and
        otherwise False, because the reference simulator never replies to a request that it does not
        know. Annotations that are not sent have no effect.
        """

    @property
    def endpoint(self) -> str:
        """The endpoint of the simulator."""

    def unexplored(
        self,
        size: _Cell | None = None,
        goals: Iterable[_Cell] | None = None,
        start: _Cell | None = None,
    ) -> KnownMaze:
        """Returns the map of a mouse that has not read any walls yet.

        Without arguments, the client asks `mmsim` for the maze with `info`. The reference simulator
        does not know `info`, so pass `size=(16, 16)` for its mazes.
        """

    @property
    def history(self) -> History:
        """Raises an error, because the states are in the other process."""

    def close(self) -> None:
        """Sends the last annotations and closes the connection. A further request uses a new one."""

    def __enter__(self) -> Client: ...
    def __exit__(self, *_error: object) -> None: ...

@final
class History(Sequence[State]):
    """The states that a mouse has reported, from the oldest to the newest."""

    def __len__(self) -> int: ...
    @overload
    def __getitem__(self, key: int, /) -> State: ...
    @overload
    def __getitem__(self, key: slice, /) -> list[State]: ...
    def __iter__(self) -> Iterator[State]: ...

    @property
    def log(self) -> list[tuple[int, str]]:
        """The log lines of the mouse, each with the index of the state that follows it.

        The index of a line that no state follows is the number of states.
        """

    @property
    def texts(self) -> dict[tuple[int, int], str]:
        """The texts that the mouse displays at the end, by cell."""

    @property
    def colours(self) -> dict[tuple[int, int], str]:
        """The letters of the colours that the mouse displays at the end, by cell."""

@final
class State:
    """A state: the pose of a mouse, its weights and its map. States with the same bytes are equal."""

    @property
    def index(self) -> int:
        """The number of states before this one."""

    @property
    def bytes(self) -> bytes:
        """The bytes of the message S."""

    @property
    def pose(self) -> Pose:
        """The pose of the mouse."""

    @property
    def weights(self) -> _Bytes8:
        """The weight of each cell. 255 means 255 or more."""

    @property
    def walls(self) -> _Bytes8:
        """The flags of each cell (see `KnownMaze.walls`)."""

    @property
    def known(self) -> KnownMaze:
        """The map of the mouse."""

    def __eq__(self, value: object, /) -> bool: ...
    __hash__: None  # type: ignore[assignment]
    def _repr_svg_(self) -> str: ...

@final
class Recording:
    """The states in a file."""

    @property
    def maze(self) -> Maze | None:
        """The true maze, or None if a client has made the recording."""

    @property
    def states(self) -> History:
        """The states."""

    @property
    def info(self) -> dict[str, Any]:
        """The reply of the simulator to `info`."""

    @property
    def is_complete(self) -> bool:
        """False if the recording has not been closed, or the file is damaged."""

@final
class Search:
    """The search of a bundled strategy. A notebook shows it as an animation."""

    @property
    def maze(self) -> Maze:
        """The true maze."""

    @property
    def mouse(self) -> str:
        """The name of the strategy."""

    @property
    def goal_reached(self) -> bool:
        """True if the mouse has entered a goal cell."""

    @property
    def steps(self) -> int:
        """The number of steps in all phases."""

    @property
    def turns(self) -> int:
        """The number of quarter turns in all phases."""

    @property
    def steps_to_goal(self) -> int | None:
        """The number of steps until the mouse first entered a goal cell."""

    @property
    def requests(self) -> int:
        """The number of requests to the simulator, except those for the name of the mouse."""

    @property
    def visited_cells(self) -> int:
        """The number of visited cells."""

    @property
    def proven(self) -> bool:
        """True if the mouse has proven that its path is shortest."""

    @property
    def path_found(self) -> int | None:
        """The length in steps of the shortest path that the mouse knows."""

    @property
    def phases(self) -> dict[str, dict[str, Any]]:
        """The `steps`, `turns` and `time_s` of `search_run`, `return_run`, `fast_run` and `total`.

        The times are those of the vehicle in seconds, or None for a run that did not take place.
        """

    @property
    def vehicle(self) -> str:
        """The name of the vehicle that times the runs."""

    @property
    def known_run_time_s(self) -> float | None:
        """The time in seconds of the fastest run through the walls that the mouse knows."""

    @property
    def fastest_run_proven(self) -> bool:
        """True if the known walls prove that no run of the vehicle is faster."""

    @property
    def error(self) -> str | None:
        """The reason why the strategy could not continue."""

    @property
    def known(self) -> KnownMaze:
        """The map of the mouse at the end."""

    @property
    def states(self) -> History:
        """The states that the mouse has reported."""

    def _repr_svg_(self) -> str: ...
    def _repr_html_(self) -> str: ...

@final
class FastRun:
    """The fastest run of a vehicle through a maze, from rest to rest."""

    @property
    def vehicle(self) -> str:
        """The name of the vehicle."""

    @property
    def time_s(self) -> float:
        """The time in seconds."""

    @property
    def gate_to_gate_s(self) -> float:
        """The time in seconds from leaving the start cell to entering the goal."""

    @property
    def length_mm(self) -> float:
        """The length in millimetres."""

    @property
    def top_speed_mm_s(self) -> float:
        """The top speed in millimetres per second."""

    @property
    def slalom_turns(self) -> int:
        """The number of slalom turns."""

    @property
    def cells(self) -> list[_Cell]:
        """The cells of the run."""

    @property
    def moves(self) -> str:
        """The straights and turns, as `mmsim fast-run --json` prints them."""

    def _repr_svg_(self) -> str: ...

def bundled_mazes() -> tuple[str, ...]:
    """Returns the names of the bundled mazes."""

def flood(
    maze: Maze | KnownMaze,
    targets: Iterable[_Cell],
    unknown: _Unknown = "open",
) -> _Distances:
    """Returns the number of steps from each cell to the nearest target, or 65535 if there is no path.

    `unknown` says how unknown walls of a `KnownMaze` count.
    """

def load_recording(path: _Path) -> Recording:
    """Reads a recording of `mmsim` or of `Simulator.save`."""

def search(
    maze: Maze | Simulator,
    strategy: str = "flood-fill",
    max_states: int | None = None,
    vehicle: str | None = None,
) -> Search:
    """Runs a bundled strategy, by default until it stops or has reported its usual limit of states.

    `vehicle` times the runs, as in `Maze.fastest_run`, and `fastest-path-search` explores for it.
    """

def compare(competition: dict[str, object], rules: str | None = None) -> Any: ...
def trial(
    mazes: Sequence[Maze],
    robots: Sequence[tuple[str, str]] | None,
    published_robots: Sequence[tuple[str, Sequence[str]]] | None,
    python: str | None,
    seed: int,
    noise: float,
    answer_limit: float,
) -> list[dict[str, Any]]: ...
def load_folder(path: _Path) -> tuple[list[Maze], list[str]]: ...

@final
class SearchBatch:
    """Several search environments that take their steps together; see `micromouse_sim.gym`."""

    def __new__(
        cls,
        mazes: Sequence[Maze] | None,
        size: tuple[int, int],
        style: str,
        until_proven: bool,
        max_steps: int | None,
        count: int,
    ) -> SearchBatch: ...
    @property
    def size(self) -> tuple[int, int]:
        """Width and height in cells."""

    def reset(self, index: int, seed: int | None) -> None:
        """Begins a new episode. A seed also determines the mazes of later episodes."""

    def step_one(self, action: int) -> tuple[float, bool, bool]:
        """Takes one action in the first environment."""

    def step(self, actions: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.float64], _Flags, _Flags]:
        """Takes one action in each environment, or begins a new episode where one is over."""

    def observation(self, index: int) -> _Observation:
        """Returns walls, openings, goals and the pose of one environment."""

    def observations(self) -> _Observation:
        """Returns walls, openings, goals and poses of all environments."""

    def info(self, index: int) -> tuple[npt.NDArray[np.int8], bool]:
        """Returns the action mask of one environment, and whether its mouse was in the goal."""

    def infos(self) -> tuple[npt.NDArray[np.int8], _Flags]:
        """Returns the action masks of all environments, and whether each mouse was in the goal."""

    def maze(self, index: int) -> Maze:
        """Returns the true maze of an environment."""

    def known(self, index: int) -> KnownMaze:
        """Returns a copy of the map that the mouse of an environment has made."""
