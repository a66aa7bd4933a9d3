#!/usr/bin/env python3
"""refusals_test.py COMMAND...: flags and names that would do nothing are refused in a line, and what goes on is told as JSON, too (COMMAND
is stof, with an emulator before it in a cross build). STOFD holds the command of stofd, its words separated by |."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time
import unittest

import verbs

STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
LONG_S = 120
NOBODY = "127.0.0.1:9"


class Refusals(verbs.Program):
    def refuse(self, fact, *words):
        ended = self.stof(*words)
        self.assertEqual((ended.returncode, ended.stdout), (2, ""), ended.stderr)
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertTrue(ended.stderr.startswith("stof: "), ended.stderr)
        self.assertIn(fact, ended.stderr)

    def start(self, name, *more):
        port = self.folder / f"{name}.port"
        sensor = subprocess.Popen([*STOFD, "--port", "0", "--port-file", str(port), "--period-ms", "150", "--size", "64x48", "--pmd", "44x36", *more],
                                  cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(sensor.wait)
        self.addCleanup(sensor.kill)
        for _ in range(10 * LONG_S):
            if port.is_file() and port.read_text().strip():
                return sensor, "127.0.0.1:" + port.read_text().strip()
            time.sleep(0.1)
        raise AssertionError("stofd did not start")

    def test_keys_without_signed_streams_are_refused(self):
        for words in (["stats", NOBODY], ["record", NOBODY, "x.mcap"], ["check", NOBODY], ["export", NOBODY, "--to", "x", "--as", "csv"]):
            for flag in (["--key", "00000001"], ["--keys", "absent"]):
                with self.subTest(words=words, flag=flag):
                    self.refuse("--signed", *words, *flag)
        self.refuse("8 hexadecimal digits", "view", NOBODY, "--key", "12")
        self.assertFalse((self.folder / "x.mcap").exists())

    def test_an_empty_sensor_is_none(self):
        for words in (["info", ""], ["stats", ""], ["health", ""], ["check", ""], ["view", ""], ["record", "", "x.mcap"], ["report", "", "x.tar"],
                      ["export", "", "--to", "x", "--as", "csv"]):
            with self.subTest(words):
                self.refuse("is empty: name a sensor", *words)
        for words in (["config", "", "get"], ["address", "", "dhcp"], ["pair", ""], ["unpair", "", "--list"], ["calib", "install", "x.cal", ""],
                      ["update", "", "x.update"]):
            with self.subTest(words):
                self.refuse("", *words)

    def test_what_means_a_sensor_is_refused_of_a_file(self):
        for verb in ("stats", "health", "check"):
            self.refuse("--seconds: is for a sensor", verb, "./absent.mcap", "--seconds", "2")
        self.refuse("--signed: is for a sensor", "stats", "./absent.mcap", "--signed")

    def test_what_is_no_file_is_told_as_what_it_is(self):
        os.mkfifo(self.folder / "pipe")
        self.refuse("is a pipe", "info", "pipe")
        (self.folder / "nowhere").symlink_to("absent")
        self.refuse("is a link to what is not there", "info", "nowhere")

    def test_stofd_tells_output_that_cannot_be_written(self):
        if not pathlib.Path("/dev/full").exists():
            self.skipTest("no /dev/full")
        for flag in ("--help", "--schema"):
            with open("/dev/full", "w", encoding="ascii") as full:
                ended = subprocess.run([*STOFD, flag], stdout=full, stderr=subprocess.PIPE, text=True, timeout=LONG_S, check=False)
            self.assertEqual(ended.returncode, 1, flag)
            self.assertRegex(ended.stderr, r"^stofd: its output cannot be written[^\n]*\n$")

    def test_a_sensor_without_a_place_says_how_many_there_are(self):
        _, place = self.start("full")
        held = [subprocess.Popen([*verbs.COMMAND, "stats", place, "--seconds", str(LONG_S)], cwd=self.folder, stdout=subprocess.PIPE, text=True)
                for _ in range(3)]
        for one in held:
            self.addCleanup(one.wait)
            self.addCleanup(one.kill)
            self.assertIn("frames of sensor", one.stdout.readline())
        ended = self.stof("stats", place, "--timeout", "2")
        self.assertEqual(ended.returncode, 1)
        self.assertIn("three of one computer", ended.stderr)
        for one in held:
            one.kill()
            one.communicate()

    def test_health_that_goes_on_tells_silence_and_events_as_json(self):
        faults = self.folder / "faults"
        sensor, place = self.start("quiet", "--fault-socket", str(faults))
        health = subprocess.Popen([*verbs.COMMAND, "health", place, "--seconds", str(LONG_S), "--timeout", str(LONG_S), "--json"], cwd=self.folder,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(health.wait)
        self.addCleanup(health.kill)
        late = threading.Timer(LONG_S, health.kill)
        late.start()
        self.addCleanup(late.cancel)

        def told(wanted):
            for line in health.stdout:
                one = json.loads(line)
                self.assertEqual(one["source"], "UDP " + place)  # the same in all
                if wanted(one):
                    return one
            raise AssertionError("not told: " + health.stderr.read())

        told(lambda one: "uptime_s" in one)
        self.assertEqual(self.stof("fault", faults, "pmd:vanish:60").returncode, 0)
        lost = told(lambda one: "event" in one and one["event"]["condition"] != "unpaired" and one["event"]["active"])
        self.assertTrue(lost["event"]["text"].startswith("event: "))
        self.assertIn(lost["event"]["severity"], ("minor", "major", "critical"))
        sensor.send_signal(signal.SIGSTOP)
        silent = told(lambda one: one.get("link", {}).get("state") == "silent")
        self.assertIn("the sensor is silent, its last frame is", silent["link"]["text"])
        sensor.send_signal(signal.SIGCONT)
        told(lambda one: one.get("link", {}).get("state") == "sends_again")
        health.send_signal(signal.SIGINT)
        health.communicate(timeout=LONG_S)


if __name__ == "__main__":
    verbs.COMMAND.extend(sys.argv[1:])
    unittest.main(argv=sys.argv[:1])
