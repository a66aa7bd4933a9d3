#!/usr/bin/env python3
"""Every verdict of check_vector_code.py, on disassemblies of made-up objects in a small build."""

import contextlib
import io
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import check_vector_code  # noqa: E402

SPAN = "std::span<short, 18446744073709551615ul>"
KERNEL = f"stof::dsp::neon::add({SPAN})"
REFERENCE = f"stof::dsp::ref::add({SPAN})"
HELPER = f"void stof::dsp::neon::(anonymous namespace)::strip<4ul>({SPAN})"

HEADER = "\nadd_neon.cpp.o:\tfile format elf64-littleaarch64\n\nSYMBOL TABLE:\n"
ADD = "uaddw\tv1.8h, v1.8h, v0.8b", "uaddw2\tv2.8h, v2.8h, v0.16b"
MOVE = ("ldr\tq0, [x1]", "movi\tv0.2d, #0000000000000000", "dup\tv1.8h, w9", "st1\t{ v0.4s }, [x8]",
        "mov\tv2.16b, v0.16b", "smov\tw8, v2.h[1]", "fmov\tv0.4s, #1.0", "ldr\td1, [x0]") * 3


def disassembly(bodies, symbols):
    """bodies: {function: instructions or relocations}; symbols: {function: its letter or *UND*}."""
    lines = [HEADER]
    for name, kind in symbols.items():
        lines.append(f"0000000000000000         *UND*\t0000000000000000 {name}" if kind == "*UND*" else
                     f"0000000000000000 {kind}     F .text\t0000000000000068 {name}")
    lines.append("\nDisassembly of section .text:")
    for name, body in bodies.items():
        lines.append(f"\n0000000000000000 <{name}>:")
        lines += [line if "R_AARCH64" in line else f"      1c:      \t{line}" for line in body]
    return "\n".join(lines) + "\n"


def call(name):
    """A call that the linker completes: to another object or section."""
    return f"bl\t0x1c <{KERNEL}+0x1c>", f"\t\t000000000000001c:  R_AARCH64_CALL26\t{name}"


def tail_call(name):
    return "b\t0x1c <.text+0x1c>", f"\t\t000000000000001c:  R_AARCH64_JUMP26\t{name}"


def local_call(name):
    return (f"bl\t0x1c0 <{name}>",)


def kernel(*body, **more):
    return disassembly({KERNEL: body + ("ret",), **more.get("bodies", {})},
                       {KERNEL: "g", HELPER: "l", REFERENCE: "*UND*"})


def counted(text):
    return check_vector_code.read_functions(text)


class ReadFunctionsTest(unittest.TestCase):
    def test_counts_what_computes_with_whole_vectors(self):
        self.assertEqual(counted(kernel(*ADD, "add\tx8, x8, #0x10", "cmhi\tv3.4s, v0.4s, v1.4s")),
                         {KERNEL: 3})

    def test_counts_nothing_that_only_moves_or_is_scalar(self):
        self.assertEqual(counted(kernel(*MOVE, "add\tw8, w8, w9", "fadd\td0, d0, d1")), {KERNEL: 0})

    def test_counts_the_tail_handed_to_the_reference_for_nothing(self):
        self.assertEqual(counted(kernel(*ADD, *call(REFERENCE))), {KERNEL: 2})

    def test_sees_a_kernel_that_is_a_call_of_the_reference(self):
        for how in (call, tail_call):
            with self.subTest(how.__name__):
                self.assertEqual(counted(kernel(*how(REFERENCE))), {KERNEL: 0})

    def test_follows_calls_within_the_object_and_theirs(self):
        inner = HELPER.replace("4ul", "1ul")
        for how in (call, tail_call, local_call):
            with self.subTest(how.__name__):
                bodies = {HELPER: (*ADD, *how(inner), "ret"), inner: (*ADD, *how(HELPER), "ret")}
                self.assertEqual(counted(kernel(*how(HELPER), bodies=bodies)), {KERNEL: 4})

    def test_does_not_count_neighbours_that_are_not_called(self):
        self.assertEqual(counted(kernel("nop", bodies={HELPER: (*ADD, "ret")})), {KERNEL: 0})

    def test_tells_overloads_apart(self):
        other = KERNEL.replace("short", "int")
        text = disassembly({KERNEL: ADD, other: ("nop",)}, {KERNEL: "g", other: "w"})
        self.assertEqual(counted(text), {KERNEL: 2, other: 0})

    def test_asks_only_functions_that_others_can_call(self):
        self.assertEqual(counted(disassembly({HELPER: ("nop",)}, {HELPER: "l"})), {})
        self.assertEqual(counted(disassembly({REFERENCE: ("nop",)}, {REFERENCE: "g"})), {})


class CheckBuildTest(unittest.TestCase):
    """The program in a tree of its own, with a disassembler that prints the object."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.objdump = self.root / "objdump"
        self.objdump.write_text('#!/bin/sh\nfor file; do :; done\nexec cat "$file"\n')
        self.objdump.chmod(0o755)

    def put(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def put_kernel(self, text):
        self.put("dsp/stereo/add_neon.cpp", "")
        self.put("dsp/stereo/add_ref.cpp", "")
        self.put("build/dsp/CMakeFiles/stof_dsp.dir/stereo/add_neon.cpp.o", text)

    def run_main(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = check_vector_code.main(
                    [str(self.root / "build"), "--objdump", str(self.objdump), *arguments], self.root)
            except SystemExit as exit_:
                code = exit_.code
        return code, out.getvalue().splitlines(), err.getvalue().splitlines()

    def test_says_how_much_it_looked_at(self):
        self.put_kernel(kernel(*ADD))
        self.assertEqual(self.run_main(), (0, ["1 functions in 1 objects looked at, 0 findings"], []))

    def test_finds_a_kernel_without_vectors(self):
        self.put_kernel(kernel(*call(REFERENCE)))
        self.assertEqual(self.run_main()[:2], (1, [
            "dsp/stereo/add_neon.cpp: stof::dsp::neon::add(std::span<short>): 0 vector instructions: "
            "write it with vectors", "1 functions in 1 objects looked at, 1 findings"]))

    def test_finds_a_kernel_outside_of_its_namespace(self):
        self.put_kernel(disassembly({REFERENCE: ADD}, {REFERENCE: "g"}))
        code, lines, _ = self.run_main()
        self.assertEqual(code, 1)
        self.assertIn("dsp/stereo/add_neon.cpp: no function of stof::dsp::neon", lines[0])

    def test_finds_a_source_that_is_not_built(self):
        self.put_kernel(kernel(*ADD))
        self.put("dsp/pmd/new_neon.cpp", "")
        code, lines, _ = self.run_main()
        self.assertEqual(code, 1)
        self.assertTrue(lines[0].startswith("dsp/pmd/new_neon.cpp: no object in "), lines)

    def test_a_tree_without_kernels_proves_nothing(self):
        (self.root / "build").mkdir()
        self.assertEqual(self.run_main()[0], 1)

    def test_says_in_one_line_why_it_could_not_look(self):
        self.put_kernel(kernel(*ADD).replace("aarch64", "x86-64"))
        for arguments in ((), ("--objdump", "/gone"), ("--objdump", "/bin/false")):
            with self.subTest(arguments):
                code, _, lines = self.run_main(*arguments)
                self.assertEqual((code, len(lines)), (2, 1))
        (self.root / "build").rename(self.root / "moved")
        self.assertEqual(self.run_main()[0], 2)


if __name__ == "__main__":
    unittest.main()
