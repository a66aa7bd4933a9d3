#!/usr/bin/env python3
"""Writes an initramfs: a newc cpio archive of files, kernel modules and programs with their libraries.

Modules are unpacked and listed in /modules, "GROUP NAME" a line, in the order in which insmod takes them: no
depmod, no modprobe. No root, no external program.
"""

import argparse
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts" / "imaging"))
from cpio import Archive  # noqa: E402
from kernel_modules import Modules  # noqa: E402
from libraries import Libraries, LibraryError  # noqa: E402

KERNEL = ROOT / "build" / "kernel-arm64"
GUEST = pathlib.Path(__file__).resolve().parent / "guest"
# What the guest of the system test needs, beside what the kernel has built in: the first group is inserted before
# the others, which do not depend on each other.
MODULES = (("xhci_pci",), ("uvcvideo",), ("virtio_net",), ("8250_pci", "i6300esb"))
APPLETS = ("cat cp dd dmesg grep insmod ip kill ls mkdir mkfifo mount poweroff reboot rm sed sh sleep stty tr touch"
           " usleep").split()
FOLDERS = ("bin", "dev", "etc", "proc", "run", "sys", "tmp", "usr/lib", "var")


class Image:
    """An archive that is filled with what the guest of the system test needs."""

    def __init__(self, kernel=KERNEL, libraries=None):
        self.kernel = pathlib.Path(kernel)
        self.libraries = Libraries(*([] if libraries is None else [libraries]))
        self.archive = Archive()
        for folder in FOLDERS:
            self.archive.folder(folder)
        self.archive.node("dev/console", 5, 1)
        self.archive.link("lib", "usr/lib")
        self.archive.file("bin/busybox", (self.kernel / "busybox").read_bytes(), 0o755)
        for name in APPLETS:
            self.archive.link(f"bin/{name}", "busybox")

    def modules(self, groups):
        order = Modules(self.kernel / "modules").in_order(groups)
        for _, name, data in order:
            self.archive.file(f"modules.d/{name}.ko", data)
        self.archive.file("modules", "".join(f"{group} {name}\n" for group, name, _ in order).encode())

    def program(self, source, target):
        """A program, and the closure of the libraries that it names."""
        data = pathlib.Path(source).read_bytes()
        self.archive.file(target, data, 0o755)
        self._closure(data)

    def _closure(self, data):
        try:
            found = self.libraries.closure(data)
        except LibraryError as error:
            raise SystemExit(f"initramfs: {error}, or name the folder with --libraries") from error
        for place, (_, path) in found.items():
            self.archive.file(place, path.read_bytes(), 0o755)

    def library(self, name):
        """One that is loaded by name while the program runs."""
        found = self.libraries.find(name)
        if found is None:
            raise SystemExit(f"initramfs: no library {name}: name the folder that has it with --libraries")
        data = found[1].read_bytes()
        self.archive.file(f"usr/lib/aarch64-linux-gnu/{name}", data, 0o755)
        self._closure(data)

    def write(self, path):
        path = pathlib.Path(path)
        part = path.with_name(path.name + ".part")
        part.write_bytes(self.archive.bytes())
        part.replace(path)


def build(out, files, programs, *, kernel=KERNEL, libraries=None, modules=MODULES, init=GUEST / "init",
          extra=None):
    """files, programs: pairs of a path here (files: or bytes) and a path there. extra(image) adds whatever else."""
    image = Image(kernel, libraries)
    image.archive.file("init", pathlib.Path(init).read_bytes(), 0o755)
    image.modules(modules)
    for source, target in files:
        image.archive.file(target, source if isinstance(source, bytes) else pathlib.Path(source).read_bytes())
    for source, target in programs:
        image.program(source, target)
    if extra:
        extra(image)
    image.write(out)


def pair(text):
    source, separator, target = text.partition(":")
    if not separator:
        raise argparse.ArgumentTypeError("takes HERE:THERE")
    return source, target


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out")
    parser.add_argument("--kernel", default=KERNEL, help="what toolchains/kernel.sh made")
    parser.add_argument("--libraries", help="where programs' libraries are, such as build/sysroot-arm64")
    parser.add_argument("--modules", default=" ".join(",".join(group) for group in MODULES),
                        help="groups with spaces between, such as xhci_pci uvcvideo,virtio_net")
    parser.add_argument("--init", default=GUEST / "init")
    parser.add_argument("--file", type=pair, action="append", default=[], metavar="HERE:THERE")
    parser.add_argument("--program", type=pair, action="append", default=[], metavar="HERE:THERE")
    options = parser.parse_args()
    build(options.out, options.file, options.program, kernel=options.kernel, libraries=options.libraries,
          modules=[group.split(",") for group in options.modules.split()], init=options.init)


if __name__ == "__main__":
    main()
