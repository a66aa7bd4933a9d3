#!/usr/bin/env python3
"""The steps of scripts/test, each with its time, its log in build/logs and its count of cases.

A case is one test of a test program, or one check (format, tidy, ...); a build that fails is one
failed case. With STOF_REQUIRE_DATA=1 a test that is skipped for want of recorded scenes counts as
failed; it is known by the name STOF_DATA in what it says.
"""

import argparse
import collections.abc
import concurrent.futures
import dataclasses
import itertools
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts" / "testing"))
import cases  # noqa: E402
from count import Count  # noqa: E402
from log import LOGS, Log, end_all, indented  # noqa: E402

CASE_LINES = 20
CASES_SHOWN = 10
# Build presets that share the folder of another one.
CONFIGURED_AS = {"emu-rest": "emu", "gcc-tests": "gcc", "arm64-kernels": "arm64", "arm64-host": "arm64",
                 "asan-rest": "emu-asan"}
FUZZ_RUNS = 20_000  # of each target; scripts/fuzz alone does more


@dataclasses.dataclass
class Step:
    """`judge(log, prepared)` gives a Count. `prepare(log)`, where there is one, runs before it, while the tests of steps
    before this one run; `prepared` is what it returned. Tests of real programs wait half of their time."""

    judge: collections.abc.Callable
    prepare: collections.abc.Callable | None = None


def one(succeeded):
    return Count(passed=1) if succeeded else Count(failed=1)


def plain(count):
    """A step with nothing to prepare: count(log)."""
    return Step(lambda log, _: count(log))


def ahead(count):
    """A step that measures nothing and tests no program: all of it is preparation."""
    return Step(lambda _, prepared: prepared, count)


def check(*command):
    """A step that is one case: a command that must succeed."""
    return plain(lambda log: one(log.run(*command)))


def unit_tests(log, script):
    """The cases of a Python test."""
    seen = len(log.lines())
    succeeded = log.run("python3", "-B", script)
    said = log.lines()[seen:]
    ran = re.findall(r"^Ran (\d+) tests", "\n".join(said), re.MULTILINE)
    if succeeded and ran:
        return Count(passed=int(ran[-1]))
    return Count(failed=1, notes=[f"failed: {script}"],
                 details=[f"    --- {script}\n{indented(said[-CASE_LINES:])}"])


def layers(log):
    count = one(log.run("scripts/check_layers.py"))
    count.add(unit_tests(log, "tests/scripts/check_layers_test.py"))
    count.add(unit_tests(log, "tests/scripts/test_steps_test.py"))
    count.add(unit_tests(log, "tests/scripts/cases_test.py"))
    count.add(one(log.run("scripts/wire_table.py", "--check")))
    count.add(unit_tests(log, "tests/scripts/wire_table_test.py"))
    count.add(unit_tests(log, "tests/scripts/security_test.py"))
    count.add(unit_tests(log, "tests/scripts/tidy_test.py"))
    count.add(unit_tests(log, "tests/scripts/packaging_test.py"))
    count.add(unit_tests(log, "tests/scripts/ros2_folder_test.py"))
    return count


def objects(log, preset, script):
    """What the kernels of a build are made of, by a script, and whether the script would notice."""
    count = unit_tests(log, f"tests/scripts/{script}_test.py")
    looked = one(log.run(f"scripts/{script}.py", f"build/{configured(preset)}"))
    if looked.failed:
        looked.notes.append(f"failed: scripts/{script}.py")
        looked.details.append(f"    --- {script}\n{indented(log.lines()[-CASE_LINES:])}")
    count.add(looked)
    return count


def configured(preset):
    return CONFIGURED_AS.get(preset, preset)


def build(log, preset):
    return (log.run("cmake", "--preset", configured(preset), "-Wno-dev")
            and log.run("cmake", "--build", "--preset", preset, "--", "-k", "0"))


def ctest(log, preset):
    """(ctest's verdict, its cases) of a build."""
    folder = ROOT / "build" / configured(preset)
    report, programs = folder / "junit.xml", folder / "cases"
    report.unlink(missing_ok=True)
    shutil.rmtree(programs, ignore_errors=True)
    return log.run("ctest", "--preset", preset, "--output-junit", report), cases.of_run(report, programs)


def skip_lines(skips):
    """A line for each reason: the case, or how many and the first of them."""
    return [f"skipped: {names[0]}: {reason}" if len(names) == 1 else
            f"skipped: {len(names)} cases, the first is {names[0]}: {reason}"
            for reason, names in sorted(skips.items())]


