#!/usr/bin/env python3
"""scripts/wire_table.py [--check | --cpp DIR | --seeds DIR | --golden FILE]: what is made of firmware/wire/messages.json.

Without an argument writes everything that is kept in the repository.
--check: writes nothing; names what is not up to date and ends with code 1.
--cpp DIR: writes the codec in C++, for the build, and prints its sources as a list of CMake.
--seeds DIR: writes what the fuzz targets begin with, a folder for each target.
--golden FILE: writes a C++ header with one value and its bytes of each message, for the tests.
"""

import argparse
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
from wire import cpp, docs, lua, python, table  # noqa: E402


def outputs(wire, root):
    """{path relative to the root: text} of what is generated and kept in the repository."""
    return python.files(wire, root) | lua.files(wire, root) | docs.files(wire, root)


def stale(texts, root):
    """{path: text} of what is not below `root` as it should be."""
    found = {}
    for path, text in texts.items():
        file = root / path
        if not file.is_file() or file.read_text(encoding="utf-8") != text:
            found[path] = text
    return found


def write(root, texts):
    for path, text in texts.items():
        file = root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--cpp", metavar="DIR", type=pathlib.Path)
    parser.add_argument("--seeds", metavar="DIR", type=pathlib.Path)
    parser.add_argument("--golden", metavar="FILE", type=pathlib.Path)
    arguments = parser.parse_args()
    wire = table.load(ROOT)
    if arguments.golden:
        from wire import golden  # needs what is generated
        arguments.golden.write_text(golden.text(wire), encoding="utf-8")
        return 0
    if arguments.cpp:
        texts = cpp.files(wire)
        write(arguments.cpp, stale(texts, arguments.cpp))
        print(";".join(str(arguments.cpp / path) for path in texts if path.endswith(".cpp")))
        return 0
    if arguments.seeds:
        from wire import seeds
        print(f"wire_table: {seeds.write(arguments.seeds)} seeds in {arguments.seeds}")
        return 0
    changed = stale(outputs(wire, ROOT), ROOT)
    if arguments.check:
        for path in changed:
            print(f"{path}: not what firmware/wire/messages.json says: run scripts/wire_table.py")
        return 1 if changed else 0
    write(ROOT, changed)
    print("wire_table: " + (f"wrote {', '.join(changed)}" if changed else "everything is up to date"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
