#!/usr/bin/env python3
"""live_calibration_test.py COMMAND...: `stof calib ... --live` (COMMAND: stof) of `stofd`, before which a board is waved. STOFD and
STOF_EMU_PAIR hold these commands, their words separated by |."""

import base64
import json
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
EMU_PAIR = [word for word in os.environ.get("STOF_EMU_PAIR", "").split("|") if word]
ENOUGH_S = 200
SIZE = ["--size", "320x240"]
# A rig of few pixels whose PMD camera looks out beside the left one, as on a bench.
BESIDE = ["--size", "64x48", "--pmd", "44x36", "--pmd-place", "0,0,0,0,0,0", "--pmd-light", "1"]
WAVE = ["--scene", "board:chess,9x6,0.06", "--poses", "wave:4,10", "--hold", "60", "--no-tof"]
TAKEN = re.compile(r"(view_\d{3}): taken \(corners moved by (\d+\.\d+) px, edges are (\d+\.\d+) px wide\), (\d+) in all; missing: ")


class LiveCalibration(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.out = self.folder / "rig.cal"
        self.views = self.folder / "rig.cal.views"

    def start(self, *flags):
        """A sensor; where it takes requests."""
        port = self.folder / "port"
        port.unlink(missing_ok=True)
        sensor = self.sensor = subprocess.Popen([*STOFD, *SIZE, "--period-ms", "100", "--port", "0", "--port-file", port, "--set", "discovery.mdns=false", "--set",
                                   "discovery.beacon=false", *map(str, flags)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

        def stop():
            sensor.send_signal(signal.SIGTERM)
            sensor.wait(ENOUGH_S)
        self.addCleanup(stop)
        end = time.monotonic() + ENOUGH_S
        while not (port.exists() and port.read_text(encoding="utf-8").endswith("\n")):
            self.assertLess(time.monotonic(), end)
            self.assertIsNone(sensor.poll())
            time.sleep(0.02)
        return "127.0.0.1:" + port.read_text(encoding="utf-8").strip()

    def words(self, sensor, *flags):
        return [*COMMAND, "calib", "stereo", "--live", sensor, "--board", "9x6:0.06", "--out", self.out, "--raw-every", "1", *map(str, flags)]

    def refuse(self, code, fact, sensor, *flags):
        ended = subprocess.run(self.words(sensor, *flags), capture_output=True, text=True, timeout=ENOUGH_S, check=False)
        self.assertEqual(ended.returncode, code, ended.stdout + ended.stderr)
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertIn(fact, ended.stderr)
        self.assertFalse(self.out.exists())
        return ended.stdout

    def stop_at(self, pattern, sensor, *flags, by=signal.SIGINT):
        """Its lines, when it was stopped at one that has the pattern; what it complains."""
        running = subprocess.Popen(self.words(sensor, *flags, "--timeout", 30), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(running.kill)
        said = ""
        while not re.search(pattern, said):
            line = running.stdout.readline()
            if not line:
                self.fail(said + running.stderr.read())
            said += line
        running.send_signal(by)
        rest, complaint = running.communicate(timeout=ENOUGH_S)
        self.assertEqual(running.returncode, 1, complaint)
        self.assertEqual(complaint.count("\n"), 1, complaint)
        return said + rest, complaint

    def test_views_of_a_waved_board_are_kept_and_a_second_run_goes_on(self):
        sensor = self.start(*WAVE)
        said, complaint = self.stop_at(TAKEN, sensor)
        self.assertIn(f"stopped: views in {self.views}: ", complaint)
        self.assertIn("; missing: ", complaint)
        self.assertTrue(said.splitlines()[1].startswith("missing: near:"), said)
        taken = TAKEN.findall(said)
        self.assertLess(float(taken[0][1]), 0.2)
        kept = sorted(path.name for path in self.views.iterdir())
        self.assertEqual(kept, ["coverage.png", *(name for name, *_ in taken)])
        for view in taken:
            for eye in ("left", "right"):
                self.assertTrue((self.views / view[0] / f"{eye}.pgm").read_bytes().startswith(b"P5\n320 240\n255\n"))
        # A program reads the same, an object a line.
        said, _ = self.stop_at('"verdict":"(?!no_board)', sensor, "--json", "--picture-width", 100)
        lines = [json.loads(line) for line in said.splitlines()]
        self.assertEqual([line["state"] for line in lines[:4]], ["subscribing", "reading", "missing", "looking"])
        self.assertTrue(lines[2]["text"].startswith(f"views of before: {len(taken)}; missing: "))
        look = next(line for line in lines if line["state"] == "looking" and line["verdict"] != "no_board")
        self.assertEqual(look["size"], [320, 240])
        self.assertGreaterEqual(look["views"], len(taken))
        self.assertEqual(len(look["wants"]), 15)
        self.assertEqual(len(look["cells"]["left"]), look["cells"]["size"][0] * look["cells"]["size"][1])
        self.assertGreaterEqual(sum(look["cells"]["left"]), 54)
        for place in look["left"] + look["right"]:
            self.assertTrue(0 <= place[0] < 320 and 0 <= place[1] < 240, place)
        self.assertEqual(len(look["left"]) or len(look["right"]), 54)
        for eye in ("left_png", "right_png"):  # of a quarter of the width
            picture = base64.b64decode(look[eye], validate=True)
            self.assertEqual((picture[:8], picture[16:24]), (b"\x89PNG\r\n\x1a\n", struct.pack(">II", 80, 60)))
        self.refuse(1, "the time limit of 1 s is over: views in ", sensor, "--time-limit", 1)
        # What was kept is a folder of views.
        ended = subprocess.run([*COMMAND, "calib", "stereo", "--target", self.views, "--board", "9x6:0.06", "--out", self.out], capture_output=True,
                               text=True, timeout=ENOUGH_S, check=False)
        self.assertEqual(ended.returncode, 2)
        self.assertIn("add", ended.stderr)
        self.assertNotIn("holds no folder", ended.stderr)

    def test_it_ends_while_it_reads_views_that_were_kept(self):
        subprocess.run([*EMU_PAIR, self.views, *WAVE[:2], "--poses", "wave:1,3", "--pmd", "none", *SIZE], check=True, timeout=ENOUGH_S)
        for number in range(1, 200):  # which take long
            shutil.copytree(self.views / "pose_000", self.views / f"pose_{number:03}", copy_function=os.link)
        sensor = self.start(*WAVE)
        said, complaint = self.stop_at("reading 200 views that were kept", sensor, by=signal.SIGTERM)
        self.assertNotIn("views of before", said)
        self.assertIn(f"stopped: views in {self.views}: 200; run it again", complaint)

    def test_with_the_view_that_was_missing_it_calibrates(self):
        # 26 views that are enough; the first of them is held before the sensor, the others were kept before.
        built = ["--scene", "board:chess,9x6,0.06", "--misbuilt", "2,1,3"]
        subprocess.run([*EMU_PAIR, self.views, *built, "--poses", "wave:26,3", "--pmd", "none", *SIZE], check=True, timeout=ENOUGH_S)
        for file in (self.views / "pose_000").iterdir():
            file.unlink()
        (self.views / "pose_000").rmdir()
        sensor = self.start(*built, "--poses", "wave:1,3", "--no-tof")
        ended = subprocess.run(self.words(sensor, "--views", 26, "--timeout", 30, "--time-limit", ENOUGH_S - 20, "--json"), capture_output=True,
                               text=True, timeout=ENOUGH_S, check=False)
        self.assertEqual(ended.returncode, 0, ended.stdout + ended.stderr)
        lines = [json.loads(line) for line in ended.stdout.splitlines()]
        self.assertEqual(lines[2]["text"], "views of before: 25; missing: more: the board anywhere, before both cameras (25 of 26)")
        self.assertEqual([line["state"] for line in lines[-3:]], ["looking", "calibrating", "calibrated"])
        taken = lines[-3]
        self.assertEqual((taken["verdict"], taken["views"]), ("taken", 26))
        self.assertRegex(taken["text"], r"^view_001: taken \(.*, 26 in all; all views are there$")
        self.assertNotIn("left_png", taken)
        result = lines[-1]["result"]
        self.assertEqual((result["file"], result["folder"], result["board"], result["missing"]), (str(self.out), str(self.views), "9x6:0.06", []))
        self.assertEqual(len(result["views"]) + len(result["held_out"]["views"]) + len(result["left_out"]), 26)
        self.assertEqual([len(result["sigma"]), len(result["covariance"]), len(result["covariance"][23])], [24, 24, 24])
        truth = json.loads((self.views / "truth.json").read_text(encoding="utf-8"))
        for eye in ("left", "right"):
            self.assertLess(abs(result[eye]["fx"] / truth[eye]["fx"] - 1), 0.003)
        self.assertLess(result["held_out"]["row_px"], 0.3)
        self.assertEqual(result["warnings"], [])
        self.assertTrue(self.out.read_bytes().startswith(b"STOFCAL\0"))

    def walls(self, code, *words, enters=0):
        """What `stof calib WORDS` says, when Enter was pressed so often."""
        ended = subprocess.run([*COMMAND, "calib", *map(str, words)], input="\n" * enters, capture_output=True, text=True, timeout=ENOUGH_S, check=False)
        self.assertEqual(ended.returncode, code, ended.stdout + ended.stderr)
        return ended.stdout, ended.stderr

    def test_walls_at_known_distances_become_a_converging_rig(self):
        planes = self.folder / "planes"
        wall = ["--scene", "plane", "--rig", "chapter"]
        subprocess.run([*EMU_PAIR, planes, *wall, "--poses", "distances:2,2.4,2.8,3.2", "--pmd", "none", *SIZE], check=True, timeout=ENOUGH_S)
        sensor = self.start(*wall, "--poses", "distances:1.6", "--no-tof")
        words = ["stereo", "--planes", planes, "--live", sensor, "--timeout", 30, "--time-limit", ENOUGH_S, "--raw-every", 1, "--out", self.out, "--pixel", 11.2,
                 "--min-disparity", -20, "--disparities", 160]
        _, complaint = self.walls(1, *words, "--distances", "1.6,2", enters=0)
        self.assertIn("stdin ended, nobody presses Enter: walls in ", complaint)
        said, _ = self.walls(0, *words, "--distances", "1.6,2,2.4,2.8,3.2", enters=1)
        self.assertEqual(said.count("put the wall at "), 1)
        self.assertRegex(said, r"\nwall_001: taken at 1.6 m, \d+ percent of it matched\ngenes ")
        self.assertEqual((planes / "wall_001" / "meta.txt").read_text(encoding="utf-8"), "plane_z_m 1.6\n")
        self.assertTrue(self.out.read_bytes().startswith(b"STOFCAL\0"))
        # When all of them are there nothing is asked, of nobody.
        again, _ = self.walls(0, *words, "--distances", "1.6,2,2.4,2.8,3.2")
        self.assertTrue(again.startswith("genes "), again)
        _, complaint = self.walls(2, "stereo", "--live", sensor, "--distances", "1.6", "--out", self.out)
        self.assertIn("give --planes DIR and --live SENSOR too", complaint)

    def known_walls(self):
        """A folder of walls at known distances before a small rig."""
        bench, walls = self.folder / "bench", self.folder / "walls"
        distances = [1.0, 1.4, 1.8, 2.2]
        subprocess.run([*EMU_PAIR, bench, "--scene", "plane", "--poses", "distances:" + ",".join(map(str, distances)), "--frames", "4", *BESIDE],
                       check=True, timeout=ENOUGH_S)
        walls.mkdir()
        for number, distance in enumerate(distances):
            pose, name = bench / f"pose_{number:03d}", f"z{round(distance * 1000)}"
            (walls / f"{name}.json").write_text(json.dumps({**json.loads((pose / "pmd.json").read_text(encoding="utf-8")), "z_m": distance}))
            (pose / "pmd_raw.pgm").rename(walls / f"{name}_raw.pgm")
        return walls

    def small_rig(self, walls):
        """Its calibration before the place of the PMD camera is known, and that of the PMD camera alone."""
        camera, rig, pair = (self.folder / name for name in ("camera.cal", "small.cal", "pair.json"))
        self.walls(0, "pmd", walls, "--out", camera)
        lens = {"type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d", "data": [61.5, 0, 31.5, 0, 61.5, 23.5, 0, 0, 1]}
        pair.write_text(json.dumps({"M1": lens, "M2": lens, "D1": {**lens, "rows": 1, "cols": 4, "data": [0, 0, 0, 0]},
                                    "D2": {**lens, "rows": 1, "cols": 4, "data": [0, 0, 0, 0]},
                                    "R": {**lens, "data": [1, 0, 0, 0, 1, 0, 0, 0, 1]},
                                    "T": {**lens, "cols": 1, "data": [-0.12, 0, 0]}}), encoding="utf-8")
        self.walls(0, "import", "opencv", pair, "--size", 64, 48, "--start", camera, "--out", rig)
        return rig, camera

    def test_walls_at_known_distances_become_a_pmd_camera(self):
        walls, camera = self.known_walls(), self.folder / "camera.cal"
        self.walls(0, "pmd", walls, "--out", camera)
        sensor = self.start("--scene", "plane", "--poses", "distances:1.6", *BESIDE)
        live = ["--live", sensor, "--timeout", 30, "--distances", "1.6,1.8", "--exposures", 4]
        _, complaint = self.walls(2, "pmd", walls, *live, "--out", camera)
        self.assertIn("give --start with a file of this rig", complaint)
        few = ["--live", sensor, "--distances", "1,2,1", "--start", camera, "--out", self.out]
        said, complaint = self.walls(2, "pmd", self.folder / "few", *few, enters=3)
        self.assertNotIn("press Enter", said)
        self.assertIn("these are 2 distances: a calibration needs 3 at least", complaint)
        words = ["pmd", walls, *live, "--start", camera, "--out", self.out]
        said, complaint = self.walls(1, *words, enters=0)
        self.assertIn("put the wall at 1.6 m from the PMD camera, facing it, and press Enter\n", said)
        self.assertIn("stdin ended, nobody presses Enter: walls in ", complaint)
        said, asked = self.walls(0, *words, "--json", enters=1)
        self.assertIn("\nz1600: taken at 1.6 m, 4 exposures\n", asked)
        told = json.loads((walls / "z1600.json").read_text(encoding="utf-8"))
        self.assertEqual((told["z_m"], told["width"], told["height"], told["frames"]), (1.6, 44, 36, 4))
        read = {wall["name"]: wall for wall in json.loads(said)["walls"]}
        self.assertEqual(sorted(read), ["z1000", "z1400", "z1600", "z1800", "z2200"])
        self.assertLess(abs(read["z1600"]["error_mm"]), 20)

    def leaves(self, pattern, *words, enters=0):
        """What `stof calib WORDS` complains of, when Enter was pressed so often and the sensor of the last start() was cut off from power at a line
        that has the pattern; then Enter is pressed once more."""
        # Its health comes once a second: after 3 s nobody takes it for one that only lacks frames.
        running = subprocess.Popen([*COMMAND, "calib", *map(str, words), "--timeout", "3"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        self.addCleanup(running.kill)
        running.stdin.write("\n" * enters)
        running.stdin.flush()
        said = ""
        while not re.search(pattern, said):
            line = running.stdout.readline()
            if not line:
                self.fail(said + running.stderr.read())
            said += line
        self.sensor.kill()
        running.stdin.write("\n")
        rest, complaint = running.communicate(timeout=ENOUGH_S)
        self.assertEqual(running.returncode, 1, said + rest + complaint)
        self.assertEqual(complaint.count("\n"), 1, complaint)
        self.assertIn(": the sensor fell silent, last health ", complaint)
        self.assertFalse(self.out.exists())
        return complaint

    def test_a_sensor_that_goes_away_in_the_middle(self):
        complaint = self.leaves(TAKEN, *self.words(self.start(*WAVE))[len(COMMAND) + 1:])
        self.assertRegex(complaint, rf"; views in {self.views}: \d+; run it again to go on")
        walls = self.known_walls()
        rig, camera = self.small_rig(walls)
        sensor = self.start("--scene", "plane", "--poses", "distances:1.6", *BESIDE)
        complaint = self.leaves("put the wall at 2 m", "pmd", walls, "--live", sensor, "--distances", "1.6,2", "--exposures", 4, "--start", camera,
                                "--out", self.out, enters=1)
        self.assertIn(f"; walls in {walls}: 5", complaint)
        sensor = self.start("--scene", "plane", "--poses", "distances:1.6", *BESIDE)
        complaint = self.leaves("hold still: ", "extrinsics", "--live", sensor, "--calibration", rig, "--out", self.out)
        self.assertIn("; no view was taken", complaint)

    def test_a_sensor_without_a_pmd_camera(self):
        walls = self.known_walls()
        rig, camera = self.small_rig(walls)
        none = ["--live", self.start("--scene", "plane", "--poses", "distances:1.6", *BESIDE, "--no-tof"), "--timeout", 2]
        for words, more in ((["extrinsics", *none, "--calibration", rig, "--out", self.out], "; no view was taken"),
                            (["pmd", walls, *none, "--distances", "1.6", "--start", camera, "--out", self.out], f"; walls in {walls}: 4"),
                            (["check", *none, "--calibration", rig], "")):
            _, complaint = self.walls(1, *words, enters=1)
            self.assertEqual(complaint.count("\n"), 1, complaint)
            self.assertIn(": the sensor has no PMD camera: connect it, or name a sensor that has one" + more, complaint)
            self.assertFalse(self.out.exists())
        # A file without a pair is told before a sensor is asked.
        _, complaint = self.walls(2, "extrinsics", "--live", "127.0.0.1:9", "--calibration", camera, "--out", self.out)
        self.assertIn("camera.cal: holds no stereo pair: calibrate it first", complaint)
        # One that has it in its calibration, but whose camera gives nothing.
        broken = self.start("--scene", "plane", "--poses", "distances:1.6", *BESIDE, "--fault", "pmd:vanish:0+1000000")
        _, complaint = self.walls(1, "extrinsics", "--live", broken, "--timeout", 2, "--calibration", rig, "--out", self.out)
        self.assertEqual(complaint.count("\n"), 1, complaint)
        self.assertIn("no raw pictures came: the link is too slow", complaint)

    def test_a_sensor_that_does_not_answer(self):
        self.refuse(1, ": no packet came: ", "127.0.0.1:9", "--timeout", 0.5)

    def test_a_paired_sensor_gives_pictures_to_a_key_alone(self):
        keys = self.folder / "user"
        made = subprocess.run([*COMMAND, "pair", "--into", self.folder / "sensor", "--keys", keys, "--role", "view"], capture_output=True, check=False)
        self.assertEqual(made.returncode, 0)
        sensor = self.start("--no-tof", "--keys", self.folder / "sensor")
        self.refuse(1, "the sensor gives them to --signed alone", sensor, "--timeout", 30)
        self.refuse(1, "no key of yours is one of this sensor: pair", sensor, "--signed", "--keys", self.folder / "nothing", "--timeout", 1)
        _, complaint = self.stop_at("no board is seen", sensor, "--signed", "--keys", keys)
        self.assertIn("stopped: no view was taken; missing: near", complaint)

    def test_a_rig_without_a_pair_has_none(self):
        sensor = self.start("--fault", "stereo:vanish:0+1000000", "--pmd", "44x36")
        self.refuse(1, "no raw pictures came: the link is too slow", sensor, "--timeout", 4)

    def test_command_lines_that_mean_nothing(self):
        self.refuse(2, "give one of --target DIR, --live SENSOR and --planes DIR", "127.0.0.1:9", "--target", self.folder)
        half = self.views / "view_001"
        half.mkdir(parents=True)
        (half / "left.pgm").write_bytes(b"P5\n1 1\n255\n\0")
        self.refuse(2, "view_001: has no right.pgm: add it, or remove the folder", "127.0.0.1:9")
        for command in ("extrinsics", "check"):
            ended = subprocess.run([*COMMAND, "calib", command, self.folder, "--live", "127.0.0.1:9", "--calibration", self.out,
                                    *(["--out", self.out] if command == "extrinsics" else [])], capture_output=True, text=True, check=False)
            self.assertEqual(ended.returncode, 2)
            self.assertIn("give a folder, or --live SENSOR, not both", ended.stderr)


if __name__ == "__main__":
    COMMAND.extend(sys.argv[1:])
    unittest.main(argv=[sys.argv[0]], verbosity=2)
