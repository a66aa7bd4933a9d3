#!/usr/bin/env python3
"""report_test.py -- COMMAND...: `stof evaluate chapter` on small scenes that the test makes: the page is whole, refers to nothing
outside of itself, and its pictures decode. STOF_EMU_PAIR holds the command stof_emu_pair, its words separated by |."""

import base64
import html.parser
import json
import math
import os
import pathlib
import random
import re
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

COMMAND = []
PAIR = [word for word in os.environ.get("STOF_EMU_PAIR", "").split("|") if word]
SECTIONS = ("claims", "scenes", "methods", "maps", "block-time", "blocks", "adaptive", "interest", "filters", "pyramid",
            "annealing", "presets", "brightness", "corridor")
VOID = {"meta", "img", "br", "hr", "link", "input"}


def write_scene(folder, truth=True, mask=True, rig=False, width=72, height=48):
    """A square, 6 px near, before a wall at 2 px, both with random texture."""
    rng = random.Random(5)
    folder.mkdir()
    wall = [[rng.randrange(256) for _ in range(width + 8)] for _ in range(height)]
    square = [[rng.randrange(256) for _ in range(width)] for _ in range(height)]
    left, right, depth, seen = (bytearray(width * height) for _ in range(4))
    for y in range(height):
        for x in range(width):
            i = y * width + x
            near = 28 <= x < 52 and 14 <= y < 36
            left[i] = square[y][x] if near else wall[y][x]
            near_right = 22 <= x < 46 and 14 <= y < 36
            right[i] = square[y][x + 6] if near_right else wall[y][x + 2]
            depth[i] = 4 * (6 if near else 2)
            hidden = x < 2 or (not near and 14 <= y < 36 and 24 <= x < 28)
            seen[i] = 0 if hidden else 255
    header = f"P5\n{width} {height}\n255\n".encode()
    for name, pixels, wanted in (("left", left, True), ("right", right, True), ("gt_left", depth, truth),
                                 ("nonocc", seen, truth and mask)):
        if wanted:
            (folder / f"{name}.pgm").write_bytes(header + bytes(pixels))
    (folder / "meta.txt").write_text("ndisp 16\ngt_scale 4\n" + ("f_px 60\nbaseline_m 0.1\n" if rig else ""))
    return folder


class Reader(html.parser.HTMLParser):
    """Ids, figures and everything that a browser would fetch; complains about tags that are not closed."""

    def __init__(self):
        super().__init__()
        self.ids, self.pictures, self.references, self.open, self.scripts = [], [], [], [], 0
        self.text = []

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        if tag not in VOID and tag not in ("rect", "path"):
            self.open.append(tag)
        self.scripts += tag in ("script", "iframe", "object", "embed")
        if "id" in attributes:
            self.ids.append(attributes["id"])
        for key in ("src", "href", "srcset", "data", "poster", "action"):
            if key in attributes:
                self.references.append(attributes[key])
        if tag == "img":
            self.pictures.append(attributes)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            raise AssertionError(f"</{tag}> closes nothing")

    def handle_data(self, data):
        if self.open and self.open[-1] != "style":
            self.text.append(data)


