#!/usr/bin/env python3
"""sequence_program_test.py -- COMMAND...: `stof evaluate sequence` (COMMAND, with an emulator before it in a cross
build) on scenes that `stof_emu_pair` renders: table, JSON, refusals in one line. STOF_EMU_PAIR holds that command, its
words separated by |."""

import json
import shutil
import sys
import unittest

import rendered_scenes


class EvaluateSequence(rendered_scenes.RenderedScenes):
    SUBCOMMAND = "sequence"

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for name, scene, frames in (("still", "corridor", 18), ("leaving", "leaving", 18), ("drive", "drive:hall,1.5", 8)):
            cls.render(name, "--scene", scene, "--size", "160x120", "--sequence", frames)

    def test_json_has_each_preset_without_and_with_the_filter(self):
        rows = json.loads(self.succeed("still", "leaving", "--json"))["rows"]
        kinds = [(f"preset {preset}", temporal) for preset in ("fast", "quality") for temporal in (False, True)]
        self.assertEqual([(row["scene"], row["matcher"], row["temporal"]) for row in rows],
                         [(scene, *kind) for scene in ("still", "leaving") for kind in kinds])
        still, filtered = rows[0], rows[1]
        self.assertLess(filtered["noise_mm"], still["noise_mm"] / 2)
        self.assertLess(filtered["flicker_percent"], still["flicker_percent"] / 1.5)
        self.assertLess(filtered["jumps_percent"], still["jumps_percent"] / 3)
        self.assertLess(filtered["e5_percent"], still["e5_percent"])
        self.assertGreater(filtered["coverage_percent"], still["coverage_percent"])
        self.assertIsNone(still["moving_e5_percent"])
        self.assertEqual(still["stays_percent"], [None] * 3)
        self.assertIsNotNone(rows[4]["stays_percent"][2])
        for row in rows:
            self.assertGreater(row["coverage_percent"], 50)

    def test_on_the_move_the_filter_changes_nothing(self):
        still, filtered = json.loads(self.succeed("drive", "--preset", "fast", "--warm-up", 2, "--json"))["rows"]
        for name in ("e5_percent", "inside_percent", "nearer_percent"):
            self.assertAlmostEqual(filtered[name], still[name], delta=0.05)

    def test_on_the_move_the_pmd_says_so_in_its_intervals(self):
        # The time between both exposures is recorded; without it intervals are narrower and hold less.
        told = json.loads(self.succeed("drive", "--preset", "fast", "--warm-up", 2, "--json"))["rows"][0]
        copy = self.folder / "untold"
        shutil.copytree(self.folder / "drive", copy)
        for file in copy.glob("*/pmd.json"):
            constants = json.loads(file.read_text())
            self.assertEqual(constants.pop("after_pair_us"), 6000)
            file.write_text(json.dumps(constants))
        untold = json.loads(self.succeed(copy, "--preset", "fast", "--warm-up", 2, "--json"))["rows"][0]
        self.assertGreater(told["inside_percent"], untold["inside_percent"] + 0.3)
        self.assertFalse(any("after_pair_us" in file.read_text() for file in (self.folder / "still").glob("*/pmd.json")))

    def test_what_has_left_is_gone_two_frames_later(self):
        for row in json.loads(self.succeed("leaving", "--json", "--warm-up", 8))["rows"]:
            self.assertLess(row["stays_percent"][2], 2)

    def test_table_lines_up(self):
        rows = self.succeed("drive", "--preset", "fast", "--warm-up", 2).splitlines()
        self.assertEqual([row.split()[0] for row in rows[-2:]], ["drive", "drive"])
        self.assertEqual(len({len(row) for row in rows[-3:]}), 1, "columns do not line up")

    def test_what_is_no_sequence_is_refused_in_one_line(self):
        self.refuse("DIR")
        self.refuse("absent", "absent")
        self.refuse("holds 18 frames", "still", "--warm-up", 13)
        self.refuse("--preset", "still", "--preset", "best")
        self.refuse("--out", "still", "--out", "maps")
        for name in ("0000/gt_left.pgm", "0000/pmd.json", "0003/left.pgm", "0003/pmd_raw.pgm"):
            copy = self.folder / "broken"
            shutil.copytree(self.folder / "drive", copy)
            (copy / name).unlink()
            self.refuse(name.split("/")[1], copy, "--warm-up", 2)
            shutil.rmtree(copy)


def main():
    rendered_scenes.RenderedScenes.COMMAND.extend(sys.argv[sys.argv.index("--") + 1:])
    if not rendered_scenes.PAIR:
        print("no emulated board in this build: Skipped")
        sys.exit(77)
    unittest.main(argv=[sys.argv[0]], verbosity=2)


if __name__ == "__main__":
    main()
