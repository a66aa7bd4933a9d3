#!/usr/bin/env python3
"""Every test that docs/SECURITY.md names as its proof is there, and every row of its table names one.

security_test.py --list prints them, a regular expression of ctest a row.
"""

import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
ELSEWHERE = {"tests/fuzz": lambda: (ROOT / "tests/fuzz").is_dir(),
             "tests/system/image_network.py": lambda: (ROOT / "tests/system/image_network.py").is_file(),
             "scripts/link_bench attack": lambda: re.search(r"^def attack\(run\)", (ROOT / "scripts/link_bench").read_text(), re.M)}


def rows():
    """(what is tried, what shows the answer) of the table of answers."""
    text = (ROOT / "docs/SECURITY.md").read_text(encoding="utf-8")
    table = re.search(r"\| attack \| answer \| shown by \|\n\| --- \| --- \| --- \|\n(.*?)\n\n", text, re.S)[1]
    previous = []
    for line in table.splitlines():
        attack, _, shown = (cell.strip() for cell in line.strip("|").rsplit("|", 2)) if line.count("|") == 4 else (
            line.strip("| ").split(" | ")[0], "", line.strip("| ").split(" | ")[-1])
        previous = previous if shown == "the same" else re.findall(r"`([^`]+)`", shown)
        yield attack, previous


def known():
    """Names of all tests: of GoogleTest, those of ctest alone, and the cases of programs' tests."""
    names = set()
    for source in (ROOT / "tests").rglob("*_test.cpp"):
        names |= {f"{suite}.{name}" for suite, name in
                  re.findall(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", source.read_text(encoding="utf-8"), re.M)}
    for lists in (ROOT / "tests").rglob("CMakeLists.txt"):
        names |= set(re.findall(r"NAME (\w+\.\w+)", lists.read_text(encoding="utf-8")))
    for folder in ("tests/host", "tests/scripts"):
        for source in (ROOT / folder).rglob("*_test.py"):
            names |= set(re.findall(r"^    def (test_\w+)", source.read_text(encoding="utf-8"), re.M))
    names |= {f"Fuzz.{target.stem}" for target in (ROOT / "tests/fuzz").glob("*.cpp")}
    return names


def pattern(name):
    """A name of the table as a regular expression: its end may be open."""
    return re.escape(name.rstrip(".*")) + (".*" if name.endswith(("*", "...")) else "")


class Security(unittest.TestCase):
    def test_every_row_is_shown_by_tests_that_are_there(self):
        names, count = known(), 0
        for attack, shown in rows():
            self.assertTrue(shown, f"{attack}: shown by nothing")
            for name in shown:
                there = ELSEWHERE[name]() if name in ELSEWHERE else any(re.fullmatch(pattern(name), known) for known in names)
                self.assertTrue(there, f"{attack}: no test {name}")
                count += 1
        self.assertGreater(count, 50)

    def test_a_test_that_is_not_there_is_missed(self):
        self.assertFalse(any(re.fullmatch(pattern("StofdStart.NoSuchThing"), name) for name in known()))


if __name__ == "__main__":
    if sys.argv[1:] == ["--list"]:
        for attack, shown in rows():
            print(f"{attack}\t{'|'.join(f'^{pattern(name)}$' for name in shown if name not in ELSEWHERE)}")
    else:
        unittest.main()
