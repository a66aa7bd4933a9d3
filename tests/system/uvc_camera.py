"""A camera of USB Video Class 1.1 with an external trigger, bulk streaming and the controls that a trigger needs."""

import struct
import threading

import triggered_camera
import usbredir

ENDPOINT, PACKET = 0x81, 512
CONTROL_INTERFACE, STREAM_INTERFACE = 0, 1
TERMINAL, UNIT, OUTPUT = 1, 2, 3
SET_CUR, GET_CUR, GET_MIN, GET_MAX, GET_RES, GET_LEN, GET_INFO, GET_DEF = 1, 0x81, 0x82, 0x83, 0x84, 0x85, 0x86, 0x87
CLASS_OUT, CLASS_IN = 0x21, 0xA1
PROBE, COMMIT = 1, 2
PROBE_FIELDS = struct.Struct("<HBBIHHHHHIIIBBBB")  # UVC 1.1, 4.3.1.1
CLOCK_HZ = 48_000_000
INTERVAL = 166_666  # 100 ns: what a descriptor must name; the trigger decides
HEADER_BYTES = 2
END_OF_FRAME, ERROR, END_OF_HEADER, FRAME_ID = 0x02, 0x40, 0x80, 0x01
MANUAL, APERTURE_PRIORITY = 1, 8

HIGH_10 = bytes(value >> 6 for value in range(256))
LOW_10 = bytes(value << 2 & 0xFF for value in range(256))
HIGH_12 = bytes(value >> 4 for value in range(256))
LOW_12 = bytes(value << 4 & 0xFF for value in range(256))


def interleave(first, second):
    out = bytearray(2 * len(first))
    out[0::2] = first
    out[1::2] = second
    return bytes(out)


# name: GUID's first four bytes, bits of a pixel, how grey becomes it.
FORMATS = {
    "GREY": (b"Y800", 8, bytes),
    "YUYV": (b"YUY2", 16, lambda grey: interleave(grey, b"\x80" * len(grey))),
    "Y16": (b"Y16 ", 16, lambda grey: interleave(bytes(len(grey)), grey)),
    "Y10": (b"Y10 ", 16, lambda grey: interleave(grey.translate(LOW_10), grey.translate(HIGH_10))),
    "Y12": (b"Y12 ", 16, lambda grey: interleave(grey.translate(LOW_12), grey.translate(HIGH_12))),
}
GUID_TAIL = bytes.fromhex("000010008000" "00aa00389b71")


class Control:
    """A number that the guest reads and sets."""

    def __init__(self, size, least, most, step, default):
        self.size, self.default, self.value = size, default, default
        self.answers = {GET_MIN: least, GET_MAX: most, GET_RES: step, GET_DEF: default}

    def get(self, request):
        if request == GET_LEN:
            return struct.pack("<H", self.size)
        if request == GET_INFO:
            return b"\x03"
        value = self.value if request == GET_CUR else self.answers.get(request)
        return None if value is None else value.to_bytes(self.size, "little")

    def set(self, data):
        self.value = int.from_bytes(data[:self.size], "little")


