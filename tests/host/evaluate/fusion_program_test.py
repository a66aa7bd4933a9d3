#!/usr/bin/env python3
"""fusion_program_test.py PART -- COMMAND...: `stof evaluate fusion` on whole scenes. From a wall to depth: `stof calib pmd`
finds what a recorded camera's json does not tell, and --calibration fuses its scenes with that (skips where STOF_DATA
does not name the folder of the recorded scenes). And rendered rooms: how much is nearer than told. STOF_EMU_PAIR holds
the command that renders them, its words separated by |."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

COMMAND = []
SKIPPED = 77
PAIR = [word for word in os.environ.get("STOF_EMU_PAIR", "").split("|") if word]
DATA = os.environ.get("STOF_DATA")
SCENES = ("Art", "Bowling2", "Laundry", "Wood2")
SENSORS = ("64x16", "176x144")


class OnScenes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_stof(self, *arguments):
        return subprocess.run([*COMMAND, *map(str, arguments)], capture_output=True, text=True, timeout=280)

    def fuse(self, pairs, *options):
        ended = self.run_stof("evaluate", "fusion", *pairs, "--runs", 1, "--json", *options)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        return json.loads(ended.stdout)


class RenderedRooms(OnScenes):
    def test_little_is_nearer_than_told(self):
        pairs = []
        for name in ("corridor", "hall", "room:31"):
            folder = self.folder / name.replace(":", "_")
            subprocess.run([*PAIR, folder, "--scene", name], check=True, timeout=240)
            pairs += [folder, folder / "pmd"]
        for preset, most in (("fast", 0.006), ("quality", 0.004)):
            report = self.fuse(pairs, "--preset", preset, "--max-range", 16)
            for scene in report["scenes"]:
                with self.subTest(scene=scene["scene"], preset=preset):
                    self.assertLess(scene["fused"]["collisions"], 1.2 * most)
                    self.assertGreater(scene["fused"]["hit_rate"], 0.94)
            self.assertLess(report["mean"]["fused"]["collisions"], most)
            for name, source in report["mean"]["by_source"].items():
                if source["share"] > 0:
                    self.assertGreater(source["hit_rate"], 0.85, name)


class TruthInABand(OnScenes):
    def test_other_pixels_are_not_judged(self):
        scene = self.folder / "bars"
        subprocess.run([*PAIR, scene, "--scene", "bars:16,upright", "--size", "320x240", "--pmd", "64x48"], check=True,
                       timeout=240)
        pair = [scene, scene / "pmd"]
        whole = self.fuse(pair, "--preset", "fast")
        bars = self.fuse(pair, "--preset", "fast", "--truth", 1, 2)
        wall = self.fuse(pair, "--preset", "fast", "--truth", 4.5, 5.5)
        self.assertEqual(bars["truth_pixels"] + wall["truth_pixels"], whole["truth_pixels"])
        self.assertAlmostEqual(bars["truth_pixels"] / (320 * 240), 4 * 16 / 320, delta=0.02)
        self.assertGreater(bars["fused"]["collisions"], whole["fused"]["collisions"])
        self.assertEqual(wall["fused"]["collisions"], 0)

    def test_a_band_without_truth_is_refused(self):
        scene = self.folder / "wall"
        subprocess.run([*PAIR, scene, "--scene", "stripes:16", "--size", "160x120", "--pmd", "64x48"], check=True,
                       timeout=240)
        for band in ((5, 6), (6, 5)):
            ended = self.run_stof("evaluate", "fusion", scene, scene / "pmd", "--truth", *band)
            self.assertEqual(ended.returncode, 2)
            self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
            self.assertIn("true depth", ended.stderr)


class FromAWall(OnScenes):
    def setUp(self):
        super().setUp()
        self.data = pathlib.Path(DATA)
        self.pairs = [path for scene in SCENES for sensor in SENSORS
                      for path in (self.data / "stereo" / scene,
                                   self.data / "tof/camera_b/scene" / f"{scene}_{sensor}")]

    def calibrate(self):
        found = self.folder / "found.cal"
        ended = self.run_stof("calib", "pmd", self.data / "tof/camera_b/wall", "--out", found)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        return found

    def test_a_wall_tells_what_the_scenes_need(self):
        found = self.calibrate()
        told = self.fuse(self.pairs, "--preset", "quality", "--calibration", found)
        untold = self.fuse(self.pairs, "--preset", "quality")
        for sensor, most in (("64x16", 0.11), ("176x144", 0.08)):
            mean = told["mean_by_sensor"][sensor]
            self.assertLess(mean["fused"]["e5"], most)
            self.assertLess(mean["fused"]["e5"], mean["pmd"]["e5"])
            self.assertLess(mean["fused"]["e5"], mean["stereo"]["e5"])
            self.assertGreater(mean["fused"]["hit_rate"], 0.93)
            self.assertLess(mean["fused"]["collisions"], 0.005)
            self.assertGreater(untold["mean_by_sensor"][sensor]["pmd"]["e5"], mean["pmd"]["e5"] + 0.2)
        shares = [source["share"] for source in told["mean"]["by_source"].values()]
        self.assertAlmostEqual(sum(shares), told["mean"]["fused"]["coverage"], 2)
        self.assertGreater(told["mean"]["by_source"]["both"]["hit_rate"], 0.94)

    def test_the_calibration_of_another_camera_is_refused(self):
        found = self.calibrate()
        scene = self.folder / "other"
        scene.with_suffix(".json").write_text(
            json.dumps({**json.loads(self.pairs[1].with_suffix(".json").read_text()), "f_mod_hz": 15e6}))
        raw = self.pairs[1].with_name(self.pairs[1].name + "_raw.pgm")
        (self.folder / "other_raw.pgm").write_bytes(raw.read_bytes())
        ended = self.run_stof("evaluate", "fusion", self.pairs[0], scene, "--preset", "fast", "--calibration", found)
        self.assertEqual(ended.returncode, 2)
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertIn("15", ended.stderr)
        ended = self.run_stof("evaluate", "fusion", *self.pairs[:2], "--calibration", self.folder / "none")
        self.assertEqual(ended.returncode, 2)
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)


def main():
    part = sys.argv[1]
    COMMAND.extend(sys.argv[sys.argv.index("--") + 1:])
    if part != "FromAWall" and not PAIR:
        print("no emulated board in this build: Skipped")
        sys.exit(SKIPPED)
    if part == "FromAWall" and not DATA:
        print("skipped: STOF_DATA does not name the folder of the recorded scenes")
        sys.exit(SKIPPED)
    unittest.main(argv=[sys.argv[0], part], verbosity=2)


if __name__ == "__main__":
    main()
