"""Stands for the boot ROM of a board: which slot of a card a start takes, what it loads of it, and the start after a restart."""

import configparser
import threading
import time

import initramfs
import machine
import rig as system_rig

import disk  # of scripts/imaging, which initramfs names

TRIAL = "restart, trial"  # what init says before it asks for the other slot once
RESTART_S = 300  # a trial ends within 72 s of guest time


def chosen(image, section):
    """The slot that autoboot.txt of the image names, for a usual start (all) or for one on trial (tryboot)."""
    text = disk.read_fat(image, disk.BOOT, "autoboot.txt").decode().rstrip("\0")
    parser = configparser.ConfigParser()
    parser.read_string(text)
    number = parser.getint(section, "boot_partition")
    return {disk.PARTITIONS.index(part) + 1: slot for slot, part in disk.SLOTS.items()}[number]


def loaded(card, slot, folder):
    """What a boot loader reads of a slot: files of kernel and initramfs, the command line."""
    files = [folder / name for name in ("kernel8.img", "initramfs")]
    for file in files:
        file.write_bytes(disk.read_fat(card, disk.SLOTS[slot], file.name))
    return files, disk.read_fat(card, disk.SLOTS[slot], "cmdline.txt").decode().strip()


class Board:
    """A card in the machine, with the rig's cameras, started as often as it restarts; until close().

    starts: (slot, section of autoboot.txt) of each start. logs: what is written is logged. port: where the program sends all packets; host_port leads to
    the sensor's.
    """

    def __init__(self, scene, card, folder, port, logs=False):
        self.scene, self.card, self.folder, self.port = scene, card, folder, port
        self.host_port = machine.free_udp_port()
        self.logs = logs
        self.starts, self.consoles = [], []
        self.rig = None
        self.why = None  # it does not start any more
        self.over = False
        self.meanwhile = None
        self.changed = threading.Condition()
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def _run(self):
        section = "all"
        try:
            while not self.over:
                section = self._start(section)
                if self.meanwhile:
                    self.meanwhile(self.card)
                    self.meanwhile, section = None, "all"
        except Exception as error:  # told to whoever waits
            self.why = f"{type(error).__name__}: {error}"
        with self.changed:
            self.changed.notify_all()

    def _start(self, section):
        """One start; the section of the next one."""
        slot = chosen(self.card, section)
        boot, words = loaded(self.card, slot, self.folder)
        with system_rig.Rig(self.scene, None, self.folder, boot=boot, port=self.port, command_line=words, drive=self.card,
                            host_port=self.host_port, watchdog="reset", drive_log=self.log_of(len(self.starts))) as rig:
            with self.changed:
                self.rig = rig
                self.starts.append((slot, section))
                self.consoles.append(rig.machine.console)
                self.changed.notify_all()
            while not self.over and rig.machine.process.poll() is None:
                time.sleep(0.05)
            return "tryboot" if any(TRIAL in line for line in rig.machine.console.other) else "all"

    def wait_for_start(self, number, timeout=RESTART_S):
        """(slot, section) of the start of that number, from 0 on, and its rig."""
        end = time.monotonic() + timeout
        with self.changed:
            while len(self.starts) <= number:
                if self.why or time.monotonic() > end:
                    raise machine.MachineError(f"start {number} did not come in {timeout} s: {self.why or self.starts}")
                self.changed.wait(1)
            return self.starts[number], self.rig

    def log_of(self, number):
        """What that start has written (block_log.py); None: nobody wants to know."""
        return self.folder / f"writes_{number}" if self.logs else None

    def said(self, number):
        """What the console of that start said."""
        return list(self.consoles[number].other)

    def power_cut(self, meanwhile):
        """Power goes, meanwhile(card) is called, and comes back."""
        self.meanwhile = meanwhile
        self.rig.machine.process.kill()

    def close(self):
        self.over = True
        self.thread.join()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
