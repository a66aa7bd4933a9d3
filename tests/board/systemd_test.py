#!/usr/bin/env python3
"""systemd_test.py STOFD: the unit of board/systemd is one, exposes little, and lets stofd make all its system calls."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

STOFD = []
UNIT = pathlib.Path(__file__).resolve().parents[2] / "board/systemd/stofd.service"
MOST_EXPOSURE = 2.5
SKIPPED = 77


def said(*command):
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    return done.stdout + done.stderr


def calls_of(group):
    """The system calls of a group, and of the groups in it."""
    found = set()
    for word in said("systemd-analyze", "syscall-filter", group).split("\n")[1:]:
        name = word.strip()
        if name.startswith("@"):
            found |= calls_of(name)
        elif re.fullmatch(r"[a-z0-9_]+", name):
            found.add(name)
    return found


def allowed():
    """What the unit's lines leave, in their order. systemd adds what every process needs."""
    names = calls_of("@default")
    for line in re.findall(r"^SystemCallFilter=(.*)$", UNIT.read_text(), re.MULTILINE):
        listed = set()
        for word in line.removeprefix("~").split():
            listed |= calls_of(word) if word.startswith("@") else {word}
        names = names - listed if line.startswith("~") else names | listed
    return names


def calls_made(log):
    return set(re.findall(r"^(?:\[pid +\d+\] |\d+ +)?([a-z0-9_]+)\(", log, re.MULTILINE))


class Unit(unittest.TestCase):
    def test_systemd_takes_it(self):
        lines = [line for line in said("systemd-analyze", "verify", UNIT).splitlines()
                 if UNIT.name in line and "is not executable" not in line]
        self.assertEqual(lines, [])

    def test_it_exposes_little(self):
        level = re.search(r"Overall exposure level for \S+: ([0-9.]+)", said("systemd-analyze", "security", "--offline=true", UNIT))
        self.assertIsNotNone(level)
        self.assertLessEqual(float(level[1]), MOST_EXPOSURE)

    def test_no_call_of_stofd_is_missing(self):
        if not shutil.which("strace"):
            self.skipTest("strace is not installed")
        with tempfile.TemporaryDirectory(prefix="stof_") as folder:
            log = pathlib.Path(folder, "calls")
            with subprocess.Popen(["strace", "-f", "-o", log, *STOFD, "--size", "64x48", "--pmd", "32x24", "--disparities", "16",
                                   "--port", "0", "--threads", "2", "--settings", f"{folder}/settings.json", "--frames", "20"],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as traced:
                _, error = traced.communicate(timeout=120)
            if "PTRACE" in error or "ptrace" in error:
                self.skipTest("this machine traces no processes")
            made = calls_made(log.read_text())
        self.assertGreater(len(made), 20)
        # The program that systemd starts is not the one that strace starts.
        self.assertEqual(made - allowed() - {"execve"}, set())

    def test_it_denies_what_nobody_needs(self):
        names = allowed()
        for call in ("mount", "ptrace", "init_module", "reboot", "settimeofday", "setuid", "bpf", "keyctl", "symlink"):
            self.assertNotIn(call, names)

    def test_small_buffers_are_told_and_the_file_beside_the_unit_allows_large_ones(self):
        wanted = dict(re.findall(r"^(net\.core\.[rw]mem_max) = (\d+)$", UNIT.with_name("60-stof.conf").read_text(), re.MULTILINE))
        self.assertEqual(set(wanted), {"net.core.rmem_max", "net.core.wmem_max"})
        if not shutil.which("setpriv"):
            self.skipTest("setpriv is not installed")
        # As the unit runs it: whoever has no CAP_NET_ADMIN gets what the system grants to all.
        started = said("setpriv", "--bounding-set=-net_admin", "--inh-caps=-net_admin", *STOFD, "--size", "64x48", "--pmd", "none",
                       "--port", "0", "--frames", "2")
        self.assertIn("2 frames published", started)
        granted = int(pathlib.Path("/proc/sys/net/core/wmem_max").read_text())
        told = re.search(r"(\d+) bytes of buffer in place of (\d+): .*net\.core\.wmem_max=(\d+)", started)
        self.assertEqual(told is None, granted >= int(wanted["net.core.wmem_max"]), started)
        if told:
            self.assertEqual([int(number) for number in told.groups()], [granted] + 2 * [int(wanted["net.core.wmem_max"])])


if __name__ == "__main__":
    if not shutil.which("systemd-analyze"):
        print("systemd-analyze is not installed")
        sys.exit(SKIPPED)
    STOFD.extend(sys.argv[1:])
    unittest.main(argv=sys.argv[:1], verbosity=2)
