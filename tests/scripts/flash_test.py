#!/usr/bin/env python3
"""Tests of scripts/flash, on files, and of what it refuses, on a machine that is made up."""

import json
import os
import pathlib
import pty
import re
import signal
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
from importlib import machinery, util

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts" / "imaging"))
import disk  # noqa: E402
import records  # noqa: E402
import target  # noqa: E402
import update_file  # noqa: E402

FLASH = ROOT / "scripts" / "flash"
EPOCH = 1_700_000_000
CALIBRATION = b"STOFCAL\0 of a rig"
CALIBRATION += records.crc32c(CALIBRATION).to_bytes(4, "little")
CODE = re.compile(r"^((?:[0-9a-f]{4}-){7}[0-9a-f]{4})$", re.MULTILINE)


def load():
    loader = machinery.SourceFileLoader("flash", str(FLASH))
    module = util.module_from_spec(util.spec_from_loader("flash", loader))
    loader.exec_module(module)
    return module


flash = load()


def seed_of(part):
    with open(part, "rb") as file:
        file.seek(disk.SEED_AT)
        return file.read(disk.SEED_BYTES)


class OnFiles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.common = pathlib.Path(folder.name)
        images = {part: cls.common / part.label for part in disk.PARTITIONS}
        key = update_file.Key.developers(cls.common / "key")
        for part in disk.PARTITIONS[:3]:
            disk.fat(images[part], part, {"cmdline.txt": part.label.encode(), flash.OPTIONS_FILE: b"--guided\n--help\n--size WxH\n"}, EPOCH)
        release = disk.used_part(images[disk.SLOTS["a"]])
        for part in disk.SLOTS.values():
            disk.put_record(images[part], update_file.make(release, key, board="virt", camera="usb", version="1", counter=0)[1])
        disk.ext4(images[disk.SETTINGS], {}, EPOCH)
        cls.image = cls.common / "image"
        disk.assemble(cls.image, images)

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.card = self.folder / "card"
        self.card.write_bytes(b"old")
        os.truncate(self.card, disk.SIZE + disk.MIB)

    def run_flash(self, *arguments, image=None, card=None, stdin=subprocess.DEVNULL):
        return subprocess.run([sys.executable, "-B", FLASH, image or self.image, card or self.card, *arguments], text=True,
                              stdin=stdin, capture_output=True, check=False)

    def settings(self):
        part = self.folder / "settings"
        with open(self.card, "rb") as card:
            card.seek(disk.SETTINGS.begin)
            part.write_bytes(card.read(disk.SETTINGS.size))
        return part

    def test_the_card_holds_the_image_and_the_first_settings(self):
        calibration = self.folder / "rig.cal"
        calibration.write_bytes(CALIBRATION)
        done = self.run_flash("--yes", "--calibration", calibration, "--name", "front \u00e4", "--address", "192.168.7.2/24",
                              "--address", "dhcp", "--gateway", "192.168.7.1", "--hostname", "front-7", "--option=--size", "--option=320x240")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, "")  # no bar: this is no terminal
        code = CODE.search(done.stdout)[1]
        with open(self.card, "rb") as card, open(self.image, "rb") as image:
            self.assertTrue(card.read(disk.SETTINGS.begin) == disk.sealed(image.read(disk.SETTINGS.begin), bytes(disk.SECTOR)))
        part = self.settings()
        self.assertEqual(disk.read_ext4(part, "rig.cal"), CALIBRATION)
        with open(part, "rb") as open_part:
            self.assertEqual(json.loads(records.newest(open_part, "settings").data), {"name": "front \u00e4", "network": {
                "dhcp": True, "address": "192.168.7.2/24", "gateway": "192.168.7.1", "hostname": "front-7"}})
        self.assertEqual(disk.read_ext4(part, "options"), b"--size\n320x240\n")
        self.assertEqual(disk.read_ext4(part, "label").decode().strip(), code.replace("-", ""))
        self.assertNotEqual(seed_of(part), bytes(disk.SEED_BYTES))
        disk.run(["e2fsck", "-fn", part])

    def test_each_card_has_a_code_and_a_seed_of_its_own(self):
        found = set()
        for _ in range(2):
            done = self.run_flash("--yes")
            found |= {CODE.search(done.stdout)[1], seed_of(self.settings())}
        self.assertEqual(len(found), 4)

    def test_nobody_to_be_asked_writes_nothing(self):
        done = self.run_flash()
        self.assertEqual(done.returncode, 2)
        self.assertIn("--yes", done.stderr)
        self.assertEqual(self.card.read_bytes()[:3], b"old")

    def answered(self, answer, before=lambda: None):
        """On a terminal: code, all that was shown. before: what happens while it asks."""
        child, terminal = pty.fork()
        if child == 0:
            signal.signal(signal.SIGINT, signal.SIG_DFL)  # whoever started this test may have it ignored
            os.execv(sys.executable, [sys.executable, "-B", str(FLASH), str(self.image), str(self.card)])
        shown = b""
        try:
            while chunk := os.read(terminal, 4096):
                shown += chunk
                if shown.endswith(b"Type yes: "):
                    before()
                    os.write(terminal, answer)
        except OSError:  # the other end is closed
            pass
        os.close(terminal)
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), shown.decode()

    def test_on_a_terminal_it_asks_and_shows_a_bar(self):
        code, shown = self.answered(b"no\n")
        self.assertEqual(code, 2)
        self.assertIn("nothing was written", shown)
        self.assertEqual(self.card.read_bytes()[:3], b"old")
        for ends in (b"\4", b"\3"):  # Ctrl-D, Ctrl-C
            code, shown = self.answered(ends)
            self.assertEqual(code, 2)
            self.assertNotIn("Traceback", shown)
            self.assertIn("nothing was written", shown)
        code, shown = self.answered(b"yes\n")
        self.assertEqual(code, 0, shown)
        self.assertIn("writing [" + "#" * 40 + "] 100 %", shown)
        self.assertIn("reading [" + "#" * 40 + "] 100 %", shown)

    def test_bad_input_is_one_line_and_writes_nothing(self):
        short = self.folder / "short"
        short.write_bytes(b"x" * 100)
        damaged = self.folder / "damaged.cal"
        damaged.write_bytes(CALIBRATION[:-1] + b"?")
        for arguments, places, said in (
                (["--name", "x" * 32], {}, "--name takes"), (["--name", ""], {}, "--name takes"), (["--name", " "], {}, "--name takes"),
                (["--name", "a\nb"], {}, "--name takes"), (["--name", 'a"b'], {}, "--name takes"), (["--name", "a\\b"], {}, "--name takes"),
                (["--calibration", "/dev/zero"], {}, "no calibration"), (["--calibration", self.image], {}, "no calibration"),
                (["--calibration", self.folder], {}, "no calibration"), (["--calibration", damaged], {}, "a damaged one"),
                (["--option=--size 640x480"], {}, "one word"), (["--option=--nonsense"], {}, "no word of this"), (["--option=--help"], {}, "no word of this"),
                (["--option=foo"], {}, "no word of this"), (["--option=--guided", "--option=3"], {}, "no word of this"), (["--option=--size=2x2"], {}, "no word of this"),
                (["--option=--size"], {}, "takes WxH"), (["--option=--size", "--option=bogus"], {}, "--size takes WxH"), (["--option=--size", "--option=--guided"], {}, "takes WxH"), ([], {"image": "/dev/zero"}, "no image of scripts/image"),
                (["--address", "192.168.7.2"], {}, "--address takes"),
                (["--address", "192.168.7.0/24"], {}, "no address of a host"), (["--address", "dhcp", "--address", "::1/64"], {}, "--address takes"),
                (["--address", "10.0.0.2/24", "--address", "10.0.0.3/24"], {}, "one fixed address"),
                (["--gateway", "10.0.0.1"], {}, "takes an --address"), (["--gateway", "x"], {}, "--gateway takes"),
                (["--address", "10.0.0.2/24", "--gateway", "10.0.1.1"], {}, "of the same network"), (["--hostname", "a_b"], {}, "--hostname takes"),
                (["--calibration", self.folder / "none"], {}, "No such file"), (["--option", ""], {}, "one word"),
                ([], {"image": short}, "no image of scripts/image"), ([], {"image": self.folder / "none"}, "No such file"),
                ([], {"card": short}, "use a larger one"), ([], {"card": self.folder / "none"}, "No such file"),
                ([], {"card": self.image}, "the image itself"), ([], {"card": "/dev/null"}, "neither a disk nor a file")):
            done = self.run_flash("--yes", *arguments, **places)
            self.assertEqual(done.returncode, 2, (arguments, places, done.stderr))
            self.assertIn(said, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertEqual(self.card.read_bytes()[:3], b"old")

    def test_a_flipped_bit_anywhere_in_an_image_is_told(self):
        broken = self.folder / "broken"
        for at in (440, disk.SECTOR + 20, 2 * disk.SECTOR, disk.BOOT.begin + 3, disk.SLOTS["a"].begin + 5000, disk.SLOTS["b"].begin + 5000,
                   disk.SETTINGS.begin + disk.MIB, disk.SIZE - 1):
            data = bytearray(self.image.read_bytes())
            data[at] ^= 1
            broken.write_bytes(data)
            done = self.run_flash("--yes", image=broken)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), (at, done.stderr))
            self.assertRegex(done.stderr, "no image of scripts/image" if at < disk.SECTOR else "other bytes than were built")
            self.assertEqual(self.card.read_bytes()[:3], b"old")

    def test_options_are_those_of_the_images_program(self):
        done = self.run_flash("--yes", "--option=--guided", "--option=--size", "--option=1x1")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(disk.read_ext4(self.settings(), "options"), b"--guided\n--size\n1x1\n")

    def run_records(self, *arguments):
        return subprocess.run([sys.executable, "-B", records.__file__, *arguments], text=True, stdin=subprocess.DEVNULL, capture_output=True,
                              check=False, timeout=60)

    def test_what_a_card_keeps_is_listed(self):
        self.assertEqual(self.run_flash("--yes", "--name", "front").returncode, 0)
        for path in (self.card, self.settings()):
            done = self.run_records(path)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertRegex(done.stdout, "^settings: generation 1, [0-9]+ bytes, generation 1, [0-9]+ bytes\ndirectory 0: settings 1\n")

    def test_what_is_no_card_has_no_documents(self):
        pipe, cut, other = self.folder / "pipe", self.folder / "cut", self.folder / "other"
        os.mkfifo(pipe)
        cut.write_bytes(self.image.read_bytes()[:disk.SIZE - 1])
        other.write_bytes(b"x" * 100)
        for path, said in ((pipe, "neither a file nor a disk"), (cut, "it was cut"), (other, "no partition table"), (self.folder, "neither a file"),
                           ("/dev/null", "neither a file"), (self.folder / "none", "No such file")):
            done = self.run_records(path)
            self.assertEqual((done.returncode, done.stderr.count("\n"), done.stdout), (2, 1, ""), done.stderr)
            self.assertIn(said, done.stderr)
        self.assertEqual(self.run_records().returncode, 2)
        self.assertEqual(self.run_records("--help").returncode, 0)

    def test_a_card_that_keeps_other_bytes_is_told(self):
        data = self.image.read_bytes()
        with flash.opened(self.card) as card:
            flash.write(card, data)
            flash.compare(card, data)
            for at in (0, disk.SLOTS["b"].begin + 5, disk.SIZE - 1):
                card.seek(at)
                byte = card.read(1)[0]
                card.seek(at)
                card.write(bytes([byte ^ 1]))
                with self.assertRaisesRegex(flash.WrittenOtherwise, "use another card"):
                    flash.compare(card, data)
                flash.write(card, data)

    def test_a_card_that_was_pulled_out_has_no_partitions(self):
        data = self.image.read_bytes()
        with flash.opened(self.card) as card:
            flash.write(card, data)
            with unittest.mock.patch.object(flash.Progress, "add", side_effect=OSError(5, "pulled out")):
                with self.assertRaises(OSError):
                    flash.write(card, data)
        self.assertEqual(disk.partitions(self.card.read_bytes()[:disk.SECTOR]), [])

    def test_two_at_once_do_not_write_one_card(self):
        with flash.opened(self.card):
            done = self.run_flash("--yes")
        self.assertEqual((done.returncode, done.stderr.count("\n"), done.stdout), (2, 1, ""), done.stderr)
        self.assertIn("is in use", done.stderr)

    def test_a_file_that_takes_the_place_of_the_card_is_not_written(self):
        other = self.folder / "other"
        other.write_bytes(b"mine")
        os.truncate(other, disk.SIZE)
        for replace in (lambda: os.replace(other, self.card), lambda: (self.card.unlink(), self.card.symlink_to(self.image))):
            code, shown = self.answered(b"yes\n", replace)
            self.assertEqual(code, 2)
            self.assertRegex(shown, "another one than when you were asked: nothing was written|is the image itself")
            self.assertEqual(self.card.read_bytes()[:4], b"mine" if not self.card.is_symlink() else self.image.read_bytes()[:4])


