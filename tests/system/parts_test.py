#!/usr/bin/env python3
"""Tests of the system test's own parts that need no machine: the archive, ELF, usbredir, cameras, serial frames."""

import io
import pathlib
import socket
import struct
import sys
import tempfile
import threading
import time
import unittest

import initramfs
import long_cases
import machine
import pmd_camera
import serial_line
import triggered_camera
import usbredir
import uvc_camera

sys.path.insert(0, str(initramfs.ROOT / "tests" / "scripts"))
import pi_packages  # noqa: E402


class ArchiveTest(unittest.TestCase):
    def entries(self, data):
        """[(name, mode, bytes)] of a newc archive."""
        at, found = 0, []
        while True:
            self.assertEqual(data[at:at + 6], b"070701")
            fields = [int(data[at + 6 + 8 * k:at + 14 + 8 * k], 16) for k in range(13)]
            name = data[at + 110:at + 110 + fields[11] - 1].decode()
            at = (at + 110 + fields[11] + 3) // 4 * 4
            if name == "TRAILER!!!":
                return found
            found.append((name, fields[1], data[at:at + fields[6]]))
            at = (at + fields[6] + 3) // 4 * 4

    def test_holds_what_was_added_and_folders_before_it(self):
        archive = initramfs.Archive()
        archive.file("a/b/c", b"12345", 0o755)
        archive.link("a/d", "b/c")
        archive.node("dev/console", 5, 1)
        entries = self.entries(archive.bytes())
        self.assertEqual([entry[0] for entry in entries], ["a", "a/b", "a/b/c", "a/d", "dev", "dev/console"])
        self.assertEqual(entries[2][1:], (0o100755, b"12345"))
        self.assertEqual(entries[3][1:], (0o120777, b"b/c"))
        self.assertEqual(len(archive.bytes()) % 512, 0)

    def test_a_name_is_added_once(self):
        archive = initramfs.Archive()
        archive.file("a", b"first")
        archive.file("a", b"second")
        self.assertEqual(self.entries(archive.bytes()), [("a", 0o100644, b"first")])

    def test_modules_come_after_what_they_depend_on(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "kernel").mkdir()
            for module, depends in (("top", "mid-dle,base"), ("mid-dle", "base,in_kernel"), ("base", "")):
                (folder / "kernel" / f"{module}.ko").write_bytes(pi_packages.module(module.replace("-", "_"), depends))
            (folder / "modules.builtin").write_text("kernel/x/in-kernel.ko\n")
            order = initramfs.Modules(folder).in_order([["base"], ["top"]])
        self.assertEqual([entry[:2] for entry in order], [(0, "base"), (1, "mid_dle"), (1, "top")])


class Host:
    """The other side of the usbredir protocol, with 64-bit ids."""

    def __init__(self, folder):
        self.path = pathlib.Path(folder) / "usb"
        self.listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.listener.bind(str(self.path))
        self.listener.listen(1)

    def accept(self):
        self.socket, _ = self.listener.accept()
        self.socket.settimeout(10)
        self.file = self.socket.makefile("rb")
        kind, length, _ = usbredir.SHORT_HEADER.unpack(self.file.read(usbredir.SHORT_HEADER.size))
        assert kind == usbredir.HELLO
        self.file.read(length)
        capabilities = struct.pack("<I", usbredir.CAPABILITIES)
        self.socket.sendall(usbredir.SHORT_HEADER.pack(usbredir.HELLO, 68, 0) + b"test".ljust(64, b"\0") + capabilities)
        return [self.receive() for _ in range(3)]

    def receive(self):
        kind, length, ident = usbredir.LONG_HEADER.unpack(self.file.read(usbredir.LONG_HEADER.size))
        return kind, ident, self.file.read(length)

    def send(self, kind, ident, body):
        self.socket.sendall(usbredir.LONG_HEADER.pack(kind, len(body), ident) + body)

    def control(self, kind, request, value, index, length, data=b""):
        self.send(usbredir.CONTROL, 7, usbredir.CONTROL_HEADER.pack(kind & 0x80, request, kind, 0, value, index, length)
                  + data)
        got, ident, body = self.receive()
        assert (got, ident) == (usbredir.CONTROL, 7)
        fields = usbredir.CONTROL_HEADER.unpack_from(body)
        return fields[3], body[usbredir.CONTROL_HEADER.size:]

    def ask_bulk(self, ident, length):
        self.send(usbredir.BULK, ident, usbredir.BULK_HEADER.pack(0x81, 0, length & 0xFFFF, 0, length >> 16))

    def bulk(self):
        kind, ident, body = self.receive()
        assert kind == usbredir.BULK, kind
        return ident, usbredir.BULK_HEADER.unpack_from(body)[1], body[usbredir.BULK_HEADER.size:]

    def close(self):
        self.file.close()
        self.socket.close()
        self.listener.close()


