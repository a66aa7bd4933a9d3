#!/usr/bin/env python3
"""Tests of scripts/image: the disk, the table of a board against unpacked packages, what is told of others' parts.

No kernel of Raspberry Pi is at hand: pi_packages.py makes a stand-in of the same layout.
"""

import gzip
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts" / "imaging"))
import cpio  # noqa: E402
import disk  # noqa: E402
import kernel_modules  # noqa: E402
import recipe  # noqa: E402
import records  # noqa: E402
import sbom  # noqa: E402
import update_file  # noqa: E402

sys.path.insert(0, str(ROOT / "tests" / "scripts"))
import pi_packages  # noqa: E402

EPOCH = 1_700_000_000
VERSION = "6.12.34+rpt-rpi-v8"
IMAGE = pi_packages.KERNEL


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def file(self, name, data=b""):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
        return path


class Boards(unittest.TestCase):
    def test_every_table_is_whole(self):
        for path in sorted((ROOT / "board").glob("*/image.json")):
            table = json.loads(path.read_text())
            self.assertIn("usb", table["cameras"])
            for camera in table["cameras"]:
                plan = recipe.Recipe(ROOT, path.parent.name, camera)
                self.assertIn(plan.program, ("stofd", "stofd-libcamera"))
                by_libcamera = plan.program == "stofd-libcamera"
                self.assertEqual((plan.libcamera is not None, plan.options), (by_libcamera, ["--cameras", "libcamera"] * by_libcamera))
                self.assertLessEqual(len(camera), 16)  # of an update file
                self.assertTrue(all(device.startswith("/dev/") and device.endswith("4") for device in plan.settings_devices))
                # An overlay that config.txt names is one that the check looks for.
                for line in plan.config:
                    name = line.removeprefix("dtoverlay=").split(",")[0]
                    if line.startswith("dtoverlay="):
                        self.assertIn(f"overlays/{name}.dtbo", plan.files)

    def test_a_board_or_camera_that_is_none_is_told_with_those_there_are(self):
        with self.assertRaisesRegex(recipe.RecipeError, "board moon has no image: use rpi4, rpi5, virt"):
            recipe.Recipe(ROOT, "moon", "usb")
        with self.assertRaisesRegex(recipe.RecipeError, "no camera film: use usb, imx296"):
            recipe.Recipe(ROOT, "rpi4", "film")


class Init(InFolder):
    """Functions of board/image/init, in this machine's shell."""

    def function(self, name, *arguments, before=""):
        text = (ROOT / "board/image/init").read_text()
        body = text[text.index(f"\n{name}() {{") + 1:]
        body = body[:body.index("\n}\n") + 3]
        return subprocess.run(["sh", "-c", f'{before}{body}{name} "$@"', "sh", *map(str, arguments)], capture_output=True,
                              text=True, check=False)

    def test_a_boot_loader_that_does_not_know_slots_is_noticed(self):
        for word, old in ((0x7F, False), (0x04, False), (0x03, True), (0x7B, True), (0xFFFFFF00, True)):
            self.file("bootloader/capabilities", word.to_bytes(4, "big"))
            self.assertEqual(self.function("old_boot_loader", self.folder / "bootloader").returncode, int(not old), hex(word))
        (self.folder / "bootloader/capabilities").unlink()  # those of before 2021 say nothing
        self.assertEqual(self.function("old_boot_loader", self.folder / "bootloader").returncode, 0)
        self.assertEqual(self.function("old_boot_loader", self.folder / "no Raspberry Pi").returncode, 1)

    def test_a_module_gets_its_words_of_the_command_line_and_no_others(self):
        words = "cmdline='quiet imx296.trigger_mode=1 imx296x.a=1 imx296.b=2 stof.slot=a uvcvideo.timeout=6000 imx296'\n"
        for module, given in (("imx296", "trigger_mode=1\nb=2\n"), ("uvcvideo", "timeout=6000\n"), ("imx", ""), ("slot", "")):
            self.assertEqual(self.function("parameters_of", module, before=words).stdout, given, module)

    def test_the_usual_slot_is_known_without_the_program_of_a_release(self):
        # GNU's grep wants to be told what busybox takes for granted.
        words = f'disk={self.folder}/card\ngrep() {{ command grep -a "$@"; }}\n'
        for number, slot in ((2, "a"), (3, "b")):
            text = f"[all]\ntryboot_a_b=1\nboot_partition={number}\n[tryboot]\nboot_partition={5 - number}\n".encode()
            disk.fat(self.folder / "card1", disk.BOOT, {"autoboot.txt": text}, EPOCH)
            done = self.function("usual_slot", before=words)
            self.assertEqual((done.stdout, done.returncode), (f"{slot}\n", 0), done.stderr)
        self.file("card1", bytes(4096))
        self.assertEqual(self.function("usual_slot", before=words).stdout, "")


