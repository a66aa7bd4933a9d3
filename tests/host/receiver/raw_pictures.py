"""Raw pictures as docs/WIRE.md describes them, put together. For receiver.py, and like it written from that page alone."""

import struct

from packets import RAW16, RAW8, RAW_INFO, Refused, crc32c

RAW_INFO_BYTES = 144
# stream: bit, bytes of a pixel, codec
STREAMS = {16: (1, 1, RAW8), 17: (2, 1, RAW8), 18: (4, 2, RAW16)}
OPEN, FINISHED = 2, 8  # kept


class Exposure:
    def __init__(self, header):
        self.header = header
        self.info = None
        self.arrived = set()
        self.images = {}  # stream: (width, height, bytes, which pixels came)

    def add(self, header, payload):
        """Raises Refused."""
        if (header.count, header.exposure) != (self.header.count, self.header.exposure):
            raise Refused("field")
        if header.index in self.arrived:
            raise Refused("duplicate")
        if header.type == RAW_INFO:
            if header.index != 0 or len(payload) < RAW_INFO_BYTES:
                raise Refused("field")
            self.info = payload
        else:
            self.place(header, payload)
        self.arrived.add(header.index)

    def place(self, header, payload):
        if header.stream not in STREAMS or header.codec != STREAMS[header.stream][2]:
            raise Refused("unknown")
        size = STREAMS[header.stream][1]
        first = header.first_row * header.width + header.first_column
        end = first + header.pixel_count
        if header.first_column >= header.width or end > header.width * header.height or len(payload) != header.pixel_count * size:
            raise Refused("field")
        pixels = header.width * header.height
        width, height, image, came = self.images.setdefault(header.stream,
                                                            (header.width, header.height, bytearray(pixels * size), bytearray(pixels)))
        if (width, height) != (header.width, header.height) or any(came[first:end]):
            raise Refused("field")
        image[first * size:end * size] = payload
        came[first:end] = bytes([1]) * header.pixel_count

    def line(self):
        """With the CRC-32C of the pictures, the PMD camera's first; a picture that misses a tile is missing."""
        pictures, crc, names = self.info[140], 0, []
        for stream in (18, 16, 17):
            bit = STREAMS[stream][0]
            if not pictures & bit:
                continue
            width, height, image, came = self.images.get(stream, (0, 0, b"", b"\0"))
            whole = all(came)
            crc = crc32c(image, crc) if whole else crc
            names.append(f"{width}x{height}" if whole else "missing")
        number, dropped = struct.unpack_from("<II", self.info, 116)
        return (f"raw {self.header.freshness} of frame {self.header.number} number {number} dropped {dropped} pictures {pictures}"
                f" {' '.join(names)} crc {crc:08x}")


class RawPictures:
    """Packets in, lines of exposures out: whole ones at once, others when a third begins."""

    def __init__(self):
        self.open = {}  # id of the exposure; the oldest first
        self.finished = []

    def push(self, header, payload):
        """Raises Refused."""
        identity = header.freshness
        if identity in self.finished:
            raise Refused("late")
        lines = []
        if identity not in self.open and len(self.open) == OPEN:
            lines += self.finish(next(iter(self.open)))
        exposure = self.open.setdefault(identity, Exposure(header))
        exposure.add(header, payload)
        if len(exposure.arrived) == header.count:
            lines += [line for older in list(self.open) if older <= identity for line in self.finish(older)]
        return lines

    def end(self):
        """Nothing more will come: lines of the exposures that are still open."""
        return [line for identity in list(self.open) for line in self.finish(identity)]

    def finish(self, identity):
        exposure = self.open.pop(identity)
        self.finished = [*self.finished, identity][-FINISHED:]
        return [exposure.line()] if exposure.info else []
