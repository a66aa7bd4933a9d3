#!/usr/bin/env python3
"""install_program_test.py COMMAND...: `stof calib install` (COMMAND: stof, with an emulator before it in a cross build) as a
user would run it, against `stofd`: STOFD holds that command, its words separated by |."""

import json
import os
import pathlib
import pty
import random
import re
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import tty
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "host/python"))
import stof_wire as wire  # noqa: E402

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
ENOUGH_S = 60
WIDTH, HEIGHT, PMD = 160, 120, (64, 48)
PIXELS = PMD[0] * PMD[1]
REQUEST_AT = wire.SignedFields.size() + wire.SettingsRequest.size()  # of an upload request in a signed payload
UPLOAD = wire.SettingsOperation.UPLOAD


def calibration(baseline_m, pattern=0, size=(WIDTH, HEIGHT)):
    """A file of version 3, docs/WIRE.md."""
    file = bytearray(792 + 2 * PIXELS + 4)
    struct.pack_into("<8sHHI", file, 0, b"STOFCAL\0", 3, 0, len(file))
    struct.pack_into("<2i4d", file, 16, *size, 130.0, 130.0, size[0] / 2, size[1] / 2)
    struct.pack_into("<2d", file, 96, baseline_m, 0.0)
    struct.pack_into("<2i4d", file, 112, *PMD, 45.0, 45.0, PMD[0] / 2, PMD[1] / 2)
    struct.pack_into("<Iiiii", file, 192, 20_000_000, 0, 4095, 0, 10)
    struct.pack_into("<6d", file, 212, 100.0, 0.1, 6.0, 60.0, 5.0, 0.0)
    struct.pack_into("<2d", file, 556, 25.0, 1.0)  # temperature, scale
    struct.pack_into("<9d", file, 688, 1, 0, 0, 0, 1, 0, 0, 0, 1)
    struct.pack_into("<I", file, 788, PIXELS)
    struct.pack_into(f"<{PIXELS}h", file, 792, *[pattern] * PIXELS)
    struct.pack_into("<I", file, len(file) - 4, wire.crc32c(bytes(file[:-4])))
    return bytes(file)


def fingerprint(file):
    return struct.unpack("<I", file[-4:])[0]


class Between(threading.Thread):
    """Passes what a client and a sensor say, but for what `spoils` of either side: it loses some, sends some twice, and some
    late. Keeps what the client has sent."""

    def __init__(self, address, spoils=0.0):
        super().__init__(daemon=True)
        self.sensor = (address.split(":")[0], int(address.split(":")[1]))
        self.here = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.here.bind(("127.0.0.1", 0))
        self.there = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.address = "127.0.0.1:%d" % self.here.getsockname()[1]
        self.spoils, self.random, self.late = spoils, random.Random(5), []
        self.asked, self.ended, self.silent, self.most_chunks = [], False, False, None
        self.start()

    def close(self):
        self.ended = True
        self.join()
        self.here.close()
        self.there.close()

    def passed(self, packet):
        chance = self.random.random() / self.spoils if self.spoils else 1.0
        if self.silent or chance < 0.4:
            return []
        if chance < 0.7:
            return [packet, packet]
        if chance < 1.0:
            self.late.append(packet)
            return []
        late, self.late = self.late, []
        return [packet, *late]

    def run(self):
        client = None
        while not self.ended:
            for ready in select.select([self.here, self.there], [], [], 0.05)[0]:
                packet, sender = ready.recvfrom(2048)
                if ready is self.here:
                    client = sender
                    self.asked.append(packet)
                    self.silent |= self.most_chunks is not None and len(self.chunks()) > self.most_chunks
                for out in self.passed(packet):
                    # What came late from the other side is a stranger's packet here: nobody takes it.
                    self.there.sendto(out, self.sensor) if ready is self.here else self.here.sendto(out, client)

    def chunks(self):
        """Offsets of the chunks that the client has sent so far."""
        offsets = []
        for packet in list(self.asked):
            header, payload = wire.parse(packet)
            if header.type == wire.PacketType.SIGNED_REQUEST and payload[wire.SignedFields.size() + 4] == UPLOAD:
                request = wire.UploadRequest.unpack(payload[REQUEST_AT:])
                if request.step == wire.UploadStep.CHUNK:
                    offsets.append(request.offset)
        return offsets


