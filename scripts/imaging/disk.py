"""The disk that is flashed: four partitions in an MBR, of which the first three are FAT and the fourth is ext4.

MBR and not GPT: every boot loader of a Raspberry Pi reads it, four partitions are enough, and it is one sector. Two disks
of the same files are equal byte for byte: numbers that others draw at random are fixed here, times are those of the caller.
The sector behind the table is the image's seal, a hash of all the rest: what was damaged on its way is told before it is flashed.
Needs mkfs.vfat, mcopy, mke2fs and debugfs (scripts/setup image); no root.
"""

import collections
import hashlib
import os
import pathlib
import shutil
import struct
import subprocess

SECTOR = 512
MIB = 1 << 20
RECORD = 4096  # at the end of a slot, behind its file system: which release is in it (update_file.py)
BLOCK = 4096  # what counts as empty or not
DISK_ID = 0x73746F66  # "stof"
FAT, LINUX = 0x0C, 0x83
Partition = collections.namedtuple("Partition", "name label type begin size serial")
# Begins are multiples of 4 MiB, the erase block of cards.
BOOT = Partition("boot", "STOF-BOOT", FAT, 4 * MIB, 4 * MIB, 0x73740001)
SLOTS = {"a": Partition("slot A", "STOF-A", FAT, 8 * MIB, 64 * MIB, 0x73740002),
         "b": Partition("slot B", "STOF-B", FAT, 72 * MIB, 64 * MIB, 0x73740003)}
SETTINGS = Partition("settings", "stof-settings", LINUX, 136 * MIB, 32 * MIB, 0x73740004)
PARTITIONS = (BOOT, SLOTS["a"], SLOTS["b"], SETTINGS)
SIZE = SETTINGS.begin + SETTINGS.size
# Of the settings partition: the factory's files, never written by a sensor; then an erase block for the random seed; then
# records (records.py).
FILES_BYTES = 16 * MIB
SEED_AT, SEED_BYTES = FILES_BYTES, SECTOR
UUID = "73746f66-0000-4000-8000-000000000004"  # of the settings' file system
ENTRY = struct.Struct("<B3sB3sII")
ENTRIES_AT = 446
SEAL_MAGIC = b"STOFIMG\0"


class DiskError(Exception):
    """One line: what, where, what to do."""


def tool(name):
    path = shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")
    if not path:
        raise DiskError(f"{name} is missing: run scripts/setup image")
    return path


def run(command, epoch=None, **options):
    """Its output; DiskError with its last line where it fails. epoch: the time that it believes in."""
    environment = {**os.environ, "TZ": "UTC", "LC_ALL": "C", "MTOOLS_SKIP_CHECK": "1"}
    if epoch is not None:
        environment |= {"SOURCE_DATE_EPOCH": str(epoch), "E2FSPROGS_FAKE_TIME": str(max(epoch, 1))}
    done = subprocess.run([tool(command[0]), *map(str, command[1:])], env=environment, stdin=subprocess.DEVNULL,
                          capture_output=True, check=False, **options)
    if done.returncode:
        said = (done.stderr or done.stdout).decode(errors="replace").strip().splitlines()
        raise DiskError(f"{command[0]} failed: {said[-1] if said else done.returncode}")
    return done.stdout


