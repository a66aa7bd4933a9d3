"""How many instructions a 64-bit ARM program takes between two marks, and in which functions, counted by
count.c in qemu-user."""

import bisect
import collections
import pathlib
import re
import subprocess
import tempfile

NM = ("llvm-nm-19", "--defined-only", "--numeric-sort", "--demangle")
CPU = "cortex-a72"
NAMESPACES = re.compile(r"stof::(?:dsp::|lab::|wire::|bench::|hal::emu::|host::)?|\(anonymous namespace\)::")


class CannotCount(Exception):
    """One line: why nothing was counted, and what to do."""


def emulate(command, plugin, sysroot, *options):
    """(the lines the program printed, [(address, instructions, times)] of each pair of marks)."""
    with tempfile.TemporaryDirectory() as folder:
        counts = pathlib.Path(folder) / "counts"
        words = ["qemu-aarch64", "-L", sysroot, "-cpu", CPU, *options, "-plugin", f"{plugin},out={counts}", *command]
        try:
            done = subprocess.run(list(map(str, words)), capture_output=True, text=True, check=False)
        except OSError as error:
            raise CannotCount(f"qemu-aarch64 cannot be run ({error.strerror}): run scripts/setup test") from error
        if not counts.is_file():
            said = (done.stderr.strip() or "it wrote no counts").splitlines()[-1]
            raise CannotCount(f"qemu-aarch64 does not run the plugin: {said}")
        if done.returncode:
            raise RuntimeError(f"{pathlib.Path(command[0]).name} ended with {done.returncode}: {done.stderr.strip()}")
        sections = []
        for line in counts.read_text().splitlines():
            if line == "section":
                sections.append([])
                continue
            address, instructions, times = line.split()
            sections[-1].append((int(address, 16), int(instructions), int(times)))
    return done.stdout.split(), sections


def total(blocks):
    return sum(instructions * times for _, instructions, times in blocks)


class Functions:
    """What lies where in a program that is loaded where it was linked."""

    def __init__(self, program):
        said = subprocess.run([*NM, program], capture_output=True, text=True, check=True).stdout
        found = [line.split(" ", 2) for line in said.splitlines() if " " in line]
        code = [(int(address, 16), name) for address, kind, name in found if kind in "tTwW"]
        code = [(address, name) for address, name in code if not name.startswith("$")]
        self.starts = [address for address, _ in code]
        self.names = [short(name) for _, name in code]
        self.end = self.starts[-1] + 0x10000 if code else 0

    def at(self, address):
        index = bisect.bisect_right(self.starts, address) - 1
        return self.names[index] if index >= 0 and address < self.end else "libraries"

    def counts(self, blocks):
        """{function: instructions}."""
        found = collections.Counter()
        for address, instructions, times in blocks:
            found[self.at(address)] += instructions * times
        return found


def short(name):
    """dsp::neon::sum_path_costs(std::span<...>) as neon::sum_path_costs: overloads and instances count as one."""
    name, depth, out = NAMESPACES.sub("", name), 0, []
    for letter in name:  # without what stands in brackets
        depth -= letter in ">)"
        if depth == 0 and letter not in "<(>)":
            out.append(letter)
        depth += letter in "<("
    words = "".join(out).replace("const", "").split()
    return words[-1] if words else name


def tasks_of(program, sysroot):
    """The names of what the program can do."""
    try:
        done = subprocess.run(["qemu-aarch64", "-L", sysroot, program], capture_output=True, text=True, check=False)
    except OSError as error:
        raise CannotCount(f"qemu-aarch64 cannot be run ({error.strerror}): run scripts/setup test") from error
    if done.returncode or not done.stdout:
        raise RuntimeError(f"{program} does not run: {done.stderr.strip()}")
    return done.stdout.split()


def per_task(program, plugin, sysroot, tasks):
    """{task: its blocks}."""
    printed, sections = emulate([program, *tasks], plugin, sysroot)
    return dict(zip(printed, sections, strict=True))