def png_size(data):
    """(width, height) of a PNG whose chunks and pixels are all there."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n", "no PNG"
    at, packed, header, palette = 8, b"", None, 0
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        assert struct.unpack(">I", data[at + 8 + length:at + 12 + length])[0] == zlib.crc32(kind + body), kind
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        palette = length // 3 if kind == b"PLTE" else palette
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    width, height, depth, colour, _, _, interlace = header
    assert interlace == 0 and colour in (0, 2, 3) and (colour != 3 or palette)
    row = math.ceil(width * depth * {0: 1, 2: 3, 3: 1}[colour] / 8) + 1
    assert len(zlib.decompress(packed)) == row * height, "not all pixels"
    return width, height


class Report(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_stof(self, *arguments):
        return subprocess.run([*COMMAND, "evaluate", "chapter", *map(str, arguments)], capture_output=True, text=True, timeout=280,
                              cwd=self.folder)

    def page(self, *arguments):
        """(stdout, text, Reader) of a page; it is checked to be well formed and self-contained."""
        ended = self.run_stof(*arguments, "--out", "out/page.html", "--quick")
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        self.assertEqual(ended.stdout.splitlines()[-1], "out/page.html")
        text = (self.folder / "out" / "page.html").read_text()
        reader = Reader()
        reader.feed(text)
        reader.close()
        self.assertEqual(reader.open, [])
        self.assertEqual(reader.scripts, 0)
        for reference in reader.references:
            self.assertRegex(reference, r"^(#[a-z-]+|data:image/png;base64,)")
        bare = re.sub(r"base64,[^\"]*", "", text)
        self.assertEqual(re.findall(r"https?:|url\(|@import|\bnan\b|\binf\b|>-0<", bare), [])
        return ended.stdout, text, reader

    def test_page_is_whole_and_refers_to_nothing_outside_of_itself(self):
        scene = write_scene(self.folder / "Square & co")
        corridor = write_scene(self.folder / "corridor", rig=True)
        stdout, text, reader = self.page(scene, "--corridor", corridor)
        self.assertEqual(reader.ids, list(SECTIONS))
        for reference in reader.references:
            if reference.startswith("#"):
                self.assertIn(reference[1:], reader.ids)
        self.assertTrue("Square &amp; co" in text)
        self.assertNotIn("left out", stdout)
        self.assertGreater(len(reader.pictures), 30)
        for picture in reader.pictures:
            data = base64.b64decode(picture["src"].split(",", 1)[1], validate=True)
            self.assertEqual(png_size(data), (int(picture["width"]), int(picture["height"])), picture["alt"])
            self.assertTrue(picture["alt"])
        claims = re.findall(r"Holds here</dt><dd><span class=\"chip (\w+)\"", text)
        self.assertGreaterEqual(len(claims), 11)
        self.assertEqual(sum(line.startswith(("yes ", "partly ", "no ", "not measured ")) for line in stdout.splitlines()),
                         len(claims))
        self.assertNotIn("unknown", claims)

    def test_scene_without_truth_has_maps_but_no_figures_of_merit(self):
        _, text, reader = self.page(write_scene(self.folder / "Blind", truth=False))
        self.assertEqual([name for name in SECTIONS if name != "corridor"], reader.ids)
        self.assertGreater(len(reader.pictures), 8)
        self.assertIn("not measured", "".join(reader.text))
        self.assertFalse("Against the truth" in text)

    def test_scene_without_mask_is_judged_by_all_pixels(self):
        _, text, _ = self.page(write_scene(self.folder / "Bare", mask=False))
        self.assertTrue("% bad of all" in text)
        self.assertFalse("% bad not occluded" in text)

    def test_plain_times_stand_beside_the_others_and_the_maps_are_equal(self):
        scene = write_scene(self.folder / "Scene")
        _, without, _ = self.page(scene)
        self.assertIn("not timed with the plain kernels", without)
        _, text, _ = self.page(scene, "--plain")
        [whole] = re.findall(r"same map, bit for bit, in all (\d+) whole methods", text)
        self.assertGreaterEqual(int(whole), 8)
        self.assertGreaterEqual(text.count(" ×</td>") - without.count(" ×</td>"), int(whole))

    @unittest.skipUnless(PAIR, "no emulated board in this build")
    def test_emulated_pair_is_a_scene_with_truth_and_a_rig(self):
        ended = subprocess.run([*PAIR, "pair"], capture_output=True, text=True, timeout=200, cwd=self.folder)
        self.assertEqual((ended.returncode, ended.stdout, ended.stderr), (0, "", ""))
        meta = (self.folder / "pair" / "meta.txt").read_text()
        self.assertRegex(meta, r"(?m)^f_px 615$")
        ended = subprocess.run([*COMMAND, "evaluate", "stereo", "pair", "--lr", "--runs", "1", "--json"],
                               capture_output=True, text=True, timeout=200, cwd=self.folder)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        [scene] = json.loads(ended.stdout)["scenes"]
        self.assertEqual((scene["width"], scene["height"], scene["ndisp"]), (640, 480, 64))
        # Walls without texture match anywhere; what agrees from both sides is mostly right.
        self.assertLess(scene["bp_percent"]["valid"], 40)

    @unittest.skipUnless(PAIR, "no emulated board in this build")
    def test_emulated_pair_refuses_what_it_cannot_do_in_one_line(self):
        (self.folder / "file").write_text("")
        for arguments in ([], ["a", "b"], ["file"]):
            ended = subprocess.run([*PAIR, *arguments], capture_output=True, text=True, timeout=60, cwd=self.folder)
            self.assertEqual((ended.returncode, ended.stderr.count("\n")), (2, 1), ended.stderr)
            self.assertTrue(ended.stderr.startswith("stof_emu_pair: "))

    def refuse(self, fact, *arguments):
        ended = self.run_stof(*arguments)
        self.assertEqual(ended.returncode, 2, ended.stderr)
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertIn(fact, ended.stderr)

    def test_bad_input_is_refused_in_one_line(self):
        scene = write_scene(self.folder / "Scene")
        self.refuse("--out", scene)
        self.refuse("DIR", "--out", "page.html")
        self.refuse("absent", "absent", "--out", "page.html")
        self.refuse("has no rig", scene, "--corridor", scene, "--out", "page.html")
        self.refuse("--runs", scene, "--runs", "0", "--out", "page.html")
        self.refuse("cannot be written", scene, "--quick", "--out", scene / "left.pgm" / "page.html")


def main():
    COMMAND.extend(sys.argv[sys.argv.index("--") + 1:])
    unittest.main(argv=[sys.argv[0]], verbosity=2)


if __name__ == "__main__":
    main()
