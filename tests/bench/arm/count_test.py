#!/usr/bin/env python3
"""The gate notices what it should: count.py and counting.py on made-up counts."""

import unittest

import count
import counting

STORED = {"wta": {"total": 1000, "neon::sad": 500}}


class Judge(unittest.TestCase):
    def grown(self, **counts):
        return count.judge({"wta": {name.replace("__", "::"): value for name, value in counts.items()}}, STORED)

    def test_lets_three_percent_pass(self):
        self.assertEqual(self.grown(total=1030, neon__sad=515), ([], []))

    def test_names_the_kernel_that_grew_and_by_how_much(self):
        grown, _ = self.grown(total=1030, neon__sad=520)
        self.assertEqual(len(grown), 1)
        self.assertIn("neon::sad", grown[0])
        self.assertIn("4.0 percent", grown[0])
        self.assertIn("--update", grown[0])

    def test_fails_a_frame_that_grew_though_no_stored_kernel_did(self):
        grown, notes = self.grown(total=1100, neon__other=500)
        self.assertEqual(len(grown), 1)
        self.assertIn("total", grown[0])
        self.assertIn("neon::other", notes[0])

    def test_tells_what_became_cheaper(self):
        grown, notes = self.grown(total=900)
        self.assertEqual(grown, [])
        self.assertIn("10.0 percent less", notes[0])

    def test_fails_a_task_of_which_nothing_is_stored(self):
        grown, _ = count.judge({"new": {"total": 1}}, STORED)
        self.assertIn("nothing is stored", grown[-1])

    def test_fails_a_stored_task_that_was_not_counted(self):
        grown, _ = count.judge({}, STORED)
        self.assertIn("wta", grown[0])


class Counting(unittest.TestCase):
    def test_adds_blocks_by_their_instructions(self):
        self.assertEqual(counting.total([(0, 3, 10), (12, 1, 5)]), 35)

    def test_shortens_names_to_what_people_call_them(self):
        for name, said in (
                ("stof::dsp::neon::phase(std::array<std::span<unsigned short const, 18ul>, 4ul> const&)", "neon::phase"),
                ("void stof::dsp::neon::(anonymous namespace)::sums<unsigned short>(std::span<int, 1ul>)", "neon::sums"),
                ("stof::dsp::RowSearch<unsigned short>::find(int)", "RowSearch::find"),
                ("memcpy", "memcpy")):
            self.assertEqual(counting.short(name), said)


if __name__ == "__main__":
    unittest.main()
