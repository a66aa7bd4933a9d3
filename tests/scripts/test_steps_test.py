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


if __name__ == "__main__":
    unittest.main()
