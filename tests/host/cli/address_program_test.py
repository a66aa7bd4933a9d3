#!/usr/bin/env python3
"""address_program_test.py COMMAND: `stof address` (COMMAND: stof) against `stofd` (STOFD holds that command), the two in networks
of their own with a cable between, where they share no network: the sensor has 10.0.0.5/24, the computer 192.168.1.7/24. A thread
stands for the image's program that sets addresses. As root where `ip netns` is allowed; ends with 77 when all was skipped."""

import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "discovery"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "host/python"))
import stof_wire as wire  # noqa: E402
from discovery_test import ENOUGH_S, FAR, NEAR, ip, within  # noqa: E402

COMMAND = []
THIRD, SWITCH = f"{NEAR}_third", f"{NEAR}_switch"
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
CODE = "00112233445566778899aabbccddeeff"
FIRST, OURS, LEASE = "10.0.0.5/24", "192.168.1.7/24", "192.168.1.60/24"
DEVICE, SERIAL = 0x23, "00000023"
ASK = f"""
import socket, sys, time
asking = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
asking.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
asking.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
asking.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, b"stof0")
asking.bind(("", int(sys.argv[1])))
asking.sendto(bytes.fromhex(sys.argv[2]), ("255.255.255.255", 7560))
end = time.monotonic() + 2
while (left := end - time.monotonic()) > 0:
    asking.settimeout(left)
    try:
        answer = asking.recv(2000)
    except TimeoutError:
        break
    if answer[5] != {wire.PacketType.ANNOUNCE.value} or answer[52:56] != bytes(4):  # no beacon
        print(answer.hex())
        break
"""


def make_network(ipv6):
    """A switch: the computer, the sensor, and a third host."""
    if not all(ip("netns", "add", name) for name in (NEAR, FAR, THIRD, SWITCH)):
        return False
    done = ip("-n", SWITCH, "link", "add", "switch", "type", "bridge") and ip("-n", SWITCH, "link", "set", "switch", "up")
    for name, device in ((NEAR, "stof0"), (FAR, "stof1"), (THIRD, "stof2")):
        done = (done and ip("link", "add", device, "netns", name, "type", "veth", "peer", "name", device, "netns", SWITCH)
                and ip("-n", SWITCH, "link", "set", device, "master", "switch", "up"))
    for name, device, address in ((NEAR, "stof0", OURS), (FAR, "stof1", FIRST), (THIRD, "stof2", "192.168.1.200/24")):
        for key, value in (("ipv6.conf.all.disable_ipv6", 1 - ipv6), ("ipv6.conf.default.accept_dad", 0), ("ipv4.conf.all.rp_filter", 0),
                           ("ipv4.conf.default.rp_filter", 0), (f"ipv4.conf.{device}.rp_filter", 0), (f"ipv6.conf.{device}.accept_dad", 0)):
            subprocess.run(within(name, ["sysctl", "-qw", f"net.{key}={value}"]), check=False, capture_output=True)
        done = done and all(ip("-n", name, *words) for words in (("link", "set", "lo", "up"), ("link", "set", device, "up"),
                                                                 ("addr", "add", address, "brd", "+", "dev", device)))
    return done


class Setter(threading.Thread):
    """board/image/network: carries out what stofd asks for. LEASE is what a DHCP server would give."""

    def __init__(self, wanted, done):
        super().__init__()
        self.wanted, self.done, self.ended, self.lost, self.leases = wanted, done, False, None, True
        self.lease = LEASE
        self.log = []

    def run(self):
        carried = None
        while not self.ended:
            asked = self.wanted.read_text(encoding="utf-8") if self.wanted.exists() else carried
            if asked != carried:
                carried = asked
                self.carry_out(dict(line.split(" ", 1) for line in asked.splitlines()))
                self.done.write_text(asked, encoding="utf-8")
            time.sleep(0.2)

    def carry_out(self, words):
        self.log.append(words)
        ip("-n", FAR, "-4", "addr", "flush", "dev", "stof1")
        address = words.get("address")
        if address is not None and address != self.lost:
            ip("-n", FAR, "addr", "add", address, "brd", "+", "dev", "stof1")
        if words["dhcp"] == "yes" and self.leases:
            ip("-n", FAR, "addr", "add", self.lease, "brd", "+", "dev", "stof1")


