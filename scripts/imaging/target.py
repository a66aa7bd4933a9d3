"""The device that is written: what it is, and why it must not be."""

import contextlib
import os
import pathlib
import stat

import disk

SYSTEM_MOUNTS = ("/", "/boot", "/boot/efi", "/boot/firmware", "/home", "/usr", "/var")


class TargetError(Exception):
    """One line: what, where, what to do."""


class System:
    """What this machine tells of its disks; tests give another root."""

    def __init__(self, root="/"):
        self.root = pathlib.Path(root)

    def block(self, number):
        """The folder of a device's number, "8:0", in /sys; None: there is none."""
        link = self.root / "sys" / "dev" / "block" / number
        return link.resolve() if link.exists() else None

    def mounts(self):
        """{device number: [where]}. A file system with a number of its own (btrfs) counts by its source's name, too."""
        found = {}
        for line in (self.root / "proc" / "self" / "mountinfo").read_text().splitlines():
            fields = line.split()
            found.setdefault(fields[2], []).append(fields[4])
            source = fields[fields.index("-") + 2]
            number = self.number_of(source)
            if number not in (None, fields[2]):
                found.setdefault(number, []).append(fields[4])
        return found

    def number_of(self, source):
        """The number of a device by its name in /dev, or None."""
        entry = self.root / "sys" / "class" / "block" / pathlib.PurePath(source).name / "dev"
        return entry.read_text().strip() if source.startswith("/dev/") and entry.exists() else None

    def swaps(self):
        lines = (self.root / "proc" / "swaps").read_text().splitlines()[1:]
        return {pathlib.PurePath(line.split()[0]).name for line in lines if line.strip()}

    def loops(self):
        """{folder in /sys of each loop device: what it is a loop of, as same_file() tells}."""
        return {backing.parent.parent.resolve(): self.same_file(backing.read_text().strip())
                for backing in (self.root / "sys" / "block").glob("loop*/loop/backing_file")}

    def same_file(self, path):
        """What is equal for two names of one file or one device."""
        with contextlib.suppress(OSError):
            found = os.stat(path)
            if not stat.S_ISBLK(found.st_mode):
                return found.st_dev, found.st_ino
            path = self.block(f"{os.major(found.st_rdev)}:{os.minor(found.st_rdev)}") or path
        return pathlib.PurePath(path).name  # a device, or what is not seen from here

    def backed_by(self, path):
        """Loop devices of that file or device: their folders in /sys."""
        return [loop for loop, of in self.loops().items() if of == self.same_file(path)]

    def behind(self, folder):
        """What a loop device is a loop of, and what that is a loop of, down to the file."""
        loops, found = self.loops(), []
        while folder in loops and loops[folder] not in found:
            found.append(loops[folder])
            folder = next((loop for loop in loops if found[-1] in (loop.name, *(part.name for part in loop.iterdir()))), None)
        return found

    def beside(self, folder):
        """Other loop devices, of what the same one is a loop of in the end."""
        own = self.behind(folder)
        return [loop for loop in self.loops() if loop != folder and own and self.behind(loop)[-1] == own[-1]]


def _users(system, folder, mounts, swaps):
    """Who uses a disk: [where its parts, and what is made of them, are mounted], at any depth."""
    users = []
    for part in [folder, *(child for child in sorted(folder.iterdir()) if (child / "partition").exists())]:
        users += mounts.get((part / "dev").read_text().strip(), [])
        if part.name in swaps:
            users.append("swap")
        holders = part / "holders"
        for holder in sorted(holders.iterdir()) if holders.is_dir() else []:
            users += _users(system, holder.resolve(), mounts, swaps) or [holder.name]
        users += _users_of_loops(system, f"/dev/{part.name}", mounts, swaps)
    return users


def _users_of_loops(system, path, mounts, swaps):
    """Who uses the loop devices of a file or a device."""
    return [user for loop in system.backed_by(path) for user in _users(system, loop, mounts, swaps) or [loop.name]]


def check(path, image, system=None):
    """TargetError where that device or file must not be written. A line about what it is."""
    system = system or System()
    try:
        found = os.stat(path)
    except OSError as error:
        raise TargetError(f"{path}: {error.strerror}: name the card's device, or a file that is there") from error
    if os.path.samestat(found, os.stat(image)):
        raise TargetError(f"{path} is the image itself: name a device or another file")
    if stat.S_ISREG(found.st_mode):
        about, size = "a file", found.st_size
        users = _users_of_loops(system, os.path.realpath(path), system.mounts(), system.swaps())
    elif stat.S_ISBLK(found.st_mode):
        number = f"{os.major(found.st_rdev)}:{os.minor(found.st_rdev)}"
        folder = system.block(number)
        if folder is None:
            raise TargetError(f"{path}: this system tells nothing of it: is /sys mounted?")
        if (folder / "partition").exists():
            raise TargetError(f"{path} is a part of {folder.parent.name}: name the whole card")
        size = int((folder / "size").read_text()) * disk.SECTOR
        names = [folder / "device" / name for name in ("model", "name")]
        about = next((name.read_text().strip() for name in names if name.exists()), "a disk")
        if (folder / "ro").exists() and (folder / "ro").read_text().strip() == "1":
            raise TargetError(f"{path} cannot be written: is the card's switch at lock?")
        if system.same_file(image) in system.behind(folder):
            raise TargetError(f"{path} is a loop device of the image itself: name another one")
        users = _users(system, folder, system.mounts(), system.swaps()) + [loop.name for loop in system.beside(folder)]
    else:
        raise TargetError(f"{path} is neither a disk nor a file: name the card's device")
    if any(user in SYSTEM_MOUNTS or user == "swap" for user in users):
        raise TargetError(f"{path} is a disk of this system ({', '.join(sorted(set(users)))}): name the card's device")
    if users:
        raise TargetError(f"{path} is in use ({', '.join(sorted(set(users)))}): unmount it")
    if size < disk.SIZE:
        raise TargetError(f"{path} has {size / 1e6:.0f} MB, the image takes {disk.SIZE / 1e6:.0f}: use a larger one")
    return f"{path}: {about}, {size / 1e6:.0f} MB"


def contents(device):
    """Lines: what is on an open one now and will be gone."""
    device.seek(0)
    found = disk.partitions(device.read(disk.SECTOR))
    return [f"  partition {k}: type {kind:#04x}, {size / 1e6:.0f} MB" for k, (kind, _, size) in enumerate(found, 1)] or [
        "  no partitions that an MBR tells of"]
