#!/usr/bin/env python3
"""Tests of what scripts/image packs for cameras by libcamera: libraries, modules with their signatures, tuning files.

Debian's libcamera has no pipeline for a Raspberry Pi 5 and Raspberry Pi's is not at hand: pi_libraries.py stands for both.
"""

import json
import pathlib
import platform
import re
import sys
import tempfile
import types
import unittest
import unittest.mock
from importlib import machinery, util

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts" / "imaging"))
import elf  # noqa: E402
import libcamera  # noqa: E402
import libraries  # noqa: E402
import recipe  # noqa: E402
import sbom  # noqa: E402

sys.path.insert(0, str(ROOT / "tests" / "scripts"))
import pi_libraries  # noqa: E402

LIBRARIES = pi_libraries.LIBRARIES
LOADER = "/lib/ld-linux-aarch64.so.1"


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def file(self, name, data=b""):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
        return path


class Elf(unittest.TestCase):
    def test_reads_the_interpreter_and_libraries_of_a_program(self):
        data = pathlib.Path(sys.executable).resolve().read_bytes()
        self.assertIn("ld-", elf.interpreter(data))
        self.assertIn("libc.so.6", elf.needed(data))
        self.assertEqual(elf.needed(pi_libraries.elf("libb.so.2", "liba.so.1")), ["libb.so.2", "liba.so.1"])
        self.assertIsNone(elf.interpreter(pi_libraries.elf()))

    def test_tells_a_program_for_another_processor(self):
        self.assertTrue(elf.is_for_arm64(pi_libraries.elf()))
        self.assertFalse(elf.is_for_arm64(b"#!/bin/sh\n"))
        self.assertFalse(elf.is_for_arm64(b""))
        if platform.machine() == "x86_64":
            self.assertFalse(elf.is_for_arm64(pathlib.Path(sys.executable).resolve().read_bytes()))

    def test_refuses_what_is_no_elf_file(self):
        for data in (b"#!/bin/sh\n", b"", b"\x7fELF\x01\x01"):
            with self.assertRaises(elf.NotElf):
                elf.needed(data)


class Programs(InFolder):
    def test_a_program_that_takes_libraries_is_for_kinds_of_cameras_that_bring_them(self):
        loader = machinery.SourceFileLoader("image", str(ROOT / "scripts" / "image"))
        image = util.module_from_spec(util.spec_from_loader("image", loader))
        loader.exec_module(image)
        options = types.SimpleNamespace(board="virt", camera="usb", stofd=self.file("stofd", pi_libraries.elf()))
        usb, csi = (types.SimpleNamespace(program="stofd", libcamera=kind) for kind in (None, "imx296"))
        takes = pathlib.Path(sys.executable).resolve().read_bytes()
        for data, plan in ((pi_libraries.elf(), usb), (takes, csi)):
            with unittest.mock.patch.object(image, "stripped", return_value=data):
                self.assertEqual(image.program_of(options, plan), data)
        with (unittest.mock.patch.object(image, "stripped", return_value=takes),
              self.assertRaisesRegex(recipe.RecipeError, "takes libraries, which the image of camera usb has not")):
            image.program_of(options, usb)


class Closure(InFolder):
    def setUp(self):
        super().setUp()
        self.file(f"debian/{LIBRARIES}/liba.so.1", pi_libraries.elf("libb.so.2", "libc.so.6"))
        self.file(f"debian/{LIBRARIES}/libb.so.2", pi_libraries.elf("liba.so.1", LOADER[5:]))
        self.file(f"debian/{LIBRARIES}/libc.so.6", pi_libraries.elf(LOADER[5:]))
        self.file(f"debian/usr{LOADER}", pi_libraries.elf())
        self.program = pi_libraries.elf("liba.so.1", interpreter=LOADER)

    def test_has_the_loader_once_and_each_library_that_is_named_by_one(self):
        found = libraries.Libraries(self.folder / "debian").closure(self.program)
        self.assertEqual(list(found), [f"{LIBRARIES}/{name}" for name in ("liba.so.1", "libb.so.2", "libc.so.6")] + [f"usr{LOADER}"])

    def test_the_first_folder_that_has_a_library_counts(self):
        other = self.file(f"other/{LIBRARIES}/libb.so.2", pi_libraries.elf())
        found = libraries.Libraries(self.folder / "other", self.folder / "debian").closure(self.program)
        self.assertEqual(found[f"{LIBRARIES}/libb.so.2"], (self.folder / "other", other))
        self.assertEqual(found[f"{LIBRARIES}/liba.so.1"][0], self.folder / "debian")

    def test_a_library_that_is_missing_is_one_line(self):
        (self.folder / f"debian/{LIBRARIES}/libb.so.2").unlink()
        with self.assertRaisesRegex(libraries.LibraryError, "^no library libb.so.2 in .*debian: unpack its package"):
            libraries.Libraries(self.folder / "debian").closure(self.program)


