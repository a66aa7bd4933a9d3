"""What the tests of the Python package stof share: the environment, and an emulated sensor."""

import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
STOFD = os.environ.get("STOFD", "")
STOF = os.environ.get("STOF", "")
CLIENT = os.environ.get("DEPTH_CLIENT", "")
CC = os.environ.get("CC", "cc")
ENOUGH_S = 60


def need_numpy():
    """Goes on with the system's Python where that has numpy and this one has not; ends with 77 where neither has."""
    if importlib.util.find_spec("numpy") is not None:
        return
    system = "/usr/bin/python3"
    if os.path.realpath(sys.executable) != os.path.realpath(system) and os.path.exists(system):
        asked = subprocess.run([system, "-c", "import numpy"], capture_output=True, check=False)
        if asked.returncode == 0:
            os.execv(system, [system, "-B", *sys.argv])
    print(f"skipped: no numpy for {sys.executable}: install python3-numpy")
    sys.exit(77)


def skip_without(*variables):
    for variable in variables:
        if not os.environ.get(variable):
            print(f"skipped: {variable} is not set: a cross build, or one with sanitizers, whose libstof no Python can load")
            sys.exit(77)


class EmulatedSensor:
    """stofd, emulated, on a free port of this machine."""

    def __init__(self, *words, size="64x48", pmd="none", period_ms=20):
        self.folder = tempfile.TemporaryDirectory(prefix="stof_")
        port = pathlib.Path(self.folder.name) / "port"
        self.process = subprocess.Popen(
            [STOFD, "--size", size, "--pmd", pmd, "--period-ms", str(period_ms), "--port", "0", "--port-file", str(port),
             "--set", "discovery.mdns=false", "--set", "discovery.beacon=false", *map(str, words)],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        end = time.monotonic() + ENOUGH_S
        while not (port.exists() and port.read_text(encoding="utf-8").endswith("\n")):
            if time.monotonic() > end or self.process.poll() is not None:
                self.end()
                raise AssertionError(f"stofd opens no port, or ended with {self.process.returncode}")
            time.sleep(0.02)
        self.address = f"127.0.0.1:{int(port.read_text(encoding='utf-8'))}"

    def end(self):
        self.process.kill()
        self.process.wait()
        self.folder.cleanup()
