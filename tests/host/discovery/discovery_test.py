#!/usr/bin/env python3
"""discovery_test.py SENSOR PART -- COMMAND...: finds a sensor as a user would: `stof discover` (COMMAND) and
python3-zeroconf, an independent implementation of multicast DNS. SENSOR (its words separated by |) is the test
program that makes itself known. Where this machine lets us, in a network of its own: two namespaces and a cable
between them. Ends with 77 when all was skipped."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest

COMMAND = []
SENSOR = []
ENOUGH_S = 60  # for what comes at once where nobody else wants the computer
NEAR, FAR = f"stof_near_{os.getpid()}", f"stof_far_{os.getpid()}"
BROWSER = r"""
import sys, time
from zeroconf import ServiceBrowser, ServiceListener, Zeroconf, IPVersion
class Listener(ServiceListener):
    def add_service(self, zc, type_, name):
        info = zc.get_service_info(type_, name, 30000)
        if info is None:
            print("unresolved", name, flush=True)
            return
        texts = {key.decode(): (value or b"").decode() for key, value in info.properties.items()}
        print("added", [name, info.server, info.port, sorted(info.parsed_addresses(IPVersion.V4Only)), texts],
              flush=True)
    def remove_service(self, zc, type_, name):
        print("removed", name, flush=True)
    def update_service(self, zc, type_, name):
        pass
zc = Zeroconf(interfaces=sys.argv[1:])
print("ready", flush=True)
ServiceBrowser(zc, "_stof._udp.local.", Listener())
time.sleep(300)
"""
RIVAL = r"""
import sys, time, socket
from zeroconf import ServiceInfo, Zeroconf
zc = Zeroconf(interfaces=[sys.argv[1]])
zc.register_service(ServiceInfo("_stof._udp.local.", "front (A17)._stof._udp.local.", port=1, server="rival.local.",
                                addresses=[socket.inet_aton(sys.argv[1])]))
print("ready", flush=True)
time.sleep(300)
"""


def python_with_zeroconf():
    """The interpreter that has the library: this one or Debian's."""
    for candidate in (sys.executable, "/usr/bin/python3"):
        if subprocess.run([candidate, "-c", "import zeroconf"], capture_output=True).returncode == 0:
            return candidate
    return None


def ip(*words):
    return subprocess.run(["ip", *words], capture_output=True, text=True).returncode == 0


def make_network():
    """Two namespaces with a cable between them; False where that is not allowed."""
    if not shutil.which("ip") or not (ip("netns", "add", NEAR) and ip("netns", "add", FAR)):
        return False
    steps = [("link", "add", "stof0", "netns", NEAR, "type", "veth", "peer", "name", "stof1", "netns", FAR)]
    for name, device, address in ((NEAR, "stof0", "192.0.2.1/24"), (FAR, "stof1", "192.0.2.2/24")):
        steps += [("-n", name, "addr", "add", address, "brd", "+", "dev", device),
                  ("-n", name, "link", "set", "lo", "up"), ("-n", name, "link", "set", device, "up")]
    return all(ip(*step) for step in steps)


def within(name, command):
    return ["ip", "netns", "exec", name, *command]


