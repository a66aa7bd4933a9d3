#!/usr/bin/env python3
"""tests/system/image_libcamera.py: the image for cameras by libcamera, in QEMU: both slots to frames, and what Raspberry Pis get.

As image_boot.py, with the kind usb-libcamera of board virt: libcamera's pipeline of USB cameras, stofd as the user stof. An
update file of the kind usb is refused. For imx296 the images of rpi4 and rpi5 are built of stand-ins of Raspberry Pi's packages,
and the program starts with the libraries and the module of the former alone. Four minutes.
"""

import contextlib
import os
import pathlib
import shutil
import subprocess
import sys

import boot_rom
import cases
import checks
import image_boot
import image_update
import initramfs
import machine
import rig as system_rig

import disk  # of scripts/imaging, which initramfs names
import libcamera
import recipe

sys.path.insert(0, str(initramfs.ROOT / "tests" / "scripts"))
import pi_libraries  # noqa: E402
import pi_packages  # noqa: E402

ROOT = initramfs.ROOT
KIND = "usb-libcamera"
PROGRAM = ROOT / "build" / "virt" / "bin" / "stofd-libcamera"
BACK_BAR_S = 15.0  # a shell gives the devices to stofd, libcamera looks at all of them again; this machine may be busy
LIBRARIES = pi_libraries.LIBRARIES


def other_kind_is_refused(scene, image, work, report, programs):
    """A release of the same board for USB cameras by V4L2: refused with a line, and nothing is written."""
    folder = work / "other_kind"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    other, card, port = folder / "usb.img", folder / "card.img", machine.free_udp_port()
    subprocess.run([ROOT / "scripts" / "image", "virt", "--out", other], check=True)
    said = image_boot.flashed(image, card, port, "dhcp", "--calibration", scene.calibration)
    code = image_update.file_of_code(said, folder)
    with boot_rom.Board(scene, card, folder, port) as board:
        _, rig = board.wait_for_start(0)
        image_update.frames_come(rig, report, "the kind usb-libcamera")
        owner = image_update.Owner(programs, folder, board)
        checks.check(owner.run("pair", owner.place, "--code", f"@{code}", timeout=120).returncode == 0, "not paired")
        done = owner.update(other.with_suffix(".update"))
        line = f"virt with camera usb, this one is virt with {KIND}"
        report.figure("update file of another kind", done.returncode, f"2, and {line!r}", done.returncode == 2 and line in done.stdout + done.stderr)
        image_update.frames_come(rig, report, "the kind usb-libcamera, after that")
        report.figure("starts", len(board.starts), "1", len(board.starts) == 1)


def cameras_come_back(scene, image, work, report):
    """Unplugged and plugged in: the image gives the user stof the new devices, and libcamera takes them for ready."""
    folder = work / "come_back"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    card, port = folder / "card.img", machine.free_udp_port()
    image_boot.flashed(image, card, port, "dhcp", "--calibration", scene.calibration)
    boot, words = boot_rom.loaded(card, "a", folder)
    with system_rig.Rig(scene, None, folder, boot=boot, port=port, command_line=words, drive=card) as rig:
        for name in rig.cameras:
            image_update.frames_come(rig, report, f"before the {name} camera is unplugged")
            cases.replug(rig, report, name, BACK_BAR_S)


def pi_image(work, board, *more):
    """(scripts/image's end, the image, {name: bytes} of its initramfs) for imx296, of a stand-in of Raspberry Pi's kernel."""
    packages = work / f"packages_{board}"
    shutil.rmtree(packages, ignore_errors=True)
    pi_packages.make(packages, recipe.Recipe(ROOT, board, "imx296"))
    out = work / f"{board}.img"
    out.unlink(missing_ok=True)
    done = subprocess.run([ROOT / "scripts" / "image", board, "--camera", "imx296", "--kernel", packages, "--out", out, *more],
                          capture_output=True, text=True, check=False)
    print("  " + (done.stdout + done.stderr).strip())
    slot = disk.SLOTS["a"]
    return done, out, pi_packages.packed(disk.read_fat(out, slot, "initramfs")) if done.returncode == 0 else {}


