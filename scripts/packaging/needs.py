"""Which packages of Debian have the run-time libraries that a program of a cross build needs: dpkg-shlibdeps asks the machine it runs on."""

import re

PACKAGES = {"libc.so.6": "libc6", "libm.so.6": "libc6", "libpthread.so.0": "libc6", "ld-linux-aarch64.so.1": "libc6",
            "libstdc++.so.6": "libstdc++6", "libgcc_s.so.1": "libgcc-s1", "libusb-1.0.so.0": "libusb-1.0-0", "libzstd.so.1": "libzstd1"}
# Of GLIBCXX_3.4.N the GCC that brought it.
GCC_OF_GLIBCXX = ((25, "8"), (28, "9"), (29, "11"), (30, "12"), (32, "13.1"), (33, "14"))


class Unknown(Exception):
    """One line: a library that no package is known for."""


def needs(needed, symbols):
    """A list of relations of Debian. needed: names in NEEDED; symbols: (symbol, GLIBC or GLIBCXX, number) as of scripts/wheel."""
    relations = {}
    for name in needed:
        if name not in PACKAGES:
            raise Unknown(f"{name}: no package is known that has it: add it to PACKAGES of scripts/packaging/needs.py")
        relations[PACKAGES[name]] = ""
    for kind, package, version in (
            ("GLIBC", "libc6", lambda number: f"2.{max(number, 17)}"),
            ("GLIBCXX", "libstdc++6", lambda number: next((gcc for most, gcc in GCC_OF_GLIBCXX if number <= most), None))):
        numbers = [number for _, of, number in symbols if of == kind]
        if numbers and package in relations:
            least = version(max(numbers))
            if least is None:
                raise Unknown(f"GLIBCXX_3.4.{max(numbers)}: add its GCC to GCC_OF_GLIBCXX of scripts/packaging/needs.py")
            relations[package] = f" (>= {least})"
    return [name + version for name, version in sorted(relations.items())]


def needed_of(headers):
    """Names in NEEDED of what objdump -p says."""
    return re.findall(r"^\s*NEEDED\s+(\S+)", headers, re.MULTILINE)