class Helpers(InFolder):
    """Functions of what runs beside stofd as root: what it takes of what stofd wrote."""

    def call(self, part, words):
        """The last line of a script of the image that stops before it does anything, with other words behind."""
        text = (ROOT / "board/image" / part).read_text()
        end = {"network": "\nip link set lo up", "devices": "\nif [ "}[part]
        return subprocess.run(["sh", "-c", text[:text.index(end) + 1].replace("export PATH=/bin", "") + words], capture_output=True, text=True,
                              check=False, cwd=self.folder)

    def test_the_network_takes_addresses_and_a_name_alone(self):
        def taken(text):
            self.file("asked", text.encode())
            done = self.call("network", 'read_asked asked && understand && echo "$dhcp $link_local [$address] [$gateway] $name"')
            self.assertEqual(done.stderr, "")
            return done.stdout.strip()

        whole = "dhcp no\nlink_local yes\naddress 192.168.7.2/24\ngateway 192.168.7.1\nhostname front-7\n"
        self.assertEqual(taken(whole), "no yes [192.168.7.2/24] [192.168.7.1] front-7")
        self.assertEqual(taken("dhcp yes\nlink_local no\nhostname stof\n"), "yes no [] [] stof")
        for was, wrong in (("dhcp no", "dhcp maybe"), ("dhcp no\n", ""), ("/24", "/31"), ("/24", ""), ("/24", "/24/1"), (".7.2", ".7.256"),
                           (".7.2", ".7.2 dev eth1"), (".7.2", ".7"), (".7.2", ".7.2.3"), ("192.168.7.1", "-h"), ("front-7", "-front"),
                           ("front-7", "a;reboot"), ("front-7", "$(reboot)"), ("front-7", "a" * 64), ("gateway", "route"),
                           ("hostname front-7\n", ""), ("dhcp no\n", "dhcp no\n" * 8)):
            self.assertEqual(taken(whole.replace(was, wrong, 1)), "", (was, wrong))

    def test_a_device_goes_to_its_group(self):
        words = 'chgrp() { echo "$1 $2"; }\nchmod() { :; }\nmark() { :; }\n'
        for device, group in (("video4linux video0", "video"), ("video4linux v4l-subdev0", "video"), ("media media1", "video"),
                              ("dma_heap dma_heap/linux,cma", "video"), ("gpio gpiochip0", "gpio"),
                              ("tty ttyAMA0", "dialout"), ("watchdog watchdog0", "watchdog")):
            subsystem, name = device.split()
            self.assertEqual(self.call("devices", f"{words}give {device} ''").stdout, f"{group} /dev/{name}\n")
        usb = "usb bus/usb/001/004"
        self.assertEqual(self.call("devices", f"{words}give {usb} 1209/50/100").stdout, "plugdev /dev/bus/usb/001/004\n")
        for other in (f"{usb} 1209/5/100", f"{usb} ''", "block vda4 ''", "tty tty1 ''", "mem mem ''", "block video0 ''", "video4linux radio0 ''",
                      "misc udmabuf ''"):
            self.assertEqual(self.call("devices", f"{words}give {other}").stdout, "", other)


