#!/usr/bin/env python3
"""tests/system/image_network.py: what the image takes over the network is kept: its addresses and its calibration.

Flashes the image of scripts/image virt to a file, puts settings.json on its boot partition, which the first start takes, pairs with
the label's code, and then, by stof config:
- a fixed address beside that of DHCP is saved, and kept over a restart of the board;
- an address at which nobody reaches the sensor is taken back after a minute, and told;
- another calibration (stof calib install) holds, also after a restart; --factory brings back that of the card.
QEMU's network leads to the address that its DHCP server gives, and to no other. Five minutes.
"""

import json
import pathlib
import struct
import subprocess
import sys
import time
import types

import boot_rom
import checks
import image_boot
import image_update
import initramfs
import machine
import rig as system_rig

import disk  # of scripts/imaging, which initramfs names

ROOT = initramfs.ROOT
sys.path.insert(0, str(ROOT / "host" / "python"))
import stof_wire as wire  # noqa: E402

BASELINE_AT = 96  # of a calibration file, docs/WIRE.md
BY_DHCP = image_boot.BY_DHCP
NAME = "front sensor"
FIRST, KEPT, LOST = "192.168.7.2/24", "192.168.7.3/24", "192.168.9.9/24"
PATIENCE_S = 180  # a minute of guest time on a busy machine


def lines_with(guest, word):
    return [line for line in list(guest.console.other) if word in line]


def wait_for(guest, word, count, timeout=PATIENCE_S):
    """Until the console has said it so often."""
    end = time.monotonic() + timeout
    while len(lines_with(guest, word)) < count:
        checks.check(time.monotonic() < end, f"the console did not say {word!r} {count} times, but " + "\n".join(guest.console.other[-8:]))
        time.sleep(0.1)


def flashed(image, card, calibration):
    """Without first settings of scripts/flash; those that any computer can put there. What was said."""
    with open(card, "wb") as file:
        file.truncate(disk.SIZE)
    done = subprocess.run([ROOT / "scripts" / "flash", image, card, "--yes", "--calibration", calibration,
                           *(f"--option={word}" for word in system_rig.RIG_OPTIONS)], check=True, text=True, stdout=subprocess.PIPE)
    settings = card.with_name("settings.json")
    settings.write_text(json.dumps({"name": NAME, "network": {"address": FIRST, "hostname": "front-7"}}) + "\n")
    disk.run(["mcopy", "-i", f"{card}@@{disk.BOOT.begin}", settings, "::settings.json"])
    return done.stdout


class Sensor:
    """A card in the machine without cameras, and its owner; started anew by start()."""

    def __init__(self, options, scene, image, work):
        self.work, self.card = work, work / "card.img"
        self.host_port = machine.free_udp_port()
        self.factory = scene.calibration
        self.code = image_update.file_of_code(flashed(image, self.card, scene.calibration), work)
        self.owner = image_update.Owner(options.programs, work, types.SimpleNamespace(host_port=self.host_port))

    def start(self):
        boot, words = boot_rom.loaded(self.card, "a", self.work)
        guest = machine.Machine(*boot, command_line=words, drive=self.card, host_port=self.host_port, log=self.work / "console.log")
        guest.go()
        return guest

    def config(self, *words):
        return self.owner.run("config", self.owner.place, *words, "--timeout", 5)

    def address(self):
        done = self.config("get", "network.address")
        return done.stdout.strip().strip('"') if done.returncode == 0 else None


def reaches(sensor, report, what, wanted):
    end = time.monotonic() + PATIENCE_S
    while (found := sensor.address()) is None and time.monotonic() < end:
        time.sleep(1)
    report.figure(what, found, wanted, found == wanted)


def first_start(sensor, guest, report):
    wait_for(guest, f"address {FIRST}", 1)
    wait_for(guest, f"address {BY_DHCP}", 1)
    done = sensor.owner.run("pair", sensor.owner.place, "--code", f"@{sensor.code}", timeout=120)
    checks.check(done.returncode == 0, "not paired")
    reaches(sensor, report, "address of the first settings", FIRST)
    report.figure("name of the first settings", sensor.config("get", "name").stdout.strip(), NAME, NAME in sensor.config("get", "name").stdout)


