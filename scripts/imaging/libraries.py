"""The shared libraries of a program for 64-bit ARM: found in unpacked packages, with all that they name in turn."""

import pathlib

import elf

FOLDERS = ("usr/lib/aarch64-linux-gnu", "usr/lib")
LOADER = "ld-linux-"  # a program names it by a path, libraries as a library


class LibraryError(Exception):
    """One line: what, where, what to do."""


class Libraries:
    """Folders of unpacked packages, the first of which that has a file counts."""

    def __init__(self, *roots):
        self.roots = [pathlib.Path(root) for root in roots]

    def __str__(self):
        return " and ".join(map(str, self.roots)) or "no folder"

    def find(self, name):
        """(root, path) of a library by its name, or of a file by its path below a root; None where there is none."""
        places = [name] if "/" in name else [f"{folder}/{name}" for folder in FOLDERS]
        for root in self.roots:
            for place in places:
                if (root / place).is_file():
                    return root, root / place
        return None

    def closure(self, *programs):
        """{place below /: (root, path)} of what these programs or libraries, as bytes, name, and what that names."""
        found, left = {}, list(programs)
        while left:
            data = left.pop()
            interpreter = elf.interpreter(data)
            names = [pathlib.PurePath(interpreter).name] if interpreter else []
            for name in [*names, *elf.needed(data)]:
                place = f"usr/lib/{name}" if name.startswith(LOADER) else f"{FOLDERS[0]}/{name}"
                if place in found:
                    continue
                found[place] = self.find(name)
                if found[place] is None:
                    raise LibraryError(f"no library {name} in {self}: unpack its package there (toolchains/sysroot.sh)")
                left.append(found[place][1].read_bytes())
        return dict(sorted(found.items()))
