#!/usr/bin/env python3
"""scripts/check_avx_symbols.py BUILD_DIR: nothing of a kernel for AVX2 or AVX-512 may reach other processors.

Of a function that several objects define (an inline one, a template) the linker keeps any copy: that
of a *_avx2.cpp or *_avx512.cpp would stop processors that have no AVX2, wherever it is called. So
their objects define no such symbol but the kernel templates that they instantiate: functions of their own
namespace that no other of them defines. Prints `object: symbol: what to do` and ends with code 1 when one does;
code 2 when there is nothing to look at.
"""

import collections
import pathlib
import re
import subprocess
import sys

SHARED = "WwVvu"  # nm's letters of what may be defined more than once


OWN = re.compile(r"^void stof::dsp::(avx2|avx512)::\w+<")  # a kernel template, for a type


def shared_symbols(listing):
    """Names of symbols that may be defined more than once, of nm's output."""
    found = []
    for line in listing.splitlines():
        kind, _, name = line[17:].partition(" ")  # address, kind, name
        if kind and kind in SHARED and line[:16].strip():
            found.append(name)
    return found


def main(arguments):
    if len(arguments) != 1:
        print("check_avx_symbols: name one build folder", file=sys.stderr)
        return 2
    objects = sorted(path for pattern in ("*_avx2.cpp.o", "*_avx512.cpp.o")
                     for path in pathlib.Path(arguments[0]).rglob(pattern) if "stof_dsp.dir" in path.parts)
    if not objects:
        print(f"check_avx_symbols: no object of a *_avx2.cpp in {arguments[0]}: build it first", file=sys.stderr)
        return 2
    shared = {}
    for path in objects:
        listing = subprocess.run(["nm", "--demangle", str(path)], capture_output=True, text=True, check=True).stdout
        shared[path] = shared_symbols(listing)
    found = findings_of({path.name: names for path, names in shared.items()})
    for finding in found:
        print(finding)
    if not found:
        print(f"check_avx_symbols: {len(objects)} objects define nothing that others could get")
    return 1 if found else 0


def findings_of(shared):
    """What {object: shared symbols} holds beside kernel templates."""
    defined = collections.Counter(name for names in shared.values() for name in names)
    return [f"{file}: {name}: make it static, or a template on something of this file alone"
            for file, names in shared.items() for name in names
            if defined[name] > 1 or not ((own := OWN.match(name)) and f"_{own[1]}.cpp" in file)]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
