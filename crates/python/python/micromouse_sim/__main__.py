"""Starts the `mmsim` command, as `python -m micromouse_sim`, if it is not on the PATH."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from pathlib import Path


def paths() -> list[Path]:
    """Returns the paths where the wheel may have installed the command."""
    name = "mmsim.exe" if os.name == "nt" else "mmsim"
    scripts = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", f"{os.name}_user")]
    return [Path(folder) / name for folder in scripts]


def command() -> Path | None:
    """Returns the path of the command that the wheel has installed, if it is there."""
    return next(filter(Path.is_file, paths()), None)


def main() -> int:
    """Runs the command, and returns its exit code."""
    path = command()
    if path is None:
        sys.exit(f"cannot find {' or '.join(map(str, paths()))} (reinstall micromouse-sim)")
    try:
        return subprocess.call([str(path), *sys.argv[1:]])
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
