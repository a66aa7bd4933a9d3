#!/usr/bin/env python3
"""tests/system/image_boot.py: the image that is flashed boots on QEMU's board, slot A and slot B, to frames.

Builds it twice (scripts/image virt), which must be equal, flashes it to a file (scripts/flash) with first settings, and
starts what the chooser of a boot ROM would: this program reads autoboot.txt of the first partition, and kernel, initramfs
and command line of that slot. Frames must be those of their edges, bit by bit, as in system_test.py. Two minutes.
"""

import argparse
import contextlib
import gzip
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import time

import boot_rom
import checks
import initramfs
import machine
import rig as system_rig

ROOT = initramfs.ROOT
sys.path.insert(0, str(ROOT / "scripts" / "imaging"))
import cpio  # noqa: E402
import disk  # noqa: E402
import recipe  # noqa: E402

sys.path.insert(0, str(ROOT / "tests" / "scripts"))
import pi_packages  # noqa: E402

FRAMES = 10
BUILD_BAR_S = 60.0
USED_BAR_MB = 60.0
NAME = "front sensor"
# How a slot is asked for, and how the sensor gets its address there.
STARTS = (("a", "all", "dhcp"), ("b", "tryboot", "10.0.2.15/24"))

FREE_PORTS, DHCP_CLIENT = 32768, {("UDP", "68")}
STATIC, BY_DHCP = "192.168.7.2/24", "10.0.2.15/24"  # the latter is what QEMU gives
MODULE_WORD = "uvcvideo.timeout=6000"  # any module that the image has
LISTENS = "0A"  # state of a TCP socket in /proc/net
# Half a minute after the start, when stofd listens and the address has come.
PROBE = """{
  usleep 30000000
  tell() { while read -r line; do echo "PROBE $1 $line"; done <"/proc/$2"; }
  tell mount mounts
  ip -4 addr show dev eth0 >/run/addresses
  tell address ../run/addresses
  for process in /proc/[0-9]*; do
    read -r name <"$process/comm"
    [ "$name" = stofd ] || continue
    ! grep -q /libcamera.so "$process/maps" || echo "PROBE library libcamera.so"
    ! grep -q LIBCAMERA_RPI_CONFIG_FILE=/libcamera_pipeline.json "$process/environ" || echo "PROBE environment pipeline"
    tell status "${process#/proc/}/status"
    for task in "$process"/task/*; do tell task "${task#/proc/}/stat"; done
  done
  tell parameter ../sys/module/uvcvideo/parameters/timeout
  for name in udp udp6 tcp tcp6 raw raw6; do [ ! -r /proc/net/$name ] || tell $name net/$name; done
  echo "PROBE end"
} >/dev/console &
"""

# Who stofd is in the image: a user of no capability, in the groups of a rig's devices (board/image/passwd, group).
STOF_ID = "900"
NO_CAPABILITY = "0" * 16
PRIVILEGES = {"Uid": [STOF_ID] * 4, "Gid": [STOF_ID] * 4, "Groups": "20 44 46 900 901 902".split(), "NoNewPrivs": ["1"],
              **{name: [NO_CAPABILITY] for name in ("CapInh", "CapPrm", "CapEff", "CapAmb")}}
SCHED_FIFO = "1"

# A card that lacks something, and what its console says of it.
LACKING = (("no_calibration", "no calibration on the settings partition"), ("no_settings", "no settings partition"))


def processor_s():
    """Of the programs that were started and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def built(work, report, camera="usb"):
    """Two builds of a kind of camera; the path of the first."""
    images = [work / f"{camera}_first.img", work / f"{camera}_second.img"]
    for image in images:
        image.unlink(missing_ok=True)
        begin, used = time.monotonic(), processor_s()
        subprocess.run([ROOT / "scripts" / "image", "virt", "--camera", camera, "--out", image], check=True)
        report.at_most("build of the image, processor time", processor_s() - used, BUILD_BAR_S, "s")
        report.figure("build of the image", f"{time.monotonic() - begin:.0f} s", "told: this machine may be busy", True)
    same = images[0].read_bytes() == images[1].read_bytes()
    report.figure("two builds", "equal" if same else "different", "equal, byte for byte", same)
    report.at_most("what is not empty", disk.used_bytes(images[0]) / 1e6, USED_BAR_MB, "MB")
    return images[0]


def flashed(image, card, port, address, *more):
    """The image on a file as large, with the options of the system test's rig. What was said."""
    card.unlink(missing_ok=True)
    with open(card, "wb") as file:
        file.truncate(disk.SIZE)
    words = ["--to", f"{system_rig.HOST}:{port}", *system_rig.RIG_OPTIONS]
    done = subprocess.run([ROOT / "scripts" / "flash", image, card, "--yes", "--name", NAME, "--address",
                           address, *(f"--option={word}" for word in words), *more], check=True, text=True,
                          stdout=subprocess.PIPE)
    return done.stdout


