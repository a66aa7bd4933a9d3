"""What the libcamera variant of stofd takes into an image: its libraries, and what libcamera loads by name."""

import hashlib
import json

import sbom

MODULES = ("usr/lib/aarch64-linux-gnu/libcamera", "usr/lib/aarch64-linux-gnu/libcamera/ipa")  # the latter of later versions
OWN = "/libcamera.so."
PIPELINE_FILE = "libcamera_pipeline.json"
# Of a public RSA key, as libcamera holds that of its modules: SubjectPublicKeyInfo in DER (RFC 3279).
RSA_KEY = bytes.fromhex("300d06092a864886f70d0101010500")
SHA256_OF = bytes.fromhex("3031300d060960864801650304020105000420")  # DigestInfo (RFC 8017, section 9.2)


class LibcameraError(Exception):
    """One line: what, where, what to do."""


def _der(data, at):
    """(tag, begin of the content, its end) of a DER element."""
    length, begin = data[at + 1], at + 2
    if length & 0x80:
        begin += length & 0x7F
        length = int.from_bytes(data[at + 2:begin], "big")
    return data[at], begin, begin + length


def public_key(library):
    """(modulus, exponent) of the key that libcamera.so checks its modules with; None: it has none."""
    at = library.find(RSA_KEY)
    if at < 0:
        return None
    _, begin, _ = _der(library, at + len(RSA_KEY))  # a bit string: how many bits are unused, then a sequence
    _, begin, _ = _der(library, begin + 1)
    numbers = []
    for _ in range(2):
        _, at, end = _der(library, begin)
        numbers.append(int.from_bytes(library[at:end], "big"))
        begin = end
    return tuple(numbers)


def signed(module, signature, key):
    """A module's signature is of that key (PKCS 1 version 1.5, SHA-256)."""
    modulus, exponent = key
    size = (modulus.bit_length() + 7) // 8
    digest = SHA256_OF + hashlib.sha256(module).digest()
    padded = b"\0\1" + b"\xff" * (size - len(digest) - 3) + b"\0" + digest
    return pow(int.from_bytes(signature, "big"), exponent, modulus) == int.from_bytes(padded, "big")


class Libcamera:
    """What plan.libcamera and the program, as bytes, need: `files`, {name in the image: bytes}, and `packages` of them.

    libraries: Debian's packages are in the last of its folders.
    """

    def __init__(self, plan, libraries, program):
        self.libraries = libraries
        named = self._named(plan)
        modules = [path.read_bytes() for place, (_, path) in named.items() if place.endswith(".so")]
        closure = libraries.closure(program, *modules)
        own = next((path for place, (_, path) in closure.items() if OWN in place), None)
        if own is None:
            raise LibcameraError(f"the program for camera {plan.camera} is linked without libcamera: name stofd-libcamera with --stofd")
        self._check(named, own)
        self.files = {place: path.read_bytes() for place, (_, path) in {**closure, **named}.items()}
        if "pipeline" in plan.libcamera:
            self.files[PIPELINE_FILE] = pipeline(**plan.libcamera["pipeline"])
        found = {(root, sbom.package_of(root, path.name)) for root, path in closure.values()}
        found |= {(self._root_of(name), name) for name in plan.libcamera.get("packages", [])}
        debian = libraries.roots[-1]
        self.packages = [sbom.Package(root, name, name, "debian" if root == debian else "raspberrypi") for root, name in sorted(found)]

    def _named(self, plan):
        """{place: (root, path)} of what is loaded by name: modules with their signatures, tuning files."""
        found, missing = {}, []
        for module in plan.libcamera.get("modules", []):
            for name in (module, f"{module}.sign"):
                place = next((f"{folder}/{name}" for folder in MODULES if self.libraries.find(f"{folder}/{name}")), None)
                if place is None:
                    missing.append(name)
                else:
                    found[place] = self.libraries.find(place)
        for name in plan.libcamera.get("files", []):
            found[name] = self.libraries.find(name)
            if found[name] is None:
                missing.append(name)
        if missing:
            raise LibcameraError(f"{self.libraries}: libcamera for board {plan.board}, camera {plan.camera}, lacks {', '.join(missing)}: "
                                 f"{plan.libcamera['get']}")
        return found

    def _check(self, named, library):
        """A module whose signature does not hold would run in a process of its own, by a program that is not in the image."""
        key = public_key(library.read_bytes())
        for place, (_, path) in named.items():
            if place.endswith(".so") and not (key and signed(path.read_bytes(), named[f"{place}.sign"][1].read_bytes(), key)):
                raise LibcameraError(f"{path} is not signed for {library}: unpack both of the same packages")

    def _root_of(self, package):
        return next((root for root in self.libraries.roots if sbom.has(root, package)), self.libraries.roots[-1])


def pipeline(target, camera_timeout_value_ms):
    """The configuration file of Raspberry Pi's pipelines, which LIBCAMERA_RPI_CONFIG_FILE names (board/image/init)."""
    return json.dumps({"version": 1.0, "target": target, "pipeline_handler": {"camera_timeout_value_ms": camera_timeout_value_ms}},
                      indent=1).encode() + b"\n"