class Records(InFolder):
    def test_both_areas_get_them_and_the_newer_whole_one_counts(self):
        part = self.file("part")
        os.truncate(part, disk.SETTINGS.size)
        records.put(part, "settings", b'{"name": "front"}')
        records.put(part, "calibration", bytes(100_000))
        with open(part, "r+b") as file:
            self.assertEqual(records.newest(file, "settings"), (1, b'{"name": "front"}'))
            self.assertEqual([records.read(file, area, "calibration").data for area in range(2)], [bytes(100_000)] * 2)
            self.assertIsNone(records.newest(file, "keys"))
            self.assertEqual([records.listed(file, area) for area in range(2)], [{"settings": 1, "calibration": 1}] * 2)
            file.seek(records.AREAS[1])
            file.write(records.record("settings", b"new", 2))
            self.assertEqual(records.newest(file, "settings"), (2, b"new"))
            file.seek(records.AREAS[1] + records.HEAD_BYTES)
            file.write(b"?")
            self.assertEqual(records.newest(file, "settings").generation, 1)
        self.assertGreaterEqual(records.AREAS[1] - records.AREAS[0] - sum(records.SIZES.values()), 4 * disk.MIB)
        self.assertGreaterEqual(records.AREAS[0], disk.SEED_AT + 4 * disk.MIB)
        with self.assertRaisesRegex(disk.DiskError, "are the most"):
            records.record("trial", bytes(records.SMALL))


