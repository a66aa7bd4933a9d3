"""What the parts of scripts/bench share."""

import json
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BENCH = ROOT / "build" / "bench"
# What is aimed at: the most of the peer's time, or of its instructions, that something of a size takes.
FLOORS = {
    ("WTA 15x15", "450x375x64"): 1 / 2.6, ("WTA 15x15", "1280x720x128"): 1 / 2.8,
    ("WTA 15x15", "640x480x64, two threads"): 1 / 1.8, ("quality", "450x375x64"): 1 / 1.5,
    ("coarse to fine, 2", "1280x720x128"): 1 / 2, ("phase", "176x144"): 1 / 1.3,
    ("whole frame", "640x480x64, PMD 176x144"): 1.6, ("temporal filter", "640x480"): 0.10,
}
ARM_FLOORS = {"wta": 0.8}  # of StereoBM
WRONG = re.compile(r"error:|CMake Error|^E: ")


class Trouble(Exception):
    """One line: what is wrong and what to do."""


def run(step, *command):
    """Runs a command, its output kept in build/bench/STEP.log."""
    log = BENCH / f"{step}.log"
    with log.open("w") as file:
        try:
            code = subprocess.run(list(map(str, command)), cwd=ROOT, stdin=subprocess.DEVNULL, stdout=file,
                                  stderr=subprocess.STDOUT, check=False).returncode
        except OSError as error:
            raise Trouble(f"{command[0]} cannot be run ({error.strerror}): run scripts/setup bench") from error
    if code:
        lines = log.read_text(errors="replace").strip().splitlines() or ["no message"]
        first = next((line for line in lines if WRONG.search(line)), lines[-1])
        raise Trouble(f"{step} failed: {first.strip()}: all of it is in {log}")


def kept(file, how):
    """What was measured before."""
    try:
        return json.loads(file.read_text())
    except OSError as error:
        raise Trouble(f"{file}: no figures yet: run {how}") from error
    except ValueError as error:
        raise Trouble(f"{file}: {error}: run {how} again") from error
