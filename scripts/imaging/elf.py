"""What the loader needs to know of an ELF file: its interpreter and the libraries it names.

Enough of the format (System V ABI, chapter 5) for 64-bit little-endian programs.
"""

import struct

PT_LOAD, PT_DYNAMIC, PT_INTERP = 1, 2, 3
DT_NULL, DT_NEEDED, DT_STRTAB = 0, 1, 5
MAGIC = b"\x7fELF\x02\x01"
EM_AARCH64 = 183


class NotElf(Exception):
    """The bytes are no 64-bit little-endian ELF file."""


def _segments(data):
    if data[:6] != MAGIC:
        raise NotElf("not a 64-bit little-endian ELF file")
    at, = struct.unpack_from("<Q", data, 32)
    size, count = struct.unpack_from("<HH", data, 54)
    for k in range(count):
        kind, _, offset, address, _, length = struct.unpack_from("<IIQQQQ", data, at + k * size)
        yield kind, offset, address, length


def _text(data, offset):
    return data[offset:data.index(b"\0", offset)].decode()


def is_for_arm64(data):
    """Whether these are a program or library for 64-bit ARM."""
    return data[:6] == MAGIC and len(data) >= 64 and struct.unpack_from("<H", data, 18)[0] == EM_AARCH64


def is_whole(data):
    """Whether the table of sections, which comes last in what compilers write, is there."""
    at, = struct.unpack_from("<Q", data, 40)
    size, count = struct.unpack_from("<HH", data, 58)
    return at + size * count <= len(data)


def interpreter(data):
    """The path of the program interpreter; None of a static program."""
    for kind, offset, _, _ in _segments(data):
        if kind == PT_INTERP:
            return _text(data, offset)
    return None


def needed(data):
    """The names of the libraries that the file asks for, in order."""
    segments = list(_segments(data))
    names, strings = [], None
    for kind, offset, _, length in segments:
        if kind != PT_DYNAMIC:
            continue
        for at in range(offset, offset + length, 16):
            tag, value = struct.unpack_from("<QQ", data, at)
            if tag == DT_NULL:
                break
            if tag == DT_NEEDED:
                names.append(value)
            elif tag == DT_STRTAB:
                strings = value
    if not names:
        return []
    for kind, offset, address, length in segments:
        if kind == PT_LOAD and address <= strings < address + length:
            return [_text(data, strings - address + offset + name) for name in names]
    raise NotElf("its string table is in no segment")
