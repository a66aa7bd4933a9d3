"""What stofd's libcamera variant needs in the guest beside its libraries: what udev would tell of devices."""

import pathlib

import initramfs


def add(image):
    """As `extra` of initramfs.build()."""
    source = pathlib.Path(initramfs.GUEST) / "udev_entry"
    image.archive.file("bin/udev_entry", source.read_bytes(), 0o755)
    image.archive.link("bin/uevent", "busybox")
    image.library("libgcc_s.so.1")  # loaded by name when a thread ends
