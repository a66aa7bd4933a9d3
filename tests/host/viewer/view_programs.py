"""Programs of a test of `stof view`, their lines and ports. COMMAND is what the test was given; the environment's STOFD holds that
program's command, its words separated by |."""

import os
import pathlib
import re
import signal
import subprocess
import time

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
ENOUGH_S = 60
WIDTH, HEIGHT = 64, 48
MOST_PAGES = 8  # that one `stof view` serves


def await_(what, condition):
    end = time.monotonic() + ENOUGH_S
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"{what}: did not come")
        time.sleep(0.02)


def is_done(answer):
    return answer["done"]


class Program:
    """A program that runs until stop(); its lines."""

    def __init__(self, words, folder, name):
        self.log = pathlib.Path(folder) / f"{name}.log"
        with self.log.open("w", encoding="utf-8") as log:
            self.process = subprocess.Popen([*map(str, words)], stdout=log, stderr=subprocess.STDOUT)

    def text(self):
        return self.log.read_text(encoding="utf-8")

    def stop(self):
        """Its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        return self.process.wait(ENOUGH_S)


class Sensor(Program):
    def __init__(self, folder, *flags, port=0, name="sensor"):
        port_file = pathlib.Path(folder) / f"{name}.port"
        port_file.unlink(missing_ok=True)
        super().__init__([*STOFD, "--scene", "room:3", "--seed", "1", "--size", f"{WIDTH}x{HEIGHT}", "--pmd", "32x24", "--period-ms", "100", "--port",
                          port, "--port-file", port_file, "--set", "discovery.mdns=false", "--set", "discovery.beacon=false", "--set",
                          "streams.grey_left=rvl", "--set", "streams.depth=rvl", *flags], folder, name)
        await_("the sensor's port", lambda: port_file.exists() and port_file.read_text(encoding="utf-8").endswith("\n"))
        self.port = int(port_file.read_text(encoding="utf-8"))


class View(Program):
    """sensor: what has a port, or what `stof view` takes. before: words before the command."""

    def __init__(self, folder, sensor, *flags, name="view", before=()):
        where = f"127.0.0.1:{sensor.port}" if hasattr(sensor, "port") else sensor
        super().__init__([*before, *COMMAND, "view", where, *flags], folder, name)
        await_("the page's address", lambda: re.search(r"^page: .*\n", self.text(), re.M) or self.process.poll() is not None)
        self.addresses = re.findall(r"^page: (http://\S+)\n", self.text(), re.M)
        assert self.addresses, self.text()
        self.port = int(re.match(r"http://127\.0\.0\.1:(\d+)/", self.addresses[0])[1])
