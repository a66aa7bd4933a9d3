"""The cases of a run of ctest. A GoogleTest program is one test of ctest; it writes its cases into a file of its own."""

import dataclasses
import pathlib
import re
import xml.etree.ElementTree

PASSED, FAILED, SKIPPED = "passed", "failed", "skipped"
# stof_add_test() names its programs so, and .host, .slow or .every_machine for a part of one.
GTEST_PROGRAM = re.compile(r".*_test(\.[a-z_]+)?")


@dataclasses.dataclass
class Case:
    name: str
    status: str
    said: str = ""  # of one that failed or was skipped


def last_line(output):
    """What a program says when it ends with the code of a skip."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    return lines[-1] if lines else "no reason given"


def gtest_reason(message):
    """A message of GTEST_SKIP() comes after a line FILE:LINE."""
    return " ".join(message.splitlines()[1:]).strip() or "no reason given"


def of_program(report):
    """The cases that a GoogleTest program wrote; those that its filter left out are none."""
    cases = []
    for case in xml.etree.ElementTree.parse(report).getroot().iter("testcase"):
        if case.get("status") != "run" and case.get("result") != "skipped":
            continue
        name = f"{case.get('classname')}.{case.get('name')}"
        failures = [failure.get("message") or failure.text or "" for failure in case.findall("failure")]
        skipped = case.find("skipped")
        if failures:
            cases.append(Case(name, FAILED, "\n".join(failures)))
        elif skipped is not None:
            cases.append(Case(name, SKIPPED, gtest_reason(skipped.get("message") or "")))
        else:
            cases.append(Case(name, PASSED))
    return cases


def of_test(test, folder):
    """The cases of a <testcase> of ctest's report: those of folder/NAME.xml, else the test itself."""
    name, status, output = test.get("name"), test.get("status"), test.findtext("system-out") or ""
    report = folder / f"{name}.xml"
    cases = of_program(report) if report.is_file() else []
    if status not in ("run", "notrun", "disabled"):
        # What ended badly without a word of a failed case: a crash, a leak, a time limit.
        return cases if any(case.status == FAILED for case in cases) else [*cases, Case(name, FAILED, output)]
    if report.is_file():
        return cases
    if status == "run" and GTEST_PROGRAM.fullmatch(name):
        return [Case(name, FAILED, "ended before its last case, with the code of success")]
    return [Case(name, PASSED) if status == "run" else Case(name, SKIPPED, last_line(output))]


def of_run(junit, folder):
    """The cases of a report of ctest (--output-junit); `folder` has those of its programs."""
    if not pathlib.Path(junit).is_file():
        return []
    return [case for test in xml.etree.ElementTree.parse(junit).getroot().findall("testcase")
            for case in of_test(test, folder)]
