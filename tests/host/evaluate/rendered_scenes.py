"""What tests of `stof evaluate` on scenes that `stof_emu_pair` renders have in common. STOF_EMU_PAIR holds that command,
its words separated by |."""

import os
import pathlib
import subprocess
import tempfile
import unittest

PAIR = [word for word in os.environ.get("STOF_EMU_PAIR", "").split("|") if word]


class RenderedScenes(unittest.TestCase):
    COMMAND = []  # stof, with an emulator before it in a cross build
    SUBCOMMAND = ""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)

    @classmethod
    def render(cls, name, *arguments):
        """The folder `name`, with a PMD camera of 88x72."""
        subprocess.run([*PAIR, name, *map(str, arguments), "--pmd", "88x72"], check=True, cwd=cls.folder, timeout=240)

    def run_stof(self, *arguments):
        return subprocess.run([*self.COMMAND, "evaluate", self.SUBCOMMAND, *map(str, arguments)], capture_output=True,
                              text=True, timeout=240, cwd=self.folder)

    def succeed(self, *arguments):
        ended = self.run_stof(*arguments)
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        return ended.stdout

    def refuse(self, fact, *arguments):
        ended = self.run_stof(*arguments)
        self.assertEqual((ended.returncode, ended.stderr.count("\n")), (2, 1), ended.stdout + ended.stderr)
        self.assertTrue(ended.stderr.startswith("stof: "), ended.stderr)
        self.assertIn(str(fact), ended.stderr)