def seed_of(card):
    """The random seed of the next start."""
    begin = disk.SETTINGS.begin + disk.SEED_AT
    return card[begin:begin + disk.SEED_BYTES]


def gives_no_depth(scene, image, work, report, name, said):
    """A card without a calibration, or without a settings partition: stofd says why, and there is nothing to be trusted."""
    folder = work / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    port, card = machine.free_udp_port(), folder / "card.img"
    flashed(image, card, port, "dhcp")
    if name == "no_settings":
        with open(card, "r+b") as file:
            file.seek(disk.SETTINGS.begin)
            file.write(bytes(disk.SETTINGS.size))
    boot, words = boot_rom.loaded(card, "a", folder)
    with system_rig.Rig(scene, None, folder, boot=boot, port=port, command_line=words, drive=card) as rig:
        rig.machine.console.plain(said)
        rig.machine.console.plain("stofd ended with 2")
        report.none(f"{name}: frames", rig.receiver.count())


def starts_without_words_that_it_refuses(scene, image, work):
    folder = work / "words"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    card = folder / "card.img"
    flashed(image, card, machine.free_udp_port(), "dhcp", "--calibration", scene.calibration, "--option=--threads", "--option=99")
    boot, words = boot_rom.loaded(card, "a", folder)
    with machine.Machine(*boot, command_line=words, drive=card, log=folder / "console.log") as guest:
        guest.go()
        # Without its words it has cameras of another size than the calibration.
        for said in ("--threads: compute.threads: takes 0 to 8", "stofd starts without the words of the card", "made for cameras of 320x240"):
            guest.console.plain(said, timeout=120)


def documented_ports():
    """{(protocol, port)} of the table in docs/HARDWARE.md."""
    text = (ROOT / "docs" / "HARDWARE.md").read_text()
    return set(re.findall(r"^\| (UDP|TCP) (\d+) \|", text[text.index("## What listens"):], re.MULTILINE))


def with_probe(initramfs_file):
    """The initramfs with an init that tells on the console what is mounted and what listens; all else is the image's."""
    text = (ROOT / "board" / "image" / "init").read_text()
    place = 'say "slot $slot, kernel'
    checks.check(text.count(place) == 1, "board/image/init begins otherwise")
    archive = cpio.Archive()
    archive.file("init", text.replace(place, PROBE + place).encode(), 0o755)
    archive.file("libcamera_pipeline.json", b"{}")  # as kinds of camera have it whose pipeline asks for one
    data = initramfs_file.read_bytes()
    initramfs_file.write_bytes(data + bytes(-len(data) % 4) + gzip.compress(archive.bytes(), mtime=0))


def has_no_privileges(told, report):
    """stofd's process as the probe saw it."""
    status = {words[0].rstrip(":"): words[1:] for kind, *words in told if kind == "status"}
    found = {name: status.get(name) for name in PRIVILEGES}
    report.figure("privileges of stofd", found, f"{PRIVILEGES}", found == PRIVILEGES)
    report.figure("its locked memory", " ".join(status.get("VmLck", [])), "> 0 kB", int(status.get("VmLck", ["0"])[0]) > 0)
    # After "PID (NAME) ": field 3 on; 41 is the policy.
    policies = [" ".join(words).rpartition(") ")[2].split()[38] for kind, *words in told if kind == "task"]
    report.figure("policies of its threads", policies, "SCHED_FIFO among them", SCHED_FIFO in policies)


