"""A PMD camera as docs/HARDWARE.md describes it: vendor requests, and one bulk message for each edge."""

import array
import random
import struct
import sys
import threading
import time

import triggered_camera
import usbredir

ENDPOINT, PACKET = 0x81, 512
INFO, CLOCK, SET_CONFIG, GET_CONFIG, STREAM = 1, 2, 3, 4, 5
VENDOR_IN, VENDOR_OUT = 0xC1, 0x41
INFO_MAGIC, FRAME_MAGIC = 0x444D5053, 0x46444D50
INFO_FIELDS = struct.Struct("<IHHHHIIIII")
CONFIG_FIELDS = struct.Struct("<IIII")  # kHz, us, us, reserved
FRAME_FIELDS = struct.Struct("<IHHIHHHHIQ8Ih30x")
SAMPLES = 4
FREQUENCY_KHZ = (5_000, 100_000)
INTEGRATION_US = (10, 5_000)
GAP_S = 0.0001  # between samples
IGNORED_EDGE = 1
# The emulated sensor's, and its noise with ambient light: hal/emu/scenes/rig.h.
DARK_LSB, NOISE_LSB = 112, 3.2
DARK_PICTURES = 8


class PmdCamera(triggered_camera.TriggeredCamera):
    """pictures: the four samples of each step of the world, u16, little-endian; used again from the first."""

    cls = (0, 0, 0)
    interfaces = (usbredir.Interface(0, 0xFF, 0x50, 0x01),)
    endpoints = (usbredir.Endpoint(ENDPOINT, usbredir.TYPE_BULK, PACKET, 0),)

    def __init__(self, path, schedule, product, size, pictures, bits, frequency_khz):
        super().__init__(path, schedule)
        self.product = product
        self.size = size
        self.pictures = pictures
        self.bits = bits
        self.frequency_khz = frequency_khz
        self.strings = ("stof", "PMD camera", f"{product:04x}")
        self.device_descriptor = usbredir.device_descriptor(self.cls, self.vendor, product)
        self.configuration_descriptor = usbredir.configuration_descriptor(
            1, usbredir.interface_descriptor(0, 1, 0xFF, 0x50, 0x01, 2) + usbredir.bulk_descriptor(ENDPOINT, PACKET))
        self.committed = threading.Event()  # it streams
        self.stalled = False
        self.darkness = []

    def powered(self):
        super().powered()
        self.config = (self.frequency_khz, 500, 0, 0)
        self.streaming = False
        self.sequence = 0
        self.ignored = False
        self.held = []
        self.committed.clear()

    def exposure_s(self):
        _, integration, delay, _ = self.config
        return delay * 1e-6 + SAMPLES * integration * 1e-6 + (SAMPLES - 1) * GAP_S

    def settings(self):
        return self.config

    def edge(self, step, at):
        with self.lock:
            if self.plugged and at < self.busy_until:
                self.ignored = True
            super().edge(step, at)

    def stall(self, stalled):
        """Bulk requests stay unanswered; control requests are answered."""
        with self.lock:
            self.stalled = stalled
            held, self.held = self.held, []
            for message in held if not stalled else ():
                self.send(message, short_end=True)

    def deliver(self, exposure, fault):
        if not self.streaming:
            return
        self.sequence += 1
        kind = fault.kind if fault else None
        message = self._message(exposure)
        if kind == triggered_camera.SHORT:
            message = message[:len(message) // 2]
        elif kind == triggered_camera.CORRUPT:
            message[0] ^= 0xFF
        if self.stalled:
            self.held = [message]  # it has memory for one frame
            return
        if len(self.outgoing) > 1:
            self.overrun += 1
            return
        self.delivered += 1
        self.send(message, short_end=True)

    def _message(self, exposure):
        frequency, integration, delay, _ = exposure.settings
        windows = []
        for k in range(SAMPLES):
            windows += [int(delay * 1000 + k * (integration * 1000 + GAP_S * 1e9)), integration * 1000]
        flags, self.ignored = IGNORED_EDGE if self.ignored else 0, False
        head = FRAME_FIELDS.pack(FRAME_MAGIC, FRAME_FIELDS.size, 1, self.sequence, *self.size, self.bits, flags,
                                 frequency, int(exposure.at * 1e9), *windows, 3150)
        pictures = self.dark_pictures() if self.ailment == triggered_camera.DARK else self.pictures
        return bytearray(head + pictures[self.step_of(exposure) % len(pictures)])

    def dark_pictures(self):
        """What the sensor collects without its lamp: noise about the dark level."""
        if not self.darkness:
            noise = random.Random(1)
            count = SAMPLES * self.size[0] * self.size[1]
            self.darkness = [array.array("H", (round(noise.gauss(DARK_LSB, NOISE_LSB)) for _ in range(count)))
                             for _ in range(DARK_PICTURES)]
            if sys.byteorder == "big":
                for picture in self.darkness:
                    picture.byteswap()
            self.darkness = [picture.tobytes() for picture in self.darkness]
        return self.darkness

    def control(self, kind, request, value, index, length, data):
        if kind == VENDOR_IN:
            if request == INFO:
                return INFO_FIELDS.pack(INFO_MAGIC, 1, *self.size, self.bits, *FREQUENCY_KHZ, *INTEGRATION_US,
                                        self.product)
            if request == CLOCK:
                return struct.pack("<Q", time.monotonic_ns())
            return CONFIG_FIELDS.pack(*self.config) if request == GET_CONFIG else None
        if kind != VENDOR_OUT:
            return None
        if request == STREAM:
            self.outgoing.clear()
            self.held = []
            self.sequence = 0
            self.streaming = value == 1
            (self.committed.set if self.streaming else self.committed.clear)()
            return b""
        return self._configure(data) if request == SET_CONFIG else None

    def _configure(self, data):
        if len(data) < CONFIG_FIELDS.size:
            return None
        config = CONFIG_FIELDS.unpack_from(data)
        frequency, integration = config[:2]
        if not (FREQUENCY_KHZ[0] <= frequency <= FREQUENCY_KHZ[1]
                and INTEGRATION_US[0] <= integration <= INTEGRATION_US[1]):
            return None
        self.config = config  # in effect from the next edge on: an exposure has taken its own
        return b""
