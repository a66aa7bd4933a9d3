"""The modules of an unpacked kernel, and the order in which insmod takes them."""

import lzma
import pathlib
import re
import struct

import elf

SIGNED = b"~Module signature appended~\n"
SIGNATURE_FIELDS = struct.Struct(">5B3xI")  # struct module_signature of the kernel; the last is the signature's length


class ModuleError(Exception):
    """One line: what, where, what to do."""


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
        folder = self.folder = pathlib.Path(folder)
        self.paths = {}
        for path in sorted((folder / "kernel").rglob("*.ko*")):
            self.paths[_name_of(path.name.split(".ko")[0])] = path
        lines = (folder / "modules.builtin").read_text().split()
        self.builtin = {_name_of(pathlib.PurePath(line).stem) for line in lines}

    def read(self, name):
        path = self.paths.get(name)
        if path is None:
            raise SystemExit(f"initramfs: the kernel in {self.folder} has no module {name}: check its name, or toolchains/kernel.sh")
        if not path.is_file():
            raise ModuleError(f"{path}: is no file: unpack its package anew")
        data = path.read_bytes()
        try:
            data = unsigned(lzma.decompress(data) if path.suffix == ".xz" else data)
        except (lzma.LZMAError, struct.error) as error:
            raise ModuleError(f"{path}: is no module: unpack its package anew ({error})") from error
        if not elf.is_for_arm64(data) or not elf.is_whole(data) or f"\0name={name}\0".encode() not in data:
            raise ModuleError(f"{path}: is not the whole module {name} for 64-bit ARM: unpack its package anew")
        return data

    def has(self, name):
        """It is a module, or part of the kernel."""
        return _name_of(name) in self.paths or _name_of(name) in self.builtin

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
