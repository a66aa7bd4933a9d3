#!/usr/bin/env python3
"""stof_library_test.py: how the Python package stof finds libstof, what it refuses, and whether its structures are those of
stof.h. Environment: STOF_LIBRARY, CC. Takes no numpy, no sensor. Ends with 77 where these are not set."""

import ctypes
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import package_support as support

if __name__ == "__main__":
    support.skip_without("STOF_LIBRARY", "CC")

PACKAGE = support.ROOT / "host/python"
sys.path.insert(0, str(PACKAGE))
from stof import _library  # noqa: E402

STRUCTURES = (*_library.FIXED, *_library.GROWING)


def python(code, **environment):
    return subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, check=False, timeout=60,
                          env={**os.environ, "PYTHONPATH": str(PACKAGE), **environment})


class Library(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def compile(self, source, output, *flags):
        file = self.folder / "source.c"
        file.write_text(source, encoding="utf-8")
        built = subprocess.run([support.CC, *flags, "-I", str(support.ROOT / "host/lib/include"), str(file), "-o", str(output)],
                               capture_output=True, text=True, check=False)
        self.assertEqual(built.returncode, 0, built.stderr)
        return output

    def fake(self, version="0.9.0", sizes=None, without=()):
        """A library with the functions, and the sizes of the structures but those of `sizes`."""
        told = {structure._name_: ctypes.sizeof(structure) for structure in STRUCTURES}
        told.update(sizes or {})
        body = "".join(f'if (strcmp(name, "{name}") == 0) return {size};' for name, size in told.items())
        special = {"stof_version": f'const char* stof_version(void) {{ return "{version}"; }}',
                   "stof_struct_size": f"unsigned long stof_struct_size(const char* name) {{ {body} return 0; }}"}
        source = "#include <string.h>\n" + "\n".join(
            special.get(name, f"int {name}(void) {{ return 0; }}") for name in _library._FUNCTIONS if name not in without)
        return self.compile(source, self.folder / "libstof.so.0", "-shared", "-fPIC")

    def refused(self, library, *facts):
        ended = python("import stof", STOF_LIBRARY=str(library))
        self.assertEqual(ended.returncode, 1)
        line = ended.stderr.strip().splitlines()[-1]
        self.assertRegex(line, r"LibraryError: stof: ")
        for fact in facts:
            self.assertIn(fact, line)

    def test_structures_are_those_of_the_header(self):
        lines, here = [], []
        for structure in STRUCTURES:
            name = structure._name_
            lines.append(f'printf("{name} %zu\\n", sizeof({name}));')
            here.append(f"{name} {ctypes.sizeof(structure)}")
            for field, *_ in structure._fields_:
                lines.append(f'printf("{name}.{field} %zu %zu\\n", offsetof({name}, {field}), sizeof((({name}*)0)->{field}));')
                described = getattr(structure, field)
                here.append(f"{name}.{field} {described.offset} {described.size}")
        program = self.compile("#include <stddef.h>\n#include <stdio.h>\n#include <stof/stof.h>\nint main(void) {\n" + "\n".join(lines)
                               + "\nreturn 0;\n}\n", self.folder / "sizes")
        there = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout.splitlines()
        self.assertEqual(here, there)
        self.assertGreater(len(there), 120)

    def test_the_library_of_this_build_is_taken(self):
        ended = python("import stof; print(stof.__version__)")
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        self.assertRegex(ended.stdout, r"^0\.\d+\.\d+$")

    def test_a_later_one_whose_structures_grew_is_taken(self):
        library = self.fake(sizes={"stof_frame": ctypes.sizeof(_library.Frame) + 16})
        self.assertEqual(python("import stof", STOF_LIBRARY=str(library)).stderr, "")

    def test_another_major_version_is_refused_in_one_line(self):
        self.refused(self.fake(version="1.0.0"), "libstof 1.0.0", "0.x")

    def test_a_structure_of_another_size_is_refused_in_one_line(self):
        for name, difference in (("stof_plane", 8), ("stof_plane", -8), ("stof_frame", -8), ("stof_options", -8), ("stof_found", -4)):
            with self.subTest(name=name, difference=difference):
                size = next(ctypes.sizeof(one) for one in STRUCTURES if one._name_ == name)
                self.refused(self.fake(sizes={name: size + difference}), name, str(size + difference))

    def test_what_is_no_libstof_or_too_old_is_refused_in_one_line(self):
        self.refused(self.fake(without=("stof_keep",)), "no stof_keep")
        self.refused(self.folder / "none.so", "none.so", "STOF_LIBRARY")
        (self.folder / "text.so").write_text("text", encoding="ascii")
        self.refused(self.folder / "text.so", "text.so")
        self.refused("libc.so.6", "stof_version")

    def test_without_numpy_all_but_images_works(self):
        ended = python("import sys; sys.modules['numpy'] = None\nimport stof\nprint(len(stof.discover(0.05)) >= 0)\n"
                       "from stof import _frame\ntry:\n  _frame._numpy()\nexcept stof.Error as error:\n  print(error)")
        self.assertEqual(ended.stderr, "")
        self.assertEqual(ended.stdout.splitlines()[0], "True")
        self.assertIn("install python3-numpy", ended.stdout.splitlines()[1])

    def test_every_status_has_an_exception_with_the_librarys_words(self):
        import stof
        from stof._errors import error_of
        kinds = {1: stof.Timeout, 2: stof.BadArgument, 3: stof.Unreachable, 4: stof.Lost, 5: stof.NotYet, 6: stof.Busy, 8: stof.Refused,
                 9: stof.NoMemory, 10: stof.Unsupported, 12: stof.End, 13: stof.FileFailed}
        for status in range(1, 15):
            error = error_of(status, "text")
            self.assertIs(type(error), kinds.get(status, stof.Error))
            self.assertEqual((str(error), error.status), ("text", status))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
