"""Builds wheels with maturin, and adds the `mmsim` command to them.

MMSIM_BINARY is the path of a finished binary, or MMSIM_PROFILE is the cargo profile with which the
command is built (by default `release`).
"""
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import maturin

FOLDER = Path(__file__).resolve().parent
SCRIPTS = FOLDER / "micromouse_sim.data" / "scripts"
# maturin needs the folder even if it writes only the metadata.
SCRIPTS.mkdir(parents=True, exist_ok=True)

get_requires_for_build_wheel = maturin.get_requires_for_build_wheel
get_requires_for_build_editable = maturin.get_requires_for_build_editable
prepare_metadata_for_build_wheel = maturin.prepare_metadata_for_build_wheel
prepare_metadata_for_build_editable = maturin.prepare_metadata_for_build_editable


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    add_command()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    add_command()
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory, config_settings=None):
    sys.exit(
        "cannot build a source distribution, because the package needs all crates of the workspace"
        " (build a wheel in a checkout: pip wheel crates/python)"
    )


def add_command():
    """Copies the `mmsim` command to the folder from which maturin packs it."""
    binary = Path(os.environ.get("MMSIM_BINARY") or build_command())
    if not binary.is_file():
        sys.exit(f"MMSIM_BINARY: no such file: {binary}")
    # A binary for Windows may be packed on Linux, so the name comes from the binary.
    shutil.rmtree(SCRIPTS, ignore_errors=True)
    SCRIPTS.mkdir(parents=True)
    shutil.copy(binary, SCRIPTS / f"mmsim{binary.suffix}")


def build_command():
    """Builds the `mmsim` command and returns the path of the binary."""
    profile = os.environ.get("MMSIM_PROFILE") or "release"
    cargo = os.environ.get("CARGO") or "cargo"
    command = [cargo, "build", "--package=mmsim", "--bin=mmsim", f"--profile={profile}"]
    command += ["--locked", "--message-format=json-render-diagnostics"]
    build = subprocess.run(command, cwd=FOLDER, stdout=subprocess.PIPE, check=True)
    messages = map(json.loads, build.stdout.splitlines())
    return next(filter(None, (message.get("executable") for message in messages)))
