#!/usr/bin/env python3
"""floor_program_test.py -- COMMAND...: `stof evaluate floor` (COMMAND, with an emulator before it in a cross build) on
scenes that `stof_emu_pair` renders: table, JSON, maps, and refusals in one line. STOF_EMU_PAIR holds that command, its
words separated by |."""

import json
import re
import shutil
import sys
import unittest

import rendered_scenes

PRESETS = ("fast", "quality", "chapter")


class EvaluateFloor(rendered_scenes.RenderedScenes):
    SUBCOMMAND = "floor"

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for name, scene in (("low", "floor:30,10"), ("high", "floor:90,20,5")):
            cls.render(name, "--scene", scene, "--size", "320x240")

    def copy_of_low(self, name):
        copy = self.folder / name
        shutil.copytree(self.folder / "low", copy)
        self.addCleanup(shutil.rmtree, copy)
        return copy

    def test_json_has_every_preset_alone_and_fused(self):
        report = json.loads(self.succeed("low", "high", "--json"))
        kinds = [(f"preset {preset}", source) for preset in PRESETS for source in ("stereo", "fused")]
        self.assertEqual([(row["scene"], row["matcher"], row["source"]) for row in report["rows"]],
                         [(scene, *kind) for scene in ("low", "high") for kind in kinds])
        self.assertEqual([(row["matcher"], row["source"]) for row in report["mean"]], kinds)
        low, high = report["rows"][0], report["rows"][-1]
        self.assertEqual((low["camera_height_m"], low["camera_tilt_degrees"]), (0.3, 10))
        self.assertEqual((high["camera_height_m"], high["camera_tilt_degrees"]), (0.9, 20))
        for row in report["rows"]:
            for surface in ("floor", "box", "wall", "lower_floor", "glass"):
                score = row[surface]
                self.assertGreater(score["pixels"], 300)
                self.assertLessEqual(score["off_percent"] + score["missing_percent"], 100 + 1e-9)
            self.assertEqual(row["glass"]["conflict_percent"] is None, row["source"] == "stereo")
        for i in range(len(kinds)):
            off = [report["rows"][k]["floor"]["off_percent"] for k in (i, i + len(kinds))]
            self.assertAlmostEqual(report["mean"][i]["floor"]["off_percent"], sum(off) / 2)
        # The PMD camera sees a bare wall, on which stereo finds nothing to match.
        fused = report["rows"][3]
        self.assertLess(fused["wall"]["off_percent"] + fused["wall"]["missing_percent"], 20)
        self.assertLess(fused["floor"]["off_percent"] + fused["floor"]["missing_percent"], 20)

    def test_table_has_a_row_for_each_and_means(self):
        rows = self.succeed("low", "high", "--preset", "fast").splitlines()
        self.assertEqual([row.split()[0] for row in rows[-6:]], ["low", "low", "high", "high", "mean", "mean"])
        self.assertEqual(len({len(row) for row in rows[-7:]}), 1, "columns do not line up")
        self.assertNotIn("mean ", self.succeed("low", "--preset", "fast").splitlines()[-1])

    def test_maps_are_left_for_each(self):
        self.succeed("low", "--preset", "fast", "--out", "maps")
        files = [str(file.relative_to(self.folder / "maps")) for file in sorted((self.folder / "maps").rglob("*.*"))]
        self.assertEqual(files, [f"low/preset_fast/{source}/{name}" for source in ("fused", "stereo")
                                 for name in ("depth.pfm", "error.png")])

    def test_results_do_not_depend_on_threads(self):
        self.assertEqual(self.succeed("low", "--json", "--threads", 2), self.succeed("low", "--json"))

    def test_what_is_no_floor_is_refused_in_one_line(self):
        self.refuse("DIR")
        self.refuse("absent", "absent")
        self.refuse("--preset", "low", "--preset", "best")
        self.refuse("--fill", "low", "--preset", "fast", "--fill")
        self.refuse("second scene", "low", self.folder / "low", "--out", "maps")
        self.refuse("--method", "low", "--method", "sa")
        for name in ("surfaces.pgm", "gt_left.pgm", "nonocc.pgm", "pmd_raw.pgm"):
            copy = self.copy_of_low("without")
            (copy / name).unlink()
            self.refuse(name, copy)
            self.doCleanups()
        copy = self.copy_of_low("broken")
        meta = (copy / "meta.txt").read_text()
        (copy / "meta.txt").write_text(meta.replace("camera_height_m 0.", "camera_height_m -0."))
        self.refuse("camera_height_m", copy)

    def test_without_a_pmd_recording_stereo_alone_is_scored(self):
        copy = self.copy_of_low("pair")
        for file in copy.glob("pmd*"):
            file.unlink()
        rows = json.loads(self.succeed("low", "pair", "--preset", "fast", "--json"))
        self.assertEqual([(row["scene"], row["source"]) for row in rows["rows"]],
                         [("low", "stereo"), ("low", "fused"), ("pair", "stereo")])
        low, fused, pair = rows["rows"]
        self.assertEqual({**low, "scene": ""}, {**pair, "scene": ""})
        self.assertEqual(rows["mean"][0]["floor"]["off_percent"], low["floor"]["off_percent"])
        self.assertEqual(rows["mean"][1]["floor"], fused["floor"])
        meta = copy / "meta.txt"
        meta.write_text(re.sub("f_px .*", "", meta.read_text()))
        self.refuse("f_px", copy)

    def test_a_pose_that_does_not_fit_the_depths_is_refused(self):
        for key in ("camera_height_m", "camera_tilt_degrees", "baseline_m"):
            copy = self.copy_of_low("moved")
            (copy / "pmd.json").unlink()  # the rig is that of meta.txt
            meta = copy / "meta.txt"
            meta.write_text(re.sub(f"({key}) (.*)", lambda told: f"{told[1]} {1.3 * float(told[2])}", meta.read_text()))
            self.refuse("by its depths the floor is", copy)
            self.doCleanups()


def main():
    rendered_scenes.RenderedScenes.COMMAND.extend(sys.argv[sys.argv.index("--") + 1:])
    if not rendered_scenes.PAIR:
        print("no emulated board in this build: Skipped")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0]], verbosity=2)


if __name__ == "__main__":
    main()
