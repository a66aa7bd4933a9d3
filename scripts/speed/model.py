"""What llvm-mca makes of the loops in which a counted program spends its instructions."""

import collections
import json
import re
import subprocess

from common import Trouble

OBJDUMP = ("llvm-objdump-19", "--disassemble", "--no-show-raw-insn")
MCA = ("llvm-mca-19", "-mtriple=aarch64", "-iterations=100", "-json")
LEAST = 0.004  # of a task's instructions: smaller loops belong to the rest
LINE = re.compile(r"^\s*([0-9a-f]+):\s+(\S+)(?:\s+(.*?))?(?:\s+<.*>)?(?:\s+//.*)?$")
BRANCH = re.compile(r"b|b\.\w+|cbn?z|tbn?z")
PLACE = re.compile(r"0x[0-9a-f]+$")


def disassembled(program):
    """{address: (name, operands)}."""
    said = subprocess.run([*OBJDUMP, program], capture_output=True, text=True, check=True).stdout
    found = {}
    for line in said.splitlines():
        if match := LINE.match(line):
            found[int(match[1], 16)] = (match[2], match[3] or "")
    return found


def loops(code, blocks):
    """[(first address, last address, iterations, instructions executed in it)] of innermost loops, largest first."""
    times = collections.Counter()
    for address, instructions, count in blocks:
        for i in range(instructions):
            times[address + 4 * i] += count
    found = []
    for address, count in times.items():
        name, operands = code.get(address, ("", ""))
        target = PLACE.search(operands)
        if (target and BRANCH.fullmatch(name) and (begin := int(target[0], 16)) <= address and begin in times
                and all(one in code for one in range(begin, address, 4))):  # else there is data between
            found.append((begin, address, min(count, times[begin])))
    inner = [one for one in found
             if not any(other is not one and one[0] <= other[0] and other[1] <= one[1] for other in found)]
    sized = [(begin, end, count, sum(times[a] for a in range(begin, end + 4, 4))) for begin, end, count in inner]
    return sorted(sized, key=lambda one: -one[3])


def text_of(code, begin, end):
    """The loop's body as assembly; the branches' places do not matter."""
    lines = []
    for address in range(begin, end + 4, 4):
        name, operands = code[address]
        if name in ("bl", "blr", "ret"):
            continue
        if BRANCH.fullmatch(name) or name in ("adr", "adrp"):
            operands = PLACE.sub("9f", operands)
        lines.append(f"{name} {operands}")
    return lines


def cycles(code, found, cpu):
    """Cycles of an iteration of each loop."""
    lines = []
    for index, (begin, end, _, _) in enumerate(found):
        lines += [f"# LLVM-MCA-BEGIN {index}", *text_of(code, begin, end), f"# LLVM-MCA-END {index}"]
    lines.append("9:")
    done = subprocess.run([*MCA, f"-mcpu={cpu}"], input="\n".join(lines) + "\n", capture_output=True, text=True,
                          check=False)
    if done.returncode:
        raise Trouble(f"llvm-mca-19 failed: {done.stderr.strip().splitlines()[0]}")
    by_name = {int(region["Name"]): region["SummaryView"] for region in json.loads(done.stdout)["CodeRegions"]}
    return [by_name[i]["TotalCycles"] / by_name[i]["Iterations"] for i in range(len(found))]


def estimate(code, blocks, cpu):
    """(cycles of a frame, [(address, cycles an iteration, iterations, share of the instructions)] largest first).

    The loops by the model, everything else at the rate of the loops."""
    whole = sum(instructions * times for _, instructions, times in blocks)
    found = [one for one in loops(code, blocks) if one[3] >= LEAST * whole]
    if not found:
        return whole, []
    each = cycles(code, found, cpu)
    inside = sum(one[3] for one in found)
    spent = sum(one * loop[2] for one, loop in zip(each, found, strict=True))
    rate = inside / spent
    return spent + (whole - inside) / rate, [(loop[0], one, loop[2], loop[3] / whole)
                                             for one, loop in zip(each, found, strict=True)]
