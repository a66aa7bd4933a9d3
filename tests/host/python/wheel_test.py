#!/usr/bin/env python3
"""wheel_test.py: scripts/wheel, and pip with what it makes, in a new virtual environment. Environment: STOF_BUILD, CC. Ends with
77 where these are not set, or Python has no venv."""

import base64
import csv
import hashlib
import importlib.util
import io
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import zipfile

import package_support as support

if __name__ == "__main__":
    support.skip_without("STOF_BUILD", "CC")

BUILD = pathlib.Path(support.os.environ.get("STOF_BUILD", ""))


def run(*command, **options):
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, timeout=200, **options)


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        made = run(support.ROOT / "scripts/wheel", "--build", BUILD, "--out", cls.folder / "packages")
        assert made.returncode == 0, made.stderr
        cls.line = made.stdout
        cls.wheels = list((cls.folder / "packages").iterdir())

    def make(self, library):
        """A build that has this library."""
        (self.folder / "fake/lib").mkdir(parents=True, exist_ok=True)
        link = self.folder / "fake/lib/libstof.so"
        link.unlink(missing_ok=True)
        link.symlink_to(library)
        return run(support.ROOT / "scripts/wheel", "--build", self.folder / "fake", "--out", self.folder / "none")

    def library(self, source, *flags):
        file = self.folder / "source.c"
        file.write_text(source, encoding="utf-8")
        library = self.folder / "libstof.so.0.9.0"
        built = run(support.CC, "-shared", "-fPIC", file, "-o", library, *flags)
        self.assertEqual(built.returncode, 0, built.stderr)
        return library

    def refused(self, ended, *facts):
        self.assertEqual((ended.returncode, ended.stdout, ended.stderr.count("\n")), (2, "", 1), ended.stderr)
        for fact in facts:
            self.assertIn(fact, ended.stderr)

    def test_its_name_and_its_record_are_right(self):
        self.assertEqual(len(self.wheels), 1)
        name = re.fullmatch(r"stof-(\d+\.\d+\.\d+)-(py3-none-manylinux_2_(\d+)_(x86_64|aarch64))\.whl", self.wheels[0].name)
        self.assertTrue(name)
        self.assertLessEqual(int(name[3]), 35)
        with zipfile.ZipFile(self.wheels[0]) as wheel:
            self.assertIsNone(wheel.testzip())
            names = set(wheel.namelist())
            info = f"stof-{name[1]}.dist-info"
            recorded = list(csv.reader(io.StringIO(wheel.read(f"{info}/RECORD").decode())))
            self.assertEqual({row[0] for row in recorded}, names)
            for path, digest, size in recorded:
                if path != f"{info}/RECORD":
                    content = wheel.read(path)
                    self.assertEqual(int(size), len(content), path)
                    self.assertEqual(digest, "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("="))
            self.assertIn(f"Tag: {name[2]}\n", wheel.read(f"{info}/WHEEL").decode())
            self.assertLessEqual({"stof/__init__.py", "stof/py.typed", "stof/libstof.so.0"}, names)
            self.assertFalse([path for path in names if "pycache" in path])
            written = b"".join(wheel.read(path) for path in names if not path.endswith(".so.0"))
            self.assertEqual(written.count(str(support.ROOT).encode()), 0, "a path of this machine")

    def test_the_same_inputs_give_the_same_bytes(self):
        again = self.folder / "again"
        self.assertEqual(run(support.ROOT / "scripts/wheel", "--build", BUILD, "--out", again).returncode, 0)
        self.assertEqual((again / self.wheels[0].name).read_bytes(), self.wheels[0].read_bytes())

    def test_pip_installs_it_without_a_network_and_its_own_library_is_used(self):
        if importlib.util.find_spec("ensurepip") is None:
            self.skipTest("Python has no venv: install python3-venv")
        venv = self.folder / "venv"
        self.assertEqual(run(sys.executable, "-m", "venv", venv).returncode, 0)
        installed = run(venv / "bin/pip", "install", "--no-index", "--disable-pip-version-check", self.wheels[0])
        self.assertEqual(installed.returncode, 0, installed.stderr)
        clean = {"PATH": "/usr/bin:/bin"}
        got = run(venv / "bin/python", "-c", "import stof; from stof import _library; print(stof.__version__, _library.library._name)",
                  env=clean, cwd="/")
        self.assertEqual((got.returncode, got.stderr), (0, ""))
        version, library = got.stdout.split()
        self.assertTrue(self.wheels[0].name.startswith(f"stof-{version}-"))
        self.assertTrue(library.startswith(str(venv)), library)
        removed = run(venv / "bin/pip", "uninstall", "-y", "stof")
        self.assertEqual(removed.returncode, 0, removed.stderr)
        self.assertEqual(list(venv.rglob("*stof*")), [])

    def test_a_library_for_a_newer_glibc_is_refused_by_its_symbol(self):
        source = "int arc4random(void); int stof(void) { return arc4random(); }"  # since 2.36
        library = self.library(source)
        if "GLIBC_2.36" not in run("readelf", "-V", library).stdout:
            self.skipTest("this system's glibc has no symbol that is too new")
        self.refused(self.make(library), "glibc 2.36", "arc4random")

    def test_a_library_that_needs_others_is_refused(self):
        other = self.folder / "libother.so"
        self.library("int other(void) { return 1; }", "-Wl,-soname,libother.so").rename(other)
        self.refused(self.make(self.library("int other(void); int stof(void) { return other(); }", str(other))), "libother.so")

    def test_what_is_no_library_is_refused(self):
        text = self.folder / "libstof.so.0.9.1"
        text.write_text("text that is long enough", encoding="ascii")
        self.refused(self.make(text), "no little-endian 64-bit ELF")
        self.refused(run(support.ROOT / "scripts/wheel", "--build", self.folder / "empty"), "cmake --build", "stof_shared")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