def has_what_imx296_needs(out, files, board, report):
    """Of a built image: lines of config.txt and cmdline.txt, kernel modules, options, libcamera's own, and who is told of."""
    plan = recipe.Recipe(ROOT, board, "imx296")
    config = disk.read_fat(out, disk.SLOTS["b"], "config.txt").decode().splitlines()
    words = disk.read_fat(out, disk.SLOTS["b"], "cmdline.txt").decode().split()
    checks.check(config == plan.config and "dtoverlay=imx296,cam0" in config, f"config.txt has {config}")
    checks.check("imx296.trigger_mode=1" in words, f"cmdline.txt has {words}")
    checks.check(disk.read_fat(out, disk.SLOTS["b"], "overlays/imx296.dtbo") == b"overlays/imx296.dtbo", "the overlay is another file")
    modules = files["modules"].decode().split()
    wanted = [names.split("|")[0] for names in plan.modules if names not in pi_packages.BUILT_IN]
    checks.check(sorted(modules) == sorted(wanted), f"modules: {modules}")
    checks.check(all(f"modules.d/{name}.ko" in files for name in modules), "a module is missing")
    checks.check(files["options"] == b"--cameras\nlibcamera\n", f"options: {files['options']}")
    lacking = [name for name in (*plan.libcamera["files"], libcamera.PIPELINE_FILE, "usr/lib/ld-linux-aarch64.so.1") if name not in files]
    checks.check(not lacking and files["lib"] == b"usr/lib", f"lacks {lacking}")
    told = disk.read_fat(out, disk.SLOTS["b"], "sbom.spdx.json").decode()
    for package in ("libcamera-ipa", "libgnutls30t64", "libc6"):
        checks.check(f'"licences/{package}.txt"' in told, f"the SBOM does not name {package}")
        checks.check(disk.read_fat(out, disk.SLOTS["b"], f"licences/{package}.txt"), f"no licence of {package}")
    report.at_most(f"what is not empty for {board}", disk.used_bytes(out) / 1e6, image_boot.USED_BAR_MB, "MB")


def image_rpi4(work, report):
    """Of Debian's libcamera, which is the real one."""
    _, out, files = pi_image(work, "rpi4", "--stofd", PROGRAM)
    has_what_imx296_needs(out, files, "rpi4", report)
    root = work / "root_rpi4"
    shutil.rmtree(root, ignore_errors=True)
    for name, data in files.items():
        if ".so" in name or name == "bin/stofd":
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_bytes(data)
    (root / "lib").symlink_to("usr/lib")
    (root / "bin" / "stofd").chmod(0o755)
    # With the module that libcamera would load, and every name that it and all libraries ask for.
    module = f"/{LIBRARIES}/libcamera/ipa_rpi_vc4.so"

    def start(preload):
        return subprocess.run(["qemu-aarch64", "-L", root, "-E", "LD_BIND_NOW=1", "-E", f"LD_PRELOAD={preload}", root / "bin" / "stofd",
                               "--help"], capture_output=True, text=True, check=False)

    done = start(module)
    report.figure("the program of rpi4 with its module", done.returncode, "0", done.returncode == 0 and not done.stderr)
    checks.check("cannot be preloaded" in start(f"{module}.none").stderr, "a module that is not there is not missed")


def image_rpi5(work, report):
    """Debian's libcamera has no pipeline for it: refused with a line; with a stand-in of Raspberry Pi's it is built."""
    done, _, _ = pi_image(work, "rpi5", "--stofd", PROGRAM)
    report.figure("rpi5 with Debian's libcamera ends with", done.returncode, "2, one line that names the module",
                  done.returncode == 2 and done.stderr.count("\n") == 1 and "ipa_rpi_pisp.so" in done.stderr)
    folder = work / "libraries_rpi5"
    shutil.rmtree(folder, ignore_errors=True)
    program = work / "stofd-libcamera"
    program.write_bytes(pi_libraries.make(folder, recipe.Recipe(ROOT, "rpi5", "imx296"), "0.6", "libcamera/ipa"))
    _, out, files = pi_image(work, "rpi5", "--stofd", program, "--libraries", folder)
    has_what_imx296_needs(out, files, "rpi5", report)
    checks.check(f"{LIBRARIES}/libcamera.so.0.6" in files and f"{LIBRARIES}/libcamera/ipa/ipa_rpi_pisp.so.sign" in files,
                 "it is not of the folder that was named")


def run(options):
    work = pathlib.Path(options.work)
    work.mkdir(parents=True, exist_ok=True)
    report = checks.Report()
    scene = system_rig.Scene(options.programs, work.parent / "scenes")
    images = []

    def case(name, function, *arguments):
        if not options.case or name in options.case:
            report.run(name, function, *arguments)

    report.run("built", lambda: images.append(image_boot.built(work, report, KIND)))
    for image in images:
        for slot, section, address in image_boot.STARTS:
            case(f"slot_{slot}", image_boot.slot_starts, scene, image, work, report, slot, section, address)
        case("open", image_boot.nothing_more_is_open, scene, image, work, report, True)
        case("come_back", cameras_come_back, scene, image, work, report)
        case("other_kind", other_kind_is_refused, scene, image, work, report, options.programs)
    case("image_rpi4", image_rpi4, work, report)
    case("image_rpi5", image_rpi5, work, report)
    return image_update.ended(report)


def main():
    parser = image_update.arguments(__doc__, "image_libcamera")
    parser.add_argument("--case", action="append", help="only these: slot_a, slot_b, open, come_back, other_kind, image_rpi4, image_rpi5")
    options = parser.parse_args()
    with contextlib.suppress(PermissionError):
        os.nice(-10)
    return run(options)


if __name__ == "__main__":
    sys.exit(main())
