#!/usr/bin/env python3
"""Tests of what scripts/test_steps.py finds by itself."""

import concurrent.futures
import contextlib
import io
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import unittest
from unittest import mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import test_steps  # noqa: E402


class BoardsTest(unittest.TestCase):
    def boards(self, folders, presets):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name in folders:
                (root / "board" / name).mkdir(parents=True)
                (root / "board" / name / "config.h").write_text("#pragma once\n")
            (root / "board" / "devices").mkdir(parents=True)  # no board: it has no table
            (root / "CMakePresets.json").write_text(json.dumps({"configurePresets": [
                {"name": name, "cacheVariables": {"STOF_BOARD": board}} for name, board in presets.items()]}))
            return test_steps.boards_to_build(root)

    def test_every_folder_with_a_table_is_built(self):
        self.assertEqual(self.boards(["emu", "virt", "mine"], {"emu": "emu", "virt": "virt", "mine": "mine"}),
                         (["mine", "virt"], []))

    def test_a_board_without_its_preset_is_told(self):
        for presets in ({"emu": "emu"}, {"emu": "emu", "mine": "virt"}):
            boards, wrong = self.boards(["emu", "mine"], presets)
            self.assertEqual(boards, ["mine"])
            self.assertEqual(len(wrong), 1)
            self.assertIn("board mine is never built", wrong[0])

    def test_this_tree_is_in_order(self):
        boards, wrong = test_steps.boards_to_build(test_steps.ROOT)
        self.assertEqual(wrong, [])
        self.assertIn("virt", boards)


class RunsTest(unittest.TestCase):
    def test_every_step_is_in_a_run(self):
        self.assertEqual(set(test_steps.STEPS), {*test_steps.SHORT, *test_steps.CI, *test_steps.ALL})

    def test_a_longer_run_has_what_a_shorter_one_has(self):
        # arm64 builds and runs all tests, so those of arm64-kernels, too; emu-rest and emu-asan have those of emu between them.
        self.assertLessEqual(set(test_steps.SHORT) - {"arm64-kernels", "emu"}, set(test_steps.CI))
        self.assertLessEqual({"arm64", "emu-rest", "emu-asan"}, set(test_steps.CI))
        self.assertLessEqual((set(test_steps.CI) - {"emu-rest"}) | {"emu"}, set(test_steps.ALL))

    def test_what_sanitizers_leave_out_runs_without_them(self):
        presets = json.loads((test_steps.ROOT / "CMakePresets.json").read_text(encoding="utf-8"))["testPresets"]
        filters = {preset["name"]: preset.get("filter", {}) for preset in presets}

        def labels(part):
            return set(re.fullmatch(r"\^\((.*)\)\$", part["label"])[1].split("|"))

        left_out = labels(filters["emu-asan"]["exclude"])
        # Of label plain are those that no build with sanitizers has.
        self.assertLessEqual(left_out | {"kernel", "plain"}, labels(filters["emu-rest"]["include"]))

    def test_what_no_build_with_sanitizers_has_is_plain_or_slow(self):
        for lists in (test_steps.ROOT / "tests").rglob("CMakeLists.txt"):
            for block in re.findall(r"if\([^)\n]*NOT STOF_SANITIZED[^)\n]*\)(.*?)endif", lists.read_text(encoding="utf-8"), re.DOTALL):
                if "add_" in block:
                    self.assertIn("LABELS plain", block, lists)


