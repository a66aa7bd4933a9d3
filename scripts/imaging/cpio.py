"""A newc cpio archive, as the kernel unpacks an initramfs. Two archives of the same calls are equal byte for byte."""

import stat


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