class CameraCase(unittest.TestCase):
    def plug(self, make):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.host = Host(folder.name)
        schedule = triggered_camera.Schedule()
        self.addCleanup(schedule.end)
        camera = make(self.host.path, schedule)
        thread = threading.Thread(target=camera.plug)
        thread.start()
        self.greeting = self.host.accept()
        thread.join()
        self.addCleanup(self.host.close)
        self.addCleanup(camera.unplug)
        return camera


class PmdCameraTest(CameraCase):
    SIZE = (64, 48)
    FRAME = 96 + 64 * 48 * 8

    def setUp(self):
        pictures = [bytes([k]) * (64 * 48 * 8) for k in range(3)]
        self.camera = self.plug(lambda path, schedule: pmd_camera.PmdCamera(path, schedule, 0x50, self.SIZE, pictures,
                                                                            12, 20_000))

    def test_announces_endpoints_interfaces_and_itself(self):
        self.assertEqual([kind for kind, _, _ in self.greeting], [usbredir.ENDPOINTS, usbredir.INTERFACES,
                                                                  usbredir.CONNECT])
        self.assertEqual(self.greeting[2][2][4:8], struct.pack("<HH", 0x1209, 0x50))

    def test_tells_what_it_is_and_takes_what_it_can(self):
        status, info = self.host.control(0xC1, 1, 0, 0, 32)
        self.assertEqual((status, info[:14]), (0, struct.pack("<IHHHHH", 0x444D5053, 1, 64, 48, 12, 5000)))
        self.assertEqual(self.host.control(0x41, 3, 0, 0, 16, struct.pack("<IIII", 30_000, 700, 5, 0))[0], 0)
        self.assertEqual(self.host.control(0x41, 3, 0, 0, 16, struct.pack("<IIII", 1, 700, 5, 0))[0], usbredir.STALL)
        self.assertEqual(self.host.control(0xC1, 4, 0, 0, 16)[1], struct.pack("<IIII", 30_000, 700, 5, 0))

    def expose(self, step):
        self.camera.edge(step, time.monotonic())

    def test_an_edge_gives_one_message_in_pieces_that_a_short_packet_ends(self):
        self.host.control(0x41, 5, 1, 0, 0)
        self.expose(4)
        data = b""
        for ident in range(10):
            self.host.ask_bulk(ident, 8192)
            got, status, part = self.host.bulk()
            self.assertEqual((got, status), (ident, 0))
            data += part
            if len(part) < 8192:
                break
        self.assertEqual(len(data), self.FRAME)
        self.assertEqual(struct.unpack_from("<IHHIHH", data), (0x46444D50, 96, 1, 1, 64, 48))
        self.assertEqual(data[96], 4 % 3)

    def test_edges_during_an_exposure_are_ignored_and_told(self):
        self.host.control(0x41, 5, 1, 0, 0)
        self.expose(0)
        self.expose(1)
        self.host.ask_bulk(1, 65536)
        _, _, frame = self.host.bulk()
        self.assertEqual((struct.unpack_from("<H", frame, 18)[0], frame[96]), (1, 0))

    def test_a_stalled_camera_answers_when_it_is_told_to(self):
        self.host.control(0x41, 5, 1, 0, 0)
        self.camera.stall(True)
        self.expose(0)
        self.host.ask_bulk(1, 65536)
        time.sleep(0.1)
        self.assertEqual(self.host.control(0xC1, 2, 0, 0, 8)[0], 0)
        self.camera.stall(False)
        self.assertEqual(self.host.bulk()[0], 1)

    def frame(self, step, ident):
        """The frame of an edge, taken once the exposure is over."""
        self.expose(step)
        self.host.ask_bulk(ident, 65536)
        _, _, frame = self.host.bulk()
        return frame

    def test_a_frozen_camera_sends_its_last_samples_under_new_numbers(self):
        self.host.control(0x41, 5, 1, 0, 0)
        before = self.frame(1, 1)
        self.camera.fall_ill(triggered_camera.FROZEN)
        frozen = self.frame(2, 2)
        self.camera.cure()
        self.assertEqual(frozen[96:], before[96:])
        self.assertNotEqual(frozen[8:12], before[8:12])
        self.assertEqual(self.frame(2, 3)[96], 2)

    def test_a_dark_lamp_leaves_noise_that_differs(self):
        self.host.control(0x41, 5, 1, 0, 0)
        self.camera.fall_ill(triggered_camera.DARK)
        first, second = self.frame(0, 1)[96:], self.frame(1, 2)[96:]
        self.assertNotEqual(first, second)
        samples = struct.unpack(f"<{64 * 48 * 4}H", first)
        self.assertAlmostEqual(sum(samples) / len(samples), pmd_camera.DARK_LSB, delta=0.5)
        self.assertLess(max(samples), pmd_camera.DARK_LSB + 8 * pmd_camera.NOISE_LSB)

    def test_cancelled_requests_are_answered_as_such(self):
        self.host.ask_bulk(5, 512)
        self.host.send(usbredir.CANCEL, 5, b"")
        self.assertEqual(self.host.bulk(), (5, usbredir.CANCELLED, b""))

    def test_messages_of_whole_packets_end_with_an_empty_one(self):
        self.camera.send(bytes(1024), short_end=True)
        for ident, length in ((1, 1024), (2, 0)):
            self.host.ask_bulk(ident, 1024)
            self.assertEqual(self.host.bulk(), (ident, 0, bytes(length)))


