#!/usr/bin/env python3
"""lapack_program_test.py STOF: `stof calib stereo` where LAPACK refuses what it is given. STOF_EMU_PAIR: the program that renders views, its words separated
by |; REFUSING_LAPACK: the library that refuses."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

COMMAND = []
EMU_PAIR = [word for word in os.environ.get("STOF_EMU_PAIR", "").split("|") if word]
VIEWS = ["--scene", "board:chess,9x6,0.06", "--poses", "wave:8,1", "--size", "320x240", "--pmd", "none"]


class Lapack(unittest.TestCase):
    def test_refuses_and_the_program_says_so_and_ends_with_one(self):
        with tempfile.TemporaryDirectory(prefix="stof_") as folder:
            views, out = pathlib.Path(folder) / "set", pathlib.Path(folder) / "rig.cal"
            subprocess.run([*EMU_PAIR, views, *VIEWS], check=True, stdout=subprocess.DEVNULL)
            ended = subprocess.run([*COMMAND, "calib", "stereo", "--target", views, "--board", "9x6:0.06", "--out", out], capture_output=True, text=True,
                                   check=False, env=dict(os.environ, LD_PRELOAD=os.environ["REFUSING_LAPACK"]))
            self.assertEqual(ended.returncode, 1, ended.stdout + ended.stderr)
            self.assertRegex(ended.stderr, r"\Astof: LAPACK's DLASCL refuses its parameter 4, .*: .*\n\Z")
            self.assertFalse(out.exists())


if __name__ == "__main__":
    COMMAND = sys.argv[1:]
    unittest.main(argv=sys.argv[:1])
