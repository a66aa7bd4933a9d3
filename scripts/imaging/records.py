"""Documents of the settings partition without a file system, as firmware/records/README.md has them: the first ones of a card.

`records.py FILE` lists those at the end of a file: of a partition, or of an image of a whole card.
"""

import collections
import pathlib
import struct
import sys

import disk

AREA = 4 * disk.MIB
AREAS = (disk.SETTINGS.size - 3 * AREA, disk.SETTINGS.size - AREA)  # in the partition
SMALL, LARGE = 64 << 10, 1536 << 10
SIZES = {"settings": SMALL, "good settings": SMALL, "trial": SMALL, "limits": SMALL, "damaged settings": SMALL, "keys": SMALL,
         "damaged keys": SMALL, "calibration": LARGE, "damaged calibration": LARGE}
MAGIC = b"STOFDOC\0"
HEAD_BYTES = 512
HEAD = struct.Struct("<8sHHIIIII")  # magic, version, document, generation, bytes, their sum, flags, sum of these
ABSENT = 1
Record = collections.namedtuple("Record", "generation data")  # data None: it says that there is none


def _crc_table():
    table = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ (0x82F63B78 if value & 1 else 0)
        table.append(value)
    return table


CRC_TABLE = _crc_table()


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ CRC_TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def _place(name):
    at = 0
    for number, (other, size) in enumerate(SIZES.items()):
        if other == name:
            return number, at
        at += size
    raise KeyError(name)


def record(name, data, generation=1):
    """The bytes of a record in its place."""
    number, _ = _place(name)
    if len(data) > SIZES[name] - HEAD_BYTES:
        raise disk.DiskError(f"{name}: {len(data)} bytes, {SIZES[name] - HEAD_BYTES} are the most")
    head = HEAD.pack(MAGIC, 1, number, generation, len(data), crc32c(data), 0, 0)[:-4]
    return (head + struct.pack("<I", crc32c(head))).ljust(HEAD_BYTES, b"\0") + data


def put(path, name, data):
    """Writes it to both areas of a partition's image."""
    bytes_of_it = record(name, data)
    with open(path, "r+b") as part:
        for area in AREAS:
            part.seek(area + _place(name)[1])
            part.write(bytes_of_it)


def read(part, area, name):
    """The Record of that area of an open partition; None: none that is whole."""
    number, at = _place(name)
    part.seek(AREAS[area] + at)
    head = part.read(HEAD_BYTES)
    magic, version, document, generation, size, data_crc, flags, crc = HEAD.unpack_from(head)
    if (magic, version, document) != (MAGIC, 1, number) or crc != crc32c(head[:HEAD.size - 4]) or size > SIZES[name]:
        return None
    data = part.read(size)
    return Record(generation, None if flags & ABSENT else data) if crc32c(data) == data_crc else None


def newest(part, name):
    """What a sensor takes: the newer whole one of both areas; None: there is none."""
    return max(filter(None, (read(part, area, name) for area in range(2))), default=None, key=lambda found: found.generation)


def main():
    path = pathlib.Path(sys.argv[1])
    with open(path, "rb") as file:
        part = Part(file, path.stat().st_size - disk.SETTINGS.size)  # they lie at the end
        for name in SIZES:
            found = [read(part, area, name) for area in range(2)]
            if any(found):
                print(f"{name}: " + ", ".join("none that is whole" if one is None else "set aside" if one.data is None else
                                              f"generation {one.generation}, {len(one.data)} bytes" for one in found))


class Part:
    """A part of an open file, from `begin` on, to be read."""

    def __init__(self, file, begin):
        self.file, self.begin = file, begin

    def seek(self, at):
        self.file.seek(self.begin + at)

    def read(self, size):
        return self.file.read(size)


if __name__ == "__main__":
    try:
        main()
    except (OSError, IndexError, struct.error) as wrong:
        sys.exit(f"records: name a partition or an image: {wrong}")
