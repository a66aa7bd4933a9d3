#!/usr/bin/env python3
"""scripts/check_layers.py [ROOT]: who may include whom, and how long a file or the README may be.

The floors are those of docs/DESIGN.md: firmware -> board -> hal -> dsp; hal/emu and hal/linux are
known to boards and tests alone. Prints `file:line: what: what to do` and ends with code 1 when
something was found.
"""

import dataclasses
import fnmatch
import functools
import pathlib
import re
import sys

from wire import cpp, table

STD = frozenset("""
algorithm any array atomic barrier bit bitset charconv chrono codecvt compare complex concepts
condition_variable coroutine deque exception execution expected filesystem format forward_list
fstream functional future initializer_list iomanip ios iosfwd iostream istream iterator latch limits
list locale map memory memory_resource mutex new numbers numeric optional ostream queue random ranges
ratio regex scoped_allocator semaphore set shared_mutex source_location span spanstream sstream stack
stacktrace stdexcept stop_token streambuf string string_view strstream syncstream system_error thread
tuple type_traits typeindex typeinfo unordered_map unordered_set utility valarray variant vector version
cassert cctype cerrno cfenv cfloat cinttypes climits clocale cmath csetjmp csignal cstdarg cstddef
cstdint cstdio cstdlib cstring ctime cuchar cwchar cwctype
""".split())

ANY_LIBRARY = ("*",)
# What the C library has beyond C.
C_LIBRARY = ("arpa/*.h", "asm/*.h", "fcntl.h", "ifaddrs.h", "net/*.h", "netdb.h", "netinet/*.h", "poll.h", "pthread.h", "sys/*.h",
             "unistd.h")


@dataclasses.dataclass(frozen=True)
class Floor:
    """Files by pattern, and what they may include beside the standard library."""

    files: str
    project: tuple[str, ...]
    libraries: tuple[str, ...] = ()
    macro: bool = False  # may include by a macro's name


# The first pattern that fits a file decides. `*` also matches slashes, except in FLAT patterns.
HAL_INTERFACES = "hal/*.h"
BOARD_TABLES = "board/*.h"
FLOORS = (
    Floor("dsp/base/simd.h", ("dsp/base/*",), ("arm_neon.h", "simde/arm/neon.h")),
    Floor("dsp/base/avx2.h", ("dsp/base/*",), ("immintrin.h",)),
    Floor("dsp/calib/*.cpp", ("dsp/*",), ("Eigen/*",)),
    Floor("dsp/*", ("dsp/*",)),
    Floor("lab/*", ("lab/*", "dsp/*")),
    Floor("posix/out_of_resources.cpp", ("posix/*",), (*C_LIBRARY, "cxxabi.h")),
    Floor("posix/*", ("posix/*",), C_LIBRARY),
    Floor("dataset/*", ("dataset/*", "dsp/base/*", "dsp/calib/*", "posix/fd.h", "posix/named_file.h"), ANY_LIBRARY),
    Floor("hal/emu/*", ("hal/emu/*", HAL_INTERFACES, "dsp/*", "dataset/*"), ANY_LIBRARY),
    Floor("hal/linux/*", ("hal/linux/*", "hal/framing/*", HAL_INTERFACES, "dsp/*", "posix/*"), ANY_LIBRARY),
    Floor("hal/framing/*", ("hal/framing/*", HAL_INTERFACES, "dsp/base/*")),
    Floor("hal/*", (HAL_INTERFACES, "dsp/base/*")),
    Floor("board/board.h", (BOARD_TABLES, HAL_INTERFACES, "dsp/*"), macro=True),
    Floor("board/*.h", (BOARD_TABLES, HAL_INTERFACES, "dsp/*")),
    Floor("board/*/config.h", (BOARD_TABLES, HAL_INTERFACES, "dsp/*")),
    # A recording is read by the one reader that there is; only the board of host builds does.
    Floor("board/emu/recorded_*", ("board/*", "hal/*", "dsp/*", "host/recording/*", "firmware/wire/*")),
    Floor("board/*", ("board/*", "hal/*", "dsp/*", "dataset/*")),
    Floor("firmware/wire/crc32c_hardware.cpp", ("firmware/wire/*",), ("sys/auxv.h",)),
    Floor("firmware/wire/crypto/crypto.cpp", ("firmware/wire/*", "dsp/*"), ("sodium.h",)),
    Floor("firmware/wire/*", ("firmware/wire/*", "hal/datagram_size.h", "dsp/*")),
    Floor("firmware/serial/*", ("firmware/*", BOARD_TABLES, HAL_INTERFACES, "hal/framing/*", "dsp/*")),
    Floor("firmware/program/main.cpp", ("firmware/*", BOARD_TABLES, HAL_INTERFACES, "dsp/*", "posix/out_of_resources.h", "posix/worker_threads.h")),
    Floor("firmware/*", ("firmware/*", BOARD_TABLES, HAL_INTERFACES, "dsp/*")),
    Floor("host/*", ("host/*", "lab/*", "dsp/*", "posix/*", "dataset/*", "firmware/wire/*", "hal/framing/*", "board/config.h"),
          ANY_LIBRARY),
    Floor("tests/*", ("*",), ANY_LIBRARY),
)
FOLDERS = sorted({floor.files.split("/")[0] for floor in FLOORS})
FLAT = {HAL_INTERFACES, BOARD_TABLES}

INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>|(\w+))')
PRAGMA_ONCE = re.compile(r"^\s*#\s*pragma\s+once\b", re.MULTILINE)
# What other projects include or copy is judged by their rules: C, names of its own, all in one file.
FOR_OTHERS = ("host/lib/include/", "examples/")
SUFFIXES = (".h", ".cpp", ".c")
OTHER_SUFFIXES = (".hpp", ".hh", ".hxx", ".cc", ".cxx", ".inl", ".inc", ".ipp")


def quoted_includes(text):
    """[(line number, name)] of every #include "name"."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        match = INCLUDE.match(line)
        if match and match[1]:
            found.append((number, match[1]))
    return found


def fits(name, pattern):
    if pattern in FLAT and name.count("/") != pattern.count("/"):
        return False
    return fnmatch.fnmatchcase(name, pattern)


def longest(path):
    header = path.endswith(".h") and not path.endswith("_body.h")  # which are instantiated elsewhere
    return 150 if header and not path.startswith("tests/") else 500


@functools.cache
def made_by_the_build(root):
    """Names of headers that are in no folder: the build makes them."""
    return frozenset(cpp.files(table.load(root))) if (root / "firmware/wire/messages.json").is_file() else frozenset()


def judge_project_include(root, path, floor, name):
    """None, or (what, what to do) about #include "name" in path."""
    if not (root / name).is_file() and name not in made_by_the_build(root):
        return f'"{name}" does not exist', "write the path from the root of the repository"
    if path.startswith("tests/"):
        return None
    if not any(fits(name, pattern) for pattern in floor.project):
        if name.startswith(("hal/emu/", "hal/linux/")):
            return (f'{floor.files} must not know "{name}"',
                    "include the interface in hal/; only board/<name>/ and tests choose an implementation")
        return (f'{floor.files} must not know "{name}"', f"it may include {', '.join(floor.project)}")
    neon = path.endswith(("_neon.cpp", "_neon.h")) or fits(path, "dsp/base/simd_*.h")
    if not neon and (fits(name, "dsp/base/simd*.h") or name.endswith("_neon.h")):
        return f'"{name}" outside of a *_neon.cpp', "move what needs vectors into the kernel's *_neon.cpp"
    avx2 = path.endswith(("_avx2.cpp", "_avx2.h", "_avx512.cpp"))
    if not avx2 and (name == "dsp/base/avx2.h" or name.endswith("_avx2.h")):
        return f'"{name}" outside of a *_avx2.cpp', "only these files are compiled for AVX2: move it there"
    return None


def judge_library_include(path, floor, name):
    """None, or (what, what to do) about #include <name> in path."""
    if name in STD or any(fnmatch.fnmatchcase(name, pattern) for pattern in floor.libraries):
        return None
    if name in ("arm_neon.h", "simde/arm/neon.h"):
        return f"<{name}> is included in dsp/base/simd.h alone", 'include "dsp/base/simd.h" in a *_neon.cpp'
    if name == "immintrin.h":
        return f"<{name}> is included in dsp/base/avx2.h alone", 'include "dsp/base/avx2.h" in a *_avx2.cpp'
    if name.endswith(".h") and "c" + name[:-2] in STD:
        return f"<{name}> is C's name", f"include <c{name[:-2]}>"
    if name.split("/")[0] in FOLDERS:
        return f"<{name}> is a file of this project", f'include "{name}"'
    allowed = ", ".join(("std", *floor.libraries))
    return f"{floor.files} must not know <{name}>", f"it may include {allowed}; devices and libraries belong behind hal/"