def mbr():
    sector = bytearray(SECTOR)
    struct.pack_into("<I", sector, 440, DISK_ID)
    for k, part in enumerate(PARTITIONS):
        far = b"\xfe\xff\xff"  # cylinders, heads and sectors are those of no disk: read the numbers behind
        ENTRY.pack_into(sector, ENTRIES_AT + k * ENTRY.size, 0x80 if part is BOOT else 0, far, part.type, far,
                        part.begin // SECTOR, part.size // SECTOR)
    sector[510:] = b"\x55\xaa"
    return bytes(sector)


def partitions(sector):
    """[(type, begin, size)] in bytes of the used entries of an MBR; none: it is no MBR."""
    if sector[510:SECTOR] != b"\x55\xaa":
        return []
    entries = [ENTRY.unpack_from(sector, ENTRIES_AT + k * ENTRY.size) for k in range(4)]
    return [(kind, begin * SECTOR, size * SECTOR) for _, _, kind, _, begin, size in entries if kind]


def fat(path, part, files, epoch):
    """A FAT file system of files, {path there: bytes}; all of them have the time `epoch`."""
    tree = pathlib.Path(f"{path}.d")
    shutil.rmtree(tree, ignore_errors=True)
    tree.mkdir()
    for name, data in files.items():
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        (tree / name).write_bytes(data)
    for entry in sorted(tree.rglob("*"), reverse=True):
        os.utime(entry, (epoch, epoch))
    path.write_bytes(b"")
    os.truncate(path, part.size - (RECORD if part in SLOTS.values() else 0))
    bits = "12" if part.size < 16 * MIB else "32"
    run(["mkfs.vfat", "--invariant", "-F", bits, "-i", f"{part.serial:08x}", "-n", part.label, path], epoch)
    if files:
        names = sorted(entry.name for entry in tree.iterdir())
        run(["mcopy", "-s", "-p", "-m", "-Q", "-i", path, *(tree / name for name in names), "::"], epoch)
    shutil.rmtree(tree)
    os.truncate(path, part.size)


def ext4(path, files, epoch):
    """The settings partition with its file system; files: {name: bytes}, of mode 0600. No journal: no sensor mounts it to write."""
    path.write_bytes(b"")
    os.truncate(path, FILES_BYTES)
    run(["mke2fs", "-q", "-F", "-t", "ext4", "-b", "4096", "-I", "256", "-m", "0", "-L", SETTINGS.label, "-U", UUID,
         "-E", f"hash_seed={UUID},lazy_itable_init=0,lazy_journal_init=0,root_owner=0:0", "-O",
         "^resize_inode,^dir_index,^has_journal,metadata_csum", path], epoch)
    add_to_ext4(path, files, epoch)
    os.truncate(path, SETTINGS.size)


def add_to_ext4(path, files, epoch=None):
    """Writes files, {name: bytes}, to the file system, of root and of mode 0600; reads each back."""
    for name, data in sorted(files.items()):
        source = pathlib.Path(f"{path}.{name}")
        source.touch(mode=0o600)
        source.write_bytes(data)
        try:
            run(["debugfs", "-w", "-R", f"rm {name}", path], epoch)
            run(["debugfs", "-w", "-R", f"write {source} {name}", path], epoch)
            run(["debugfs", "-w", "-R", f"set_inode_field {name} mode 0100600", path], epoch)
            if epoch is not None:
                for field in ("atime", "ctime", "mtime", "crtime"):
                    run(["debugfs", "-w", "-R", f"set_inode_field {name} {field} @{epoch:x}", path], epoch)
        finally:
            source.unlink()
        if read_ext4(path, name) != data:
            raise DiskError(f"debugfs wrote {name} otherwise than it was told: is its package whole?")


def put_seed(path, seed):
    """The random seed of the next start, in the image of the settings partition."""
    with open(path, "r+b") as part:
        part.seek(SEED_AT)
        part.write(seed)


def read_ext4(path, name):
    """A file's bytes; empty: there is none."""
    return run(["debugfs", "-R", f"cat {name}", path])


def read_fat(image, part, name):
    """A file's bytes."""
    return run(["mtype", "-i", f"{image}@@{part.begin}", f"::{name}"])


def used_part(path):
    """The bytes of a file up to its last block that is not empty."""
    data = path.read_bytes()
    end = len(data)
    while end and not any(data[max(0, end - BLOCK):end]):
        end -= BLOCK
    return data[:max(0, end)]


def seal(image):
    """The sector of an image's bytes that tells whether they are those that were built."""
    rest = memoryview(image)
    return (SEAL_MAGIC + hashlib.sha256(bytes(rest[:SECTOR]) + rest[2 * SECTOR:]).digest()).ljust(SECTOR, b"\0")


def sealed(image, sector):
    """The image with that sector in place of its seal."""
    return image[:SECTOR] + sector + image[2 * SECTOR:]


def put_record(path, record):
    """The last bytes of a slot's image."""
    with open(path, "r+b") as image:
        image.seek(-len(record), os.SEEK_END)
        image.write(record)


def assemble(path, images):
    """The whole disk of partitions' images, {Partition: file}; what is empty takes no space."""
    with open(path, "wb") as disk:
        disk.write(mbr())
        for part, image in images.items():
            disk.seek(part.begin)
            with open(image, "rb") as source:
                while block := source.read(BLOCK):
                    if any(block):
                        disk.write(block)
                    else:
                        disk.seek(len(block), os.SEEK_CUR)
        disk.truncate(SIZE)
    with open(path, "r+b") as disk:
        sector = seal(disk.read())
        disk.seek(SECTOR)
        disk.write(sector)


def used_bytes(path):
    """Bytes of its blocks that are not empty."""
    zero = bytes(BLOCK)
    with open(path, "rb") as disk:
        return sum(BLOCK for block in iter(lambda: disk.read(BLOCK), b"") if block != zero[:len(block)])