class Address(unittest.TestCase):
    ipv6 = 0

    @classmethod
    def setUpClass(cls):
        if cls is Address:
            raise unittest.SkipTest("those that are of it have the tests")
        cls.addClassCleanup(lambda: [ip("netns", "del", name) for name in (NEAR, FAR, THIRD, SWITCH)])
        if not make_network(cls.ipv6):
            raise unittest.SkipTest("no network namespaces here: run as root where `ip netns` is allowed")

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.environment = {**os.environ, "XDG_CONFIG_HOME": str(self.folder / "config")}
        self.settings = self.folder / "settings.json"
        self.settings.write_text(json.dumps({"network": {"dhcp": False, "address": FIRST}}), encoding="utf-8")
        (self.folder / "label").touch(mode=0o600)
        (self.folder / "label").write_text(CODE + "\n", encoding="utf-8")
        self.setter = Setter(self.folder / "network", self.folder / "done")
        self.setter.start()
        self.addCleanup(self.end_setter)
        self.log = self.folder / "log"
        with self.log.open("w", encoding="utf-8") as log:
            self.sensor = subprocess.Popen(
                within(FAR, [*STOFD, "--size", "64x48", "--pmd", "32x24", "--device", str(DEVICE), "--settings", str(self.settings), "--label",
                             str(self.folder / "label"), "--network", str(self.folder / "network"), "--network-done",
                             str(self.folder / "done")]), stdout=log, stderr=subprocess.STDOUT)
        self.addCleanup(lambda: (self.sensor.terminate(), self.sensor.wait(ENOUGH_S)))
        # The host keeps the addresses of the test before until then.
        self.until(lambda: "publishing" in self.said() and (self.folder / "done").exists())

    def end_setter(self):
        self.setter.ended = True
        self.setter.join()

    def said(self):
        return self.log.read_text(encoding="utf-8")

    def until(self, done):
        end = time.monotonic() + ENOUGH_S
        while not (found := done()):
            self.assertLess(time.monotonic(), end, self.said())
            time.sleep(0.1)
        return found

    def stof(self, *words):
        if words[0] == "address":
            words = (*words, "--timeout", "3")  # of each attempt: the machine may be busy with other tests
        return subprocess.run(within(NEAR, [*COMMAND, *map(str, words)]), capture_output=True, text=True, timeout=180, cwd=self.folder,
                              env=self.environment)

    def ask(self, *words):
        ended = self.stof(*words)
        self.assertEqual(ended.returncode, 0, ended.stderr + self.said())
        return ended.stdout

    def pair(self):
        self.ask("pair", SERIAL, "--code", CODE, "--timeout", "5")

    def saved(self):
        return json.loads(self.settings.read_text(encoding="utf-8"))["network"]

    def found(self):
        return next((sensor for sensor in json.loads(self.stof("discover", "--json").stdout or "[]") if sensor["serial"] == SERIAL), None)

    def link(self, port, request):
        answer = subprocess.run(within(NEAR, [sys.executable, "-c", ASK, str(port), request.hex()]), capture_output=True, text=True,
                                check=True).stdout.strip()
        return bytes.fromhex(answer)


