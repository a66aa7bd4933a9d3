#!/usr/bin/env python3
"""Writes an initramfs: a newc cpio archive of files, kernel modules and programs with their libraries.

Modules are unpacked and listed in /modules, "GROUP NAME" a line, in the order in which insmod takes them: no
depmod, no modprobe. No root, no external program.
"""

import argparse
import lzma
import pathlib
import re
import stat
import struct

import elf

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
KERNEL = ROOT / "build" / "kernel-arm64"
GUEST = pathlib.Path(__file__).resolve().parent / "guest"
# What the guest of the system test needs, beside what the kernel has built in: the first group is inserted before
# the others, which do not depend on each other.
MODULES = (("xhci_pci",), ("uvcvideo",), ("virtio_net",), ("8250_pci", "i6300esb"))
SIGNED = b"~Module signature appended~\n"
SIGNATURE_FIELDS = struct.Struct(">5B3xI")  # struct module_signature of the kernel; the last is the signature's length
LIBRARY_FOLDERS = ("usr/lib/aarch64-linux-gnu", "usr/lib")
APPLETS = ("cat cp dd dmesg grep insmod ip kill ls mkdir mkfifo mount poweroff reboot rm sed sh sleep stty tr touch"
           " usleep").split()
FOLDERS = ("bin", "dev", "etc", "proc", "run", "sys", "tmp", "usr/lib", "var")


class Archive:
    """A newc cpio archive in memory; folders come before what they hold."""

    def __init__(self):
        self.parts = []
        self.names = set()

    def _add(self, name, mode, data, device=(0, 0)):
        path = name.encode() + b"\0"
        fields = (len(self.names) + 1, mode, 0, 0, 1, 0, len(data), 0, 0, *device, len(path), 0)
        head = b"070701" + b"".join(b"%08X" % field for field in fields) + path
        self.parts += [head, bytes(-len(head) % 4), data, bytes(-len(data) % 4)]
        self.names.add(name)

    def folder(self, name):
        """The folder and those above it, where they are missing."""
        parts = name.strip("/").split("/")
        for k in range(1, len(parts) + 1):
            path = "/".join(parts[:k])
            if path and path not in self.names:
                self._add(path, stat.S_IFDIR | 0o755, b"")

    def file(self, name, data, mode=0o644):
        name = name.strip("/")
        if "/" in name:
            self.folder(name.rsplit("/", 1)[0])
        if name not in self.names:
            self._add(name, stat.S_IFREG | mode, data)

    def link(self, name, target):
        name = name.strip("/")
        if "/" in name:
            self.folder(name.rsplit("/", 1)[0])
        if name not in self.names:
            self._add(name, stat.S_IFLNK | 0o777, target.encode())

    def node(self, name, major, minor):
        """A character device."""
        self.folder(name.rsplit("/", 1)[0])
        self._add(name, stat.S_IFCHR | 0o600, b"", (major, minor))

    def bytes(self):
        end = Archive()
        end._add("TRAILER!!!", 0, b"")
        body = b"".join(self.parts + end.parts)
        return body + bytes(-len(body) % 512)


def _name_of(module):
    return module.replace("-", "_")


def unsigned(module):
    """The module without its signature, whose verification takes an emulated processor long."""
    if not module.endswith(SIGNED):
        return module
    end = len(module) - len(SIGNED) - SIGNATURE_FIELDS.size
    return module[:end - SIGNATURE_FIELDS.unpack_from(module, end)[-1]]


class Modules:
    """The modules of an unpacked kernel by their names."""

    def __init__(self, folder):
        folder = pathlib.Path(folder)
        self.paths = {}
        for path in (folder / "kernel").rglob("*.ko*"):
            self.paths[_name_of(path.name.split(".ko")[0])] = path
        lines = (folder / "modules.builtin").read_text().split()
        self.builtin = {_name_of(pathlib.PurePath(line).stem) for line in lines}

    def read(self, name):
        path = self.paths.get(name)
        if path is None:
            raise SystemExit(f"initramfs: the kernel has no module {name}: check its name, or toolchains/kernel.sh")
        data = path.read_bytes()
        return unsigned(lzma.decompress(data) if path.suffix == ".xz" else data)

    def in_order(self, groups):
        """[(group's number, name, bytes)]: these and what they depend on, each once and after what it depends on."""
        found, order = set(), []

        def take(number, name):
            name = _name_of(name)
            if name in found or name in self.builtin:
                return
            found.add(name)
            data = self.read(name)
            depends = re.search(rb"(?:^|\0)depends=([^\0]*)\0", data)
            for other in filter(None, depends[1].decode().split(",") if depends else []):
                take(number, other)
            order.append((number, name, data))

        for number, names in enumerate(groups):
            for name in names:
                take(number, name)
        return order


class Image:
    """An archive that is filled with what the guest of the system test needs."""

    def __init__(self, kernel=KERNEL, libraries=None):
        self.kernel = pathlib.Path(kernel)
        self.libraries = None if libraries is None else pathlib.Path(libraries)
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
        interpreter = elf.interpreter(data)
        names = elf.needed(data)
        if interpreter:
            self.archive.file(interpreter.replace("/lib/", "usr/lib/", 1),
                              self._library(pathlib.PurePath(interpreter).name), 0o755)
        for name in names:
            target = f"usr/lib/aarch64-linux-gnu/{name}"
            if target in self.archive.names:
                continue
            library = self._library(name)
            self.archive.file(target, library, 0o755)
            self._closure(library)

    def library(self, name):
        """One that is loaded by name while the program runs."""
        data = self._library(name)
        self.archive.file(f"usr/lib/aarch64-linux-gnu/{name}", data, 0o755)
        self._closure(data)

    def _library(self, name):
        for folder in LIBRARY_FOLDERS if self.libraries else ():
            path = self.libraries / folder / name
            if path.exists():
                return path.read_bytes()
        raise SystemExit(f"initramfs: no library {name} in {self.libraries}: name the folder with --libraries")

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