def nothing_more_is_open(scene, image, work, report, by_libcamera=False):
    """What the guest has mounted to be written, and which ports are open: the documented ones."""
    folder = work / "open"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    card = folder / "card.img"
    flashed(image, card, machine.free_udp_port(), "dhcp", "--address", STATIC, "--calibration", scene.calibration,
            "--option=--set", "--option=discovery.mdns=true")
    boot, words = boot_rom.loaded(card, "a", folder)
    with_probe(boot[1])
    with machine.Machine(*boot, command_line=f"{words} {MODULE_WORD}", drive=card, log=folder / "console.log") as guest:
        guest.go()
        guest.console.plain("listening at UDP port", timeout=120)
        guest.console.plain("PROBE end", timeout=120)
        told = [line.split()[1:] for line in guest.console.other if line.startswith("PROBE ")]
    addresses = [words[1] for kind, *words in told if kind == "address" and words[0] == "inet"]
    report.figure("addresses", sorted(addresses), "by DHCP and the one that was named", sorted(addresses) == sorted((BY_DHCP, STATIC)))
    mounts = [words for kind, *words in told if kind == "mount"]
    checks.check(any(words[0] == "/dev/vda4" for words in mounts), "the probe saw no settings partition")
    writable = [words[1] for words in mounts if "rw" in words[3].split(",") and (words[0].startswith("/dev/") or words[1] == "/")]
    report.figure("partitions mounted to be written, and the root", writable, "none", not writable)
    has_no_privileges(told, report)
    report.figure("libcamera in stofd", ["library", "libcamera.so"] in told, by_libcamera, (["library", "libcamera.so"] in told) == by_libcamera)
    report.figure("pipeline's file in the environment", ["environment", "pipeline"] in told, True, ["environment", "pipeline"] in told)
    parameter = next((words[0] for kind, *words in told if kind == "parameter"), None)
    report.figure(f"parameter of a module by {MODULE_WORD}", parameter, MODULE_WORD.partition("=")[2], parameter == MODULE_WORD.partition("=")[2])
    ports = set()
    for kind, *words in told:
        if kind in ("udp", "udp6", "tcp", "tcp6") and words[0] != "sl" and (kind.startswith("udp") or words[3] == LISTENS):
            ports.add((kind[:3].upper(), str(int(words[1].rpartition(":")[2], 16))))
        checks.check(kind not in ("raw", "raw6") or words[0] == "sl", f"a raw socket is open: {words}")
    wanted = documented_ports()
    beacon = {port for port in ports if int(port[1]) >= FREE_PORTS}  # another one at each start
    same = len(beacon) == 1 and (ports - beacon) | DHCP_CLIENT == wanted
    report.figure("open ports", sorted(ports), f"{sorted(wanted)}, the beacon's, and that of DHCP not all the time", same)


def slot_starts(scene, image, work, report, slot, section, address):
    folder = work / f"slot_{slot}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    port, card = machine.free_udp_port(), folder / "card.img"
    said = flashed(image, card, port, address, "--calibration", scene.calibration)
    checks.check(re.search(r"^([0-9a-f]{4}-){7}[0-9a-f]{4}$", said, re.MULTILINE) is not None, "flash told no code")
    found = boot_rom.chosen(card, section)
    report.figure(f"slot of a start by [{section}]", found, slot, found == slot)
    boot, words = boot_rom.loaded(card, found, folder)
    before = card.read_bytes()
    with system_rig.Rig(scene, None, folder, boot=boot, port=port, command_line=words, drive=card) as rig:
        try:
            frame = rig.receiver.wait(lambda frame: frame["missing"] == 0 and frame["depth"], timeout=90, what="frame")
            at = (frame["middle_ns"] + frame["latency_ns"]) * 1e-9
            report.figure(f"slot {slot}: kernel's start to the first frame, guest time", f"{at:.2f} s", "told", True)
            for _ in range(FRAMES):  # how many of the edges give one is for system_test.py
                rig.receiver.wait(lambda frame: frame["missing"] == 0 and frame["sensors"] == system_rig.BOTH,
                                  rig.receiver.count(), what="next frame of both sensors")
            verdict = rig.judge(rig.receiver.frames)
            report.none(f"slot {slot}: frames that are not of their edge", verdict["mispaired"])
            report.none(f"slot {slot}: frames that differ from the host's", verdict["different"])
            report.figure(f"slot {slot}: frames equal to the host's", len(verdict["steps"]) - verdict["of_one"], f">= {FRAMES}",
                          len(verdict["steps"]) - verdict["of_one"] >= FRAMES)
            subscriber = system_rig.Receiver(scene.receive, "--sensor", f"127.0.0.1:{rig.machine.port}")
            with contextlib.closing(subscriber):
                subscriber.wait(lambda frame: frame["missing"] == 0, timeout=20, what="frame by subscription")
        finally:
            log = rig.machine.console.other
            print("  " + "\n  ".join(log[:12]))
        checks.check(any(f"slot {slot}, kernel" in line for line in log), "the supervisor says another slot")
    after = card.read_bytes()
    # A start on trial may have been confirmed meanwhile: then autoboot.txt names it.
    kept = [*disk.SLOTS.values(), *([disk.BOOT] if section == "all" else [])]
    same = all(before[p.begin:p.begin + p.size] == after[p.begin:p.begin + p.size] for p in kept)
    report.figure(f"slot {slot}: what is not written after it ran", "unchanged" if same else "changed", "unchanged",
                  same and before[:disk.BOOT.begin] == after[:disk.BOOT.begin])
    seeds = [seed_of(card) for card in (before, after)]
    checks.check(any(seeds[1]) and seeds[0] != seeds[1], "the next start has the same random seed")


