"""Instructions of a frame on 64-bit ARM, beside OpenCV's, and what they may come to in time."""

import json
import sys

import model
from common import ARM_FLOORS, BENCH, ROOT, Trouble, run

sys.path.insert(0, str(ROOT / "tests/bench/arm"))
import counting  # noqa: E402

BUILD = ROOT / "build" / "arm64"
SYSROOT = ROOT / "build" / "sysroot-arm64"
OPENCV = ROOT / "build" / "opencv-arm64"
LIBRARIES = "/usr/lib/aarch64-linux-gnu"
PIXELS, PMD_PIXELS = 640 * 480, 176 * 144
# Name, model of llvm-mca, GHz.
PROCESSORS = (("Cortex-A76", "neoverse-n1", 2.4), ("Cortex-A72", "cortex-a72", 1.8))
TASKS = {
    "wta": "WTA 15x15, 640x480x64", "fast": "preset fast", "fast_depth": "the same, with confidence",
    "quality": "preset quality",
    "pyramid1": "coarse to fine, 1", "pyramid2": "coarse to fine, 2", "rectify": "rectify both pictures",
    "phase": "PMD phase, 176x144", "convert": "PMD convert, 176x144", "fuse": "convert and fuse", "packets": "packets",
    "rvl_encode": "RVL encode depth", "rvl_decode": "RVL decode depth", "crc": "CRC of 600 KiB",
    "frame": "whole frame: convert, match, fuse, packets",
}


def count_opencv(plugin):
    run("opencv-arm64", ROOT / "tests/bench/arm/opencv_sysroot.sh", OPENCV)
    program = BENCH / "opencv_count"
    libraries = [f"{OPENCV}{LIBRARIES}/libopencv_{name}.so.406" for name in ("calib3d", "imgproc", "core")]
    run("opencv-count", "clang++-19", "--target=aarch64-linux-gnu", f"--sysroot={OPENCV}",
        f"--gcc-toolchain={OPENCV}/usr", "-fuse-ld=lld-19", "-std=c++23", "-O2", "-I", ROOT,
        "-isystem", "/usr/include/opencv4", "tests/bench/arm/opencv_count.cpp", "tests/bench/bench_noise.cpp",
        "dsp/base/check.cpp", *libraries, "-Wl,--allow-shlib-undefined", "-o", program)
    path = f"LD_LIBRARY_PATH={LIBRARIES}/lapack:{LIBRARIES}/blas"
    _, (blocks,) = counting.emulate([program], plugin, OPENCV, "-E", path)
    return counting.total(blocks)


def judge(task, blocks, code, peer):
    whole = counting.total(blocks)
    entry = {"task": task, "what": TASKS.get(task, task), "instructions": whole, "of_stereo_bm": whole / peer}
    for name, cpu, ghz in PROCESSORS:
        cycles, loops = model.estimate(code, blocks, cpu)
        entry[name] = {"cycles": cycles, "ms": cycles / (ghz * 1e6)}
        if cpu == "neoverse-n1":
            entry["loops"] = [{"address": hex(at), "cycles": each, "iterations": times, "share": share}
                              for at, each, times, share in loops]
    return entry


def say(entries, peer):
    print(f"StereoBM, dense, 640x480x64: {peer / 1e6:.1f} million instructions")
    names = [name for name, _, _ in PROCESSORS]
    print(f"  {'':<44} {'million':>9} {'of BM':>6}  " + "  ".join(f"{name:>13}" for name in names))
    for entry in entries:
        times = "  ".join(f"{entry[name]['ms']:10.2f} ms" for name in names)
        floor = ARM_FLOORS.get(entry["task"])
        promised = "" if floor is None else f"  (at most {floor:.2f} of StereoBM's)"
        print(f"  {entry['what']:<44} {entry['instructions'] / 1e6:9.2f} {entry['of_stereo_bm']:6.2f}  {times}{promised}")
    print("  ms are estimates: cycles that llvm-mca gives an iteration of each inner loop, times its iterations; all\n"
          "  other instructions at the same rate; by the clock ("
          + ", ".join(f"{name}: {ghz} GHz, model {cpu}" for name, cpu, ghz in PROCESSORS) + "). Memory is never waited for.")


def say_loops(by_task):
    """The figures with floors: cycles of the search for 64 candidates, of the phase for a pixel."""
    found = {}
    for task, unit, count, promised in (("wta", "64 candidates", PIXELS, 45), ("phase", "a pixel", PMD_PIXELS, 13)):
        entry = by_task[task]
        loops = entry["loops"]
        hottest = loops[0]["cycles"] * loops[0]["iterations"] / count
        every = sum(loop["cycles"] * loop["iterations"] for loop in loops) / count
        instructions = entry["instructions"] / count
        found[task] = {"hottest_loop": hottest, "all_loops": every, "instructions": instructions, "floor": promised}
        print(f"  {task}, cycles for {unit}: hottest loop {hottest:.1f} ({100 * loops[0]['share']:.0f} % of the "
              f"instructions), all loops {every:.1f}; instructions {instructions:.1f}; promised: at most {promised}")
    return found


def go(out):
    if not out.parent.is_dir():
        raise Trouble(f"{out.parent}: no such folder: make it, or name another file")
    run("sysroot", ROOT / "toolchains/sysroot.sh")
    run("configure-arm64", "cmake", "--preset", "arm64", "-Wno-dev")
    run("build-arm64", "cmake", "--build", BUILD, "--target", "stof_count")
    program, plugin = BUILD / "bin/stof_count", BUILD / "tests/bench/arm/count.so"
    try:
        peer = count_opencv(plugin)
        blocks = counting.per_task(program, plugin, SYSROOT, counting.tasks_of(program, SYSROOT))
    except (counting.CannotCount, RuntimeError) as error:
        raise Trouble(str(error)) from error
    code = model.disassembled(program)
    order = [task for task in TASKS if task in blocks]
    entries = [judge(task, blocks[task], code, peer) for task in order]
    say(entries, peer)
    loops = say_loops({entry["task"]: entry for entry in entries})
    out.write_text(json.dumps({"stereo_bm": peer, "processors": [name for name, _, _ in PROCESSORS],
                               "loops": loops, "results": entries}, indent=1) + "\n")
    print(f"kept in {out}")
