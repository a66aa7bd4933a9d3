#!/usr/bin/env python3
"""Tests of scripts/check_avx_symbols.py."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import check_avx_symbols  # noqa: E402

LISTING = """\
0000000000000000 r .L.str
                 U stof::dsp::check_failed(char const*, char const*, int)
                 w __gmon_start__
0000000000000000 T stof::dsp::avx2::sum_path_costs(int)
0000000000000040 t stof::dsp::avx2::(anonymous namespace)::own()
"""


class SharedSymbols(unittest.TestCase):
    def test_own_and_needed_ones_are_none(self):
        self.assertEqual(check_avx_symbols.shared_symbols(LISTING), [])

    def test_an_inline_function_is_one(self):
        listing = LISTING + "0000000000000080 W std::span<int>::size() const\n"
        self.assertEqual(check_avx_symbols.shared_symbols(listing), ["std::span<int>::size() const"])

    def test_a_unique_variable_is_one(self):
        listing = LISTING + "0000000000000000 u guard variable for table()::values\n"
        self.assertEqual(check_avx_symbols.shared_symbols(listing), ["guard variable for table()::values"])

    def test_a_kernel_template_is_its_object_s_own(self):
        kernel = "void stof::dsp::avx2::winners<unsigned char>(std::span<unsigned char const>)"
        self.assertEqual(check_avx_symbols.findings_of({"winner_avx2.cpp.o": [kernel], "path_avx2.cpp.o": []}), [])
        self.assertEqual(len(check_avx_symbols.findings_of({"winner_avx2.cpp.o": [kernel], "path_avx2.cpp.o": [kernel]})), 2)
        self.assertEqual(len(check_avx_symbols.findings_of({"tile_sums_avx512.cpp.o": [kernel]})), 1)
        self.assertEqual(len(check_avx_symbols.findings_of({"winner_avx2.cpp.o": ["std::span<int>::size() const"]})), 1)

    def test_a_folder_without_objects_is_no_success(self):
        self.assertEqual(check_avx_symbols.main(["/nowhere"]), 2)


if __name__ == "__main__":
    unittest.main()