class Disks(unittest.TestCase):
    """A made-up /sys and /proc: disk sdx (8:0) with a partition (8:1); a file of this test stands for each device."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.disk = self.root / "sys/devices/sdx"
        self.put("sys/devices/sdx/dev", "8:0")
        self.put("sys/devices/sdx/size", str(disk.SIZE // 512 + 8))
        self.put("sys/devices/sdx/device/model", "CARD READER")
        self.put("sys/devices/sdx/sdx1/dev", "8:1")
        self.put("sys/devices/sdx/sdx1/partition", "1")
        (self.disk / "sdx1/holders").mkdir()
        for number, name in (("8:0", "sdx"), ("8:1", "sdx/sdx1")):
            self.link(f"sys/dev/block/{number}", self.root / "sys/devices" / name)
            self.link(f"sys/class/block/{name[-4:].strip('/')}", self.root / "sys/devices" / name)
        self.put("proc/swaps", "Filename Type Size Used Priority\n")
        self.mounts("20 1 254:0 / / rw - ext4 /dev/other rw")

    def put(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text + "\n")

    def link(self, name, to):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.symlink_to(to)

    def mounts(self, *lines):
        self.put("proc/self/mountinfo", "\n".join(lines))

    def check(self, minor=0):
        real = os.stat
        block = os.stat_result((0o060660, 0, 0, 1, 0, 0, 0, 0, 0, 0), {"st_rdev": os.makedev(8, minor)})
        with unittest.mock.patch.object(target.os, "stat", lambda path, **more: block if path == "/dev/card" else
                                        real(path, **more)):
            return target.check("/dev/card", FLASH, target.System(self.root))

    def refused(self, words, minor=0):
        with self.assertRaisesRegex(target.TargetError, words):
            self.check(minor)

    def test_a_free_card_is_named_by_its_model(self):
        self.assertRegex(self.check(), "CARD READER, 176 MB")

    def test_a_part_of_a_disk_is_refused(self):
        self.refused("is a part of sdx", minor=1)

    def test_a_mounted_disk_is_refused(self):
        self.mounts("30 1 8:1 / /media/card rw - vfat /dev/sdx1 rw")
        self.refused("in use .*/media/card")
        self.mounts("30 1 8:0 / /media/card rw - vfat /dev/sdx rw")
        self.refused("in use .*/media/card")

    def test_the_disk_of_this_system_is_refused(self):
        self.mounts("30 1 8:1 / / rw - ext4 /dev/sdx1 rw")
        self.refused("a disk of this system")
        self.mounts("30 1 0:31 / / rw shared:1 - btrfs /dev/sdx1 rw")
        self.refused("a disk of this system")

    def test_swap_and_what_is_made_of_a_partition_count(self):
        self.put("proc/swaps", "Filename Type Size Used Priority\n/dev/sdx1 partition 8 0 -2")
        self.refused("a disk of this system .swap")
        self.put("proc/swaps", "Filename Type Size Used Priority\n")
        self.put("sys/devices/dm-0/dev", "253:0")
        self.link("sys/devices/sdx/sdx1/holders/dm-0", self.root / "sys/devices/dm-0")
        self.refused("in use .dm-0")
        self.mounts("30 1 253:0 / /home rw - ext4 /dev/mapper/home rw")
        self.refused("a disk of this system ./home")

    def test_loop_devices_of_its_parts_count_at_any_depth(self):
        for number, backing in ((1, "/dev/sdx1"), (2, "/dev/loop1p1")):
            self.put(f"sys/devices/loop{number}/dev", f"7:{number}")
            self.put(f"sys/devices/loop{number}/loop/backing_file", backing)
            self.put(f"sys/devices/loop{number}/loop{number}p1/dev", f"259:{number}")
            self.put(f"sys/devices/loop{number}/loop{number}p1/partition", "1")
            self.link(f"sys/block/loop{number}", self.root / f"sys/devices/loop{number}")
        self.refused("in use .loop2")
        self.mounts("30 1 259:2 / /media/inner rw - vfat /dev/loop2p1 rw")
        self.refused("in use ./media/inner")

    def test_a_loop_device_of_the_image_or_beside_another_one_is_refused(self):
        self.put("sys/devices/sdx/loop/backing_file", str(FLASH))
        self.link("sys/block/loop0", self.root / "sys/devices/sdx")
        self.refused("of the image itself")
        inner = self.root / "inner.img"  # a hard link of it, behind another loop
        os.link(FLASH, inner) if os.stat(FLASH).st_dev == os.stat(self.root).st_dev else inner.symlink_to(FLASH)
        self.put("sys/devices/sdx/loop/backing_file", "/dev/loop1")
        self.put("sys/devices/loop1/loop/backing_file", str(inner))
        self.link("sys/block/loop1", self.root / "sys/devices/loop1")
        self.refused("of the image itself")
        self.put("sys/devices/loop1/loop/backing_file", "/tmp/other")
        self.put("sys/devices/sdx/loop/backing_file", "/tmp/card")
        self.assertRegex(self.check(), "CARD READER")
        self.put("sys/devices/loop1/loop/backing_file", "/tmp/card")
        self.refused("in use .loop1")
        self.put("sys/devices/loop1/loop/backing_file", "/dev/loop2")
        self.put("sys/devices/loop2/loop/backing_file", "/tmp/card")
        self.link("sys/block/loop2", self.root / "sys/devices/loop2")
        self.refused("in use .loop1, loop2")

    def test_a_card_that_is_small_or_locked_is_refused(self):
        self.put("sys/devices/sdx/ro", "1")
        self.refused("switch at lock")
        self.put("sys/devices/sdx/ro", "0")
        self.put("sys/devices/sdx/size", str(disk.SIZE // 512 - 1))
        self.refused("use a larger one")


if __name__ == "__main__":
    unittest.main()