class Running:
    """A process whose lines can be waited for."""

    def __init__(self, command):
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        os.set_blocking(self.process.stdout.fileno(), False)
        self.text = ""

    def wait_for(self, words, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.text += (self.process.stdout.read() or b"").decode()
            if all(word in self.text for word in words):
                return True
            time.sleep(0.02)
        return False

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        self.process.wait(ENOUGH_S)
        self.process.stdout.close()


class Discovery(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.addClassCleanup(lambda: (ip("netns", "del", NEAR), ip("netns", "del", FAR)))
        if not make_network():
            raise unittest.SkipTest("no network namespaces here: run as root where `ip netns` is allowed")

    def start(self, name, command, ready):
        running = Running(within(name, command))
        self.addCleanup(running.stop)
        self.assertTrue(running.wait_for([ready], ENOUGH_S), running.text)
        return running

    def sensor(self, serial="A17", name="front", port=7560, where=FAR):
        return self.start(where, [*SENSOR, serial, name, str(port)], f"port {port}")

    def discover(self, *arguments, where=NEAR, until=lambda ended: True):
        """What it says, `until` it says that: it listens no longer than it was told to, and a busy computer may answer later."""
        end = time.monotonic() + ENOUGH_S
        while True:
            ended = subprocess.run(within(where, [*COMMAND, "discover", *arguments]), capture_output=True, text=True, timeout=120)
            if until(ended) or time.monotonic() > end:
                return ended


class Discover(Discovery):
    def test_a_sensor_is_found_in_every_way_within_three_seconds(self):
        self.sensor()
        took = []

        def all_ways(ended):
            took.append(time.monotonic())
            return all(f'"{way}"' in ended.stdout for way in ("direct", "beacon", "mdns"))

        begin = time.monotonic()
        ended = self.discover("--json", until=all_ways)
        self.assertLess((took[-1] - begin) / len(took), 30)  # of these 2.5 to listen; a busy computer adds to it
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertEqual(json.loads(ended.stdout), [{
            "serial": "A17", "name": "front", "address": "192.0.2.2", "port": 7560, "device_id": 0x0a0b0c0d,
            "version": "0.1.0", "board": "emu", "health": "degraded", "found_by": ["direct", "beacon", "mdns"],
            "standby": False, "rate_hz": 29.97, "subscribers": 0, "most_subscribers": 4}])

    def test_it_is_one_line(self):
        self.sensor(port=7777)  # nobody asks there: found by beacon and mDNS, then asked
        ended = self.discover(until=lambda ended: ended.stdout.endswith("by direct beacon mdns\n"))
        self.assertEqual(ended.stdout, "A17 'front' at 192.0.2.2:7777: emu, version 0.1.0, health degraded, "
                         "30.0 Hz, 0 of 4 subscribers; by direct beacon mdns\n")

    def test_it_is_found_on_the_same_machine(self):
        self.sensor(where=NEAR)
        self.assertEqual(len(json.loads(self.discover("--json", until=lambda ended: ended.returncode == 0).stdout)), 1)

    def test_a_given_address_is_asked_at_its_port(self):
        self.sensor(port=7777)
        ended = self.discover("--json", "--timeout", "0.5", "--address", "192.0.2.2:7777",
                              until=lambda ended: '"direct"' in ended.stdout)
        self.assertIn("direct", json.loads(ended.stdout)[0]["found_by"])

    def test_nothing_is_an_error_of_one_line(self):
        ended = self.discover("--timeout", "0.3")
        self.assertEqual((ended.returncode, ended.stdout), (1, ""))
        self.assertEqual(ended.stderr.count("\n"), 1)
        self.assertIn("--address", ended.stderr)

    def test_a_bad_address_is_refused(self):
        ended = self.discover("--timeout", "0.3", "--address", "[::1")
        self.assertEqual(ended.returncode, 2)
        self.assertIn("'[::1'", ended.stderr)


class Zeroconf(Discovery):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.python = python_with_zeroconf()
        if not cls.python:
            raise unittest.SkipTest("no zeroconf library: install python3-zeroconf")

    def browser(self):
        return self.start(NEAR, [self.python, "-c", BROWSER, "192.0.2.1"], "ready")

    def test_it_sees_the_sensor_come_and_go(self):
        browser = self.browser()
        sensor = self.sensor()
        self.assertTrue(browser.wait_for(["added"], ENOUGH_S), browser.text)
        for fact in ("front (A17)._stof._udp.local.", "'stof-a17.local.', 7560, ['192.0.2.2']", "'serial': 'A17'",
                     "'id': '0a0b0c0d'", "'version': '0.1.0'"):
            self.assertIn(fact, browser.text)
        sensor.stop()
        self.assertTrue(browser.wait_for(["removed front (A17)"], ENOUGH_S), browser.text)

    def test_it_finds_a_sensor_that_was_there_before(self):
        self.sensor()
        time.sleep(3)  # announced
        browser = self.browser()
        self.assertTrue(browser.wait_for(["added"], ENOUGH_S), browser.text)

    def test_two_sensors_on_one_machine_are_two(self):
        self.sensor()
        self.sensor(serial="A17", name="front", port=7570)
        browser = self.browser()
        self.assertTrue(browser.wait_for(["front (A17)._stof", "front (A17)-2._stof"], ENOUGH_S), browser.text)

    def test_a_name_that_is_taken_is_left_to_its_owner(self):
        self.start(NEAR, [self.python, "-c", RIVAL, "192.0.2.1"], "ready")
        self.sensor()
        browser = self.browser()
        facts = ["front (A17)-2._stof", "'stof-a17-2.local.', 7560", "'rival.local.', 1,"]
        self.assertTrue(browser.wait_for(facts, ENOUGH_S), browser.text)


def main():
    split = sys.argv.index("--")
    SENSOR.extend(word for word in sys.argv[1].split("|") if word)
    COMMAND.extend(sys.argv[split + 1:])
    result = unittest.main(argv=[sys.argv[0], *sys.argv[2:split]], verbosity=2, exit=False).result
    for _, reason in result.skipped:
        print("skipped:", reason)
    if not result.wasSuccessful():
        return 1
    return 77 if result.testsRun == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