NEON_STORE = re.compile(r"\bvst\d\w*")
WIDE_STORE = re.compile(r"\b_mm\d*_(?:mask_)?(?:\w*store|stream|\w*scatter)\w*")
MUTATED_STORES = "tests/support/mutated_stores.h"


def judge_stores(root, path, line, number):
    """What a line of a kernel stores must be what step `mutation` of scripts/test mutates."""
    if path.endswith(("_neon.cpp", "_neon.h")):
        known = (root / MUTATED_STORES).read_text(encoding="utf-8")
        return [f"{path}:{number}: {name} is mutated by no build: add it to {MUTATED_STORES}"
                for name in NEON_STORE.findall(line) if f"#define {name} " not in known]
    return [f"{path}:{number}: {name} outside of dsp/base/avx2.h: call a store of that header, which step mutation mutates"
            for name in WIDE_STORE.findall(line) if path != "dsp/base/avx2.h"]


def judge_file(root, path):
    """Findings in one file, `path` relative to `root`."""
    floor = next((floor for floor in FLOORS if fits(path, floor.files)), None)
    text = (root / path).read_text(encoding="utf-8", errors="replace")
    lines = text.splitlines()
    found = []
    for number, line in enumerate(lines, 1):
        if path.startswith(("dsp/", "lab/")):
            found += judge_stores(root, path, line, number)
        match = INCLUDE.match(line)
        if not match:
            continue
        project, library, macro = match.groups()
        if project:
            verdict = judge_project_include(root, path, floor, project)
        elif library:
            verdict = judge_library_include(path, floor, library)
        elif not floor.macro and not path.startswith("tests/"):
            verdict = f"include by the macro {macro}", "only board/board.h may: name the file"
        else:
            verdict = None
        if verdict:
            found.append(f"{path}:{number}: {verdict[0]}: {verdict[1]}")
    if path.endswith(".h") and not PRAGMA_ONCE.search(text):
        found.append(f"{path}:1: header without guard: begin it with #pragma once")
    limit = longest(path)
    if len(lines) > limit:
        found.append(f"{path}:{limit + 1}: {len(lines)} lines, {limit} are the limit: split it by subject")
    return found


# A robot builder reads it in three minutes.
FIRST_PAGE, FIRST_PAGE_LINES, FIRST_PAGE_WIDTH = "README.md", 150, 120


def judge_first_page(root):
    if not (root / FIRST_PAGE).is_file():
        return []
    lines = (root / FIRST_PAGE).read_text(encoding="utf-8").splitlines()
    found = [f"{FIRST_PAGE}:{number}: {len(line)} characters, {FIRST_PAGE_WIDTH} are the limit: break the line"
             for number, line in enumerate(lines, 1) if len(line) > FIRST_PAGE_WIDTH]
    if len(lines) > FIRST_PAGE_LINES:
        found.append(f"{FIRST_PAGE}:{FIRST_PAGE_LINES + 1}: {len(lines)} lines, {FIRST_PAGE_LINES} are the limit: "
                     "move what a newcomer does not need to docs/")
    return found


def check_tree(root):
    """Findings in all sources below root, sorted by file, and in its first page."""
    root = pathlib.Path(root)
    found = judge_first_page(root)
    for folder in FOLDERS:
        for file in sorted((root / folder).rglob("*")):
            path = file.relative_to(root).as_posix()
            if path.startswith(FOR_OTHERS):
                continue
            if file.suffix in SUFFIXES:
                found += judge_file(root, path)
            elif file.suffix in OTHER_SUFFIXES:
                found.append(f"{path}:1: ending {file.suffix}: name it .h or .cpp")
    return found


def main():
    root = sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent
    found = check_tree(root)
    print("\n".join(found) if found else "check_layers: every include and every length is in order")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
