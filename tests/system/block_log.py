"""What a guest wrote to its disk, in the order in which it did: QEMU's blklogwrites (the format of Linux's dm-log-writes)."""

import collections
import struct

SUPER = struct.Struct("<QQQI")
ENTRY = struct.Struct("<QQQQ")
MAGIC = 0x6A736677736872
FLUSH = 1
SECTOR = 512
# bytes empty: a flush, before which all writes are on the medium.
Write = collections.namedtuple("Write", "offset bytes")


class BlockLogError(Exception):
    """The file is no such log."""


def read(path):
    """[Write]. The count at its begin may lag behind the end of a machine that was cut off: what is there is taken."""
    data = path.read_bytes()
    if len(data) < SECTOR:
        return []
    magic, version, _, sector = SUPER.unpack_from(data)
    if magic != MAGIC or version != 1:
        raise BlockLogError(f"{path}: no log of block writes")
    writes, at = [], sector
    while at + sector <= len(data):
        first, count, flags, _ = ENTRY.unpack_from(data, at)
        at += sector
        if flags & ~15 or at + count * sector > len(data):
            break
        if flags & FLUSH:
            writes.append(Write(0, b""))
        if count and not flags & 4:  # discards carry no bytes
            writes.append(Write(first * sector, data[at:at + count * sector]))
            at += count * sector
        elif not count and not flags:
            break
    return writes
