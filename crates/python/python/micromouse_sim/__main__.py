"""Starts the `mmsim` command, as `python -m micromouse_sim`, if it is not on the PATH."""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path


def main() -> int:
    """Runs the command that the wheel has installed, and returns its exit code."""
    name = "mmsim.exe" if os.name == "nt" else "mmsim"
    scripts = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", f"{os.name}_user")]
    command = next((path for folder in scripts if (path := Path(folder) / name).is_file()), None)
    if command is None:
        sys.exit(f"cannot find {name} in {' or '.join(scripts)} (reinstall micromouse-sim)")
    try:
        return subprocess.call([str(command), *sys.argv[1:]])
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