def kept(sensor, guest, report):
    done = sensor.config("set", f"network.address={KEPT}")
    checks.check(done.returncode == 0 and "for one minute" in done.stdout + done.stderr, "the trial is not told")
    early = sensor.config("save")
    if early.returncode == 0:  # so slow a machine has it in force already
        print("  saved at once")
    else:
        checks.check("not in force yet" in early.stdout + early.stderr, f"save: {early.stderr}")
    wait_for(guest, f"address {KEPT}", 1)
    wait_for(guest, f"address {BY_DHCP}", 2)
    end = time.monotonic() + 60
    while sensor.config("save").returncode != 0:
        checks.check(time.monotonic() < end, "it cannot be saved")
        time.sleep(1)
    reaches(sensor, report, "address that was saved", KEPT)


def taken_back(sensor, guest, report):
    before = len(lines_with(guest, f"address {BY_DHCP}"))
    done = sensor.config("set", "network.dhcp=false", f"network.address={LOST}")
    checks.check(done.returncode == 0, "set was refused")
    wait_for(guest, f"address {LOST}", 1)
    report.figure("reached at an address of another network", sensor.address(), "not at all", sensor.address() is None)
    wait_for(guest, "network is as before, because nobody saved its change in time", 1)
    wait_for(guest, f"address {BY_DHCP}", before + 1)
    reaches(sensor, report, "address of before", KEPT)
    wrong = sensor.config("set", "network.address=192.168.7.3")
    said = (wrong.stdout + wrong.stderr).strip()
    report.figure("a wrong address", said, "one line that names what it takes", wrong.returncode != 0 and "\n" not in said and
                  "network.address: takes an address" in said)


def fingerprint(file):
    """Of a calibration file: its last four bytes."""
    return f"{struct.unpack('<I', pathlib.Path(file).read_bytes()[-4:])[0]:08x}"


def remeasured(file, out):
    """The calibration with a baseline that is 1 percent longer."""
    data = bytearray(pathlib.Path(file).read_bytes())
    struct.pack_into("<d", data, BASELINE_AT, 1.01 * struct.unpack_from("<d", data, BASELINE_AT)[0])
    struct.pack_into("<I", data, len(data) - 4, wire.crc32c(bytes(data[:-4])))
    out.write_bytes(data)
    return out


def takes_calibration(sensor, report, what, words, wanted):
    """stof calib install: which one is in force now, and which one was."""
    done = sensor.owner.run("calib", "install", *words, sensor.owner.place, "--timeout", 5, "--json")
    checks.check(done.returncode == 0, f"{what} was refused")
    said = json.loads(done.stdout)
    found = (said["calibration"], said["former"])
    report.figure(f"{what}: calibration in force, and before", found, wanted, found == wanted)


def installed(sensor, guest, report):
    file = remeasured(sensor.factory, sensor.work / "remeasured.cal")
    takes_calibration(sensor, report, "installed", [file], (fingerprint(file), fingerprint(sensor.factory)))
    wait_for(guest, f"calibration {fingerprint(file)} in place of {fingerprint(sensor.factory)}", 1)


def after_a_restart(sensor, guest, report):
    wait_for(guest, f"address {KEPT}", 1)
    reaches(sensor, report, "address after a restart", KEPT)
    wait_for(guest, "the calibration is the installed one", 1)
    takes_calibration(sensor, report, "factory's", ["--factory"],
                      (fingerprint(sensor.factory), fingerprint(sensor.work / "remeasured.cal")))


def run(options):
    work, report, scene, image = image_update.begun(options)
    sensor = Sensor(options, scene, image, work)
    with sensor.start() as guest:
        if report.run("first_start", first_start, sensor, guest, report):
            report.run("kept", kept, sensor, guest, report)
            report.run("taken_back", taken_back, sensor, guest, report)
            report.run("installed", installed, sensor, guest, report)
        print("  " + "\n  ".join(guest.console.other))
    with sensor.start() as guest:
        report.run("after_a_restart", after_a_restart, sensor, guest, report)
    return image_update.ended(report)


def main():
    return run(image_update.arguments(__doc__, "network").parse_args())


if __name__ == "__main__":
    sys.exit(main())
