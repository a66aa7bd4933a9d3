#!/usr/bin/env python3
"""Documents of the settings partition without a file system, as firmware/records/README.md has them: the first ones of a card,
and the directories that list them.

`records.py FILE` lists those of an image, of a card (the device), or of the settings partition; it ends with 2 where FILE is none.
"""

import argparse
import collections
import os
import pathlib
import stat
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
ABSENT, LISTED = 1, 2
DIRECTORY_AT = AREA - 4096  # in an area
DIRECTORY = struct.Struct(f"<8sHHII{len(SIZES)}I")  # magic, version, area, generation, documents, newest of each
DIRECTORY_MAGIC, DIRECTORY_BYTES = b"STOFDIR\0", 512
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
    head = HEAD.pack(MAGIC, 1, number, generation, len(data), crc32c(data), LISTED, 0)[:-4]
    return (head + struct.pack("<I", crc32c(head))).ljust(HEAD_BYTES, b"\0") + data


def put(path, name, data):
    """Writes it to both areas of a partition's image, and lists it."""
    bytes_of_it = record(name, data)
    with open(path, "r+b") as part:
        for area in AREAS:
            part.seek(area + _place(name)[1])
            part.write(bytes_of_it)
    put_directories(path)


def directory(area, generation, newest):
    """The bytes of an area's directory; newest: generations by document."""
    head = DIRECTORY.pack(DIRECTORY_MAGIC, 1, area, generation, len(SIZES), *(newest.get(name, 0) for name in SIZES))
    head = head.ljust(DIRECTORY_BYTES - 4, b"\0")
    return head + struct.pack("<I", crc32c(head))


def put_directories(path):
    """Writes those of a partition's image: they list what it has."""
    with open(path, "r+b") as part:
        found = {name: newest(part, name) for name in SIZES}
        generations = {name: one.generation for name, one in found.items() if one}
        for area, begin in enumerate(AREAS):
            part.seek(begin + DIRECTORY_AT)
            part.write(directory(area, 1, generations))


def listed(part, area):
    """{document: newest generation} of that area's directory; None: it is not whole."""
    part.seek(AREAS[area] + DIRECTORY_AT)
    data = part.read(DIRECTORY_BYTES)
    magic, version, number, _, count, *generations = DIRECTORY.unpack_from(data)
    if (magic, version, number) != (DIRECTORY_MAGIC, 1, area) or count < len(SIZES) or \
            crc32c(data[:-4]) != struct.unpack("<I", data[-4:])[0]:
        return None
    return {name: generation for name, generation in zip(SIZES, generations) if generation}


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


def is_begun(part, area, name):
    """Something was written there once."""
    part.seek(AREAS[area] + _place(name)[1])
    return any(part.read(HEAD_BYTES))


def newest(part, name):
    """What a sensor takes: the newer whole one of both areas; None: there is none."""
    return max(filter(None, (read(part, area, name) for area in range(2))), default=None, key=lambda found: found.generation)


def main():
    parser = argparse.ArgumentParser(description="lists the documents that a card keeps")
    parser.add_argument("file", type=pathlib.Path, help="an image, a card (the device), or a card's settings partition")
    path = parser.parse_args().file
    try:
        if not stat.S_ISREG(kind := os.stat(path).st_mode) and not stat.S_ISBLK(kind):
            raise disk.DiskError(f"{path}: is neither a file nor a disk")
        with open(path, "rb") as file:
            list_documents(Part(file, settings_begin(path, file)))
    except OSError as error:
        print(f"records: {path}: {error.strerror}", file=sys.stderr)
        return 2
    except disk.DiskError as error:
        print(f"records: {error}: name an image, a card, or the settings partition of one", file=sys.stderr)
        return 2
    return 0


def list_documents(part):
    for name in SIZES:
        found = [read(part, area, name) for area in range(2)]
        if any(found) or any(is_begun(part, area, name) for area in range(2)):
            print(f"{name}: " + ", ".join("none that is whole" if one is None else "set aside" if one.data is None else
                                          f"generation {one.generation}, {len(one.data)} bytes" for one in found))
    for area in range(2):
        known = listed(part, area)
        print(f"directory {area}: " + ("none that is whole" if known is None else
                                       ", ".join(f"{name} {generation}" for name, generation in known.items()) or "nothing"))


def settings_begin(path, file):
    """Of an image, a disk, or the settings partition alone, as long as it is."""
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    whole = file.read(disk.SECTOR) == disk.mbr()
    if whole and size < disk.SIZE:
        raise disk.DiskError(f"{path}: has {size} bytes of an image's {disk.SIZE}: it was cut")
    if not whole and size != disk.SETTINGS.size:
        raise disk.DiskError(f"{path}: has {size} bytes and no partition table of a card; a settings partition has {disk.SETTINGS.size}")
    return disk.SETTINGS.begin if whole else 0


class Part:
    """A part of an open file, from `begin` on, to be read."""

    def __init__(self, file, begin):
        self.file, self.begin = file, begin

    def seek(self, at):
        self.file.seek(self.begin + at)

    def read(self, size):
        return self.file.read(size)


if __name__ == "__main__":
    sys.exit(main())
