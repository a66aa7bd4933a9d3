"""Update files: a release for one board, signed by its maker. The format is told in firmware/update/README.md.
update_file.py FILE prints the public key of the maker's key in FILE.

Needs libsodium (scripts/setup test has it) to sign; nothing of a private key is ever written but to its own file.
"""

import ctypes
import ctypes.util
import hashlib
import os
import pathlib
import re
import secrets
import struct
import sys

HEAD = struct.Struct("<8sHHI16s16s32sIIII32s")
MOST_COUNTER = 0xFFFFFFFF
SIGNATURE_BYTES = 64
HEAD_BYTES = HEAD.size + SIGNATURE_BYTES
CHUNK = 1 << 16
RECORD = 4096  # at the end of a slot, behind its file system
NO_LETTER = 0xFFFFFFFF
MAGIC = b"STOFUPD\0"
SEED_BYTES = 32
PUBLIC_KEY = re.compile(r"[0-9a-fA-F]{64}")


class UpdateError(Exception):
    """One line: what, where, what to do."""


def _sodium():
    name = ctypes.util.find_library("sodium")
    if name is None:
        raise UpdateError("libsodium is missing: run scripts/setup test")
    library = ctypes.CDLL(name)
    if library.sodium_init() < 0:
        raise UpdateError("libsodium does not start on this system")
    return library


class Key:
    """A maker's key of a file with 64 hexadecimal digits, the secret seed of Ed25519."""

    def __init__(self, seed):
        self._library = _sodium()
        public, secret = ctypes.create_string_buffer(32), ctypes.create_string_buffer(64)
        self._library.crypto_sign_ed25519_seed_keypair(public, secret, seed)
        self.public = public.raw
        self._secret = secret

    def sign(self, data):
        signature = ctypes.create_string_buffer(SIGNATURE_BYTES)
        self._library.crypto_sign_ed25519_detached(signature, None, data, ctypes.c_ulonglong(len(data)), self._secret)
        return signature.raw

    @classmethod
    def read(cls, path):
        try:
            seed = bytes.fromhex(pathlib.Path(path).read_text(encoding="ascii").strip())
        except OSError as error:
            raise UpdateError(f"{path}: {error.strerror}: name the maker's key") from error
        except ValueError:
            seed = b""
        if len(seed) != SEED_BYTES:
            raise UpdateError(f"{path}: a maker's key is {2 * SEED_BYTES} hexadecimal digits")
        return cls(seed)

    @classmethod
    def developers(cls, path):
        """The key of this folder alone, drawn where there is none yet: for tests and for boards on a desk."""
        path = pathlib.Path(path)
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="ascii") as file:
                file.write(secrets.token_hex(SEED_BYTES) + "\n")
        return cls.read(path)


def _text(text, size, what):
    data = text.encode(errors="surrogateescape")
    if not 0 < len(data) <= size or not text.strip() or not text.isprintable():
        raise UpdateError(f"{what} {text!r}: takes 1 to {size} bytes of printable text")
    return data


def head(content, hashes, key, *, board, camera, version, counter, letter_at=None):
    """The signed head of a release."""
    if not 0 <= counter <= MOST_COUNTER:
        raise UpdateError(f"counter {counter}: takes 0 to {MOST_COUNTER}")
    signed = HEAD.pack(MAGIC, 1, 0, CHUNK, _text(board, 16, "board"), _text(camera, 16, "camera"), _text(version, 32, "version"),
                       counter, len(content), NO_LETTER if letter_at is None else letter_at, 0,
                       hashlib.blake2b(hashes, digest_size=32).digest())
    return signed + key.sign(signed)


def make(content, key, **words):
    """(update file, record of a slot with the same content)."""
    hashes = b"".join(hashlib.blake2b(content[at:at + CHUNK], digest_size=32).digest() for at in range(0, len(content), CHUNK))
    top = head(content, hashes, key, **words)
    return top + hashes + content, top.ljust(RECORD, b"\0")


def public_keys(*keys):
    """The file that a sensor gets with --update-keys."""
    return "".join(f"{key.hex()}\n" for key in keys).encode()


def read_public_keys(path):
    """The lines of such a file; UpdateError where a sensor would not take it."""
    path = pathlib.Path(path)
    try:
        lines = path.read_text(encoding="ascii").split("\n") if path.is_file() else [""]
    except (OSError, UnicodeDecodeError):
        lines = [""]
    if lines[-1:] == [""]:
        lines.pop()
    if not lines or not all(PUBLIC_KEY.fullmatch(line) for line in lines):
        raise UpdateError(f"{path}: public keys are {2 * SEED_BYTES} hexadecimal digits a line (scripts/imaging/update_file.py FILE prints one)")
    return "".join(f"{line}\n" for line in lines).encode()


if __name__ == "__main__":
    try:
        print(Key.read(*sys.argv[1:2] or ("",)).public.hex())
    except UpdateError as wrong:
        sys.exit(f"update_file: {wrong}")