def add_case(count, case):
    if case.status == cases.PASSED:
        count.passed += 1
    elif case.status == cases.FAILED:
        count.failed += 1
        count.notes.append(f"failed: {case.name}")
        count.details.append(f"    --- {case.name}\n{indented(case.said.splitlines()[-CASE_LINES:])}")
    elif "STOF_DATA" in case.said and os.environ.get("STOF_REQUIRE_DATA") == "1":
        count.failed += 1
        count.notes.append(f"skipped, though STOF_REQUIRE_DATA=1: {case.name}: {case.said}")
    else:
        count.skipped += 1
        count.skips.setdefault(case.said, []).append(case.name)


def tested(preset, *checks):
    """A step that builds a preset, looks at what was built (scripts/CHECK.py) and runs its tests."""
    def judge(log, built):
        if not built:
            return Count(failed=1, notes=["the build failed"])
        count = Count()
        for script in checks:
            count.add(objects(log, preset, script))
        verdict, ran = ctest(log, preset)
        for case in ran:
            add_case(count, case)
        if not verdict and not count.failed:
            count.failed += 1
            count.notes.append("ctest failed (no test found?)")
        return count
    return Step(judge, lambda log: build(log, preset))


def arm64(preset, *checks):
    """As tested(), with the sysroot unpacked before."""
    return Step(tested(preset, *checks).judge, lambda log: log.run("toolchains/sysroot.sh") and build(log, preset))


def tidy(log):
    """clang-tidy of the product, also of what only boards have; those sources are compiled for `virt`."""
    count = one(log.run("scripts/tidy", "--product"))
    if not (log.run("toolchains/sysroot.sh") and log.run("cmake", "--preset", "virt", "-Wno-dev")):
        count.add(Count(failed=1, notes=["board virt cannot be configured"]))
        return count
    sources = sorted(str(path.relative_to(ROOT)) for pattern in ON_BOARDS_ONLY for path in ROOT.glob(pattern))
    count.add(one(log.run("scripts/tidy", "--build-dir", "build/virt", *sources)))
    return count


EMULATED = "emu"  # the board that every build for the host has


def boards_to_build(root):
    """(boards, what is wrong with them, a line each): each folder board/NAME with a config.h is one."""
    names = sorted(path.parent.name for path in root.glob("board/*/config.h"))
    presets = {preset["name"]: preset.get("cacheVariables", {})
               for preset in json.loads((root / "CMakePresets.json").read_text())["configurePresets"]}
    wrong = [f'failed: board {name} is never built: add a configure preset "{name}" with STOF_BOARD {name} to '
             "CMakePresets.json" for name in names
             if name != EMULATED and presets.get(name, {}).get("STOF_BOARD") != name]
    if EMULATED not in names:
        wrong.append(f"failed: board/{EMULATED}/config.h is not there")
    return [name for name in names if name != EMULATED], wrong


# What only a build for a board has, so that step `tidy` has not read it.
ON_BOARDS_ONLY = ("board/devices/*.cpp", "hal/linux/gpio/*.cpp", "hal/linux/libcamera/*.cpp",
                  "hal/linux/usb/libusb_udev.cpp")


def build_board(log, board):
    return (log.run("cmake", "--preset", board, "-Wno-dev")
            and log.run("cmake", "--build", f"build/{board}", "--target", "stof_product", "--", "-k", "0"))


def boards(log):
    """The appliance of every board, within its budgets."""
    if not log.run("toolchains/sysroot.sh"):
        return Count(failed=1, notes=["no sysroot"])
    boards_there, wrong = boards_to_build(ROOT)
    count = Count(failed=len(wrong), notes=wrong)
    for board in boards_there:
        built = build_board(log, board)
        count.add(one(built and log.run("scripts/budgets.py", f"build/{board}")))
        if not built:
            count.notes.append(f"failed: the build of board {board}")
    count.add(unit_tests(log, "tests/scripts/budgets_test.py"))
    return count


def system_tools(log, *boards_needed):
    """What the programs of tests/system need is built."""
    return (log.run("toolchains/sysroot.sh") and log.run("toolchains/kernel.sh")
            and all(build_board(log, board) for board in boards_needed)
            and log.run("cmake", "--preset", "emu", "-Wno-dev")
            and log.run("cmake", "--build", "--preset", "emu", "--target", "stof_system_tools", "stofd"))


def system_program(log, *command):
    """The cases of a program of tests/system, by its last line."""
    succeeded = log.run("python3", "-B", *command)
    lines = log.lines()
    last = [match for match in (re.fullmatch(r"(\d+) passed, (\d+) failed(?:, (\d+) skipped)?", line)
                                for line in lines) if match]
    if not last:
        return Count(failed=1, notes=[f"{command[0]} did not end"])
    count = Count(passed=int(last[-1][1]), failed=int(last[-1][2]) or (0 if succeeded else 1))
    count.notes += [line for line in lines if line.startswith(("figure: ", "FAILED: "))]
    return count