class UvcCameraTest(CameraCase):
    def setUp(self):
        pictures = [bytes([k]) * (32 * 8) for k in range(3)]
        self.camera = self.plug(lambda path, schedule: uvc_camera.UvcCamera(path, schedule, 0x51, "left", (32, 8),
                                                                            pictures))

    def test_descriptors_add_up(self):
        _, configuration = self.host.control(0x80, 6, 0x0200, 0, 4096)
        self.assertEqual(struct.unpack_from("<H", configuration, 2)[0], len(configuration))
        at = 0
        while at < len(configuration):
            at += configuration[at]
        self.assertEqual(at, len(configuration))

    def test_streams_what_edges_expose_in_the_format_that_was_committed(self):
        for selector in (1, 2):
            self.assertEqual(self.host.control(0x21, 1, selector << 8, 1, 34, b"\0\0\x02\x01".ljust(34, b"\0"))[0], 0)
        self.assertEqual(self.host.control(0x21, 1, 0x0400, 0x0100, 4, struct.pack("<I", 5))[0], 0)
        self.camera.edge(2, time.monotonic())
        self.host.ask_bulk(1, 16384)
        _, status, data = self.host.bulk()
        self.assertEqual((status, len(data), data[0], data[1] & 0xC2), (0, 2 + 2 * 32 * 8, 2, 0x82))
        self.assertEqual(data[2:6], bytes((2, 128, 2, 128)))
        self.assertEqual(self.camera.exposures[0].settings["exposure_us"], 500)


class WorldTest(unittest.TestCase):
    def test_lines_that_rise_together_are_one_step(self):
        world = triggered_camera.World(0.05)
        self.assertEqual([world.edge(at) for at in (1.0, 1.001, 1.002, 1.2, 1.201)], [0, 0, 0, 1, 1])


class SerialTest(unittest.TestCase):
    def test_decodes_cobs(self):
        for frame, data in ((b"\x01\x01", b"\0"), (b"\x03\x11\x22\x02\x33", b"\x11\x22\0\x33"),
                            (b"\xff" + bytes(range(1, 255)), bytes(range(1, 255))), (b"\x05\x11", None), (b"", b"")):
            self.assertEqual(serial_line.cobs_decode(frame), data)


class ConsoleTest(unittest.TestCase):
    def test_events_lines_and_the_rest_are_told_apart(self):
        here, there = socket.socketpair()
        with here, there, tempfile.NamedTemporaryFile() as copy:
            console = machine.Console(here, copy.name)
            there.sendall(b"GUEST start 1.25 77\r\nLOG 1.30 stofd: publishing\r\nanything\r\nGUEST torn\r\n")
            self.assertEqual(console.event("start", timeout=5), machine.Event("start", 1.25, "77"))
            self.assertEqual(console.line("publ", timeout=5), machine.Log(1.3, "stofd: publishing"))
            there.shutdown(socket.SHUT_RDWR)
            with self.assertRaises(machine.MachineError):
                console.event("never", timeout=0.1)
            self.assertEqual(console.other, ["anything", "GUEST torn"])


class TraceTest(unittest.TestCase):
    def test_reads_rising_edges_of_the_first_line(self):
        text = io.StringIO(" stofd-1 [000] d..1. 1.500000: gpio_value: 512 set 1\n"
                           " stofd-1 [000] d..1. 1.500003: gpio_value: 513 set 1\n"
                           " stofd-1 [000] d..1. 1.500100: gpio_value: 512 set 0\n")
        self.assertEqual(long_cases.edge_times(text), [1.5])


if __name__ == "__main__":
    unittest.main()
