#!/usr/bin/env python3
"""Tests of what scripts/test_steps.py finds by itself."""

import json
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import test_steps  # noqa: E402


class BoardsTest(unittest.TestCase):
    def boards(self, folders, presets):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name in folders:
                (root / "board" / name).mkdir(parents=True)
                (root / "board" / name / "config.h").write_text("#pragma once\n")
            (root / "board" / "devices").mkdir(parents=True)  # no board: it has no table
            (root / "CMakePresets.json").write_text(json.dumps({"configurePresets": [
                {"name": name, "cacheVariables": {"STOF_BOARD": board}} for name, board in presets.items()]}))
            return test_steps.boards_to_build(root)

    def test_every_folder_with_a_table_is_built(self):
        self.assertEqual(self.boards(["emu", "virt", "mine"], {"emu": "emu", "virt": "virt", "mine": "mine"}),
                         (["mine", "virt"], []))

    def test_a_board_without_its_preset_is_told(self):
        for presets in ({"emu": "emu"}, {"emu": "emu", "mine": "virt"}):
            boards, wrong = self.boards(["emu", "mine"], presets)
            self.assertEqual(boards, ["mine"])
            self.assertEqual(len(wrong), 1)
            self.assertIn("board mine is never built", wrong[0])

    def test_this_tree_is_in_order(self):
        boards, wrong = test_steps.boards_to_build(test_steps.ROOT)
        self.assertEqual(wrong, [])
        self.assertIn("virt", boards)


class RunsTest(unittest.TestCase):
    def test_every_step_is_in_a_run(self):
        self.assertEqual(set(test_steps.STEPS), {*test_steps.SHORT, *test_steps.CI, *test_steps.ALL})

    def test_a_longer_run_has_what_a_shorter_one_has(self):
        # arm64 builds and runs all tests, so those of arm64-kernels, too.
        self.assertLessEqual(set(test_steps.SHORT) - {"arm64-kernels"}, set(test_steps.CI))
        self.assertIn("arm64", test_steps.CI)
        self.assertLessEqual(set(test_steps.CI), set(test_steps.ALL))


class SkipsTest(unittest.TestCase):
    def test_cases_with_one_reason_are_one_line(self):
        count = test_steps.Count(skipped=1, skips={"no data": ["A.one"]})
        count.add(test_steps.Count(skipped=2, skips={"no data": ["B.two"], "no terminal": ["C.three"]}))
        self.assertEqual(test_steps.skip_lines(count.skips), [
            "skipped: 2 cases, the first is A.one: no data", "skipped: C.three: no terminal"])


if __name__ == "__main__":
    unittest.main()
