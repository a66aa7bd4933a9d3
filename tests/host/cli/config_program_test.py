#!/usr/bin/env python3
"""config_program_test.py COMMAND...: `stof config` (COMMAND: stof, with an emulator before it in a cross build) as a
user would run it, against `stofd`: STOFD holds that command, its words separated by |."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
ENOUGH_S = 60


class Config(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.file = self.folder / "settings.json"
        self.sensor = None

    def tearDown(self):
        self.cut_power()

    def start(self, *arguments):
        """Starts stofd; what it has printed so far is in self.log."""
        self.assertIsNone(self.sensor)
        port = self.folder / "port"
        port.unlink(missing_ok=True)
        self.log = self.folder / "log"
        with self.log.open("w", encoding="utf-8") as log:
            self.sensor = subprocess.Popen(
                [*STOFD, "--size", "160x120", "--port", "0", "--port-file", str(port), "--settings", str(self.file),
                 "--set", "discovery.mdns=false", "--set", "discovery.beacon=false", *arguments], stdout=log, stderr=subprocess.STDOUT)
        end = time.monotonic() + ENOUGH_S
        while not (port.exists() and port.read_text(encoding="utf-8").endswith("\n")):
            self.assertIsNone(self.sensor.poll(), self.log.read_text(encoding="utf-8"))
            self.assertLess(time.monotonic(), end, "stofd does not start")
            time.sleep(0.02)
        self.address = f"127.0.0.1:{port.read_text(encoding='utf-8').strip()}"

    def cut_power(self):
        if self.sensor is not None:
            self.sensor.kill()
            self.sensor.wait()
            self.sensor = None

    def run_config(self, *words):
        return subprocess.run([*COMMAND, "config", *map(str, words)], capture_output=True, text=True, timeout=120,
                              cwd=self.folder)

    def ask(self, *words):
        ended = self.run_config(self.address, *words, "--timeout", "5")
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        return ended.stdout

    def refuse(self, code, fact, *words):
        ended = self.run_config(*words)
        self.assertEqual(ended.returncode, code, ended.stdout + ended.stderr)
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertTrue(ended.stderr.startswith("stof: "), ended.stderr)
        self.assertIn(fact, ended.stderr)

    def test_bad_command_lines(self):
        self.refuse(2, "which sensor", )
        self.refuse(2, "what to do", "127.0.0.1:1")
        self.refuse(2, "erase", "127.0.0.1:1", "erase")
        self.refuse(2, "nothing to change", "127.0.0.1:1", "set")
        self.refuse(2, "absent.json", "127.0.0.1:1", "set", "absent.json")
        self.refuse(2, "--document", "127.0.0.1:1", "get", "--document", "none")
        self.refuse(2, "/dev/absent", "--serial", "/dev/absent", "get")
        self.refuse(1, "127.0.0.1:1", "127.0.0.1:1", "get", "--timeout", "0.05")

    def test_what_was_committed_outlives_a_power_cut(self):
        self.start()
        self.ask("set", "depth.max_range_mm=3000")
        self.ask("stage", "name=arm", "depth.preset=quality")
        self.assertEqual(self.ask("get", "name"), "stof\n")
        self.ask("commit")
        self.ask("set", "depth.max_range_mm=4000")
        self.cut_power()
        self.start()
        self.assertEqual(self.ask("get", "name"), "arm\n")
        self.assertEqual(self.ask("get", "depth.preset"), "quality\n")
        self.assertEqual(self.ask("get", "depth.max_range_mm"), "3000\n")
        self.assertEqual(sorted(json.loads(self.ask("diff", "--json"))),
                         ["depth.max_range_mm", "depth.preset", "discovery.beacon", "discovery.mdns", "name"])

    def test_a_damaged_file_is_told_and_kept(self):
        damaged = '{"name": "arm", "period_ms": 50'
        self.file.write_text(damaged, encoding="utf-8")
        self.start()
        self.assertEqual(self.ask("get", "name"), "stof\n")
        self.assertIn(f"{self.file}: not JSON: it ends too early: the defaults hold",
                      self.log.read_text(encoding="utf-8"))
        self.assertEqual(pathlib.Path(f"{self.file}.bad").read_text(encoding="utf-8"), damaged)

    def test_a_stranger_cannot_keep_the_sensor_from_starting(self):
        self.start()
        before = self.ask("get")
        for device in ("/dev/watchdog0", "/dev/nope", "/dev/pts/0"):
            self.refuse(2, "serial.device: takes a line of board emu", self.address, "set", f"serial.device={device}", "--timeout", "5")
            self.refuse(2, "serial.device: takes a line of board emu", self.address, "set", "name=x", f"serial.device={device}")
        self.assertEqual(self.ask("get"), before)
        self.ask("set", "serial.device=/dev/ttyS99", "serial.mode=stof", "depth.max_range_mm=500")
        self.ask("save")
        for start in range(4):
            self.cut_power()
            self.start()
            range_mm = self.ask("get", "depth.max_range_mm")
            self.assertEqual(range_mm, "500\n" if start < 2 else "10000\n", self.log.read_text(encoding="utf-8"))
        self.assertIn("two starts with these settings have failed", self.log.read_text(encoding="utf-8"))
        self.assertEqual(self.ask("get", "depth.max_range_mm", "--document", "saved"), "10000\n")
        self.ask("save")
        self.assertEqual(json.loads(self.file.read_text(encoding="utf-8"))["depth"]["max_range_mm"], 10000)

    def test_saves_have_a_limit(self):
        self.start()
        for number in range(10):
            self.ask("set", f"name=n{number}")
            self.ask("save")
        self.ask("set", "name=late")
        ended = self.run_config(self.address, "save", "--timeout", "5")
        self.assertNotEqual(ended.returncode, 0)
        self.assertIn("then one a minute", ended.stdout + ended.stderr)
        self.assertEqual(json.loads(self.file.read_text(encoding="utf-8"))["name"], "n9")

    def test_what_the_board_cannot_do_is_refused_and_nothing_changes(self):
        self.start("--set", "name=bench")
        before = self.ask("get")
        ended = self.run_config(self.address, "set", "name=x", "depth.disparities=200", "--timeout", "5")
        self.assertEqual(ended.returncode, 2)
        self.assertIn("200 disparities are more than the 128 of board emu", ended.stderr)
        self.assertEqual(self.ask("get"), before)
        self.assertEqual(json.loads(before)["name"], "bench")

    def test_schema_is_the_one_in_docs(self):
        self.start()
        docs = pathlib.Path(__file__).resolve().parents[3] / "docs" / "settings.schema.json"
        self.assertEqual(self.ask("schema"), docs.read_text(encoding="utf-8"))


if __name__ == "__main__":
    COMMAND.extend(sys.argv[1:])
    unittest.main(argv=sys.argv[:1])
