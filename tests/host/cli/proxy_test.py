#!/usr/bin/env python3
"""proxy_test.py -- COMMAND...: `stof proxy` (COMMAND is `stof`, with an emulator before it in a cross build) between
two sockets, and what it refuses."""

import json
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

COMMAND = []
SENT = 200


def opened_port(file, process):
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and process.poll() is None:
        if file.exists() and file.read_text().endswith("\n"):
            return int(file.read_text())
        time.sleep(0.02)
    raise AssertionError(f"no port in {file}")


def received(endpoint, most):
    """Datagrams, until `most` are there or nothing came for a second."""
    endpoint.settimeout(1)
    datagrams = []
    try:
        while len(datagrams) < most:
            datagrams.append(endpoint.recvfrom(2000))
    except TimeoutError:
        pass
    return datagrams


class Proxy(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.sensor = self.endpoint()
        self.client = self.endpoint()

    def endpoint(self):
        endpoint = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(endpoint.close)
        endpoint.bind(("127.0.0.1", 0))
        return endpoint

    def start(self, *arguments):
        port_file = self.folder / "port"
        process = subprocess.Popen([*COMMAND, "proxy", "--bind", "127.0.0.1", "--listen", "0", "--to",
                                    f"127.0.0.1:{self.sensor.getsockname()[1]}", "--port-file", str(port_file),
                                    *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        return process, opened_port(port_file, process)

    def stop(self, process):
        process.send_signal(signal.SIGINT)
        lines, errors = process.communicate(timeout=60)
        self.assertEqual((process.returncode, errors), (0, ""))
        return lines

    def test_what_goes_up_and_down_is_passed(self):
        process, port = self.start()
        for i in range(SENT):
            self.client.sendto(bytes([i]) * 100, ("127.0.0.1", port))
        arrived = received(self.sensor, SENT)
        self.assertEqual([data for data, _ in arrived], [bytes([i]) * 100 for i in range(SENT)])
        for data, source in arrived:
            self.sensor.sendto(data[:50], source)
        answers = received(self.client, SENT)
        self.assertEqual([data for data, _ in answers], [bytes([i]) * 50 for i in range(SENT)])
        lines = self.stop(process)
        self.assertIn(f"down {SENT} in {SENT} out 0 lost", lines)
        self.assertIn(f"up {SENT} in {SENT} out 0 lost", lines)

    def test_what_is_lost_and_doubled_is_counted(self):
        process, port = self.start("--loss", 50, "--duplicate", 50, "--reorder", 8, "--only", "up", "--seed", 7)
        for i in range(SENT):
            self.client.sendto(i.to_bytes(2, "little"), ("127.0.0.1", port))
        numbers = [int.from_bytes(data, "little") for data, _ in received(self.sensor, 2 * SENT)]
        lines = self.stop(process)
        up = re.findall(r"up (\d+) in (\d+) out (\d+) lost (\d+) twice", lines)[-1]
        sent, out, lost, twice = map(int, up)
        self.assertEqual((sent, out), (SENT, len(numbers)))
        self.assertEqual(sent - lost + twice, out)
        self.assertTrue(60 < lost < 140 and 20 < twice < 80, up)
        self.assertNotEqual(numbers, sorted(numbers))

    def test_json_is_an_object_a_line(self):
        process, port = self.start("--json")
        self.client.sendto(b"up", ("127.0.0.1", port))
        self.assertEqual(len(received(self.sensor, 1)), 1)
        last = [json.loads(line) for line in self.stop(process).splitlines()][-1]
        self.assertEqual((last["port"], last["clients"], last["up"]["in"], last["up"]["out"], last["down"]["in"]), (port, 1, 1, 1, 0))

    def test_bad_input_is_refused_in_one_line(self):
        taken = self.sensor.getsockname()[1]
        for arguments in (["--to", "nowhere"], ["--to", "127.0.0.1:port"], [], ["--to", "127.0.0.1:1", "--loss", "101"],
                          ["--to", "127.0.0.1:1", "--only", "sideways"], ["--to", "127.0.0.1:1", "--burst", "0"],
                          ["--to", "127.0.0.1:1", "--listen", taken]):
            with self.subTest(arguments):
                listen = [] if "--listen" in arguments else ["--listen", "0"]
                ended = subprocess.run([*COMMAND, "proxy", "--bind", "127.0.0.1", *listen, *map(str, arguments)],
                                       capture_output=True, text=True, timeout=60)
                self.assertEqual(ended.returncode, 2, ended.stderr)
                self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
                self.assertTrue(ended.stderr.startswith("stof: "), ended.stderr)


if __name__ == "__main__":
    split = sys.argv.index("--")
    COMMAND.extend(sys.argv[split + 1:])
    unittest.main(argv=sys.argv[:1], verbosity=2)