class Install(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.environment = {**os.environ, "XDG_CONFIG_HOME": str(self.folder / "config")}
        self.settings = self.folder / "settings.json"
        self.kept = self.folder / "settings.json.calibration"
        self.factory = calibration(0.10)
        self.other = calibration(0.20, pattern=700)
        (self.folder / "factory.cal").write_bytes(self.factory)
        (self.folder / "other.cal").write_bytes(self.other)
        self.sensor = None
        self.addCleanup(self.stop)

    def stop(self, how=signal.SIGKILL):
        if self.sensor is not None:
            self.sensor.send_signal(how)
            self.sensor.wait(timeout=ENOUGH_S)
            self.sensor = None

    def until(self, what, done):
        end = time.monotonic() + ENOUGH_S
        while not (found := done()):
            self.assertLess(time.monotonic(), end, f"{what}: {self.said()}")
            time.sleep(0.02)
        return found

    def said(self):
        return self.log.read_text(encoding="utf-8")

    def run_stof(self, *words):
        return subprocess.run([*COMMAND, *map(str, words)], capture_output=True, text=True, timeout=120, cwd=self.folder,
                              env=self.environment)

    def pair(self, role="admin"):
        ended = self.run_stof("pair", "--into", f"{self.settings}.keys", "--role", role)
        self.assertEqual(ended.returncode, 0, ended.stderr)

    def start(self, *arguments, settings=True):
        port = self.folder / "port"
        port.unlink(missing_ok=True)
        self.log = self.folder / "log"
        kept = ["--settings", str(self.settings)] if settings else ["--keys", f"{self.settings}.keys"]
        with self.log.open("w", encoding="utf-8") as log:
            self.sensor = subprocess.Popen(
                [*STOFD, "--size", f"{WIDTH}x{HEIGHT}", "--pmd", f"{PMD[0]}x{PMD[1]}", "--port", "0", "--port-file", str(port), *kept,
                 "--calibration", str(self.folder / "factory.cal"), "--set", "discovery.mdns=false", "--set", "discovery.beacon=false",
                 "--set", "streams.depth=raw", *arguments], stdout=log, stderr=subprocess.STDOUT)
        self.until("no port", lambda: (port.exists() and port.read_text(encoding="utf-8").endswith("\n")) or self.sensor.poll() is not None)
        self.assertIsNone(self.sensor.poll(), self.said())
        self.address = f"127.0.0.1:{port.read_text(encoding='utf-8').strip()}"
        self.until("no frame", lambda: "publishing" in self.said())

    def install(self, *words):
        ended = self.run_stof("calib", "install", *words)
        self.assertEqual((ended.returncode, ended.stderr), (0, ""), ended.stdout)
        return ended.stdout

    def refuse(self, code, fact, *words):
        ended = self.run_stof("calib", "install", *words)
        self.assertEqual(ended.returncode, code, ended.stdout + ended.stderr)
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertIn(fact, ended.stderr)

    def receive(self, frames=3, until=lambda _: True, infos=None):
        """What is sent until there are so many frames, and what came is as it should be: by frame the fingerprint that its info names, and its depths;
        the calibrations and events, in their order. infos: where the former goes, as it comes."""
        host, port = self.address.split(":")
        infos = {} if infos is None else infos
        depths, calibrations, events = {}, [], []
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as here:
            here.connect((host, int(port)))
            here.settimeout(1)
            cookie, asked, end = 0, 0.0, time.monotonic() + 2 * ENOUGH_S
            while len(infos) < frames + 1 or not until(events):
                self.assertLess(time.monotonic(), end, self.said())
                if not infos or time.monotonic() - asked > 1:
                    asked = time.monotonic()
                    here.send(wire.seal(wire.Header(type=wire.PacketType.SUBSCRIBE),
                                        wire.Subscribe(request_id=1, lease_ms=10000, cookie=cookie).pack()))
                try:
                    header, payload = wire.parse(here.recv(2048))
                except TimeoutError:
                    continue
                if header.type == wire.PacketType.SUBSCRIBED:
                    cookie = wire.Subscribed.unpack(payload).cookie
                elif header.type == wire.PacketType.FRAME_INFO:
                    infos[header.number] = wire.FrameInfo.unpack(payload)
                elif header.type == wire.PacketType.CALIBRATION:
                    calibrations.append(wire.CalibrationPacket.unpack(payload))
                elif header.type == wire.PacketType.EVENT:
                    events.append(wire.EventReport.unpack(payload))
                elif header.type == wire.PacketType.TILE and header.stream == wire.Stream.DEPTH:
                    values = struct.unpack(f"<{len(payload) // 2}H", payload)
                    depths.setdefault(header.number, []).extend(value for value in values if value)
            here.send(wire.seal(wire.Header(type=wire.PacketType.UNSUBSCRIBE), wire.Subscribe(request_id=2, cookie=cookie).pack()))
        return infos, depths, calibrations, events

    def median_depth(self):
        _, depths, _, _ = self.receive()
        whole = sorted(max(depths.values(), key=len))
        self.assertGreater(len(whole), WIDTH * HEIGHT // 4)
        return whole[len(whole) // 2]

    def expect_in_force(self, file):
        # The frame that is computed when the answer comes is the last one with the calibration before.
        self.until("another calibration is in force", lambda: self.named() == ({fingerprint(file)}, {fingerprint(file)}))

    def named(self):
        infos, _, calibrations, _ = self.receive()
        return {info.calibration_fingerprint for info in infos.values()}, {seen.fingerprint for seen in calibrations}

    def test_it_is_in_force_with_the_next_frames_and_after_a_start_and_the_factorys_comes_back(self):
        self.pair()
        # Stereo alone: what is measured is what the baseline says.
        self.start("--set", "depth.require=any", "--fault", "pmd:drop:0:1")
        self.expect_in_force(self.factory)
        before = self.median_depth()
        out = self.install("other.cal", self.address)
        self.assertIn(f"calibration {fingerprint(self.other):08x} is in force and kept; it was {fingerprint(self.factory):08x}", out)
        self.expect_in_force(self.other)
        self.assertAlmostEqual(self.median_depth() / before, 2, delta=0.1)
        self.assertIn(f"calibration {fingerprint(self.other):08x} in place of {fingerprint(self.factory):08x}, put there by 127.0.0.1",
                      self.said())
        self.assertEqual(self.kept.read_bytes(), self.other)
        self.stop()
        self.start()
        self.assertIn("the calibration is the installed one", self.said())
        self.expect_in_force(self.other)
        told = json.loads(self.install("--factory", self.address, "--json"))
        self.assertEqual((told["calibration"], told["former"], told["factory"], told["device_id"]),
                         (f"{fingerprint(self.factory):08x}", f"{fingerprint(self.other):08x}", True, 1))
        self.expect_in_force(self.factory)
        self.assertFalse(self.kept.exists())
        self.assertEqual((self.folder / "factory.cal").read_bytes(), self.factory)
        self.stop()
        self.start()
        self.expect_in_force(self.factory)

    def test_the_event_names_both_and_nothing_of_before_is_in_the_frames_after(self):
        self.pair()
        self.start("--temporal")
        told, infos = [], {}
        over = []

        def changed_for_some_frames(events):
            over.append(any(event.condition == wire.Condition.CALIBRATION_CHANGED for event in events))
            return sum(over) > 500  # packets

        listener = threading.Thread(target=lambda: told.extend(self.receive(frames=60, until=changed_for_some_frames, infos=infos)))
        listener.start()
        self.until("nothing stands", lambda: any(info.steady_frames > 2 for info in list(infos.values())))
        self.install("other.cal", self.address)
        listener.join()
        _, _, calibrations, events = told
        changed = [event for event in events if event.condition == wire.Condition.CALIBRATION_CHANGED and event.active]
        self.assertTrue(changed, events)
        self.assertEqual((changed[0].value, changed[0].former), (fingerprint(self.other), fingerprint(self.factory)))
        old = [info for _, info in sorted(infos.items()) if info.calibration_fingerprint == fingerprint(self.factory)]
        new = [info for _, info in sorted(infos.items()) if info.calibration_fingerprint == fingerprint(self.other)]
        self.assertGreater(max(info.steady_frames for info in old), 2)
        self.assertEqual(new[0].steady_frames, 1)
        self.assertGreater(max(info.steady_frames for info in new), 2)
        self.assertEqual({seen.fingerprint for seen in calibrations}, {fingerprint(self.factory), fingerprint(self.other)})

    def test_a_bad_link_only_takes_longer(self):
        self.pair()
        self.start()
        between = Between(self.address, spoils=0.3)
        self.addCleanup(between.close)
        self.install("other.cal", between.address, "--timeout", "0.2")
        self.expect_in_force(self.other)
        self.assertEqual(self.kept.read_bytes(), self.other)

    def begin(self, between, chunks):
        """An upload of which only so many chunks come through."""
        between.most_chunks = chunks
        upload = subprocess.Popen([*COMMAND, "calib", "install", "other.cal", between.address, "--timeout", "0.1"], text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=self.folder, env=self.environment)
        self.addCleanup(upload.kill)
        self.until("no chunk", lambda: between.silent)
        return upload

    def test_a_client_that_is_started_anew_goes_on_where_it_stopped(self):
        self.pair()
        self.start()
        between = Between(self.address)
        self.addCleanup(between.close)
        upload = self.begin(between, chunks=3)
        upload.kill()
        upload.communicate()
        between.asked.clear()
        between.most_chunks, between.silent = None, False
        self.install("other.cal", between.address)
        self.assertEqual(between.chunks()[0], 3 * 960)
        self.expect_in_force(self.other)

    def test_a_sensor_that_is_started_anew_gets_all_of_it_again(self):
        self.pair()
        self.start()
        between = Between(self.address)
        self.addCleanup(between.close)
        upload = self.begin(between, chunks=3)
        self.stop()
        self.start()
        between.sensor = ("127.0.0.1", int(self.address.split(":")[1]))
        between.asked.clear()
        between.most_chunks, between.silent = None, False
        out, error = upload.communicate(timeout=ENOUGH_S)
        self.assertEqual((upload.returncode, error), (0, ""), out)
        self.assertIn(0, between.chunks())
        self.expect_in_force(self.other)

    def test_who_may_not_is_refused(self):
        self.start()
        self.refuse(1, "takes a key with role admin", "other.cal", self.address)  # nobody has paired it
        self.stop()
        self.pair("tune")
        self.start()
        self.refuse(1, "takes a key with role admin", "other.cal", self.address)
        self.refuse(1, "takes a key with role admin", "--factory", self.address)
        self.expect_in_force(self.factory)
        self.assertFalse(self.kept.exists())

    def test_what_was_signed_once_is_not_served_again(self):
        self.pair()
        self.start()
        between = Between(self.address)
        self.install("other.cal", between.address)
        self.install("--factory", self.address)
        between.close()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as here:
            for packet in between.asked:
                here.sendto(packet, between.sensor)
        time.sleep(0.3)
        self.expect_in_force(self.factory)
        self.assertFalse(self.kept.exists())

    def test_a_file_that_is_not_of_this_rig_is_refused(self):
        self.pair()
        self.start()
        (self.folder / "large.cal").write_bytes(calibration(0.2, size=(2 * WIDTH, HEIGHT)))
        self.refuse(2, "made for cameras of 320x120", "large.cal", self.address)
        (self.folder / "damaged.cal").write_bytes(self.other[:-1] + b"?")
        self.refuse(2, "not a calibration file, or damaged", "damaged.cal", self.address)
        self.refuse(2, "none.cal", "none.cal", self.address)
        self.expect_in_force(self.factory)
        self.assertFalse(self.kept.exists())

    def test_bad_words_are_one_line(self):
        for fact, words in (("takes FILE SENSOR", []), ("SENSOR is missing behind other.cal", ["other.cal"]), ("FILE is missing before a", ["a"]),
                            ("nothing behind them", ["a", "b", "c"]), ("SENSOR is missing behind --factory", ["--factory"]),
                            ("--factory takes SENSOR alone", ["--factory", "a", "b"]), ("FILE is missing", ["--serial", "x"]),
                            ("takes FILE alone", ["a", "b", "--serial", "x"]), ("neither FILE nor SENSOR", ["--factory", "a", "--serial", "x"]),
                            ("127.0.0.1:9 is no file, but other.cal is one", ["127.0.0.1:9", "other.cal"])):
            self.refuse(2, fact, *words)
        self.refuse(1, "no answer within", "other.cal", "127.0.0.1:9", "--timeout", "0.05", "--patience", "0.2")

    def test_a_sensor_without_a_file_for_it_says_so(self):
        self.pair()
        self.start(settings=False)
        self.refuse(1, "this sensor keeps none: start stofd with --settings FILE", "other.cal", self.address)

    def test_a_folder_that_cannot_be_written_keeps_the_one_before(self):
        self.pair()
        self.start()
        (self.folder / "settings.json.calibration.new").mkdir()
        self.refuse(1, "cannot be written", "other.cal", self.address)
        self.expect_in_force(self.factory)

    def test_a_damaged_installed_one_is_told_and_the_factorys_holds(self):
        self.pair()
        self.start()
        self.install("other.cal", self.address)
        self.stop()
        self.kept.write_bytes(self.other[:-5])
        self.start()
        self.assertIn("settings.json.calibration: not a calibration file, or damaged", self.said())
        self.assertIn("the factory's calibration holds", self.said())
        self.expect_in_force(self.factory)
        self.install("other.cal", self.address)
        self.expect_in_force(self.other)

    def test_what_is_no_file_in_its_place_is_left_alone(self):
        self.pair()
        self.kept.mkdir()
        self.start()
        self.assertIn("settings.json.calibration: no regular file, or it cannot be read; the factory's calibration holds", self.said())
        self.expect_in_force(self.factory)
        self.refuse(1, "cannot be written", "other.cal", self.address)
        self.assertEqual(list(self.kept.iterdir()), [])
        self.expect_in_force(self.factory)

    def test_the_factorys_file_is_never_that_of_the_installed_one(self):
        ended = subprocess.run([*STOFD, "--settings", str(self.settings), "--calibration", str(self.kept)], capture_output=True, text=True,
                               timeout=ENOUGH_S)
        self.assertEqual(ended.returncode, 2)
        self.assertIn("settings.json.calibration is a file of --settings", ended.stderr)

    def test_over_the_cable_without_a_key(self):
        ends = [pty.openpty() for _ in range(2)]
        for _, line in ends:
            tty.setraw(line)
        ended = threading.Event()

        def carry():
            here, there = (far for far, _ in ends)
            while not ended.is_set():
                for ready in select.select([here, there], [], [], 0.05)[0]:
                    os.write(there if ready == here else here, os.read(ready, 4096))

        cable = threading.Thread(target=carry)
        cable.start()
        try:
            names = [os.ttyname(line) for _, line in ends]
            self.start("--serial", names[0], "--baud", "921600", "--set", "serial.mode=stof", "--set", "serial.profile=sectors")
            self.install("other.cal", "--serial", names[1], "--timeout", "20")
            self.expect_in_force(self.other)
            self.install("--factory", "--serial", names[1], "--timeout", "20")
            self.expect_in_force(self.factory)
        finally:
            self.stop()
            ended.set()
            cable.join()

    def test_the_help_has_an_example_and_the_codes(self):
        ended = self.run_stof("calib", "install", "--help")
        self.assertEqual(ended.returncode, 0)
        self.assertIn("Example: stof calib install rig.cal 192.168.1.20", ended.stdout)
        self.assertTrue(re.search(r"Ends with 0 .*1 .*2 ", ended.stdout, re.DOTALL))

    def test_progress_is_shown_on_a_terminal(self):
        self.pair()
        self.start()
        far, near = pty.openpty()
        upload = subprocess.Popen([*COMMAND, "calib", "install", "other.cal", self.address], stdout=subprocess.DEVNULL, stderr=near,
                                  cwd=self.folder, env=self.environment)
        os.close(near)
        shown = b""
        try:
            while part := os.read(far, 4096):
                shown += part
        except OSError:  # the terminal's last user has gone
            pass
        os.close(far)
        self.assertEqual(upload.wait(timeout=ENOUGH_S), 0)
        self.assertIn(f"{len(self.other)} of {len(self.other)} bytes (100 %)".encode(), shown)


if __name__ == "__main__":
    COMMAND.extend(sys.argv[1:])
    unittest.main(argv=sys.argv[:1])
