"""A stand-in for the unpacked packages of Raspberry Pi's kernel and boot firmware: their layout, and nothing that runs."""

import gzip

KERNEL = bytes(56) + b"ARM\x64" + bytes(1000)  # what tells a kernel for 64-bit ARM
BUILT_IN = ("ext4", "mmc_block")


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
    for name in plan.modules:
        if name not in BUILT_IN:
            file(f"{modules}/kernel/drivers/{name.replace('_', '-')}.ko", b"\0depends=\0")
    trees = f"usr/lib/linux-image-{version}"
    for name in plan.files:
        firmware = name.endswith((".elf", ".dat"))
        file(f"usr/lib/raspi-firmware/{name}" if firmware else f"{trees}/{name}" if "/" in name
             else f"{trees}/broadcom/{name}", name.encode())
    for name, source in ((f"linux-image-{version}", "linux"), ("raspi-firmware", "raspi-firmware")):
        file(f"usr/share/doc/{name}/changelog.Debian.gz", gzip.compress(f"{source} (1:1-2) stable; urgency=low\n".encode()))
        file(f"usr/share/doc/{name}/copyright", b"see /usr/share/common-licenses/GPL-2.")
    return version
