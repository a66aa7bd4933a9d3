#!/usr/bin/env python3
"""scripts/check_vector_code.py BUILD_DIR [--objdump PROGRAM]: does every NEON kernel hold vector code?

Disassembles the object of each dsp/**/*_neon.cpp of an arm64 build. A function of stof::dsp::neon that
others can call needs at least LEAST instructions that compute with whole vectors (v0.16b, v1.4s), in
itself or in the functions of its object that it calls: what hands all its work to the reference has
none. What only moves or sets vectors, as any copy of a struct does, counts for nothing. Prints
`file: function: K vector instructions: what to do` and a summary; ends with code 1 when something was
found, 2 when it could not look.
"""

import argparse
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
OBJDUMPS = ("llvm-objdump-19", "llvm-objdump")
OPTIONS = ("--syms", "--disassemble", "--reloc", "--demangle", "--no-show-raw-insn")
NAMESPACE = "stof::dsp::neon::"
LEAST = 2  # the smallest kernels widen and add 16 costs to 16 sums

EXPORTED = re.compile(r"^[0-9a-f]+ (?:g|\s?w)\s+F \S+\s+[0-9a-f]+ (?:\.hidden )?(.+)$")  # templates are weak
SECTION = re.compile(r"^Disassembly of section (\S+):$")
FUNCTION = re.compile(r"^(?:([0-9a-f]+) )?<(.+)>:$")
INSTRUCTION = re.compile(r"^\s*[0-9a-f]+:\s+([a-z][\w.]*)(?:\s+(.*))?$")
RELOCATION = re.compile(r"^\s*[0-9a-f]+:\s+R_AARCH64_(?:CALL26|JUMP26)\s+(.+?)(?:\+0x([0-9a-f]+))?$")
TARGET = re.compile(r"<(.+?)(?:\+0x[0-9a-f]+)?>$")
MOVES = re.compile(r"movi|mvni|mov|fmov|dup|ld\d.*|st\d.*")
VECTOR = re.compile(r"\bv\d+\.\d+[bhsd]\b")


def read_functions(text):
    """{exported function of the namespace: vector instructions within reach} of a disassembly."""
    exported, own, calls = [], {}, {}
    current, section, at = None, None, {}  # at: functions by section and address
    for line in text.splitlines():
        if match := EXPORTED.match(line):
            if match[1].removeprefix("void ").startswith(NAMESPACE):  # so begin the names of templates
                exported.append(match[1])
        elif match := SECTION.match(line):
            section = match[1]
        elif match := FUNCTION.match(line):
            current = match[2]
            at[section, int(match[1] or "0", 16)] = current
            own.setdefault(current, 0)
            calls.setdefault(current, set())
        elif current is None:
            continue
        elif match := RELOCATION.match(line):
            # A function that others cannot call goes by the place in its section.
            calls[current].add((match[1], int(match[2] or "0", 16)) if match[1].startswith(".") else match[1])
        elif match := INSTRUCTION.match(line):
            name, operands = match[1], match[2] or ""
            own[current] += bool(VECTOR.search(operands)) and not MOVES.fullmatch(name)
            if name in ("b", "bl") and (target := TARGET.search(operands)):
                calls[current].add(target[1])
    calls = {name: {at.get(called, called) for called in all_of} for name, all_of in calls.items()}
    return {name: sum(own[reached] for reached in within_reach(name, calls)) for name in exported}


def within_reach(name, calls):
    """The function and what it calls, of those with a body in this object."""
    reached, pending = set(), [name]
    while pending:
        function = pending.pop()
        if function in calls and function not in reached:
            reached.add(function)
            pending += calls[function]
    return reached


def short(name):
    return name.replace(", 18446744073709551615ul>", ">")  # the length of a span that knows none


def findings_in(source, text):
    """(findings, number of functions) of one object's disassembly."""
    functions = read_functions(text)
    if not functions:
        return [f"{source}: no function of {NAMESPACE[:-2]}: a kernel belongs into that namespace"], 0
    return [f"{source}: {short(name)}: {count} vector instructions: write it with vectors"
            for name, count in functions.items() if count < LEAST], len(functions)


def check_build(root, build, objdump):
    """(findings, number of functions, number of objects) of a build of the tree in root."""
    findings, functions, objects = [], 0, 0
    for path in sorted(root.glob("dsp/**/*_neon.cpp")):
        source = path.relative_to(root)
        found = sorted(build.glob(f"dsp/CMakeFiles/*.dir/{source.relative_to('dsp')}.o*"))
        if not found:
            findings.append(f"{source}: no object in {build}: name it in dsp/CMakeLists.txt and build")
        for file in found:
            text = subprocess.run([objdump, *OPTIONS, file], capture_output=True, text=True,
                                  check=True).stdout
            if "aarch64" not in text:
                sys.exit(fail(f"{file}: not for 64-bit ARM: give the folder of preset arm64"))
            said, count = findings_in(source, text)
            findings += said
            functions += count
            objects += 1
    return findings, functions, objects


def fail(what):
    print(f"check_vector_code: {what}", file=sys.stderr)
    return 2


def main(arguments=None, root=ROOT):
    parser = argparse.ArgumentParser(prog="scripts/check_vector_code.py")
    parser.add_argument("build", metavar="BUILD_DIR", type=pathlib.Path, help="of preset arm64")
    parser.add_argument("--objdump", metavar="PROGRAM", help=f"default: {' or '.join(OBJDUMPS)}")
    options = parser.parse_args(arguments)
    wanted = [options.objdump] if options.objdump else OBJDUMPS
    objdump = next(filter(None, map(shutil.which, wanted)), None)
    if objdump is None:
        return fail(f"{wanted[0]} is missing: run scripts/setup test")
    if not options.build.is_dir():
        return fail(f"{options.build}: no such folder: run scripts/test arm64, which makes build/arm64")
    try:
        findings, functions, objects = check_build(root, options.build, objdump)
    except (OSError, subprocess.CalledProcessError) as error:
        return fail(f"{objdump} failed: {error}: run scripts/setup test")
    for finding in findings:
        print(finding)
    print(f"{functions} functions in {objects} objects looked at, {len(findings)} findings")
    return 1 if findings or not objects else 0


if __name__ == "__main__":
    sys.exit(main())
