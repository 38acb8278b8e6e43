import re
from pathlib import Path

import numpy as np
import pytest

import micromouse_sim as mm

SMALL = "o---o---o\n|   | G |\no   o   o\n| S     |\no---o---o\n"


def test_a_maze_has_walls_distances_and_a_shortest_path() -> None:
    maze = mm.Maze.parse(SMALL, "small")
    assert (maze.name, maze.width, maze.height) == ("small", 2, 2)
    assert maze.start == mm.Pose(0, 0, mm.Heading.NORTH) == (0, 0, "N")
    assert maze.goals == ((1, 1),)
    assert [maze.has_wall(0, 1, heading) for heading in mm.Heading] == [True, True, False, True]
    assert maze.distances().dtype == np.uint16 and maze.distances().tolist() == [[2, 3], [1, 0]]
    assert maze.walls.dtype == np.uint8 and maze.walls.tolist() == [[12, 26], [6, 26]]
    assert maze.shortest_path() == [(0, 0), (1, 0), (1, 1)]
    assert mm.flood(maze, [(0, 1)]).tolist() == [[1, 0], [2, 3]]
    assert str(maze) == SMALL and repr(maze) == "<Maze \"small\", 2x2 cells>"
    assert maze == mm.Maze.parse(SMALL.encode()) != mm.Maze.bundled("01")
    assert len({maze, mm.Maze.parse(SMALL)}) == 1
    assert maze._repr_svg_().startswith("<svg ")


def test_unreachable_cells_have_the_largest_distance() -> None:
    closed = mm.Maze.parse("o---o---o\n| S | G |\no---o---o\n")
    assert closed.distances().tolist() == [[65535], [0]]
    assert closed.shortest_path() is None
    with pytest.raises(mm.SearchError, match="goal unreachable"):
        closed.fastest_run()


def test_arrays_own_their_memory() -> None:
    distances = mm.Maze.bundled("01").distances()
    expected = distances.copy()
    assert distances.flags.writeable and distances.shape == (16, 16)
    for _ in range(100):
        mm.Maze.generate(1).distances()[:] = 7
    assert (distances == expected).all()


def test_mazes_are_found_by_the_words_of_their_names() -> None:
    assert len(mm.bundled_mazes()) > 10
    for name in mm.bundled_mazes():
        assert mm.Maze.bundled(name).name == name
    assert mm.Maze.bundled("HARBOUR 01").name == "01-harbour"
    with pytest.raises(mm.MazeError, match='no bundled maze matches "nowhere"'):
        mm.Maze.bundled("nowhere")


def test_files_are_read_and_written_in_every_format(tmp_path: Path) -> None:
    maze = mm.Maze.generate(3)
    for extension in ("txt", "num", "maz", "trial"):
        path = tmp_path / f"three.{extension}"
        maze.save(path)
        assert mm.Maze.load(path) == maze and mm.Maze.load(str(path)).name == "three"
    assert (tmp_path / "three.txt").read_bytes() == maze.write() == str(maze).encode()
    maze.save(tmp_path / "other", format="num")
    assert (tmp_path / "other").read_bytes() == maze.write("num")


def test_generated_mazes_depend_on_the_seed_only() -> None:
    maze = mm.Maze.generate(7, (32, 20), "perfect")
    assert maze == mm.Maze.generate(seed=7, size=(32, 20), style="perfect")
    assert (maze.name, maze.width, maze.height) == ("perfect-32x20-7", 32, 20)
    found = mm.Maze.generate()
    assert found == mm.Maze.generate(int(found.name.rsplit("-", 1)[1]))


def test_the_fastest_run_has_the_figures_of_the_command(mmsim: str, tmp_path: Path) -> None:
    import json
    import subprocess

    maze = mm.Maze.bundled("01")
    maze.save(tmp_path / "maze.txt")
    command = [mmsim, "fast-run", str(tmp_path / "maze.txt"), "--json"]
    [expected] = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    run = maze.fastest_run()
    assert (run.vehicle, run.time_s, run.slalom_turns) == (
        expected["vehicle"], expected["time_s"], expected["slalom_turns"]
    )
    assert [list(cell) for cell in run.cells] == expected["cells"] and run.moves == expected["moves"]
    assert run.gate_to_gate_s == expected["gate_to_gate_s"] and run.length_mm == expected["length_mm"]
    assert run.top_speed_mm_s == expected["top_speed_mm_s"] and "<svg" in run._repr_svg_()
    (tmp_path / "mine.toml").write_text('base = "ukmars"\n')
    assert maze.fastest_run(str(tmp_path / "mine.toml")).time_s == maze.fastest_run("ukmars").time_s


def test_every_reading_of_an_ambiguous_file_can_be_selected(tmp_path: Path) -> None:
    path = tmp_path / "rows.txt"
    path.write_text("bf\nab\nee\n")
    with pytest.raises(mm.MazeError, match="rows.txt: .* numbers that fit 3 ") as loaded:
        mm.Maze.load(path)
    with pytest.raises(mm.MazeError) as parsed:
        mm.Maze.parse(path.read_bytes())
    assert str(loaded.value).endswith(str(parsed.value))
    readings = re.findall(r"^--bits (\S+) --rows (\S+)\n((?:[o|].*\n)+)", f"{parsed.value}\n", re.MULTILINE)
    assert len(readings) == 3
    for bits, rows, drawn in readings:
        maze = mm.Maze.load(path, bits=bits, rows=rows)
        assert str(maze) == drawn
        assert maze == mm.Maze.parse(path.read_text(), bits=bits, rows=rows)
    with pytest.raises(ValueError, match='expected .* such as N1E2S4W8 .* found "NESW"'):
        mm.Maze.load(path, bits="NESW")
    with pytest.raises(ValueError, match='expected .* north, .* found "up"'):
        mm.Maze.parse("", rows="up")


def test_faults_are_reported_with_the_messages_of_the_command(tmp_path: Path) -> None:
    (tmp_path / "wrong.txt").write_text("o---o---o\n| S   G  \no---o---o\n")
    with pytest.raises(mm.MazeError, match="wrong.txt: line 2, column 9: expected "):
        mm.Maze.load(tmp_path / "wrong.txt")
    with pytest.raises(FileNotFoundError, match="cannot read .*missing"):
        mm.Maze.load(tmp_path / "missing")
    with pytest.raises(FileNotFoundError, match="cannot write .*missing"):
        mm.Maze.generate(1).save(tmp_path / "missing" / "maze.txt")
    with pytest.raises(mm.MazeError, match="requires a 16x16 or 32x32 maze"):
        mm.Maze.parse(SMALL).write("maz")
    with pytest.raises(ValueError, match="expected one of text, "):
        mm.Maze.parse(SMALL).write("png")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"\(2, 0\) is outside the maze of 2x2 cells"):
        mm.Maze.parse(SMALL).has_wall(2, 0, "N")
    with pytest.raises(ValueError, match="expected a maze of 1x1 to 32x32 cells, found 33x1"):
        mm.Maze.generate(1, (33, 1))
    with pytest.raises(ValueError, match="found -1"):
        mm.Maze.generate(-1)
    with pytest.raises(ValueError, match="expected ukmars, ares, expert, kerise or a TOML file"):
        mm.Maze.parse(SMALL).fastest_run("bicycle")
    with pytest.raises(FileNotFoundError):
        mm.Maze.parse(SMALL).fastest_run("bicycle.toml")
    with pytest.raises(TypeError, match="expected str or bytes, found int"):
        mm.Maze.parse(3)  # type: ignore[arg-type]
