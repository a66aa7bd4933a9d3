#!/usr/bin/env python3
"""Tests of the parts of scripts/package that need no Debian, and of the files that its packages are made of."""

import os
import pathlib
import re
import stat
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/packaging"))
import chroots  # noqa: E402
import man  # noqa: E402
import needs  # noqa: E402

HELP = """Does things.
Usage: prog [OPTIONS] SUBCOMMAND

Options:
  -h,--help                   Print this help message and exit
  --a-very-long-option-of-all UINT:INT in [1 - 65535]=1
                              Its text, which goes on
                              in a second line

Subcommands:
  go                          Go
  .dot                        Begins with a dot

Ends with 0 (done).
"""


class ManTest(unittest.TestCase):
    def test_options_and_their_texts_are_items(self):
        items = [block for block in man.paragraphs(HELP) if block[0] == "item"]
        self.assertEqual(items, [
            ("item", "-h,--help", "Print this help message and exit"),
            ("item", "--a-very-long-option-of-all UINT:INT in [1 - 65535]=1", "Its text, which goes on in a second line"),
            ("item", "go", "Go"), ("item", ".dot", "Begins with a dot")])

    def test_subcommands_are_those_below_their_heading(self):
        self.assertEqual(man.summaries(HELP), [("go", "Go"), (".dot", "Begins with a dot")])

    def test_nothing_of_the_help_is_taken_for_a_macro(self):
        for line in man.body(HELP + ".SH not a heading\n'tis\n", ".SS"):
            self.assertTrue(not line.startswith((".", "'")) or re.match(r"\.(SS|TP|PP)( |$)", line), line)

    def test_a_program_has_a_page_and_each_of_its_commands_one(self):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder, "prog")
            program.write_text('#!/bin/sh\ncase "$*" in\n--help) printf "Does.\\n\\nSubcommands:\\n  go   Goes\\n" ;;\n'
                               '"go --help") printf "Goes.\\n\\nSubcommands:\\n  far   Further\\n" ;;\n'
                               '*) printf "Further.\\n\\nOptions:\\n  --miles   How far\\n\\nExample: prog go far\\nEnds with 0.\\n" ;;\nesac\n')
            program.chmod(0o755)
            pages = man.pages([program], "prog", "does", "1.0", "2026-01-01", ".BR other (1)")
        self.assertEqual(set(pages), {"prog", "prog-go"})
        for line in (".TH PROG 1 ", "prog \\- does", ".BR prog\\-go (1),", ".BR other (1)"):
            self.assertIn(line, pages["prog"])
        for line in (".TH PROG-GO 1 ", "prog\\-go \\- Goes", ".SH PROG GO FAR", "\\fB\\-\\-miles\\fR", "How far", "\\fBprog go far\\fR",
                     "Ends with 0.", ".BR prog (1)"):
            self.assertIn(line, pages["prog-go"])

    def test_a_program_without_help_is_told(self):
        with self.assertRaisesRegex(man.NoPage, "false --help: ended with 1"):
            man.pages(["false"], "false", "", "", "", "")


class NeedsTest(unittest.TestCase):
    def test_versions_are_those_of_the_newest_symbol(self):
        symbols = [("a", "GLIBC", 34), ("b", "GLIBC", 17), ("c", "GLIBCXX", 29), ("d", "GLIBCXX", 9)]
        self.assertEqual(needs.needs(["libc.so.6", "libm.so.6", "libstdc++.so.6", "libgcc_s.so.1"], symbols),
                         ["libc6 (>= 2.34)", "libgcc-s1", "libstdc++6 (>= 11)"])

    def test_what_nobody_knows_is_told(self):
        with self.assertRaisesRegex(needs.Unknown, "libfoo"):
            needs.needs(["libfoo.so.1"], [])
        with self.assertRaisesRegex(needs.Unknown, "GLIBCXX_3.4.99"):
            needs.needs(["libstdc++.so.6"], [("a", "GLIBCXX", 99)])


class ChrootsTest(unittest.TestCase):
    def test_what_a_package_may_leave_is_seen(self):
        for left in ("etc/stof/rig.cal", "etc/default/stofd", "var/lib/stof/settings.json", "usr/lib/python3/dist-packages/stof/__pycache__",
                     "etc/systemd/system/multi-user.target.wants/stofd.service", "usr/share/doc/stofd"):
            self.assertIsNone(chroots.OF_THE_SYSTEM.match(left), left)
        for own in ("var/lib/dpkg/info/stofd.list", "var/cache/apt/pkgcache.bin", "var/log/dpkg.log", "etc/ld.so.cache", "etc/passwd-"):
            self.assertIsNotNone(chroots.OF_THE_SYSTEM.match(own), own)


