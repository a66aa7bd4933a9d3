#!/usr/bin/env python3
"""raw_view_test.py COMMAND...: `stof view --raw` (COMMAND: stof, with an emulator before it in a cross build) of `stofd`: raw pictures
are what the emulated cameras gave. STOFD and STOF_EMU_PAIR hold these commands, their words separated by |."""

import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
EMU_PAIR = [word for word in os.environ.get("STOF_EMU_PAIR", "").split("|") if word]
ENOUGH_S = 60
WIDTH, HEIGHT, PMD_WIDTH, PMD_HEIGHT = 160, 120, 32, 24
# Lenses that bend and eyes that do not match: what is rectified is another picture.
SCENE = ["--scene", "room:3", "--misbuilt", "5", "--seed", "1", "--size", f"{WIDTH}x{HEIGHT}", "--pmd", f"{PMD_WIDTH}x{PMD_HEIGHT}"]
EXPOSURE = re.compile(r"raw exposure (\d+) of frame (\d+): (.*); edge (\d+\.\d{9}) s, sequences (\d+) (\d+) (\d+)\n")


def pixels(file):
    """Size and bytes of a PGM."""
    kind, size, most, data = pathlib.Path(file).read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    assert kind == b"P5" and len(data) == width * height * (2 if int(most) > 255 else 1), file
    return (width, height), data


class RawView(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.out = self.folder / "out"

    def start(self, *flags, period_ms=100):
        """A sensor; where it takes requests."""
        port = self.folder / "port"
        sensor = subprocess.Popen(
            [*STOFD, *SCENE, "--period-ms", str(period_ms), "--port", "0", "--port-file", port, "--set", "discovery.mdns=false", "--set",
             "discovery.beacon=false", *flags], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

        def stop():
            sensor.send_signal(signal.SIGTERM)
            sensor.wait(ENOUGH_S)
        self.addCleanup(stop)
        end = time.monotonic() + ENOUGH_S
        while not (port.exists() and port.read_text(encoding="utf-8").endswith("\n")):
            self.assertLess(time.monotonic(), end)
            time.sleep(0.02)
        return "127.0.0.1:" + port.read_text(encoding="utf-8").strip()

    def stof(self, *arguments):
        return subprocess.run([*COMMAND, *map(str, arguments)], capture_output=True, text=True, timeout=ENOUGH_S, check=False)

    def view(self, sensor, *flags):
        """The exposures that it names, as (id, frame, parts, edge, sequences)."""
        ended = self.stof("view", sensor, "--timeout", 20, "--out", self.out, *flags)
        self.assertEqual(ended.returncode, 0, ended.stdout + ended.stderr)
        return [(int(one[0]), int(one[1]), one[2], one[3], [int(number) for number in one[4:]])
                for one in EXPOSURE.findall(ended.stdout)]

    def refuse(self, code, fact, *arguments):
        ended = self.stof("view", *arguments)
        self.assertEqual(ended.returncode, code, ended.stdout + ended.stderr)
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertIn(fact, ended.stderr)

    def picture(self, identity, name):
        return pixels(self.out / f"raw_{identity:010d}_{name}.pgm")

    def given(self, exposure):
        """What the emulated cameras give at an exposure, by name."""
        folder = self.folder / f"exposure{exposure}"
        subprocess.run([*EMU_PAIR, folder, "--exposure", str(exposure), *SCENE], check=True, timeout=ENOUGH_S)
        return {"left": pixels(folder / "left.pgm"), "right": pixels(folder / "right.pgm"), "pmd": pixels(folder / "pmd_raw.pgm")}

    def test_they_are_what_the_cameras_gave_and_not_what_was_rectified(self):
        sensor = self.start()
        exposures = self.view(sensor, "--raw", "left,right,pmd", "--raw-count", 3, "--raw-every", 2)
        self.assertGreaterEqual(len(exposures), 3)
        for identity, _, parts, _, sequences in exposures:
            self.assertEqual(parts, f"left {WIDTH}x{HEIGHT}, right {WIDTH}x{HEIGHT}, pmd {PMD_WIDTH}x{PMD_HEIGHT} x 4")
            self.assertEqual(len(set(sequences)), 1)
            given = self.given(sequences[0])
            for name, picture in given.items():
                self.assertEqual(self.picture(identity, name), picture, name)
            self.assertNotEqual(given["left"], given["right"])
        self.assertTrue(all(after[0] - before[0] >= 2 for before, after in zip(exposures, exposures[1:])))
        self.assertEqual(len({exposure[3] for exposure in exposures}), len(exposures))

    def test_a_part_of_them_each_second_pixel(self):
        sensor = self.start()
        identity, _, parts, _, sequences = self.view(sensor, "--raw", "right", "--raw-count", 1, "--raw-step", 2, "--raw-part",
                                                     "5,7,40,31")[0]
        self.assertEqual(parts, "right 20x16")
        whole = self.given(sequences[1])["right"][1]
        rows = [whole[y * WIDTH:(y + 1) * WIDTH] for y in range(7, 38, 2)]
        self.assertEqual(self.picture(identity, "right"), ((20, 16), b"".join(row[5:45:2] for row in rows)))
        self.assertFalse(list(self.out.glob("*_left.pgm")))
        self.refuse(2, f"--raw-part: lies outside of the cameras' {WIDTH} x {HEIGHT} pictures", sensor, "--raw", "left", "--raw-part",
                    f"{WIDTH},0,1,1")

    def test_of_a_paired_sensor_they_take_a_key(self):
        keys = self.folder / "user"
        self.assertEqual(self.stof("pair", "--into", self.folder / "sensor", "--keys", keys, "--role", "view").returncode, 0)
        sensor = self.start("--keys", self.folder / "sensor")
        self.refuse(1, "--signed alone", sensor, "--raw", "left", "--raw-count", 1, "--timeout", 4)
        exposures = self.view(sensor, "--raw", "left,right,pmd", "--raw-count", 2, "--signed", "--keys", keys)
        for identity, _, _, _, sequences in exposures:
            self.assertEqual(self.picture(identity, "pmd"), self.given(sequences[2])["pmd"])

    def test_one_at_a_time_has_them_and_they_end_with_it(self):
        sensor = self.start()
        first = subprocess.Popen([*COMMAND, "view", sensor, "--raw", "left"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(first.kill)
        while not EXPOSURE.match(first.stdout.readline() or self.fail("it ended")):
            pass
        self.refuse(1, "another subscriber has them", sensor, "--raw", "left", "--raw-count", 1, "--timeout", 4)
        first.send_signal(signal.SIGINT)
        first.communicate(timeout=ENOUGH_S)
        self.view(sensor, "--raw", "left", "--raw-count", 1)

    def test_command_lines_that_mean_nothing(self):
        for arguments in (["--raw", "left"], ["host", "--raw", "depth"], ["host", "--raw", ""], ["host", "--raw-every", "2"],
                          ["host", "--raw", "left", "--raw-every", "0"], ["host", "--raw", "left", "--raw-step", "256"],
                          ["host", "--raw", "left", "--raw-part", "1,2,3"], ["host", "--raw", "left", "--raw-part", "1,2,3,70000"],
                          ["host", "--raw", "left", "--raw-part", "1,2,3,-4"], ["host", "--raw-count", "3"]):
            with self.subTest(arguments):
                self.refuse(2, "", *arguments)


if __name__ == "__main__":
    COMMAND.extend(sys.argv[1:])
    unittest.main(argv=[sys.argv[0]], verbosity=2)
