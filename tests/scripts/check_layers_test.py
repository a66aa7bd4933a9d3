#!/usr/bin/env python3
"""Every rule of check_layers.py, kept once and broken once, in a small tree of its own."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import check_layers  # noqa: E402

# A tree that keeps all rules and uses every permission.
GOOD = {
    "dsp/base/simd.h": "#pragma once\n#include <arm_neon.h>\n#include <simde/arm/neon.h>\n",
    "dsp/base/simd_lowest.h": '#pragma once\n#include "dsp/base/simd.h"\n',
    "dsp/base/image.h": "#pragma once\n#include <span>\n#include <cstdint>\n",
    "dsp/calib/rays.h": '#pragma once\n#include "dsp/base/image.h"\n',
    "dsp/calib/rays.cpp": '#include "dsp/calib/rays.h"\n#include <Eigen/Dense>\n',
    "dsp/stereo/sad.h": '#pragma once\n#include "dsp/base/image.h"\n',
    "dsp/base/avx2.h": "#pragma once\n#include <immintrin.h>\n",
    "dsp/stereo/sad_avx2.cpp": '#include "dsp/base/avx2.h"\n#include "dsp/stereo/sad.h"\n',
    "dsp/stereo/sums_neon.h": '#pragma once\n#include "dsp/base/simd.h"\n',
    "dsp/stereo/sad_neon.cpp": '#include "dsp/stereo/sad.h"\n#include "dsp/stereo/sums_neon.h"\n',
    "dataset/scene.cpp": '#include <nlohmann/json.hpp>\n#include "dsp/calib/rays.h"\n',
    "dataset/scene.h": "#pragma once\n",
    "lab/ordered.h": '#pragma once\n#include "dsp/stereo/sad.h"\n',
    "lab/ordered.cpp": '#include "lab/ordered.h"\n',
    "hal/camera.h": '#pragma once\n#include "dsp/base/image.h"\n#include "hal/time.h"\n',
    "hal/time.h": "#pragma once\n#include <chrono>\n",
    "hal/framing/cobs.h": '#pragma once\n#include "dsp/base/image.h"\n',
    "hal/emu/camera.h": '#pragma once\n#include "hal/camera.h"\n#include "dataset/scene.h"\n',
    "hal/emu/link.cpp": '#include <sys/socket.h>\n#include "hal/emu/camera.h"\n',
    "hal/linux/usb.h": '#pragma once\n#include <libusb.h>\n#include "hal/framing/cobs.h"\n',
    "posix/socket.h": "#pragma once\n#include <sys/socket.h>\n#include <span>\n",
    "hal/linux/port.cpp": '#include "posix/socket.h"\n',
    "firmware/program/main.cpp": '#include "posix/worker_threads.h"\n',
    "posix/worker_threads.h": "#pragma once\n",
    "board/config.h": '#pragma once\n#include "hal/time.h"\n',
    "board/board.h": '#pragma once\n#include "board/config.h"\n#include STOF_BOARD_CONFIG\n',
    "board/emu/config.h": '#pragma once\n#include "board/config.h"\n',
    "board/emu/flags.h": '#pragma once\n#include "hal/emu/camera.h"\n',
    "board/emu/board.cpp": '#include "board/board.h"\n#include "hal/emu/camera.h"\n',
    "firmware/wire/packet.h": '#pragma once\n#include <bit>\n#include "dsp/base/image.h"\n',
    "firmware/wire/crypto/crypto.cpp": '#include <sodium.h>\n#include "firmware/wire/packet.h"\n',
    "firmware/loop.h": '#pragma once\n#include "board/board.h"\n#include "hal/camera.h"\n'
                       '#include "firmware/wire/packet.h"\n#include "dsp/stereo/sad.h"\n',
    "host/cli/main.cpp": '#include <CLI/CLI.hpp>\n#include <png.h>\n#include "board/config.h"\n'
                         '#include "firmware/wire/packet.h"\n#include "dataset/scene.h"\n',
    "tests/hal/camera_test.cpp": '#include <gtest/gtest.h>\n#include "hal/emu/camera.h"\n'
                                 '#include "firmware/loop.h"\n#include "dsp/base/simd.h"\n',
    "tests/support/mutated_stores.h": "#pragma once\n#define vst1q_u8 mutated\n",
    "scripts/notes.h": '#include "anything"\n',  # not a source of this project
    "build/emu/generated.h": '#include "anything"\n',
}

# What is written, and a part of what must be said about it.
BROKEN = {
    "dsp knows a device": ("dsp/stereo/bad.cpp", '#include "hal/camera.h"', "dsp/* must not know"),
    "dsp knows the system": ("dsp/stereo/bad.cpp", "#include <unistd.h>", "must not know <unistd.h>"),
    "dsp knows threads": ("dsp/stereo/bad.cpp", '#include "posix/worker_threads.h"', "dsp/* must not know"),
    "who else computes with keys": ("firmware/wire/bad.cpp", "#include <sodium.h>", "must not know <sodium.h>"),
    "posix knows dsp": ("posix/bad.cpp", '#include "dsp/base/image.h"', "posix/* must not know"),
    "posix knows a device": ("posix/bad.cpp", '#include "hal/time.h"', "posix/* must not know"),
    "posix knows a library": ("posix/bad.cpp", "#include <libusb.h>", "must not know <libusb.h>"),
    "emu knows sockets": ("hal/emu/bad.cpp", '#include "posix/socket.h"', "must not know"),
    "the loop knows sockets": ("firmware/bad.cpp", '#include "posix/socket.h"', "must not know"),
    "dsp knows the lab": ("dsp/stereo/bad.cpp", '#include "lab/ordered.h"', "must not know"),
    "the appliance knows the lab": ("firmware/bad.cpp", '#include "lab/ordered.h"', "must not know"),
    "the lab knows a dataset": ("lab/bad.cpp", '#include "dataset/scene.h"', "must not know"),
    "dsp knows a dataset": ("dsp/base/bad.cpp", '#include "dataset/scene.h"', "must not know"),
    "Eigen outside of calib": ("dsp/stereo/bad.cpp", "#include <Eigen/Core>", "<Eigen/Core>"),
    "Eigen in a header": ("dsp/calib/bad.h", "#pragma once\n#include <Eigen/Core>", ":2: "),
    "NEON by its own name": ("dsp/pmd/bad_neon.cpp", "#include <arm_neon.h>", "dsp/base/simd.h alone"),
    "SIMDe by its own name": ("dsp/pmd/bad_neon.cpp", "#include <simde/arm/neon.h>", "dsp/base/simd.h alone"),
    "some vectors in a reference": ("dsp/pmd/bad_ref.cpp", '#include "dsp/base/simd_lowest.h"',
                                    "outside of a *_neon.cpp"),
    "vectors in a reference": ("dsp/pmd/bad_ref.cpp", '#include "dsp/base/simd.h"', "outside of a *_neon.cpp"),
    "vectors by a helper": ("dsp/pmd/bad_ref.cpp", '#include "dsp/stereo/sums_neon.h"', "outside of a *_neon.cpp"),
    "AVX2 by its own name": ("dsp/pmd/bad_avx2.cpp", "#include <immintrin.h>", "dsp/base/avx2.h alone"),
    "AVX2 in a file for all": ("dsp/pmd/bad.cpp", '#include "dsp/base/avx2.h"', "outside of a *_avx2.cpp"),
    "a NEON store that no build mutates": ("dsp/pmd/bad_neon.cpp", "vst3q_u8(p, v);", "vst3q_u8 is mutated by no build"),
    "a wide store of its own": ("dsp/pmd/bad_avx2.cpp", "_mm256_stream_si256(p, v);", "outside of dsp/base/avx2.h"),
    "an interface knows dsp's methods": ("hal/bad.h", '#pragma once\n#include "dsp/stereo/sad.h"', "hal/* must not know"),
    "an interface knows a library": ("hal/bad.h", "#pragma once\n#include <libusb.h>", "<libusb.h>"),
    "an interface knows an adapter": ("hal/bad.h", '#pragma once\n#include "hal/emu/camera.h"', "implementation"),
    "framing knows a method": ("hal/framing/bad.cpp", '#include "dsp/stereo/sad.h"', "must not know"),
    "emu knows linux": ("hal/emu/bad.cpp", '#include "hal/linux/usb.h"', "must not know"),
    "emu knows a board": ("hal/emu/bad.cpp", '#include "board/config.h"', "must not know"),
    "emu knows the loop": ("hal/emu/bad.cpp", '#include "firmware/loop.h"', "must not know"),
    "linux knows emu": ("hal/linux/bad.cpp", '#include "hal/emu/camera.h"', "must not know"),
    "linux knows a dataset": ("hal/linux/bad.cpp", '#include "dataset/scene.h"', "must not know"),
    "board.h knows an adapter": ("board/board.h", '#pragma once\n#include "hal/emu/camera.h"', "must not know"),
    "a table knows an adapter": ("board/x/config.h", '#pragma once\n#include "hal/emu/camera.h"', "must not know"),
    "a table by a macro": ("board/x/config.h", "#pragma once\n#include CONFIG", "macro CONFIG"),
    "a board knows a library": ("board/x/board.cpp", "#include <gpiod.h>", "must not know <gpiod.h>"),
    "a board knows the loop": ("board/x/board.cpp", '#include "firmware/loop.h"', "must not know"),
    "the loop knows emu": ("firmware/bad.cpp", '#include "hal/emu/camera.h"', "only board/<name>/"),
    "the loop knows one board": ("firmware/bad.cpp", '#include "board/emu/config.h"', "must not know"),
    "the loop knows framing": ("firmware/bad.cpp", '#include "hal/framing/cobs.h"', "must not know"),
    "the loop knows a dataset": ("firmware/bad.cpp", '#include "dataset/scene.h"', "must not know"),
    "the loop knows a library": ("firmware/bad.cpp", "#include <nlohmann/json.hpp>", "must not know"),
    "the wire knows the loop": ("firmware/wire/bad.cpp", '#include "firmware/loop.h"', "must not know"),
    "the wire knows a device": ("firmware/wire/bad.cpp", '#include "hal/time.h"', "must not know"),
    "the host knows the loop": ("host/bad.cpp", '#include "firmware/loop.h"', "must not know"),
    "the host knows a device": ("host/bad.cpp", '#include "hal/camera.h"', "must not know"),
    "the loop knows a board's flags": ("firmware/bad.cpp", '#include "board/emu/flags.h"', "must not know"),
    "the host knows a board": ("host/bad.cpp", '#include "board/board.h"', "must not know"),
    "a dataset knows a method": ("dataset/bad.cpp", '#include "dsp/stereo/sad.h"', "must not know"),
    "a dataset knows a device": ("dataset/bad.cpp", '#include "hal/camera.h"', "must not know"),
    "a missing file": ("tests/dsp/bad.cpp", '#include "dsp/base/gone.h"', "does not exist"),
    "a path from its own folder": ("dsp/base/bad.cpp", '#include "image.h"', "from the root"),
    "C's name of a header": ("dsp/base/bad.cpp", "#include <stdint.h>", "<cstdint>"),
    "own file as a library": ("firmware/bad.cpp", "#include <dsp/base/image.h>", 'include "dsp/base/image.h"'),
    "no guard": ("host/bad.h", "int f();", "#pragma once"),
    "another ending": ("host/bad.hpp", "#pragma once", ".hpp"),
    "a long header": ("host/bad.h", "#pragma once" + "\n" * 150 + "int f();", "151 lines"),
    "a long source": ("host/bad.cpp", "\n" * 500 + "int i;", "501 lines"),
    "a long first page": ("README.md", "line\n" * 151, "151 lines"),
    "a wide first page": ("README.md", "x" * 121, "121 characters"),
    "a long test": ("tests/host/bad.cpp", "\n" * 500 + "int i;", "501 lines"),
}


def findings(files):
    with tempfile.TemporaryDirectory() as folder:
        for path, text in files.items():
            file = pathlib.Path(folder, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        return check_layers.check_tree(folder)


class CheckLayersTest(unittest.TestCase):
    def test_says_nothing_about_a_tree_in_order(self):
        self.assertEqual(findings(GOOD), [])

    def test_allows_files_of_the_full_length(self):
        full = {
            "host/a.h": "#pragma once\n" + "\n" * 149,
            "host/a.cpp": "\n" * 300,
            "tests/host/a.cpp": "\n" * 400,
        }
        self.assertEqual(findings(full), [])

    def test_points_at_the_line_of_the_include(self):
        found = findings({"dsp/a.cpp": "// first line\n\n  #  include <unistd.h> // for read\n"})
        self.assertEqual(len(found), 1)
        self.assertTrue(found[0].startswith("dsp/a.cpp:3: "), found[0])

    def test_says_what_to_do(self):
        for what, (path, text, _) in BROKEN.items():
            with self.subTest(what):
                for line in findings({**GOOD, path: text}):
                    self.assertRegex(line, r"^[^:]+:\d+: [^:]+: \S")


def breaking(path, text, said):
    def test(self):
        found = findings({**GOOD, path: text})
        self.assertEqual(len(found), 1, found)
        self.assertTrue(found[0].startswith(path + ":"), found[0])
        self.assertIn(said, found[0])
    return test


for name, case in BROKEN.items():
    setattr(CheckLayersTest, "test_finds_" + name.replace(" ", "_").replace("'", ""), breaking(*case))

if __name__ == "__main__":
    unittest.main()