def system(length):
    """The appliance of board virt in an emulated machine, with emulated devices."""
    def judge(log, built):
        count = unit_tests(log, "tests/system/parts_test.py")
        if built:
            count.add(system_program(log, "tests/system/system_test.py", f"--{length}"))
        else:
            count.add(Count(failed=1, notes=["the build failed"]))
        return count
    return Step(judge, lambda log: system_tools(log, *(("virt", "rpi4") if length == "long" else ("virt",))))


def image(log):
    """The image that is flashed: its scripts, and that it boots. The packages are those of this step alone."""
    if not log.run("scripts/setup", "image"):
        return Count(failed=1, notes=["no packages"])
    count = unit_tests(log, "tests/scripts/image_test.py")
    count.add(unit_tests(log, "tests/scripts/image_libcamera_test.py"))
    count.add(unit_tests(log, "tests/scripts/flash_test.py"))
    if system_tools(log, "virt"):
        count.add(system_program(log, "tests/system/image_boot.py"))
        count.add(system_program(log, "tests/system/image_libcamera.py"))
        count.add(system_program(log, "tests/system/image_update.py"))
        count.add(system_program(log, "tests/system/image_network.py"))
    else:
        count.add(Count(failed=1, notes=["the build failed"]))
    return count


def package(log):
    """Debian packages, and what they do in a fresh Debian: a case is a line of scripts/package --check."""
    if not log.run("scripts/setup", "package"):
        return Count(failed=1, notes=["no packages"])
    count = one(log.run("scripts/package"))
    seen = len(log.lines())
    succeeded = log.run("scripts/package", "--check")
    said = log.lines()[seen:]
    count.passed += sum(": ok " in line for line in said)
    failed = [line for line in said if ": FAILED " in line]
    count.add(Count(failed=len(failed) or (0 if succeeded else 1), notes=failed))
    return count


def mutation(log):
    """Kernels whose stores have a wrong byte: comparisons with the reference must notice each array at each level."""
    if not build(log, "mutation"):
        return Count(failed=1, notes=["the build failed"])
    listed = subprocess.run(["ctest", "--preset", "mutation", "--show-only=json-v1"], cwd=ROOT,
                            capture_output=True, text=True, check=False).stdout
    programs = sorted({test["command"][0] for test in json.loads(listed or "{}").get("tests", []) if "command" in test})
    count = Count()
    for program, level in itertools.product(programs, ("neon", "avx2", "avx512")):
        name = f"{pathlib.Path(program).name}, {level}"
        seen = len(log.lines())
        log.run("env", f"STOF_KERNEL_LEVEL={level}", program, "--gtest_filter=*Reference*")
        said = log.lines()[seen:]
        survived = sorted({line.strip() for line in said if line.startswith("survived: ")})
        compared = any(line.startswith("[ RUN ") for line in said)
        ended = any(re.match(r"\[=+\] .* ran\.", line) for line in said)
        count.add(one(compared and ended and not survived))
        count.notes += survived
        if not compared:
            count.notes.append(f"{name} compares no kernel: name its comparisons EqualsReference")
        elif not ended:
            count.notes.append(f"{name} ended early, the rest is not judged: unmutate() what becomes an index")
    if not programs:
        count.add(Count(failed=1, notes=["no test has the label `kernel`"]))
    return count


def fuzz(log):
    """A short run of each fuzz target; a case is a target."""
    succeeded = log.run("scripts/fuzz", "--runs", str(FUZZ_RUNS))
    last = re.search(r"^(\d+) passed, (\d+) failed$", "\n".join(log.lines()), re.MULTILINE)
    if not last:
        return Count(failed=1, notes=["the build failed"])
    count = Count(passed=int(last[1]), failed=int(last[2]) or (0 if succeeded else 1))
    count.notes += [line for line in log.lines() if "FINDING" in line or line.startswith("    again: ")]
    return count


def gcc_tests(log):
    """What step `gcc` leaves: the tests that do not run there."""
    return one(build(log, "gcc-tests"))


def calib(log):
    """What calibrates a rig, whose packages only this step wants: its tests, and clang-tidy of it."""
    if not log.run("scripts/setup", "calib"):
        return Count(failed=1, notes=["no packages"])
    count = tested("calib").judge(log, build(log, "calib"))
    sources = sorted(str(path.relative_to(ROOT)) for folder in ("host/calibrate/rig", "host/cli/rig")
                     for path in ROOT.glob(f"{folder}/**/*.cpp") if path.name != "no_calib_rig.cpp")
    count.add(one(log.run("scripts/tidy", "--build-dir", "build/calib", *sources)))
    return count


