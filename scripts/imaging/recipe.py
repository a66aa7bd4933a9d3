"""What a board's image is made of: its table (board/NAME/image.json) and the unpacked packages of its kernel."""

import gzip
import json
import pathlib
import re
import struct
import zlib

import kernel_modules

GZIP = b"\x1f\x8b"
TRY_WORD = b"tryboot"  # of kernels of Raspberry Pi that know it
CERTIFICATES = 144  # in the optional header of PE32+: where the signature is
RAW_MAGIC = (0x38, b"ARM\x64")  # of an uncompressed arm64 kernel


class RecipeError(Exception):
    """One line: what, where, what to do."""


class Recipe:
    """The table of a board, with that of one kind of camera."""

    def __init__(self, root, board, camera):
        path = pathlib.Path(root) / "board" / board / "image.json"
        if not re.fullmatch(r"[a-z0-9]+", board) or not path.exists():
            have = sorted(found.parent.name for found in (pathlib.Path(root) / "board").glob("*/image.json"))
            raise RecipeError(f"board {board} has no image: use {', '.join(have)}")
        table = json.loads(path.read_text())
        cameras = table["cameras"]
        if camera not in cameras:
            raise RecipeError(f"board {board} has no camera {camera}: use {', '.join(cameras)}")
        kind = cameras[camera]
        boot = table["boot"]
        self.board = board
        self.camera = camera
        self.program = kind["program"]
        self.options = kind.get("options", [])
        self.libcamera = kind.get("libcamera")
        self.flavour = table["kernel"]["flavour"]
        self.package = table["kernel"]["package"]
        self.cmdline = " ".join(filter(None, [boot["cmdline"], kind.get("cmdline", "")]))
        self.starts_on_trial = boot.get("starts_on_trial", False)
        self.config = boot.get("config", []) + kind.get("config", [])
        self.files = boot["files"] + kind.get("files", [])
        self.modules = table["modules"] + kind.get("modules", [])
        self.settings_devices = table["settings_devices"]


def _length_told(kernel):
    """Where the last section, or the signature, ends of a kernel that UEFI can start, too (PE/COFF); 0 of another one; more than it has
    where these are not told."""
    if kernel[:2] != b"MZ":
        return 0
    try:
        at, = struct.unpack_from("<I", kernel, 60)
        sections, = struct.unpack_from("<H", kernel, at + 6)
        options, = struct.unpack_from("<H", kernel, at + 20)
        places = [struct.unpack_from("<II", kernel, at + 24 + options + 40 * k + 16) for k in range(sections)]
        if options >= CERTIFICATES + 8:
            places.append(struct.unpack_from("<II", kernel, at + 24 + CERTIFICATES)[::-1])
    except struct.error:
        return len(kernel) + 1
    return max((begin + size for size, begin in places), default=0)


class KernelTree:
    """Packages of a kernel, of its device trees and of boot firmware, unpacked to one folder (dpkg -x)."""

    def __init__(self, folder, recipe):
        self.folder = pathlib.Path(folder)
        self.recipe = recipe
        images = [path for path in self._any("boot/vmlinuz-*", "usr/lib/modules/*/vmlinuz*", "lib/modules/*/vmlinuz*")
                  if self._version(path).endswith(recipe.flavour)]
        versions = sorted({self._version(path) for path in images})
        if len(versions) > 1:
            raise RecipeError(f"{folder}: kernels {' and '.join(versions)}: leave one of them there")
        if not images:
            raise RecipeError(f"{folder}: no kernel *{recipe.flavour}: unpack {recipe.package} there (dpkg -x)")
        self.image = images[0]
        self.version = versions[0]
        found = self._any(f"usr/lib/modules/{self.version}/modules.builtin", f"lib/modules/{self.version}/modules.builtin")
        if not found:
            raise RecipeError(f"{folder}: no modules of kernel {self.version}: unpack {recipe.package} there (dpkg -x)")
        self.modules = kernel_modules.Modules(found[0].parent)
        self._check()

    def _any(self, *patterns):
        return sorted(path for pattern in patterns for path in self.folder.glob(pattern))

    @staticmethod
    def _version(path):
        name = re.sub(r"^vmlinu[xz]-?", "", path.name)
        return name or path.parent.name

    def _check(self):
        """All that the board's table names is there, or one line says what is not."""
        missing = [f"module {' or '.join(names)}" for names in self._alternatives() if not any(map(self.modules.has, names))]
        missing += [name for name in self.recipe.files if self._find(name) is None]
        if missing:
            raise RecipeError(f"{self.folder}: kernel {self.version} for board {self.recipe.board}, camera "
                              f"{self.recipe.camera}, lacks {', '.join(missing)}: unpack {self.recipe.package} there (dpkg -x)")

    def _alternatives(self):
        """The modules of the recipe, each with the names that kernels have it by."""
        return [entry.split("|") for entry in self.recipe.modules]

    def module_files(self):
        """[(name, bytes)] in the order in which insmod takes them."""
        wanted = [next(filter(self.modules.has, names)) for names in self._alternatives()]
        return [(name, data) for _, name, data in self.modules.in_order([wanted])]

    def _find(self, name):
        """A device tree, an overlay or a file of the boot firmware."""
        trees = f"usr/lib/linux-image-{self.version}"
        found = self._any(f"{trees}/broadcom/{name}", f"{trees}/{name}", f"usr/lib/raspi-firmware/{name}")
        return found[0] if found else None

    def boot_files(self):
        """{name on the slot: bytes} beside kernel and initramfs."""
        return {name: self._find(name).read_bytes() for name in self.recipe.files}

    def can_try(self):
        """This kernel, or whoever starts the board, can start the other slot once (reboot "0 tryboot")."""
        data = self.image.read_bytes()
        return self.recipe.starts_on_trial or TRY_WORD in (gzip.decompress(data) if data[:2] == GZIP else data)

    def compressed(self):
        """The kernel, as slots hold it."""
        data = self.image.read_bytes()
        packed = data[:2] == GZIP
        try:
            raw = gzip.decompress(data) if packed else data
        except (EOFError, OSError, zlib.error) as error:
            raise RecipeError(f"{self.image}: is damaged: unpack {self.recipe.package} anew (dpkg -x)") from error
        offset, magic = RAW_MAGIC
        if raw[offset:offset + len(magic)] != magic:
            raise RecipeError(f"{self.image}: no kernel for 64-bit ARM")
        if len(raw) < _length_told(raw):
            raise RecipeError(f"{self.image}: is cut: unpack {self.recipe.package} anew (dpkg -x)")
        return data if packed else gzip.compress(data, 6, mtime=0)
