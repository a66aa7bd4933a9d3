#!/usr/bin/env python3
"""pmd_program_test.py -- COMMAND...: `stof evaluate pmd` (COMMAND, with an emulator before it in a cross build) on a
recording that the test makes: text, JSON, a page that refers to nothing outside of itself, and refusals in one line."""

import json
import math
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest

COMMAND = []
WIDTH, HEIGHT, EDGE = 16, 8, 8
NEAR, FAR = 1.0, 2.0


def write_pgm(file, rows):
    header = f"P5\n{len(rows[0])} {len(rows)}\n65535\n".encode()
    file.write_bytes(header + b"".join(struct.pack(f">{len(row)}H", *row) for row in rows))


def write_edge(folder, name="edge"):
    """Everything left of column EDGE is NEAR, right of it FAR, itself half of both. No noise."""
    folder.mkdir(exist_ok=True)
    planes = []
    for k in range(4):
        def sample(metres, turn=k / 4):
            return 600 + 400 * math.cos(2 * math.pi * (metres * 2 * 20e6 / 299792458.0 + turn))
        near, far = sample(NEAR), sample(FAR)
        row = [near] * EDGE + [(near + far) / 2] + [far] * (WIDTH - EDGE - 1)
        planes += [[round(value) for value in row]] * HEIGHT
    write_pgm(folder / f"{name}_raw.pgm", planes)
    for kind, in_edge in (("min", NEAR), ("med", NEAR), ("max", FAR)):
        row = [NEAR] * EDGE + [in_edge] + [FAR] * (WIDTH - EDGE - 1)
        write_pgm(folder / f"{name}_r_{kind}.pgm", [[round(8000 * metres) for metres in row]] * HEIGHT)
    (folder / f"{name}.json").write_text(json.dumps(
        {"width": WIDTH, "height": HEIGHT, "f_mod_hz": 20e6, "dark_lsb": 100, "sat_lsb": 4095, "fx": 200, "fy": 200,
         "cx": 7.5, "cy": 3.5, "lsb_e": 60, "read_e": 300, "x_edge_m": 0}))
    return folder


class EvaluatePmd(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_stof(self, *arguments):
        return subprocess.run([*COMMAND, "evaluate", "pmd", *map(str, arguments)], capture_output=True, text=True,
                              timeout=280, cwd=self.folder)

    def succeed(self, *arguments):
        ended = self.run_stof(*arguments)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertEqual(ended.stderr, "")
        return ended.stdout

    def refuse(self, fact, *arguments):
        ended = self.run_stof(*arguments)
        self.assertEqual(ended.returncode, 2, ended.stdout + ended.stderr)
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertIn(str(fact), ended.stderr)

    def test_text_names_what_is_there_and_what_is_absent(self):
        text = self.succeed(write_edge(self.folder / "edge"))
        self.assertIn("kernels ref and neon equal: yes", text)
        self.assertIn("the edge of a board before a wall", text)
        self.assertIn("absent: walls at known distances", text)

    def test_json_counts_every_mixed_pixel(self):
        report = json.loads(self.succeed(write_edge(self.folder / "edge"), "--json"))
        self.assertEqual(report["phase"]["samples"], 4_000_000)
        self.assertLess(report["phase"]["largest_error_lsb"], 1)
        counts = report["edges"][0]["all"]
        self.assertEqual(counts["mixed"], HEIGHT)
        self.assertEqual(counts["holds_both"], 1)
        self.assertEqual(counts["mixed_flagged"], 1)
        self.assertEqual(counts["pure_flagged"], 2 / (WIDTH - 1))

    def test_the_page_is_whole_and_refers_to_nothing_outside(self):
        page = self.folder / "new" / "page.html"
        self.succeed(write_edge(self.folder / "edge"), "--html", page)
        text = page.read_text()
        self.assertTrue(text.endswith("</html>\n"))
        self.assertEqual(text.count("<figure>"), 3)
        for link in re.findall(r'(?:src|href)="([^"]*)"', text):
            self.assertTrue(link.startswith(("data:image/png;base64,", "#")), link[:60])
        self.assertNotIn("<script", text)

    def test_bad_input_is_refused_in_one_line(self):
        edge = write_edge(self.folder / "edge")
        self.refuse("DIR")
        self.refuse("absent", "absent")
        (self.folder / "empty").mkdir()
        self.refuse("no PMD recording", "empty")
        self.refuse("--frames", edge, "--frames", "some")
        self.refuse("absent.cal", edge, "--calibration", "absent.cal")
        self.refuse("cannot be written", edge, "--html", edge / "edge.json" / "page.html")
        (edge / "edge_r_max.pgm").write_bytes(b"P5\n1 1\n65535\n\0\0")
        self.refuse("edge_r_max.pgm", edge)
        (edge / "edge.json").write_text("[]")
        self.refuse("edge.json", edge)


def main():
    COMMAND.extend(sys.argv[sys.argv.index("--") + 1:])
    unittest.main(argv=[sys.argv[0]], verbosity=2)


if __name__ == "__main__":
    main()