class ByBroadcast(Address):
    """Without IPv6."""

    def test_it_is_found_and_others_are_told_what_to_do(self):
        found = self.until(self.found)
        self.assertEqual((found["address"], found["device_id"]), ("10.0.0.5", DEVICE))
        self.assertIn("beacon", found["found_by"])  # and by its multicast DNS, whose answers may cross the link as well
        self.assertIn("in another network than this computer (stof address)", self.stof("discover").stdout)
        for words in (("view", "--frames", "1"), ("info",), ("update", "absent.update")):
            ended = self.stof(words[0], SERIAL, *words[1:])
            self.assertNotEqual(ended.returncode, 0)
            if words[0] != "update":
                self.assertEqual((ended.returncode, ended.stderr.count("\n")), (1, 1), ended.stderr)
                self.assertIn(f"stof address {SERIAL} ADDRESS/BITS", ended.stderr)

    def test_it_gets_an_address_by_its_serial_number(self):
        refused = self.stof("address", SERIAL, "192.168.1.50/24")
        self.assertEqual((refused.returncode, refused.stdout), (1, ""), refused.stderr)
        self.assertEqual(self.saved()["address"], FIRST)
        self.pair()
        told = json.loads(self.ask("address", SERIAL, "192.168.1.50/24", "--json"))
        self.assertEqual((told["device_id"], told["address"], told["place"], told["saved_too"]),
                         (DEVICE, "192.168.1.50", "192.168.1.50:7560", []))
        self.assertEqual((self.saved()["address"], self.saved()["dhcp"]), ("192.168.1.50/24", False))
        self.assertIn("settings changed by broadcast; network is on trial", self.said())
        self.assertEqual(self.ask("config", SERIAL, "get", "network.address").strip(), "192.168.1.50/24")
        # From here on its address is one of this network. Two at once, and back to DHCP.
        self.ask("address", SERIAL, "dhcp", "192.168.1.51/24", "--gateway", "192.168.1.1")
        self.assertEqual((self.saved()["address"], self.saved()["dhcp"], self.saved()["gateway"]), ("192.168.1.51/24", True, "192.168.1.1"))
        told = json.loads(self.ask("address", SERIAL, "dhcp", "--json"))
        self.assertEqual((told["address"], self.saved()["address"], self.saved()["dhcp"]), ("192.168.1.60", "", True))

    def test_it_may_get_one_of_another_network_too(self):
        self.pair()
        said = self.ask("address", SERIAL, "172.16.0.9/24")
        self.assertIn(f"sensor {DEVICE}: heard at 172.16.0.9, and saved", said)
        self.assertIn("reaches the sensor by broadcast alone", said)
        self.assertEqual(self.saved()["address"], "172.16.0.9/24")

    def test_where_nobody_hears_it_it_goes_back(self):
        self.pair()
        self.setter.lost = "192.168.1.52/24"
        ended = self.stof("address", SERIAL, self.setter.lost, "--wait", "8", "--json")
        self.assertEqual((ended.returncode, ended.stdout, ended.stderr.count("\n")), (1, "", 1), ended.stderr)
        self.assertIn("is not heard at its new address: it goes back", ended.stderr)
        self.assertEqual(self.saved()["address"], FIRST)
        end = time.monotonic() + 75
        while "because nobody saved its change in time" not in self.said():
            self.assertLess(time.monotonic(), end, self.said())
            time.sleep(0.5)
        self.until(lambda: (sensor := self.found()) and sensor["address"] == "10.0.0.5")
        self.assertEqual(self.ask("config", SERIAL, "get", "network.address").strip(), FIRST)
        self.assertEqual(self.saved()["address"], FIRST)

    def test_who_gives_up_is_told_what_comes_of_it(self):
        self.pair()
        self.setter.lost = "192.168.1.52/24"
        changing = subprocess.Popen(within(NEAR, [*COMMAND, "address", SERIAL, self.setter.lost]), stdout=subprocess.PIPE,
                                    stderr=subprocess.PIPE, text=True, cwd=self.folder, env=self.environment)
        self.until(lambda: "network is on trial" in self.said())
        changing.send_signal(signal.SIGINT)
        out, error = changing.communicate(timeout=ENOUGH_S)
        self.assertEqual((changing.returncode, out, error.count("\n")), (1, "", 1), error)
        self.assertIn("was given up", error)
        self.assertIn("goes back to the one of before", error)

    def test_where_a_lease_is_of_another_network_it_is_heard_there(self):
        self.pair()
        self.setter.lease = "10.0.0.60/24"
        told = json.loads(self.ask("address", SERIAL, "dhcp", "--json"))
        self.assertEqual((told["address"], self.saved()["address"], self.saved()["dhcp"]), ("10.0.0.60", "", True))

    def test_bad_words_change_nothing(self):
        self.pair()
        asked = len(self.setter.log)
        for words in (("192.168.1.50",), ("192.168.1.0/24",), ("192.168.1.50/33",), ("dhcp", "dhcp"), ("link-local", "dhcp"), ("up",),
                      ("dhcp", "--gateway", "192.168.1.1"), ("192.168.1.50/24", "--gateway", "192.168.2.1"), ()):
            ended = self.stof("address", SERIAL, *words)
            self.assertEqual((ended.returncode, ended.stdout, ended.stderr.count("\n")), (2, "", 1), f"{words} {ended.stderr}")
        time.sleep(1.5)
        self.assertEqual(len(self.setter.log), asked)


class ByIpv6(Address):
    """The addresses that IPv6 gives each link lead to it whatever the others are."""

    ipv6 = 1

    def test_it_is_found_and_gets_an_address(self):
        found = self.until(lambda: (sensor := self.found()) and "direct" in sensor["found_by"] and sensor)
        self.assertTrue(found["address"].startswith("fe80:"), found)
        self.ask("view", SERIAL, "--frames", "1")
        self.pair()
        told = json.loads(self.ask("address", SERIAL, "172.16.0.9/24", "--json"))
        self.assertEqual(told["address"], "172.16.0.9")
        self.assertTrue(told["place"].startswith("[fe80:"), told)
        self.assertIn("reaches the sensor by IPv6 of the link alone", self.ask("address", SERIAL, "172.16.0.10/24"))
        told = json.loads(self.ask("address", SERIAL, "192.168.1.50/24", "--json"))
        self.assertEqual((told["place"], self.saved()["address"]), ("192.168.1.50:7560", "192.168.1.50/24"))
        found = self.until(lambda: (sensor := self.found()) and "direct" in sensor["found_by"] and sensor)
        self.assertEqual(found["address"], "192.168.1.50")

    def test_without_any_other_address_it_is_found_too(self):
        ip("-n", FAR, "-4", "addr", "flush", "dev", "stof1")
        self.assertTrue(self.until(self.found)["address"].startswith("fe80:"))


def main():
    COMMAND.extend(sys.argv[1:])
    result = unittest.main(argv=sys.argv[:1], verbosity=2, exit=False).result
    for _, reason in result.skipped:
        print("skipped:", reason)
    if not result.wasSuccessful():
        return 1
    return 77 if result.testsRun == len(result.skipped) else 0


if __name__ == "__main__":
    sys.exit(main())
