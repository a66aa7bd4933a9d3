#!/usr/bin/env python3
"""strangers_program_test.py COMMAND: what a host of the link can make `stof` (COMMAND) believe of a sensor that is named by its number
or name. The networks are those of address_program_test.py; ends with 77 when all was skipped."""

import json
import pathlib
import subprocess
import sys

import address_program_test as networks
from address_program_test import CODE, Address, DEVICE, FAR, FIRST, OURS, SERIAL, STOFD, THIRD, ip, wire, within
from discovery_test import ENOUGH_S

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


# A host that says who it is itself, and hands on to another sensor all else that it is asked.
PROXY = f"""
import socket, sys
sys.path.insert(0, sys.argv[3])
import stof_wire as wire
asked, to = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
asked.bind(("", 7560))
to.settimeout(0.2)
header, payload = wire.parse(bytes.fromhex(sys.argv[1]))
while True:
    packet, sender = asked.recvfrom(2000)
    if packet[5] == {wire.PacketType.DISCOVER.value}:
        asked.sendto(wire.seal(header, packet[packet[6]:][:4] + payload[4:]), sender)
        continue
    to.sendto(packet, (sys.argv[2], 7560))
    try:
        asked.sendto(to.recv(2000), sender)
    except TimeoutError:
        pass
"""


class Strangers(Address):
    """Without IPv6."""

    def relay(self):
        announced = self.link(7561, wire.seal(wire.Header(type=wire.PacketType.DISCOVER), wire.Discover(request_id=7).pack()))
        stranger = subprocess.Popen(within(THIRD, [sys.executable, "-c", RELAY, "192.168.1.200", announced.hex(),
                                                   str(pathlib.Path(wire.__file__).parent)]))
        self.addCleanup(lambda: (stranger.kill(), stranger.wait()))
        return stranger

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

    def forge(self, address, serial, origin=wire.Origin(device_id=DEVICE + 1, session_id=77), name=None, request_id=7, port=7560):
        """Another sensor is announced there; origin None: this one, with that number and name."""
        discover = wire.seal(wire.Header(type=wire.PacketType.DISCOVER), wire.Discover(request_id=7).pack())
        header, payload = wire.parse(self.link(7561, discover))
        header.origin = origin or header.origin
        announce = wire.Announce.unpack(payload)
        announce.serial = serial
        announce.name = name or announce.name
        announce.request_id, announce.port = request_id, port
        stranger = subprocess.Popen(within(FAR, [sys.executable, "-c", FORGE, address, wire.seal(header, announce.pack()).hex()]))
        self.addCleanup(lambda: (stranger.kill(), stranger.wait()))
        return stranger

    def test_who_says_that_he_has_its_serial_number_is_not_taken_for_it(self):
        self.pair()
        asked = len(self.setter.log)
        # A serial number is a device number: who says that he is another device is not even asked.
        stranger = self.forge("192.168.1.77", SERIAL)
        self.assertEqual(self.ask("config", SERIAL, "get", "network.address").strip(), FIRST)
        stranger.kill()
        self.forge("192.168.1.77", SERIAL, origin=wire.Origin(device_id=DEVICE, session_id=77), port=7562)
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
        self.refused(("config", "00000055", "get", "name"), "no sensor near has that serial number")
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

    def proxy(self, header, announce):
        stranger = subprocess.Popen(within(THIRD, [sys.executable, "-c", PROXY, wire.seal(header, announce.pack()).hex(), "192.168.1.50",
                                                   str(pathlib.Path(wire.__file__).parent)]))
        self.addCleanup(lambda: (stranger.kill(), stranger.wait()))
        return stranger

    def test_who_hands_on_what_he_is_asked_changes_no_other_sensor(self):
        self.pair()
        discover = wire.seal(wire.Header(type=wire.PacketType.DISCOVER), wire.Discover(request_id=7).pack())
        header, payload = wire.parse(self.link(7561, discover))
        ip("-n", FAR, "addr", "add", "192.168.1.50/24", "brd", "+", "dev", "stof1")
        announce = wire.Announce.unpack(payload)
        announce.name = "rear"  # of this device
        stranger = self.proxy(header, announce)
        self.until(lambda: "rear" in self.stof("discover", "--json").stdout)
        for words in (("config", "rear", "set", "name=other"), ("address", "rear", "192.168.1.51/24"), ("unpair", "rear"), ("pair", "rear", "--renew"),
                      ("pair", "rear", "--code", CODE, "--again", "--keys", self.folder / "others"), ("info", "rear", "--signed"),
                      ("view", "rear", "--signed", "--frames", "1")):
            ended = self.stof(*words)
            self.assertEqual((ended.returncode, ended.stdout), (2, ""), ended.stderr)
            self.assertRegex(ended.stderr, "whoever answers as this sensor is called '|is announced with the names|where sensor 00000023|does not exist")
        stranger.kill()
        stranger.wait()
        header.origin = wire.Origin(device_id=0x55, session_id=77)
        announce.serial = "00000055"
        stranger = self.proxy(header, announce)
        self.until(lambda: "00000055" in self.stof("discover", "--json").stdout)
        keyless = ("--keys", self.folder / "none")
        for words in (("config", "00000055", "set", "name=other"), ("config", "rear", "set", "name=other", *keyless),
                      ("config", "00000055", "get", "name", *keyless), ("address", "00000055", "192.168.1.51/24"), ("unpair", "00000055"),
                      ("view", "rear", "--frames", "1", "--timeout", "2")):
            ended = self.stof(*words)
            self.assertNotEqual(ended.returncode, 0, (words, ended.stdout))
            self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertIsNone(stranger.poll())
        self.assertNotEqual(self.ask("config", "192.168.1.50", "get", "name").strip(), "other")
        self.ask("unpair", "192.168.1.50", "--list")  # the key is in force

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


if __name__ == "__main__":
    sys.exit(networks.main())
