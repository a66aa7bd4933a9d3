#!/usr/bin/env python3
"""package_test.py: libstof as another project gets it. Installs it, moves the whole, builds the programs of
examples/ against it, by CMake, by pkg-config and by hand, and runs them against one stofd; the Python ones, too.
Environment: STOF_BUILD, STOF_EXAMPLES, STOFD (folders and program), CMAKE, CC, CXX, CFLAGS, CXXFLAGS, GENERATOR.
Ends with 77 in a cross build: its programs do not run against the installed library here."""

import functools
import os
import pathlib
import re
import select
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

ENVIRONMENT = os.environ
FRAMES = 5
LOOKS = 40  # at 20 Hz: the first calibration comes within a second


def run(*command, **options):
    ended = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=240, **options)
    if ended.returncode != 0:
        raise AssertionError(f"{command}: {ended.returncode}\n{ended.stdout}\n{ended.stderr}")
    return ended.stdout


def refusal(*command):
    """What a command that ends with 2 says."""
    ended = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=60, env={
        **ENVIRONMENT, "LD_LIBRARY_PATH": str(Package.library)})
    if ended.returncode != 2:
        raise AssertionError(f"{command}: {ended.returncode}\n{ended.stdout}\n{ended.stderr}")
    return ended.stderr


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="stof_package_")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.examples = pathlib.Path(ENVIRONMENT["STOF_EXAMPLES"])
        first = cls.folder / "first"
        run(ENVIRONMENT["CMAKE"], "--install", ENVIRONMENT["STOF_BUILD"], "--prefix", first, "--component", "stof")
        cls.prefix = cls.folder / "moved" / "deeper"
        cls.prefix.parent.mkdir()
        shutil.move(first, cls.prefix)  # nothing may know where it was
        cls.library = next(cls.prefix.rglob("libstof.so")).parent
        cls.line, far_end = os.openpty()
        cls.sensor = subprocess.Popen([ENVIRONMENT["STOFD"], "--size", "160x120", "--port", "0", "--port-file", cls.folder / "port",
                                       "--serial", os.ttyname(far_end), "--set", "serial.mode=mavlink"],
                                      stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        cls.addClassCleanup(cls.stop)
        end = time.monotonic() + 60
        while not (cls.folder / "port").exists() or not (cls.folder / "port").read_text().strip():
            if time.monotonic() > end or cls.sensor.poll() is not None:
                raise AssertionError("stofd opens no port")
            time.sleep(0.05)
        cls.endpoint = "127.0.0.1:" + (cls.folder / "port").read_text().strip()

    @classmethod
    def stop(cls):
        cls.sensor.terminate()
        cls.sensor.wait(20)

    def run_example(self, program, frames=FRAMES):
        return run(program, self.endpoint, frames,
                   env={**ENVIRONMENT, "LD_LIBRARY_PATH": str(self.library)})

    @classmethod
    @functools.cache
    def build_by_cmake(cls):
        build = cls.folder / "cmake"
        run(ENVIRONMENT["CMAKE"], "-S", cls.examples, "-B", build, "-G", ENVIRONMENT["GENERATOR"],
            f"-DCMAKE_PREFIX_PATH={cls.prefix}", f"-DCMAKE_CXX_COMPILER={ENVIRONMENT['CXX']}", f"-DCMAKE_C_COMPILER={ENVIRONMENT['CC']}",
            *(f"-DCMAKE_{language}_FLAGS={ENVIRONMENT[f'{language}FLAGS']} -Wall -Wextra -Werror" for language in ("C", "CXX")))
        run(ENVIRONMENT["CMAKE"], "--build", build)
        return build

    def test_a_cmake_project_finds_it_and_gets_points(self):
        text = self.run_example(self.build_by_cmake() / "points")
        self.assertEqual(len(re.findall(r"^frame \d+: \d+x\d+, [1-9]\d* points, the nearest at", text, re.MULTILINE)),
                         FRAMES, text)

    def assert_sees_what_is_ahead(self, text):
        """Of LOOKS lines all but those before the first calibration say what is nearest in the corridor, and how sure it is."""
        self.assertEqual(len(text.splitlines()), LOOKS, text)
        seen = re.findall(r"^frame \d+: (\d+\.\d\d) m, -\+ (\d+\.\d\d) m$", text, re.MULTILINE)
        self.assertEqual(len(seen) + text.count("stop: no depth\n"), LOOKS, text)
        self.assertGreaterEqual(len(seen), 1, text)
        for nearest, half_width in seen:
            self.assertTrue(0.3 < float(nearest) < 12 and float(half_width) < 8, text)

    def test_the_short_clients_see_what_is_ahead(self):
        for program in ("obstacle", "obstacle_c"):
            self.assert_sees_what_is_ahead(self.run_example(self.build_by_cmake() / program, LOOKS))
            self.assertRegex(refusal(self.build_by_cmake() / program), "^usage: ")

    def test_the_short_client_in_python_sees_what_is_ahead(self):
        if "sanitize" in ENVIRONMENT["CFLAGS"]:
            self.skipTest("no Python loads a library with sanitizers")
        python = next((python for python in (sys.executable, "/usr/bin/python3")
                       if os.path.exists(python) and subprocess.run([python, "-c", "import numpy"], capture_output=True).returncode == 0), None)
        if python is None:
            self.skipTest("no numpy: install python3-numpy")
        package = pathlib.Path(__file__).resolve().parents[3] / "host/python"
        environment = {**ENVIRONMENT, "PYTHONPATH": str(package), "STOF_LIBRARY": str(self.library / "libstof.so")}
        self.assert_sees_what_is_ahead(run(python, "-B", self.examples / "obstacle.py", self.endpoint, LOOKS, env=environment))

    def test_a_client_records_and_reads_it_again(self):
        file = self.folder / "recorded.mcap"
        text = run(self.build_by_cmake() / "record", self.endpoint, file, FRAMES, env={**ENVIRONMENT, "LD_LIBRARY_PATH": str(self.library)})
        self.assertEqual(len(re.findall(r"^frame \d+: 160x120, ", text, re.MULTILINE)), FRAMES, text)
        self.assertIn(f"{FRAMES} frames in {file}", text)

    def test_a_c_project_finds_it_by_pkg_config(self):
        if not shutil.which("pkg-config"):
            self.skipTest("no pkg-config: install it")
        found = {**ENVIRONMENT, "PKG_CONFIG_PATH": str(self.library / "pkgconfig"), "PKG_CONFIG_LIBDIR": ""}
        self.assertEqual(run("pkg-config", "--modversion", "stof", env=found).strip(),
                         run("pkg-config", "--modversion", "stof >= 0.1", env=found).strip())
        flags = run("pkg-config", "--cflags", "--libs", "stof", env=found).split()
        program = self.folder / "watch"
        run(ENVIRONMENT["CC"], *ENVIRONMENT["CFLAGS"].split(), "-Wall", "-Wextra", "-Werror",
            self.examples / "watch.c", "-o", program, *flags)
        text = self.run_example(program)
        self.assertGreaterEqual(len(re.findall(r"^frame \d+: \d+\.\d+ m straight ahead", text, re.MULTILINE)), FRAMES)
        self.assertIn("libstof 0.1", text)

    def test_a_c_project_links_it_statically_by_pkg_config(self):
        if not shutil.which("pkg-config"):
            self.skipTest("no pkg-config: install it")
        found = {**ENVIRONMENT, "PKG_CONFIG_PATH": str(self.library / "pkgconfig")}
        self.assertEqual(run("pkg-config", "--print-requires-private", "stof_static", env=found).split(), ["libsodium", "libzstd"])
        flags = run("pkg-config", "--static", "--cflags", "--libs", "stof_static", env=found).split()
        program = self.folder / "watch_static"
        run(ENVIRONMENT["CC"], *ENVIRONMENT["CFLAGS"].split(), self.examples / "watch.c", "-o", program, *flags)
        self.assertNotIn("libstof", run("readelf", "-d", program))
        text = run(program, self.endpoint, FRAMES)  # the folder of the shared one is not named
        self.assertGreaterEqual(len(re.findall(r"^frame \d+: \d+\.\d+ m straight ahead", text, re.MULTILINE)), FRAMES)

    def test_libzstd_is_in_the_shared_library_and_its_names_are_local(self):
        zstd = re.compile(r" ([A-TV-Z]) (ZSTD_\w+|HUF_\w+|FSE_\w+)(?:@\w+)?$", re.MULTILINE)
        self.assertEqual(zstd.findall(run("nm", "-D", self.library / "libstof.so")), [])  # not given
        inside = set(re.findall(r" t (ZSTD_\w+)$", run("nm", self.library / "libstof.so"), re.MULTILINE))
        self.assertLessEqual({"ZSTD_compressCCtx", "ZSTD_freeCCtx"}, inside)

    def test_libsodium_is_in_the_shared_library_and_its_names_are_local(self):
        sodium = re.compile(r" (\w) ((?:crypto|sodium|randombytes)_\w+)$", re.MULTILINE)
        self.assertEqual(sodium.findall(run("nm", "-D", self.library / "libstof.so")), [])  # neither given nor needed
        inside = dict(map(reversed, sodium.findall(run("nm", self.library / "libstof.so"))))
        for name in ("crypto_generichash_init", "crypto_scalarmult", "randombytes_buf", "sodium_memzero"):
            self.assertEqual(inside.get(name), "t", name)
        needed = dict(map(reversed, sodium.findall(run("nm", self.library / "libstof.a"))))
        self.assertEqual(needed.get("crypto_generichash_init"), "U")  # the static one leaves it to the program

    def test_the_static_library_is_whole(self):
        program = self.folder / "static"
        run(ENVIRONMENT["CC"], *ENVIRONMENT["CFLAGS"].split(), f"-I{self.prefix}/include", self.examples / "watch.c",
            "-o", program, self.library / "libstof.a", "-lsodium", "-lzstd", "-lstdc++", "-lm", "-pthread")
        self.assertIn("straight ahead", self.run_example(program))

    def test_the_client_of_an_autopilot_hears_the_nearest_obstacle(self):
        with subprocess.Popen([sys.executable, "-B", "-u", self.examples / "mavlink_watch.py", "0"], stdout=subprocess.PIPE, text=True) as watch, \
                socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            port = int(re.fullmatch(r"listening at UDP port (\d+)\n", watch.stdout.readline())[1])
            heard = []
            reader = threading.Thread(target=lambda: heard.append(watch.stdout.readline()))
            reader.start()
            end = time.monotonic() + 60
            while reader.is_alive() and time.monotonic() < end:
                if select.select([self.line], [], [], 0.1)[0]:
                    sender.sendto(os.read(self.line, 1024), ("127.0.0.1", port))
            watch.kill()
            reader.join()
        self.assertRegex(heard[0], r"^nearest \d+ cm at [+-]\d+\.\d degrees\n$")

    def test_nothing_but_the_interface_is_visible(self):
        names = run("nm", "-D", "--defined-only", self.library / "libstof.so").split("\n")
        visible = {line.split()[-1].split("@")[0] for line in names if line}
        header = (self.prefix / "include/stof/stof.h").read_text()
        declared = set(re.findall(r"^STOF_API [^;]*?(stof_\w+)\(", header, re.MULTILINE))
        self.assertEqual({name for name in visible if not name.startswith("__")} - {"STOF_0"}, declared)

    def test_it_needs_the_run_time_libraries_alone(self):
        if "sanitize" in ENVIRONMENT["CXXFLAGS"]:
            self.skipTest("sanitizers add theirs")
        needed = re.findall(r"NEEDED.*\[(.*?)\.so", run("readelf", "-d", self.library / "libstof.so"))
        self.assertLessEqual(set(needed), {"libc", "libm", "libstdc++", "libgcc_s", "libpthread", "ld-linux-x86-64",
                                           "ld-linux-aarch64"})
        self.assertIn("libstof.so.0", run("readelf", "-d", self.library / "libstof.so"))

    def test_another_version_is_not_taken(self):
        with self.assertRaises(AssertionError) as refused:
            source = self.folder / "newer"
            source.mkdir()
            (source / "CMakeLists.txt").write_text(
                "cmake_minimum_required(VERSION 3.16)\nproject(newer LANGUAGES CXX)\nfind_package(stof 0.2 REQUIRED)\n")
            run(ENVIRONMENT["CMAKE"], "-S", source, "-B", source / "build", "-G", ENVIRONMENT["GENERATOR"],
                f"-DCMAKE_PREFIX_PATH={self.prefix}", f"-DCMAKE_CXX_COMPILER={ENVIRONMENT['CXX']}")
        self.assertIn("0.2", str(refused.exception))


if __name__ == "__main__":
    if not ENVIRONMENT.get("STOFD"):
        print("skipped: a cross build: the examples cannot run against the installed library here")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
