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


FORGE = """
import socket, struct, sys, time
raw = socket.socket(socket.AF_INET, socket.SOCK_RAW, socket.IPPROTO_RAW)
raw.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
raw.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, b"stof1")
words = bytes.fromhex(sys.argv[2])
udp = struct.pack("!HHHH", 7560, 7561, 8 + len(words), 0) + words
head = struct.pack("!BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), 1, 0, 1, 17, 0, socket.inet_aton(sys.argv[1]), b"\\xff" * 4)
while True:
    raw.sendto(head + udp, ("255.255.255.255", 0))
    time.sleep(0.2)
"""


# A host of the link that has the address which the sensor shall have: beacons in its name lead there, and what is asked
# there it hands on by broadcast, and back what the sensor answers so.
RELAY = f"""
import select, socket, struct, sys, time, zlib
sys.path.insert(0, sys.argv[3])
import stof_wire as wire
own, announced = sys.argv[1], bytes.fromhex(sys.argv[2])
def opened(address, port):
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    for option in (socket.SO_BROADCAST, socket.SO_REUSEADDR):
        made.setsockopt(socket.SOL_SOCKET, option, 1)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, b"stof2")
    made.bind((address, port))
    return made
asked, link, beacon, asking = opened(own, 7560), opened("", 7561), opened(own, 0), {{}}
header, payload = wire.parse(announced)
heard = time.monotonic()
while True:
    if time.monotonic() - heard > 0.3:
        beacon.sendto(wire.seal(header, bytes(4) + payload[4:]), ("255.255.255.255", 7561))
        heard = time.monotonic()
    for ready in select.select([asked, link], [], [], 0.05)[0]:
        packet, sender = ready.recvfrom(2000)
        if len(packet) < 60 or packet[:4] != b"STOF":
            continue
        kind = packet[5]
        signed = 24 if kind in ({wire.PacketType.SIGNED_REQUEST.value}, {wire.PacketType.SIGNED_ANSWER.value}) else 0
        request = packet[packet[6] + signed:][:4]
        if ready is link:
            if request in asking and sender[0] != own:
                asked.sendto(packet, asking[request])
        elif kind == {wire.PacketType.DISCOVER.value}:
            asked.sendto(wire.seal(header, request + payload[4:]), sender)
        else:
            asking[request] = sender
            link.sendto(packet, ("255.255.255.255", 7560))
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
            raise unittest.SkipTest("the two below have the tests")
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


class ByBroadcast(Address):
    """Without IPv6."""

    def link(self, port, request):
        answer = subprocess.run(within(NEAR, [sys.executable, "-c", ASK, str(port), request.hex()]), capture_output=True, text=True,
                                check=True).stdout.strip()
        return bytes.fromhex(answer)

    def relay(self):
        announced = self.link(7561, wire.seal(wire.Header(type=wire.PacketType.DISCOVER), wire.Discover(request_id=7).pack()))
        stranger = subprocess.Popen(within(THIRD, [sys.executable, "-c", RELAY, "192.168.1.200", announced.hex(),
                                                   str(pathlib.Path(wire.__file__).parent)]))
        self.addCleanup(lambda: (stranger.kill(), stranger.wait()))
        return stranger

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

    def test_an_address_that_a_stranger_tells_of_it_is_not_its_own(self):
        self.pair()
        discover = wire.seal(wire.Header(type=wire.PacketType.DISCOVER), wire.Discover(request_id=7).pack())
        announced = self.link(7561, discover)
        self.setter.leases = False
        stranger = subprocess.Popen(within(FAR, [sys.executable, "-c", FORGE, "10.0.0.200", announced.hex()]))
        self.addCleanup(lambda: (stranger.kill(), stranger.wait()))
        ended = self.stof("address", SERIAL, "dhcp", "--wait", "8", "--json")
        self.assertEqual((ended.returncode, ended.stdout, ended.stderr.count("\n")), (1, "", 1), ended.stderr)
        self.assertIn("is not heard at its new address: it goes back", ended.stderr)
        self.assertEqual((self.saved()["address"], self.saved()["dhcp"]), (FIRST, False))

    def test_an_address_at_which_a_stranger_hands_on_what_the_sensor_signs_is_not_its_own(self):
        self.pair()
        stranger = self.relay()
        self.setter.leases = False
        ended = self.stof("address", SERIAL, "dhcp", "--wait", "12", "--json")
        self.assertIsNone(stranger.poll())
        self.assertEqual((ended.returncode, ended.stdout, ended.stderr.count("\n")), (1, "", 1), ended.stderr)
        self.assertIn("who answers at 192.168.1.200 is not the sensor", ended.stderr)
        self.assertEqual((self.saved()["address"], self.saved()["dhcp"]), (FIRST, False))

    def test_who_hands_on_what_the_sensor_signs_is_not_kept_as_its_place(self):
        self.pair()
        stranger = self.relay()
        told = json.loads(self.ask("address", SERIAL, "172.16.0.9/24", "--wait", "20", "--json"))
        self.assertIsNone(stranger.poll())
        self.assertEqual(told["address"], "172.16.0.9")
        self.assertIn("by broadcast", told["place"])
        self.assertEqual(self.saved()["address"], "172.16.0.9/24")

    def forge(self, address, serial, origin=wire.Origin(device_id=DEVICE + 1, session_id=77), name=None, request_id=7):
        """Another sensor is announced there; origin None: this one, with that number and name."""
        discover = wire.seal(wire.Header(type=wire.PacketType.DISCOVER), wire.Discover(request_id=7).pack())
        header, payload = wire.parse(self.link(7561, discover))
        header.origin = origin or header.origin
        announce = wire.Announce.unpack(payload)
        announce.serial = serial
        announce.name = name or announce.name
        announce.request_id = request_id
        stranger = subprocess.Popen(within(FAR, [sys.executable, "-c", FORGE, address, wire.seal(header, announce.pack()).hex()]))
        self.addCleanup(lambda: (stranger.kill(), stranger.wait()))
        return stranger

    def test_who_says_that_he_has_its_serial_number_is_not_taken_for_it(self):
        self.pair()
        asked = len(self.setter.log)
        self.forge("192.168.1.77", SERIAL)
        ended = self.stof("address", SERIAL, "192.168.1.50/24")
        self.assertEqual((ended.returncode, ended.stdout, ended.stderr.count("\n")), (2, "", 1), ended.stderr)
        self.assertIn("two sensors near say that they have this serial number", ended.stderr)
        for address in ("192.168.1.77", "10.0.0.5"):
            self.assertIn(address, ended.stderr)
        self.assertEqual(len(self.setter.log), asked)

    def test_one_that_was_there_before_at_another_port_is_not_a_second_one(self):
        stranger = self.forge("192.168.1.77", SERIAL, request_id=0)  # tells, and answers nobody
        self.assertEqual(self.ask("config", SERIAL, "get", "network.address").strip(), FIRST)
        self.assertIsNone(stranger.poll())

    def refused(self, words, *said):
        ended = self.stof(*words)
        self.assertEqual((ended.returncode, ended.stdout, ended.stderr.count("\n")), (2, "", 1), ended.stderr)
        for one in said:
            self.assertIn(one, ended.stderr)

    def test_who_announces_it_with_another_number_or_name_is_told(self):
        stranger = self.forge("10.0.0.5", "00000055", origin=None)
        self.refused(("config", "00000055", "get", "name"), "one sensor near is announced with the serial numbers", SERIAL)
        stranger.kill()
        self.forge("10.0.0.5", SERIAL, origin=None, name="rear")
        self.refused(("config", "rear", "get", "name"), "is announced with the names", "'rear'")

    def test_an_announcement_that_leads_to_another_sensor_is_told(self):
        with self.log.open("a", encoding="utf-8") as log:
            other = subprocess.Popen(within(THIRD, [*STOFD, "--size", "64x48", "--pmd", "32x24", "--device", "36", "--name", "front", "--settings",
                                                    str(self.folder / "other.json")]), stdout=log, stderr=log)
        self.addCleanup(lambda: (other.terminate(), other.wait(ENOUGH_S)))
        self.until(lambda: self.stof("config", "192.168.1.200", "get", "name").returncode == 0)
        self.assertEqual(self.ask("config", "front", "get", "name").strip(), "front")
        self.forge("192.168.1.200", "00000055", origin=wire.Origin(device_id=0x55, session_id=77), name="rear", request_id=0)
        for words in (("config", "00000055", "set", "name=it"), ("config", "rear", "get"), ("info", "00000055"), ("view", "rear", "--frames", "1")):
            self.refused(words, "what is announced as this sensor leads to 192.168.1.200:7560", "where sensor 00000024 ('front') answers")
        self.assertEqual(self.ask("config", "00000024", "get", "name").strip(), "front")

    def test_a_second_address_that_answers_as_it_is_told(self):
        self.pair()
        self.ask("address", SERIAL, "192.168.1.50/24")
        self.assertEqual(self.stof("config", SERIAL, "get", "network.address").stderr, "")
        self.relay()
        ended = self.until(lambda: (asked := self.stof("config", SERIAL, "get", "network.address")).stderr and asked)
        self.assertIn("answer as this sensor; the first is asked", ended.stderr)
        for address in ("192.168.1.50:7560", "192.168.1.200:7560"):
            self.assertIn(address, ended.stderr)

    def test_an_address_that_is_taken_is_refused(self):
        self.pair()
        asked = len(self.setter.log)
        self.forge("192.168.1.77", "00000024")
        for address, fact in (("192.168.1.77/24", "is heard there"), (OURS, "is this computer's own")):
            ended = self.stof("address", SERIAL, address)
            self.assertEqual((ended.returncode, ended.stdout, ended.stderr.count("\n")), (2, "", 1), ended.stderr)
            self.assertIn(fact, ended.stderr)
        self.assertEqual(len(self.setter.log), asked)

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

    def test_a_stranger_of_the_link_is_answered_and_changes_nothing(self):
        self.pair()
        discover = wire.seal(wire.Header(type=wire.PacketType.DISCOVER), wire.Discover(request_id=7).pack())
        header, _ = wire.parse(self.link(7561, discover))
        self.assertEqual(header.origin.device_id, DEVICE)
        text = b'{"network": {"dhcp": true}}'

        def request(device, cookie):
            header = wire.Header(type=wire.PacketType.SETTINGS_REQUEST, origin=wire.Origin(device_id=device))
            return wire.seal(header, wire.SettingsRequest(request_id=8, operation=wire.SettingsOperation.SET, cookie=cookie).pack() + text)

        self.assertEqual(self.link(7561, request(0, 0)), b"")  # for any sensor
        _, first = wire.parse(self.link(7561, request(DEVICE, 0)))
        answer = wire.SettingsAnswer.unpack(first)
        self.assertEqual(answer.result, wire.SettingsResult.COOKIE)
        _, second = wire.parse(self.link(7561, request(DEVICE, answer.cookie)))
        self.assertEqual(wire.SettingsAnswer.unpack(second).result, wire.SettingsResult.DENIED)
        # From any other port the answer goes to that host alone, which is not reached.
        self.assertEqual(self.link(0, discover), b"")
        self.assertEqual(self.saved()["address"], FIRST)


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