class PreparationTest(unittest.TestCase):
    def setUp(self):
        patch = mock.patch.object(test_steps.Log, "__init__", lambda log, step: log.__dict__.update(
            path=test_steps.ROOT / step, aside=False))  # no file
        patch.start()
        self.addCleanup(patch.stop)

    def steps(self, **steps):
        said = io.StringIO()
        with (mock.patch.object(test_steps, "STEPS", steps), contextlib.redirect_stdout(said),
              concurrent.futures.ThreadPoolExecutor(1) as worker):
            return test_steps.run(list(steps), worker), said.getvalue()

    def test_a_step_is_prepared_while_the_one_before_it_is_judged(self):
        begun = threading.Event()

        def prepare(log):
            self.assertTrue(log.aside)
            begun.set()
            return 7

        def judge(log, prepared):
            self.assertFalse(log.aside)
            return test_steps.Count(passed=prepared)

        first = test_steps.plain(lambda log: test_steps.one(begun.wait(60)))
        code, said = self.steps(first=first, second=test_steps.Step(judge, prepare))
        self.assertEqual((code, said.splitlines()[-1]), (0, "8 passed, 0 failed"))

    def test_what_could_not_be_prepared_fails_its_step_alone(self):
        unbuilt = test_steps.Step(lambda log, built: test_steps.Count(failed=not built, details=["it"]), lambda log: False)
        code, said = self.steps(unbuilt=unbuilt, other=test_steps.ahead(lambda log: test_steps.Count(passed=1)))
        self.assertEqual((code, said.splitlines()[-1]), (1, "1 passed, 1 failed"))
        self.assertEqual(said.splitlines()[-4:-1], ["what failed, and the end of what it said:", "unbuilt: failed", "it"])


class UnitTestsTest(unittest.TestCase):
    def test_the_one_that_fails_is_named_with_what_it_said(self):
        with tempfile.TemporaryDirectory() as folder:
            with mock.patch.object(sys.modules["log"], "LOGS", pathlib.Path(folder)):
                log = test_steps.Log("it")
            good, bad = pathlib.Path(folder) / "good.py", pathlib.Path(folder) / "bad.py"
            good.write_text("print('Ran 3 tests')\n")
            bad.write_text("print('the reason')\nraise SystemExit(1)\n")
            self.assertEqual(test_steps.unit_tests(log, good), test_steps.Count(passed=3))
            count = test_steps.unit_tests(log, bad)
        self.assertEqual((count.passed, count.failed, count.notes), (0, 1, [f"failed: {bad}"]))
        self.assertIn("the reason", count.details[0])
        self.assertNotIn("Ran 3 tests", count.details[0])


class EndTest(unittest.TestCase):
    PROGRAM = ("import sys, threading\nsys.path.insert(0, sys.argv[1])\nimport log, pathlib, subprocess\n"
               "log.LOGS = pathlib.Path(sys.argv[2])\nstep = log.Log('it')\nstep.aside = True\n{before}"
               "other = threading.Thread(target=step.run, args=('sh', '-c', 'echo begun; sleep 600'))\nother.start()\n"
               "{meanwhile}other.join()\nprint(step.run('true'))\n")

    def ended(self, **parts):
        with tempfile.TemporaryDirectory() as folder:
            program = subprocess.run(
                [sys.executable, "-B", "-c", self.PROGRAM.format(**parts), str(test_steps.ROOT / "scripts" / "testing"), folder],
                capture_output=True, text=True, timeout=300, check=False)
            self.assertEqual((program.returncode, program.stdout, program.stderr), (0, "False\n", ""))

    def test_what_runs_aside_ends_with_the_run(self):
        self.ended(before="", meanwhile="while 'begun' not in step.lines(): pass\nlog.end_all()\n")

    def test_what_begins_while_the_run_ends_ends_too(self):
        self.ended(before=("log.aside()\nbegin = subprocess.Popen\n"
                           "def late(*command, **how):\n    log.end_all()\n    return begin(*command, **how)\n"
                           "subprocess.Popen = late\n"), meanwhile="")


class SkipsTest(unittest.TestCase):
    def test_cases_with_one_reason_are_one_line(self):
        count = test_steps.Count(skipped=1, skips={"no data": ["A.one"]})
        count.add(test_steps.Count(skipped=2, skips={"no data": ["B.two"], "no terminal": ["C.three"]}))
        self.assertEqual(test_steps.skip_lines(count.skips), [
            "skipped: 2 cases, the first is A.one: no data", "skipped: C.three: no terminal"])


if __name__ == "__main__":
    unittest.main()
