#!/usr/bin/env python3
"""Tests of scripts/testing/cases.py: no case of a program is lost, and none is told twice."""

import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts" / "testing"))
import cases  # noqa: E402
from cases import FAILED, PASSED, SKIPPED  # noqa: E402

PROGRAM = """<?xml version="1.0" encoding="UTF-8"?>
<testsuites tests="4" failures="1" name="AllTests">
  <testsuite name="Sad" tests="3">
    <testcase name="Adds" status="run" result="completed" time="0.1" classname="Sad" />
    <testcase name="Subtracts" status="run" result="completed" time="0.1" classname="Sad">
      <failure message="sad_test.cpp:3&#x0A;Expected: 1" type=""><![CDATA[sad_test.cpp:3]]></failure>
      <failure message="sad_test.cpp:4&#x0A;Expected: 2" type=""><![CDATA[sad_test.cpp:4]]></failure>
    </testcase>
    <testcase name="OnScenes" status="run" result="skipped" time="0" classname="Sad">
      <skipped message="sad_test.cpp:9&#x0A;STOF_DATA is not set"><![CDATA[sad_test.cpp:9]]></skipped>
    </testcase>
    <testcase name="LeftOut" status="notrun" result="suppressed" time="0" classname="Sad" />
  </testsuite>
  <testsuite name="All/Level" tests="1">
    <testcase name="Equals/0" status="run" result="completed" time="0.1" classname="All/Level" />
  </testsuite>
</testsuites>
"""
PASSING = """<testsuites><testsuite><testcase name="Adds" status="run" result="completed" classname="Sad" /></testsuite></testsuites>"""


class CasesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def ran(self, *tests):
        """(name, status, said) of each case, where ctest told these (name, status, output) of its tests."""
        report = self.folder / "junit.xml"
        report.write_text("<testsuite>" + "".join(
            f'<testcase name="{name}" status="{status}"><system-out>{output}</system-out></testcase>'
            for name, status, output in tests) + "</testsuite>")
        return [(case.name, case.status, case.said) for case in cases.of_run(report, self.folder)]

    def test_a_program_is_its_cases(self):
        (self.folder / "sad_test.xml").write_text(PROGRAM)
        self.assertEqual(self.ran(("sad_test", "fail", "much")), [
            ("Sad.Adds", PASSED, ""),
            ("Sad.Subtracts", FAILED, "sad_test.cpp:3\nExpected: 1\nsad_test.cpp:4\nExpected: 2"),
            ("Sad.OnScenes", SKIPPED, "STOF_DATA is not set"),
            ("All/Level.Equals/0", PASSED, "")])

    def test_another_program_is_one_case(self):
        self.assertEqual(self.ran(("Program.View", "run", "fine"), ("Program.Link", "fail", "so\nbad"),
                                  ("Program.Zeroconf", "notrun", "much\nno zeroconf\n")), [
            ("Program.View", PASSED, ""), ("Program.Link", FAILED, "so\nbad"),
            ("Program.Zeroconf", SKIPPED, "no zeroconf")])

    def test_a_program_that_ends_before_it_reports_failed(self):
        self.assertEqual(self.ran(("sad_test", "fail", "Segmentation fault")), [("sad_test", FAILED, "Segmentation fault")])

    def test_a_program_that_leaves_with_success_before_it_reports_failed(self):
        for name in ("sad_test", "sad_test.host"):
            self.assertEqual([case[:2] for case in self.ran((name, "run", "exit(0)"))], [(name, FAILED)])

    def test_a_part_of_a_program_may_have_no_case(self):
        (self.folder / "sad_test.every_machine.xml").write_text("<testsuites/>")
        self.assertEqual(self.ran(("sad_test.every_machine", "run", "")), [])

    def test_a_program_that_ends_badly_after_its_last_case_failed(self):
        (self.folder / "sad_test.xml").write_text(PASSING)
        self.assertEqual(self.ran(("sad_test", "fail", "detected memory leaks")), [
            ("Sad.Adds", PASSED, ""), ("sad_test", FAILED, "detected memory leaks")])

    def test_without_a_report_there_are_none(self):
        self.assertEqual(cases.of_run(self.folder / "junit.xml", self.folder), [])


if __name__ == "__main__":
    unittest.main()