class UvcCamera(triggered_camera.TriggeredCamera):
    """pictures: grey, one for each step of the world, used again from the first."""

    cls = (0xEF, 2, 1)
    interfaces = (usbredir.Interface(CONTROL_INTERFACE, 14, 1, 0), usbredir.Interface(STREAM_INTERFACE, 14, 2, 0))
    endpoints = (usbredir.Endpoint(ENDPOINT, usbredir.TYPE_BULK, PACKET, STREAM_INTERFACE),)
    first_exposure = 100  # what it has when it is plugged in, 100 us

    def __init__(self, path, schedule, product, name, size, pictures, formats=("GREY", "YUYV", "Y16", "Y10")):
        super().__init__(path, schedule)
        self.product = product
        self.size = size
        self.pictures = pictures
        self.formats = formats
        self.strings = ("stof", name, f"{product:04x}")
        self.device_descriptor = usbredir.device_descriptor(self.cls, self.vendor, product)
        self.configuration_descriptor = self._configuration()
        self.committed = threading.Event()
        self.converted = {}

    def powered(self):
        super().powered()
        self.auto = Control(1, 0, 0, MANUAL | APERTURE_PRIORITY, APERTURE_PRIORITY)
        self.exposure = Control(4, 1, 2000, 1, self.first_exposure)  # 100 us
        self.gain = Control(2, 0, 255, 1, 0)
        self.controls = {(TERMINAL, 2): self.auto, (TERMINAL, 4): self.exposure, (UNIT, 4): self.gain}
        self.probe = self._probe(1)
        self.frame_id = 0
        self.streaming = False
        self.committed.clear()

    def stopped(self):
        self.streaming = False
        self.committed.clear()

    def format(self):
        """The name of the format that the guest chose last."""
        with self.lock:
            return self.formats[self.probe[1] - 1]

    def exposure_s(self):
        return self.exposure.value * 1e-4

    def settings(self):
        return {"auto": self.auto.value != MANUAL, "exposure_us": self.exposure.value * 100, "gain": self.gain.value}

    def deliver(self, exposure, fault):
        if not self.streaming:
            return
        if self.outgoing:
            self.overrun += 1  # the sensor has no memory: what was not fetched is lost
            if len(self.outgoing) > 1:
                return
        kind = fault.kind if fault else None
        name = self.formats[self.probe[1] - 1]
        payload = self._payload(name, self.step_of(exposure) % len(self.pictures))
        flags = END_OF_HEADER | END_OF_FRAME | self.frame_id | (ERROR if kind == triggered_camera.CORRUPT else 0)
        message = bytearray(payload)
        message[1] = flags
        if kind == triggered_camera.SHORT:
            message = message[:len(message) // 2]
        self.frame_id ^= FRAME_ID
        self.delivered += 1
        self.send(message, short_end=len(message) % PACKET == 0)

    def pixels(self, name, k):
        """Picture k in the named format."""
        return FORMATS[name][2](self.pictures[k])

    def _payload(self, name, k):
        if (name, k) not in self.converted:
            self.converted[name, k] = bytes((HEADER_BYTES, 0)) + self.pixels(name, k)
        return self.converted[name, k]

    # Requests.

    def control(self, kind, request, value, index, length, data):
        interface, entity, selector = index & 0xFF, index >> 8, value >> 8
        if interface == STREAM_INTERFACE and selector in (PROBE, COMMIT):
            return self._stream_control(kind, request, selector, data)
        control = self.controls.get((entity, selector))
        if control is None or interface != CONTROL_INTERFACE:
            return None
        if kind == CLASS_IN:
            return control.get(request)
        if kind == CLASS_OUT and request == SET_CUR:
            control.set(data)
            return b""
        return None

    def _stream_control(self, kind, request, selector, data):
        if kind == CLASS_IN:
            if request == GET_LEN:
                return struct.pack("<H", PROBE_FIELDS.size)
            return b"\x03" if request == GET_INFO else PROBE_FIELDS.pack(*self.probe)
        if kind != CLASS_OUT or request != SET_CUR:
            return None
        wanted = data[2] if len(data) > 3 and 1 <= data[2] <= len(self.formats) else 1
        self.probe = self._probe(wanted)
        if selector == COMMIT:
            self.outgoing.clear()
            self.streaming = True
            self.committed.set()
        return b""

    def _frame_bytes(self, name):
        return self.size[0] * self.size[1] * FORMATS[name][1] // 8

    def _probe(self, number):
        size = self._frame_bytes(self.formats[number - 1])
        return (0, number, 1, INTERVAL, 0, 0, 0, 0, 0, size, size + HEADER_BYTES, CLOCK_HZ, 3, 1, 1, 1)

    # Descriptors, UVC 1.1, 3.7 to 3.9.

    def _configuration(self):
        association = bytes((8, 11, CONTROL_INTERFACE, 2, 14, 3, 0, 2))
        units = (struct.pack("<BBBBHBBHHHB", 18, 0x24, 2, TERMINAL, 0x0201, 0, 0, 0, 0, 0, 3) + b"\x0a\0\0"
                 + struct.pack("<BBBBBHBHBB", 12, 0x24, 5, UNIT, TERMINAL, 0, 2, 0x0200, 0, 0)
                 + struct.pack("<BBBBHBBB", 9, 0x24, 3, OUTPUT, 0x0101, 0, UNIT, 0))
        header = struct.pack("<BBBHHIBB", 13, 0x24, 1, 0x0110, 13 + len(units), CLOCK_HZ, 1, STREAM_INTERFACE)
        formats = b"".join(self._format(k + 1, name) for k, name in enumerate(self.formats))
        count = len(self.formats)
        stream = struct.pack("<BBBBHBBBBBBB", 13 + count, 0x24, 1, count, 13 + count + len(formats), ENDPOINT, 0,
                             OUTPUT, 0, 0, 0, 1) + bytes(count)
        body = (association + usbredir.interface_descriptor(CONTROL_INTERFACE, 0, 14, 1, 0, 2) + header + units
                + usbredir.interface_descriptor(STREAM_INTERFACE, 1, 14, 2, 0) + stream + formats
                + usbredir.bulk_descriptor(ENDPOINT, PACKET))
        return usbredir.configuration_descriptor(2, body)

    def _format(self, number, name):
        guid, bits, _ = FORMATS[name]
        size = self._frame_bytes(name)
        kind = struct.pack("<BBBBB", 27, 0x24, 4, number, 1) + guid + GUID_TAIL + bytes((bits, 1, 0, 0, 0, 0))
        frame = struct.pack("<BBBBBHHIIIIBI", 30, 0x24, 5, 1, 0, *self.size, size * 8, size * 8 * 60, size, INTERVAL,
                            1, INTERVAL)
        return kind + frame + bytes((6, 0x24, 13, 1, 1, 4))
