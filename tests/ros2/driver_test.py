#!/usr/bin/env python3
"""driver_test.py DRIVER_ON_STANDIN STOFD: the component of ros2/stof_driver gets an emulated sensor's frames, and sees that they stop."""

import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "host/bridge"))
from bridge_support import start_sensor  # noqa: E402


def main():
    driver, stofd = sys.argv[1:]
    with tempfile.TemporaryDirectory(prefix="stof_") as scratch:
        sensor, place = start_sensor([stofd], pathlib.Path(scratch), "--size", "64x48", "--period-ms", "100")
        try:
            running = subprocess.Popen([driver, place], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            said = []
            for line in running.stdout:
                said.append(line)
                if line.strip() == "ready":
                    sensor.kill()
                    sensor.wait()
                    running.stdin.write("gone\n")
                    running.stdin.flush()
            code = running.wait()
        finally:
            sensor.kill()
            sensor.wait()
    print("".join(said), end="")
    sys.exit(0 if code == 0 and "ready\n" in said else 1)


if __name__ == "__main__":
    main()