class FilesTest(unittest.TestCase):
    def test_scripts_of_packages_are_programs_and_shell_reads_them(self):
        scripts = [path for path in (ROOT / "scripts/packaging/control").rglob("*") if path.name in ("postinst", "prerm", "postrm")]
        self.assertEqual(len(scripts), 5)
        for script in (*scripts, ROOT / "scripts/packaging/trial.sh", ROOT / "scripts/packaging/container.sh"):
            if script.name != "trial.sh":
                self.assertTrue(script.stat().st_mode & stat.S_IXUSR, script)
            self.assertEqual(subprocess.run(["sh", "-n", script], check=False).returncode, 0, script)

    def test_the_container_starts_what_is_copied_into_it(self):
        rules = (ROOT / "Dockerfile").read_text()
        for source, target in re.findall(r"^COPY (scripts/\S+) (\S+)$", rules, re.MULTILINE):
            self.assertTrue((ROOT / source).stat().st_mode & stat.S_IXUSR, source)
            self.assertIn(f'ENTRYPOINT ["{pathlib.PurePath(target).name}"]', rules)
        for script in re.findall(r"^RUN (scripts/\w+)", rules, re.MULTILINE):
            self.assertTrue((ROOT / script).stat().st_mode & stat.S_IXUSR, script)
        with tempfile.TemporaryDirectory() as folder:
            stofd = pathlib.Path(folder, "stofd")
            stofd.write_text('#!/bin/sh\necho "stofd $*"\n')
            stofd.chmod(0o755)
            for given, taken in (((), "--scene corridor"), (("--size", "64x48"), "--size 64x48")):
                said = subprocess.run(["sh", ROOT / "scripts/packaging/container.sh", *given], capture_output=True, text=True, check=True,
                                      env={"PATH": f"{folder}:{os.environ['PATH']}"}).stdout
                self.assertIn("stof view 127.0.0.1", said)
                self.assertTrue(said.endswith(f"stofd {taken}\n"), said)

    def test_conffiles_are_installed(self):
        listed = (ROOT / "scripts/packaging/control/stofd/conffiles").read_text().split()
        rules = (ROOT / "scripts/packaging/CMakeLists.txt").read_text()
        self.assertEqual(listed, ["/etc/default/stofd"])
        self.assertIn("DESTINATION /etc/default RENAME stofd", rules)
        self.assertIn("EnvironmentFile=-/etc/default/stofd", (ROOT / "board/systemd/stofd.service").read_text())

    def test_the_symbols_are_those_of_the_header(self):
        header = (ROOT / "host/lib/include/stof/stof.h").read_text()
        declared = set(re.findall(r"^STOF_API [^;]*?(stof_\w+)\(", header, re.MULTILINE))
        listed = re.findall(r"^ (stof_\w+)@STOF_0 \d+\.\d+\.\d+$", (ROOT / "scripts/packaging/libstof0.symbols").read_text(), re.MULTILINE)
        self.assertEqual(set(listed), declared)


class SetupTest(unittest.TestCase):
    def names(self, release):
        """What scripts/setup takes of `run` on a release: its program for the list, with its own lists."""
        script = (ROOT / "scripts/setup").read_text()
        lists = re.search(r"^run_packages='.*?^'$", script, re.MULTILINE | re.DOTALL)[0]
        others = re.search(r"^other_names='.*?^'$", script, re.MULTILINE | re.DOTALL)[0]
        program = re.search(r"^mapfile -t wanted < <\((.*?)\)\n", script, re.MULTILINE | re.DOTALL)[1]
        done = subprocess.run(["bash", "-c", f"{lists}\n{others}\nlist=$run_packages\nrelease={release}\n{program}"],
                              capture_output=True, text=True, check=True, env={"PATH": os.environ["PATH"]})
        return done.stdout.split()

    def test_each_release_has_its_own_names(self):
        self.assertIn("libstdc++-12-dev", self.names("debian-12"))
        for release in ("debian-13", "ubuntu-24.04"):
            names = self.names(release)
            self.assertIn("libstdc++-14-dev", names)
            self.assertNotIn("libstdc++-12-dev", names)
            self.assertEqual(len(names), len(self.names("debian-12")))


if __name__ == "__main__":
    unittest.main()
