#!/usr/bin/env python3
"""Tests of what scripts/tidy reads: each source that it is given, or it says that it cannot."""

import importlib.machinery
import importlib.util
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("tidy", str(ROOT / "scripts" / "tidy"))
tidy = importlib.util.module_from_spec(importlib.util.spec_from_loader("tidy", loader))
loader.exec_module(tidy)


class DatabaseTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.build = pathlib.Path(folder.name)

    def test_a_unity_build_has_each_of_its_sources(self):
        (self.build / "Unity").mkdir()
        whole = self.build / "Unity" / "unity_0_cxx.cxx"
        whole.write_text('/* generated */\n\n/* NOLINTNEXTLINE */\n#include "/a/one.cpp"\n#include "/a/two.cpp"\n')
        alone = {"directory": str(self.build), "file": "/a/three.cpp", "command": "c++ -o three.o -c /a/three.cpp"}
        entries = list(tidy.sources_of([
            {"directory": str(self.build), "file": str(whole), "command": f"c++ -DX -o unity.o -c {whole}"}, alone]))
        self.assertEqual([entry["file"] for entry in entries], ["/a/one.cpp", "/a/two.cpp", "/a/three.cpp"])
        self.assertEqual(entries[1]["command"], "c++ -DX -o unity.o -c /a/two.cpp")
        self.assertEqual(entries[2], alone)

    def test_a_file_that_is_not_compiled_there_is_an_error(self):
        (self.build / "compile_commands.json").write_text(json.dumps([]))
        ended = subprocess.run([sys.executable, "-B", ROOT / "scripts" / "tidy", "--build-dir", self.build,
                                ROOT / "dsp" / "base" / "check.cpp"], capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, 1)
        self.assertIn("does not compile it", ended.stderr)
        self.assertEqual(ended.stderr.count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