STEPS = {
    "format": check("scripts/format", "--check"),
    "layers": plain(layers),
    "emu": tested("emu", "check_avx_symbols"),
    "emu-rest": tested("emu-rest", "check_avx_symbols"),
    "arm64-kernels": arm64("arm64-kernels", "check_vector_code"),
    "boards": ahead(boards),
    "tidy": ahead(tidy),
    "emu-asan": tested("emu-asan"),
    "gcc": tested("gcc"),
    "arm64": arm64("arm64", "check_vector_code"),
    "system": system("short"),
    "asan-rest": tested("asan-rest"),
    "mutation": plain(mutation),
    "arm64-host": arm64("arm64-host"),
    "arm64-ubsan": arm64("arm64-ubsan"),
    "fuzz": plain(fuzz),
    "tidy-tests": ahead(lambda log: one(log.run("scripts/tidy"))),  # what `tidy` has read is not read again
    "gcc-tests": ahead(gcc_tests),
    "system-long": system("long"),
    "calib": plain(calib),
    "image": plain(image),
    "package": plain(package),
}
# A newcomer's run. scripts/test installs no more than these need.
SHORT = ("format", "layers", "emu", "arm64-kernels", "boards")
# Of every change: each test once as x86 code, with sanitizers where they are no burden. Step arm64 has the kernels, too.
CI = ("format", "layers", "emu-rest", "boards", "tidy", "emu-asan", "gcc", "arm64", "system")
ALL = tuple("emu" if step == "emu-rest" else step for step in CI) + (
    "asan-rest", "mutation", "arm64-host", "arm64-ubsan", "fuzz", "tidy-tests", "gcc-tests", "system-long", "calib", "image",
             "package")


def main():
    parser = argparse.ArgumentParser(
        prog="scripts/test", epilog=f"STEP: {', '.join(STEPS)}; without any: {', '.join(SHORT)}.")
    parser.add_argument("--ci", dest="run", action="store_const", const=CI, help="what every change is held against")
    parser.add_argument("--all", dest="run", action="store_const", const=ALL, help="everything, hours")
    parser.add_argument("steps", metavar="STEP", nargs="*", help="only these steps")
    arguments = parser.parse_args()
    chosen = arguments.steps or arguments.run or SHORT
    unknown = [step for step in chosen if step not in STEPS]
    if unknown:
        parser.error(f"unknown step {', '.join(unknown)}: choose from {', '.join(STEPS)}")

    signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended by a signal"))
    LOGS.mkdir(parents=True, exist_ok=True)
    with concurrent.futures.ThreadPoolExecutor(1) as worker:
        try:
            return run(chosen, worker)
        finally:
            end_all()
            worker.shutdown(cancel_futures=True)


def run(chosen, worker):
    """The exit code of these steps; `worker` prepares them."""
    logs = {name: Log(name) for name in chosen}

    def prepare(name):
        logs[name].aside = True
        try:
            return STEPS[name].prepare(logs[name])
        finally:
            logs[name].aside = False

    prepared = {name: worker.submit(prepare, name) for name in chosen if STEPS[name].prepare}
    total = Count()
    failures = []  # once more at the end, where people and excerpts of long runs look
    times = []
    for name in chosen:
        log = logs[name]
        begin = time.monotonic()
        ready = prepared[name].result() if name in prepared else None
        waited = time.monotonic() - begin
        count = STEPS[name].judge(log, ready)
        total.add(count)
        times.append(f"{name} {time.monotonic() - begin:.0f}")
        print(f"{name:<13} {time.monotonic() - begin:6.1f} s  {count}" + (
            f", {waited:.1f} s of it until it was built" if name in prepared else ""), flush=True)
        for note in count.notes + skip_lines(count.skips):
            print(f"    {note}")
        if count.failed:
            said = "\n".join(count.details[:CASES_SHOWN]) or log.excerpt()
            print(f"{said}\n    (all of it in {log.path.relative_to(ROOT)})", flush=True)
            failed = [note for note in count.notes if not note.startswith("figure: ")]
            failures += [f"{name}: {note}" for note in failed or ["failed"]] + said.splitlines()[-CASE_LINES:]
    print(f"seconds: {', '.join(times)}")
    if total.skipped:
        print(f"{total.skipped} skipped, each with its reason above")
    if failures:
        print("\n".join(["what failed, and the end of what it said:", *failures]))
    print(f"{total.passed} passed, {total.failed} failed")
    return 1 if total.failed else 0


if __name__ == "__main__":
    sys.exit(main())
