#!/usr/bin/env python3
"""update_program_test.py COMMAND...: `stof update` (COMMAND: stof) as a user would run it, against scripts/emulated_board, whose
slots start `stofd`: STOFD holds that command, its words separated by |. STOF_LONG=1: also what takes half a minute."""

import json
import os
import pathlib
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
LONG = os.environ.get("STOF_LONG") == "1"
ENOUGH_S = 60


def free_port():
    """Not one that the system gives to others by itself: each start of the sensor takes it anew."""
    while True:
        port = random.randrange(20_000, 32_000)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", port))
                return port
            except OSError:
                continue


class Update(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.environment = {**os.environ, "XDG_CONFIG_HOME": str(self.folder / "config")}
        self.settings = self.folder / "settings.json"
        self.log = self.folder / "log"
        self.board = None
        self.addCleanup(self.stop)
        self.emulated("make")
        self.run_stof("pair", "--into", f"{self.settings}.keys", "--role", "admin")

    def stop(self):
        if self.board is not None:
            self.board.send_signal(signal.SIGTERM)
            self.board.wait(timeout=ENOUGH_S)
            self.board = None

    def emulated(self, command, *words):
        subprocess.run([ROOT / "scripts/emulated_board", command, self.folder / "card", "--stofd", STOFD[-1], *words], check=True,
                       timeout=ENOUGH_S)

    def release(self, name, *words, program=None):
        """An update file; program: a script in place of stofd."""
        if program is not None:
            (self.folder / "program").write_text(program, encoding="ascii")
            words = (*words, "--program", self.folder / "program")
        self.emulated("release", self.folder / name, *words)
        return self.folder / name

    def run_stof(self, *words):
        return subprocess.run([*COMMAND, *map(str, words)], capture_output=True, text=True, timeout=300, env=self.environment)

    def said(self):
        return self.log.read_text(encoding="utf-8")

    def until(self, what, done):
        end = time.monotonic() + ENOUGH_S
        while not done():
            self.assertLess(time.monotonic(), end, f"{what}: {self.said()}")
            time.sleep(0.05)

    def start(self):
        port = free_port()
        self.address = f"127.0.0.1:{port}"
        with self.log.open("w", encoding="utf-8") as log:
            self.board = subprocess.Popen(
                [ROOT / "scripts/emulated_board", "run", self.folder / "card", "--stofd", STOFD[-1], "--size", "64x48", "--pmd", "32x24",
                 "--port", str(port), "--settings", self.settings, "--set", "discovery.mdns=false", "--set", "discovery.beacon=false"],
                stdout=log, stderr=subprocess.STDOUT)
        self.until("no frame", lambda: "publishing" in self.said())

    def starts(self):
        return [line for line in self.said().splitlines() if line.startswith("board: starts")]

    def update(self, code, fact, *words):
        ended = self.run_stof("update", *words)
        self.assertEqual(ended.returncode, code, ended.stdout + ended.stderr + self.said())
        self.assertEqual(ended.stderr.count("\n"), 0 if code == 0 else 1, ended.stderr)
        self.assertIn(fact, ended.stdout if code == 0 else ended.stderr)

    def test_what_is_no_good_is_refused_and_what_crashes_is_left(self):
        self.start()
        self.update(2, "try --help", self.address)
        self.update(2, "does not exist", self.address, self.folder / "none")
        self.update(2, "is no update file", self.address, self.settings.with_name("log"))
        (self.folder / "other").write_text("11" * 32, encoding="ascii")
        self.update(2, "not signed", self.address, self.release("forged.update", "--key", self.folder / "other"))
        self.update(2, "downgrade counter", self.address, self.release("old.update", "--counter", "0"))
        self.update(2, "is for board rpi4", self.address, self.release("rpi4.update", "--board", "rpi4"))
        self.assertEqual(self.starts(), ["board: starts slot a"])
        crash = self.release("crash.update", program="#!/bin/sh\nexit 1\n")
        ended = self.run_stof("update", self.address, crash, "--json")
        self.assertEqual((ended.returncode, json.loads(ended.stdout)["state"]), (1, "reverted"), ended.stderr + self.said())
        self.assertIn("went back to the former release", ended.stderr)
        self.assertEqual(self.starts(), ["board: starts slot a", "board: starts slot b, once", "board: starts slot a"])
        # Whoever is on trial takes no other release, and a reset is the end of the trial.
        good = self.release("good.update", "--version", "2.0")
        ended = self.run_stof("update", "--no-wait", self.address, good, "--json")
        self.assertEqual((ended.returncode, ended.stderr), (0, ""), self.said())
        told = json.loads(ended.stdout)
        self.assertEqual((told["device_id"], told["state"]), (1, "on_trial"))
        self.assertRegex(told["release"] + told["former"], "^[0-9a-f]{16}$")
        self.until("no trial", lambda: "release 2.0 in slot b on trial" in self.said() and self.said().count("publishing") >= 3)
        self.update(1, "is on trial", self.address, good)

    @unittest.skipUnless(LONG, "takes two minutes: set STOF_LONG=1")
    def test_what_publishes_is_confirmed_and_what_does_not_is_left(self):
        self.start()
        self.update(0, "is confirmed", self.address, self.release("good.update", "--version", "2.0"))
        self.update(0, "is confirmed", "--revert", self.address)
        self.assertEqual(self.starts(), ["board: starts slot a", "board: starts slot b, once", "board: starts slot a, once"])
        blind = f'#!/bin/sh\nexec "{STOFD[-1]}" "$@" --fault trigger:drop:0:1\n'
        for number, program in enumerate(["#!/bin/sh\nexec sleep 1000\n", blind]):
            self.update(1, "went back", self.address, self.release(f"{number}.update", program=program))
            self.assertEqual(self.starts()[-2:], ["board: starts slot b, once", "board: starts slot a"])


if __name__ == "__main__":
    COMMAND[:] = sys.argv[1:]
    unittest.main(argv=sys.argv[:1])