class Packed(InFolder):
    """A kind of camera of a Raspberry Pi 4: what lies where in its image."""

    BOARD, VERSION, MODULES = "rpi4", "0.4", "libcamera"

    def setUp(self):
        super().setUp()
        self.plan = recipe.Recipe(ROOT, self.BOARD, "imx296")
        self.program = pi_libraries.make(self.folder, self.plan, self.VERSION, self.MODULES)
        self.module = self.plan.libcamera["modules"][0]

    def made(self):
        return libcamera.Libcamera(self.plan, libraries.Libraries(self.folder), self.program)

    def refused(self, pattern):
        with self.assertRaisesRegex((libcamera.LibcameraError, sbom.SbomError), pattern) as raised:
            self.made()
        self.assertNotIn("\n", str(raised.exception))

    def test_all_that_the_program_and_libcamera_ask_for_is_there_and_unchanged(self):
        made = self.made()
        self.assertLess({f"{LIBRARIES}/libcamera.so.{self.VERSION}", f"{LIBRARIES}/libyaml-0.so.2", f"usr{LOADER}",
                         f"{LIBRARIES}/{self.MODULES}/{self.module}", f"{LIBRARIES}/{self.MODULES}/{self.module}.sign"}, set(made.files))
        self.assertLess(set(self.plan.libcamera["files"]), set(made.files))
        for name, data in made.files.items():
            if name != libcamera.PIPELINE_FILE:
                self.assertEqual(data, (self.folder / name).read_bytes(), name)

    def test_a_trigger_that_is_slow_is_no_camera_that_stands_still(self):
        read = json.loads(self.made().files[libcamera.PIPELINE_FILE])
        self.assertEqual((read["version"], read["target"]), (1.0, self.plan.libcamera["pipeline"]["target"]))
        self.assertGreater(read["pipeline_handler"]["camera_timeout_value_ms"], 60_000)  # period_ms of docs/SETTINGS.md

    def test_each_package_is_told(self):
        names = [package.package for package in self.made().packages]
        self.assertEqual(names, sorted([f"libcamera{self.VERSION}", "libcamera-ipa", "libgnutls30t64", "libyaml-0-2", "libc6"]))

    def test_whatever_is_missing_is_named_in_one_line(self):
        for name in self.plan.libcamera["files"]:
            (self.folder / name).unlink()
        (self.folder / f"{LIBRARIES}/{self.MODULES}/{self.module}.sign").unlink()
        lacking = ", ".join([f"{self.module}.sign", *self.plan.libcamera["files"]])
        self.refused(f"libcamera for board {self.BOARD}, camera imx296, lacks {lacking}: " + re.escape(self.plan.libcamera["get"]))

    def test_a_module_of_another_libcamera_is_refused(self):
        path = self.folder / f"{LIBRARIES}/{self.MODULES}/{self.module}"
        path.write_bytes(path.read_bytes() + b"?")
        self.refused(f"{self.module} is not signed for .*libcamera.so.{self.VERSION}: unpack both of the same packages")

    def test_a_libcamera_that_trusts_no_module_is_refused(self):
        path = self.folder / f"{LIBRARIES}/libcamera.so.{self.VERSION}"
        path.write_bytes(path.read_bytes().replace(libcamera.RSA_KEY, bytes(len(libcamera.RSA_KEY))))
        self.refused("is not signed for")

    def test_a_program_without_libcamera_is_refused(self):
        self.program = pi_libraries.elf()
        self.plan.libcamera = {}
        self.refused("is linked without libcamera: name stofd-libcamera")

    def test_a_library_of_no_package_is_refused(self):
        (self.folder / "usr/share/doc/libgnutls30t64").rename(self.folder / "usr/share/doc/gnutls")
        self.refused("no package of library libgnutls.so.30: unpack libgnutls30 there")


class PackedForRpi5(Packed):
    """Later versions have their modules in another folder."""

    BOARD, VERSION, MODULES = "rpi5", "0.6", "libcamera/ipa"


class PackagesOfLibraries(InFolder):
    def test_a_library_is_of_the_package_that_debian_names_after_it(self):
        packages = {"libcamera.so.0.4": "libcamera0.4", "libcamera-base.so.0.4": "libcamera0.4", "libyaml-0.so.2": "libyaml-0-2",
                    "libgcc_s.so.1": "libgcc-s1", "libstdc++.so.6": "libstdc++6", "libgnutls.so.30": "libgnutls30t64",
                    "libbz2.so.1.0": "libbz2-1.0", "libz.so.1": "zlib1g", "libm.so.6": "libc6", "ld-linux-aarch64.so.1": "libc6",
                    "liblttng-ust-tracepoint.so.1": "liblttng-ust1t64", "liblttng-ust-common.so.1": "liblttng-ust-common1t64"}
        for package in packages.values():
            (self.folder / "usr/share/doc" / package).mkdir(parents=True, exist_ok=True)
        self.assertEqual({library: sbom.package_of(self.folder, library) for library in packages}, packages)


if __name__ == "__main__":
    unittest.main()