def pi_image(work, report, board):
    """An image of a stand-in of Raspberry Pi's packages: what a boot ROM would read of its slots. Nothing of it runs."""
    packages = work / f"packages_{board}"
    shutil.rmtree(packages, ignore_errors=True)
    pi_packages.make(packages, recipe.Recipe(ROOT, board, "imx296"))
    out = work / f"{board}.img"
    # Of another board, because it never runs here.
    command = [ROOT / "scripts" / "image", board, "--kernel", packages, "--out", out, "--stofd", ROOT / "build/virt/bin/stofd"]
    subprocess.run(command, check=True)
    plan = recipe.Recipe(ROOT, board, "usb")
    for slot, part in disk.SLOTS.items():
        config = disk.read_fat(out, part, "config.txt").decode().splitlines()
        checks.check(config == plan.config, f"slot {slot}: config.txt has {config}")
        words = disk.read_fat(out, part, "cmdline.txt").decode().split()
        checks.check(f"stof.slot={slot}" in words, f"slot {slot}: cmdline.txt has {words}")
        for name in plan.files:
            checks.check(disk.read_fat(out, part, name) == name.encode(), f"slot {slot}: {name} is another file")
    report.at_most(f"what is not empty for {board}", disk.used_bytes(out) / 1e6, USED_BAR_MB, "MB")
    (packages / "boot" / f"vmlinuz-6.12.34+rpt{plan.flavour}").unlink()
    refused = subprocess.run(command, capture_output=True, text=True, check=False)
    checks.check(refused.returncode == 2 and refused.stderr.count("\n") == 1 and "no kernel" in refused.stderr,
                 f"no kernel: {refused.stderr}")


def run(options):
    work = pathlib.Path(options.work)
    work.mkdir(parents=True, exist_ok=True)
    report = checks.Report()
    scene = system_rig.Scene(options.programs, work.parent / "scenes")
    images = []

    def case(name, function, *arguments):
        if not options.case or name in options.case:
            report.run(name, function, *arguments)

    report.run("built", lambda: images.append(built(work, report)))
    for image in images:
        for slot, section, address in STARTS:
            case(f"slot_{slot}", slot_starts, scene, image, work, report, slot, section, address)
        case("open", nothing_more_is_open, scene, image, work, report)
        case("words", starts_without_words_that_it_refuses, scene, image, work)
        for name, said in LACKING:
            case(name, gives_no_depth, scene, image, work, report, name, said)
    for board in ("rpi4", "rpi5"):
        case(f"image_{board}", pi_image, work, report, board)
    print(f"{report.passed} passed, {report.failed} failed")
    return 1 if report.failed or not report.passed else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", default=ROOT / "build/emu/bin", help="this machine's stofd and test programs")
    parser.add_argument("--work", default=ROOT / "build/system/image")
    parser.add_argument("--case", action="append", help="only these: slot_a, slot_b, open, words, no_calibration, no_settings, image_rpi4, image_rpi5")
    options = parser.parse_args()
    for name in ("stofd", "stof_system_frames"):
        if not (pathlib.Path(options.programs) / name).exists():
            sys.exit(f"image_boot: {options.programs}/{name} is missing: cmake --preset emu && cmake --build --preset emu "
                     "--target stof_system_tools stofd")
    with contextlib.suppress(PermissionError):
        os.nice(-10)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    return run(options)


if __name__ == "__main__":
    sys.exit(main())
