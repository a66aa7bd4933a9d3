"""A stand-in for the unpacked packages of Raspberry Pi's kernel and boot firmware: their layout, and nothing that runs."""

import gzip
import stat

KERNEL = bytes(56) + b"ARM\x64" + bytes(1000)  # what tells a kernel for 64-bit ARM
BUILT_IN = ("ext4", "mmc_block")


def module(name, depends=""):
    """What tells a kernel module for 64-bit ARM."""
    return (b"\x7fELF\x02\x01".ljust(18, b"\0") + b"\xb7").ljust(64, b"\0") + f"\0name={name}\0depends={depends}\0".encode()


def make(folder, plan):
    """All that the recipe `plan` names, in `folder`. The kernel's version."""
    version = f"6.12.34+rpt{plan.flavour}"

    def file(name, data):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)

    file(f"boot/vmlinuz-{version}", KERNEL)
    modules = f"usr/lib/modules/{version}"
    file(f"{modules}/modules.builtin", "".join(f"kernel/fs/{name}.ko\n" for name in BUILT_IN).encode())
    for name in (names.split("|")[0] for names in plan.modules):
        if name not in BUILT_IN:
            file(f"{modules}/kernel/drivers/{name.replace('_', '-')}.ko", module(name))
    trees = f"usr/lib/linux-image-{version}"
    for name in plan.files:
        firmware = name.endswith((".elf", ".dat"))
        file(f"usr/lib/raspi-firmware/{name}" if firmware else f"{trees}/{name}" if "/" in name
             else f"{trees}/broadcom/{name}", name.encode())
    for name, source in ((f"linux-image-{version}", "linux"), ("raspi-firmware", "raspi-firmware")):
        file(f"usr/share/doc/{name}/changelog.Debian.gz", gzip.compress(f"{source} (1:1-2) stable; urgency=low\n".encode()))
        file(f"usr/share/doc/{name}/copyright", b"see /usr/share/common-licenses/GPL-2.")
    return version


def packed(initramfs):
    """{name: bytes of a file, or where a link leads} of an initramfs as slots hold it."""
    data, at, found = gzip.decompress(initramfs), 0, {}
    while True:
        fields = [int(data[at + 6 + 8 * k:at + 14 + 8 * k], 16) for k in range(13)]
        mode, size, length = fields[1], fields[6], fields[11]
        name = data[at + 110:at + 110 + length - 1].decode()
        begin = (at + 110 + length + 3) // 4 * 4
        at = (begin + size + 3) // 4 * 4
        if name == "TRAILER!!!":
            return found
        if stat.S_ISREG(mode) or stat.S_ISLNK(mode):
            found[name] = data[begin:begin + size]