class CommandLine(InFolder):
    def test_what_cannot_be_built_is_one_line(self):
        missing = self.folder / "none"
        for arguments, environment, said in (
                (["moon"], {}, "board moon has no image"), (["virt", "--camera", "film"], {}, "no camera film"),
                (["rpi5"], {}, "board rpi5 takes --kernel DIR"), (["rpi4", "--kernel", missing], {}, "no kernel"),
                (["virt"], {"SOURCE_DATE_EPOCH": "today"}, "SOURCE_DATE_EPOCH takes"),
                (["virt", "--stofd", missing], {}, "is missing: cmake --preset virt")):
            done = subprocess.run([sys.executable, "-B", ROOT / "scripts" / "image", *arguments, "--out", self.folder / "out"],
                                  env={**os.environ, **environment}, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(said, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertEqual(list(self.folder.iterdir()), [])

    def test_the_image_is_not_called_as_the_release_beside_it(self):
        done = subprocess.run([sys.executable, "-B", ROOT / "scripts" / "image", "virt", "--out", self.folder / "it.update"],
                              capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        self.assertIn("name the image otherwise", done.stderr)
        self.assertEqual(list(self.folder.iterdir()), [])


class Packages(InFolder):
    def setUp(self):
        super().setUp()
        self.plan = recipe.Recipe(ROOT, "rpi4", "imx296")
        self.assertEqual(pi_packages.make(self.folder, self.plan), VERSION)

    def tree(self):
        return recipe.KernelTree(self.folder, self.plan)

    def test_a_whole_set_is_taken(self):
        tree = self.tree()
        self.assertEqual(tree.version, VERSION)
        self.assertEqual(tree.boot_files(), {name: name.encode() for name in self.plan.files})
        self.assertEqual(gzip.decompress(tree.compressed()), IMAGE)
        names = [name for name, _ in tree.module_files()]
        self.assertNotIn("ext4", names)
        self.assertLess({"imx296", "bcm2835_unicam_legacy", "bcm2835_isp", "i2c_mux_pinctrl"}, set(names))

    def test_a_module_counts_by_any_name_that_kernels_have_it_by(self):
        modules = self.folder / f"usr/lib/modules/{VERSION}/kernel/drivers"
        (modules / "bcm2835-unicam-legacy.ko").unlink()
        (modules / "bcm2835-unicam.ko").write_bytes(pi_packages.module("bcm2835_unicam"))
        self.assertIn("bcm2835_unicam", [name for name, _ in self.tree().module_files()])
        (modules / "bcm2835-unicam.ko").unlink()
        with self.assertRaisesRegex(recipe.RecipeError, "lacks module bcm2835_unicam_legacy or bcm2835_unicam: unpack"):
            self.tree()

    def test_a_module_that_is_another_one_or_not_whole_is_refused(self):
        path = self.folder / f"usr/lib/modules/{VERSION}/kernel/drivers/imx296.ko"
        whole = pi_packages.module("imx296")
        cut = whole[:40] + (1000).to_bytes(8, "little") + whole[48:58] + b"\x40\0\2\0" + whole[62:]  # its sections are gone
        for data in (b"", b"text", pi_packages.module("other"), whole.replace(b"\xb7", b"\x3e"), cut):
            path.write_bytes(data)
            with self.assertRaisesRegex(kernel_modules.ModuleError, "not the whole module imx296 for 64-bit ARM"):
                self.tree().module_files()
        path.unlink()
        os.mkfifo(path)
        with self.assertRaisesRegex(kernel_modules.ModuleError, "is no file"):
            self.tree().module_files()

    def test_a_kernel_that_was_cut_is_refused(self):
        head = bytearray(512)
        head[:2], head[56:64], head[60:64] = b"MZ", b"ARM\x64\x40\0\0\0", (64).to_bytes(4, "little")
        head[64:72] = b"PE\0\0\x64\xaa\1\0"
        head[84:86] = (160).to_bytes(2, "little")
        head[88 + 144:88 + 152] = (2000).to_bytes(4, "little") + (100).to_bytes(4, "little")  # the signature
        head[88 + 160 + 16:88 + 160 + 24] = (1000).to_bytes(4, "little") + (512).to_bytes(4, "little")
        whole = bytes(head).ljust(2100, b"\1")
        for data in (whole, gzip.compress(whole)):
            self.file(f"boot/vmlinuz-{VERSION}", data)
            self.assertEqual(gzip.decompress(self.tree().compressed()), whole)
        for data, said in ((whole[:-1], "is cut"), (whole[:1600], "is cut"), (whole[:64], "is cut"), (whole[:100], "is cut"), (gzip.compress(whole)[:-30], "is damaged")):
            self.file(f"boot/vmlinuz-{VERSION}", data)
            with self.assertRaisesRegex(recipe.RecipeError, said):
                self.tree().compressed()

    def test_a_kernel_that_is_compressed_stays_as_it_is(self):
        packed = gzip.compress(IMAGE)
        self.file(f"boot/vmlinuz-{VERSION}", packed)
        self.assertEqual(self.tree().compressed(), packed)

    def test_a_kernel_that_cannot_start_a_slot_on_trial_is_known_by_its_words(self):
        self.assertFalse(self.tree().can_try())
        for data in (IMAGE + b" tryboot ", gzip.compress(IMAGE + b" tryboot ")):
            self.file(f"boot/vmlinuz-{VERSION}", data)
            self.assertTrue(self.tree().can_try())

    def test_whatever_is_missing_is_named_in_one_line(self):
        for path in (f"usr/lib/modules/{VERSION}/kernel/drivers/imx296.ko", "usr/lib/raspi-firmware/start4.elf",
                     f"usr/lib/linux-image-{VERSION}/overlays/imx296.dtbo"):
            (self.folder / path).unlink()
        with self.assertRaises(recipe.RecipeError) as raised:
            self.tree()
        line = str(raised.exception)
        self.assertIn("lacks module imx296, start4.elf, overlays/imx296.dtbo: unpack", line)
        self.assertNotIn("\n", line)

    def test_each_name_of_the_table_counts(self):
        for path in sorted(self.folder.rglob("*")):
            if path.is_file() and path.suffix in (".ko", ".elf", ".dat", ".dtb", ".dtbo"):
                data = path.read_bytes()
                path.unlink()
                with self.assertRaises(recipe.RecipeError, msg=path):
                    self.tree()
                path.write_bytes(data)
        self.tree()

    def test_a_kernel_of_another_board_or_two_of_this_one_are_refused(self):
        self.file("boot/vmlinuz-6.12.34+rpt-rpi-2712", IMAGE)
        self.assertEqual(self.tree().version, VERSION)
        self.file("boot/vmlinuz-6.6.1+rpt-rpi-v8", IMAGE)
        with self.assertRaisesRegex(recipe.RecipeError, "leave one of them"):
            self.tree()

    def test_what_is_no_kernel_is_refused(self):
        self.file(f"boot/vmlinuz-{VERSION}", b"MZ not for ARM" * 10)
        with self.assertRaisesRegex(recipe.RecipeError, "no kernel for 64-bit ARM"):
            self.tree().compressed()


class Disk(InFolder):
    def whole(self, name, seed=b"seed"):
        images = {part: self.folder / f"{name}.{part.label}" for part in disk.PARTITIONS}
        disk.fat(images[disk.BOOT], disk.BOOT, {"autoboot.txt": b"[all]\n"}, EPOCH)
        for slot, part in disk.SLOTS.items():
            disk.fat(images[part], part, {"cmdline.txt": slot.encode(), "licences/a long name.txt": b"x" * 9000}, EPOCH)
        disk.ext4(images[disk.SETTINGS], {"seed": seed}, EPOCH)
        disk.assemble(self.folder / name, images)
        return self.folder / name

    def test_partitions_do_not_overlap_and_begin_at_erase_blocks(self):
        found = disk.partitions(disk.mbr())
        self.assertEqual(found, [(part.type, part.begin, part.size) for part in disk.PARTITIONS])
        end = disk.SECTOR
        for _, begin, size in found:
            self.assertGreaterEqual(begin, end)
            self.assertEqual(begin % (4 * disk.MIB), 0)
            end = begin + size
        self.assertEqual(end, disk.SIZE)
        self.assertEqual([part.size for part in disk.SLOTS.values()], [64 * disk.MIB] * 2)
        self.assertEqual(disk.partitions(bytes(disk.SECTOR)), [])

    def test_two_of_the_same_files_are_equal_and_others_are_not(self):
        first = self.whole("first").read_bytes()
        self.assertTrue(first == self.whole("second").read_bytes())
        self.assertFalse(first == self.whole("third", b"other").read_bytes())

    def test_files_come_back(self):
        image = self.whole("image")
        self.assertEqual(disk.read_fat(image, disk.BOOT, "autoboot.txt"), b"[all]\n")
        self.assertEqual(disk.read_fat(image, disk.SLOTS["b"], "cmdline.txt"), b"b")
        self.assertEqual(disk.read_fat(image, disk.SLOTS["a"], "licences/a long name.txt"), b"x" * 9000)
        part = self.folder / f"image.{disk.SETTINGS.label}"
        self.assertEqual(disk.read_ext4(part, "seed"), b"seed")
        disk.add_to_ext4(part, {"seed": b"a new one", "label": b"code"})
        self.assertEqual((disk.read_ext4(part, "seed"), disk.read_ext4(part, "label")), (b"a new one", b"code"))
        self.assertIn(b"Mode:  0600", disk.run(["debugfs", "-R", "stat label", part]))
        disk.run(["e2fsck", "-fn", part])

    def test_what_is_not_empty_is_counted(self):
        path = self.file("some", bytes(disk.BLOCK) + b"\1" + bytes(3 * disk.BLOCK))
        self.assertEqual(disk.used_bytes(path), disk.BLOCK)

    def test_a_slot_that_is_too_full_is_told(self):
        with self.assertRaisesRegex(disk.DiskError, "mcopy failed"):
            disk.fat(self.folder / "boot", disk.BOOT, {"large": bytes(5 * disk.MIB)}, EPOCH)


class Arguments(InFolder):
    """scripts/image refuses in a line, before it builds anything."""

    def refused(self, *arguments, said, **words):
        done = subprocess.run([sys.executable, "-B", ROOT / "scripts" / "image", *arguments], text=True, capture_output=True, check=False,
                              env={**os.environ, **words})
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        self.assertIn(said, done.stderr)

    def test_what_is_wrong_is_told_in_one_line(self):
        self.refused("../board/virt", said="board ../board/virt has no image: use rpi4, rpi5, virt")
        for text in ("99999999999999999999", "4354819200", "-1", "now"):
            self.refused("virt", said="SOURCE_DATE_EPOCH takes", SOURCE_DATE_EPOCH=text)

    def test_keys_that_a_sensor_would_not_take_are_refused(self):
        good = b"0" * 64 + b"\n"
        self.assertEqual(update_file.read_public_keys(self.file("keys", good * 2)), good * 2)
        self.assertEqual(update_file.read_public_keys(self.file("bare", good[:-1])), good)
        for data in (b"", b"\n", b"zz\n", b"0" * 63, good + b"\n", b"\xff" * 64, good + b"0" * 65):
            with self.assertRaisesRegex(update_file.UpdateError, "64 hexadecimal digits a line"):
                update_file.read_public_keys(self.file("bad", data))
        with self.assertRaises(update_file.UpdateError):
            update_file.read_public_keys("/dev/zero")


class Archive(unittest.TestCase):
    def test_the_same_calls_give_the_same_bytes(self):
        def one():
            archive = cpio.Archive()
            archive.file("bin/a", b"1", 0o755)
            archive.node("dev/console", 5, 1)
            return archive.bytes()
        self.assertEqual(one(), one())


class Sbom(InFolder):
    def package(self, name, licence=b"see /usr/share/common-licenses/GPL-2."):
        self.file(f"usr/share/doc/{name}/changelog.Debian.gz", gzip.compress(b"busybox (1:1.37.0-6) unstable; urgency=low\n"))
        self.file(f"usr/share/doc/{name}/copyright", licence)
        return sbom.Package(self.folder, name, "BusyBox")

    def test_every_package_stands_in_it_with_version_text_and_source(self):
        files = sbom.files("stof-virt", "0.1.0", [self.package("busybox-static")], b"Apache", EPOCH)
        document = json.loads(files["sbom.spdx.json"])
        self.assertEqual(document["spdxVersion"], "SPDX-2.3")
        self.assertEqual(document["creationInfo"]["created"], "2023-11-14T22:13:20Z")
        names = {entry["SPDXID"]: entry for entry in document["packages"]}
        self.assertEqual(names["SPDXRef-busybox-static"]["versionInfo"], "1:1.37.0-6")
        self.assertEqual(names["SPDXRef-busybox-static"]["externalRefs"][0]["referenceLocator"],
                         "pkg:deb/debian/busybox@1%3A1.37.0-6?arch=source")
        related = {relation["relatedSpdxElement"] for relation in document["relationships"]}
        self.assertEqual(related, set(names))
        self.assertIn(b"busybox 1:1.37.0-6", files["sources.txt"])
        self.assertIn(b"common-licenses/GPL-2", files["licences/busybox-static.txt"])
        self.assertIn(b"GNU GENERAL PUBLIC LICENSE", files["licences/common/GPL-2.txt"])

    def test_a_signed_kernel_has_the_sources_of_the_kernel(self):
        self.package("linux-image")
        log = self.folder / "usr/share/doc/linux-image/changelog.Debian.gz"
        log.write_bytes(gzip.compress(b"linux-signed-arm64 (6.12.117+1) trixie-security; urgency=high\n"))
        self.assertEqual(sbom.Package(self.folder, "linux-image", "Linux").source, "linux")

    def test_a_package_without_its_licence_is_refused(self):
        self.package("busybox-static")
        (self.folder / "usr/share/doc/busybox-static/copyright").unlink()
        with self.assertRaisesRegex(sbom.SbomError, "no changelog and copyright"):
            sbom.Package(self.folder, "busybox-static", "BusyBox")


class UpdateFiles(InFolder):
    WORDS = {"board": "virt", "camera": "usb", "version": "1.0", "counter": 3}

    def test_a_key_is_drawn_once_for_its_owner_alone_and_signs_the_same_bytes(self):
        path = self.folder / "keys" / "update_key"
        key = update_file.Key.developers(path)
        self.assertEqual(path.stat().st_mode & 0o777, 0o600)
        again = update_file.Key.developers(path)
        self.assertEqual(key.public, again.public)
        content = bytes(range(256)) * 600
        self.assertEqual(update_file.make(content, key, **self.WORDS), update_file.make(content, again, **self.WORDS))

    def test_the_file_is_head_hashes_and_content_and_the_record_is_the_head(self):
        content = bytes(update_file.CHUNK) + b"end"
        file, record = update_file.make(content, update_file.Key(bytes(32)), letter_at=5, **self.WORDS)
        fields = update_file.HEAD.unpack_from(file)
        self.assertEqual(fields[:5], (update_file.MAGIC, 1, 0, update_file.CHUNK, b"virt".ljust(16, b"\0")))
        self.assertEqual(fields[7:10], (3, len(content), 5))
        self.assertEqual(file[update_file.HEAD_BYTES + 64:], content)
        self.assertEqual(record, file[:update_file.HEAD_BYTES].ljust(update_file.RECORD, b"\0"))
        # RFC 8032, section 7.1, has this public key for the seed of its first test.
        seed = bytes.fromhex("9d61b19deffd5a60ba844af492ec2cc44449c5697b326919703bac031cae7f60")
        self.assertEqual(update_file.Key(seed).public.hex(), "d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a")

    def test_what_is_no_key_or_no_name_is_one_line(self):
        with self.assertRaisesRegex(update_file.UpdateError, "64 hexadecimal digits"):
            update_file.Key.read(self.file("short", b"1234"))
        with self.assertRaisesRegex(update_file.UpdateError, "name the maker's key"):
            update_file.Key.read(self.folder / "none")
        for words in ({"board": "b" * 17}, {"board": ""}, {"version": "1\n2"}, {"version": " "}, {"camera": "usb\udcff"}):
            with self.assertRaisesRegex(update_file.UpdateError, "takes 1 to (16|32) bytes of printable text"):
                update_file.make(b"x", update_file.Key(bytes(32)), **(self.WORDS | words))
        for counter in (-1, 1 << 32):
            with self.assertRaisesRegex(update_file.UpdateError, f"counter {counter}: takes 0 to 4294967295"):
                update_file.make(b"x", update_file.Key(bytes(32)), **(self.WORDS | {"counter": counter}))

    def test_a_slot_keeps_its_end_free_of_files(self):
        path = self.folder / "slot"
        slot = disk.SLOTS["b"]
        disk.fat(path, slot, {"cmdline.txt": b"stof.slot=b\n"}, EPOCH)
        data = path.read_bytes()
        self.assertEqual(len(data), slot.size)
        sectors = int.from_bytes(data[32:36], "little")  # of the file system
        self.assertLessEqual(sectors * disk.SECTOR, slot.size - disk.RECORD)
        used = disk.used_part(path)
        self.assertLess(len(used), disk.MIB * 2)
        self.assertEqual(data, used.ljust(len(data), b"\0"))
        disk.put_record(path, b"R" * disk.RECORD)
        self.assertEqual(path.read_bytes(), data[:-disk.RECORD] + b"R" * disk.RECORD)


if __name__ == "__main__":
    unittest.main()
