#!/usr/bin/env python3
"""Whether scripts/budgets.py notices what it is there for, on files made here."""

import pathlib
import struct
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import budgets  # noqa: E402

WITHIN = {"virt": {"text_kib": 8, "data_kib": 8, "bss_kib": 8, "frame_bytes": 1000}}


def program(*parts, machine=budgets.ARM64):
    """An ELF file of nothing but program headers: (type, flags, bytes in the file, bytes in memory)."""
    head = b"\x7fELF\x02\x01" + bytes(10) + struct.pack("<HHI", 2, machine, 1) + bytes(8)
    head += struct.pack("<Q", 64) + bytes(8) + bytes(4) + struct.pack("<HHH", 64, 56, len(parts)) + bytes(6)
    body = b"".join(struct.pack("<IIQQQQQQ", kind, flags, 0, 0, 0, in_file, in_memory, 0)
                    for kind, flags, in_file, in_memory in parts)
    return head + body


class Budgets(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.build = pathlib.Path(folder.name)
        (self.build / "bin").mkdir()
        (self.build / "CMakeCache.txt").write_text("STOF_BOARD:STRING=virt\n")
        (self.build / "a.su").write_text("a.cpp:1:1:f\t96\tstatic\nb.cpp:2:2:int g()\t960\tstatic\n")
        self.put((budgets.PT_LOAD, 5, 4096, 4096), (budgets.PT_LOAD, 6, 1024, 3072))

    def put(self, *parts, **options):
        (self.build / "bin" / "stofd").write_bytes(program(*parts, **options))

    def verdicts(self):
        return [within for _, within in budgets.judge(self.build, WITHIN)]

    def test_counts_text_data_and_bss_apart(self):
        self.assertEqual(budgets.sizes(self.build / "bin" / "stofd"), {"text": 4096, "data": 1024, "bss": 2048})
        self.assertEqual(self.verdicts(), [True] * 4)

    def test_each_budget_is_kept_alone(self):
        self.put((budgets.PT_LOAD, 5, 9000, 9000), (budgets.PT_LOAD, 6, 0, 0))
        self.assertEqual(self.verdicts(), [False, True, True, True])
        self.put((budgets.PT_LOAD, 5, 1, 1), (budgets.PT_LOAD, 6, 9000, 9000))
        self.assertEqual(self.verdicts(), [True, False, True, True])
        self.put((budgets.PT_LOAD, 5, 1, 1), (budgets.PT_LOAD, 6, 0, 9000))
        self.assertEqual(self.verdicts(), [True, True, False, True])

    def test_a_large_or_unbounded_frame_is_over(self):
        (self.build / "b.su").write_text("c.cpp:3:3:h\t1001\tstatic\n")
        self.assertEqual(self.verdicts()[3], False)
        (self.build / "b.su").write_text("c.cpp:3:3:h\t16\tdynamic\n")
        self.assertEqual(self.verdicts()[3], False)

    def test_frames_of_library_headers_are_the_library_s(self):
        (self.build / "b.su").write_text("../sysroot/usr/include/eigen3/a.h:3:3:h\t16\tdynamic\n")
        self.assertEqual(self.verdicts()[3], True)

    def test_without_any_frame_nothing_is_known(self):
        (self.build / "a.su").unlink()
        self.assertEqual(self.verdicts()[3], False)

    def test_a_loader_and_libraries_are_refused(self):
        for kind in (budgets.PT_INTERP, budgets.PT_DYNAMIC):
            self.put((budgets.PT_LOAD, 5, 1, 1), (kind, 4, 1, 1))
            with self.assertRaisesRegex(ValueError, "-static"):
                self.verdicts()

    def test_another_processor_is_refused(self):
        self.put((budgets.PT_LOAD, 5, 1, 1), machine=62)
        with self.assertRaisesRegex(ValueError, "not a 64-bit ARM program"):
            self.verdicts()


if __name__ == "__main__":
    unittest.main()
