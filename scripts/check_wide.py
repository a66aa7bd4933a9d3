#!/usr/bin/env python3
"""scripts/check_wide.py BUILD_DIR: nothing of a kernel for AVX2 or AVX-512 may reach other processors.

Of a function that several objects define (an inline one, a template) the linker keeps any copy: that
of a *_avx2.cpp or *_avx512.cpp would stop processors that have no AVX2, wherever it is called. So
their objects define no such symbol. Prints `object: symbol: what to do` and ends with code 1 when
one does; code 2 when there is nothing to look at.
"""

import pathlib
import subprocess
import sys

SHARED = "WwVvu"  # nm's letters of what may be defined more than once


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
        print("check_wide: name one build folder", file=sys.stderr)
        return 2
    objects = sorted(path for pattern in ("*_avx2.cpp.o", "*_avx512.cpp.o")
                     for path in pathlib.Path(arguments[0]).rglob(pattern) if "stof_dsp.dir" in path.parts)
    if not objects:
        print(f"check_wide: no object of a *_avx2.cpp in {arguments[0]}: build it first", file=sys.stderr)
        return 2
    findings = 0
    for path in objects:
        listing = subprocess.run(["nm", "--demangle", str(path)], capture_output=True, text=True, check=True).stdout
        for name in shared_symbols(listing):
            print(f"{path.name}: {name}: make it static, or a template on something of this file alone")
            findings += 1
    if not findings:
        print(f"check_wide: {len(objects)} objects define nothing that others could get")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
