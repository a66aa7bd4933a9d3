"""The virtual machine of the system test: QEMU, its console, its monitor, its GPIO lines and its serial line.

Everything lives in a temporary folder and ends with the Machine, also when the test fails or is killed.
"""

import collections
import json
import os
import pathlib
import queue
import re
import shutil
import socket
import subprocess
import tempfile
import threading
import time

QEMU = "qemu-system-aarch64"
ENDS_WITH_US = ("setpriv", "--pdeathsig", "KILL")  # also when this program is killed
CONNECT_S = 20.0
ANSWER_S = 20.0
Event = collections.namedtuple("Event", "name uptime more")
Log = collections.namedtuple("Log", "uptime text")


class MachineError(Exception):
    """The machine did not do in time what it was told."""


def connect(path, process=None):
    end = time.monotonic() + CONNECT_S
    while True:
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            connection.connect(str(path))
            return connection
        except OSError as error:
            connection.close()
            if time.monotonic() > end or (process and process.poll() is not None):
                raise MachineError(f"{path}: {error}") from error
            time.sleep(0.01)


def free_udp_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Monitor:
    """QMP, with the human monitor's commands where QMP has none."""

    def __init__(self, connection):
        self.file = connection.makefile("rwb", buffering=0)
        self.socket = connection
        self.answers = queue.Queue()
        self.events = []
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()
        self.execute("qmp_capabilities")

    def _read(self):
        try:
            for line in self.file:
                message = json.loads(line)
                if "event" in message:
                    self.events.append((time.monotonic(), message["event"], message.get("data", {})))
                elif "QMP" not in message:
                    self.answers.put(message)
        except (OSError, ValueError):
            pass

    def execute(self, command, **arguments):
        self.file.write(json.dumps({"execute": command, "arguments": arguments}).encode() + b"\n")
        try:
            answer = self.answers.get(timeout=ANSWER_S)
        except queue.Empty:
            raise MachineError(f"QMP: no answer to {command}") from None
        if "error" in answer:
            raise MachineError(f"QMP: {command}: {answer['error'].get('desc')}")
        return answer["return"]

    def human(self, line):
        return self.execute("human-monitor-command", **{"command-line": line})


class Lines:
    """The GPIO lines of the PL061: outputs are watched, inputs driven, through qtest."""

    def __init__(self, connection, device):
        self.socket = connection
        self.file = connection.makefile("rb")
        self.device = device
        self.answers = queue.Queue()
        self.lock = threading.Lock()
        self.listeners = []  # called with (line, level, time.monotonic()) on the reader's thread
        threading.Thread(target=self._read, daemon=True).start()
        self._command(f"irq_intercept_out {device}")

    def _read(self):
        try:
            for raw in self.file:
                at = time.monotonic()
                words = raw.split()
                if words[:1] == [b"IRQ"]:
                    for listener in self.listeners:
                        listener(int(words[2]), int(words[1] == b"raise"), at)
                else:
                    self.answers.put(raw)
        except (OSError, ValueError):
            pass

    def _command(self, line):
        with self.lock:
            self.socket.sendall(line.encode() + b"\n")
            try:
                answer = self.answers.get(timeout=ANSWER_S)
            except queue.Empty:
                raise MachineError(f"qtest: no answer to {line}") from None
        if not answer.startswith(b"OK"):
            raise MachineError(f"qtest: {line}: {answer.decode().strip()}")

    def drive(self, line, level):
        """Sets an input. Not from a listener, which is what reads the answer."""
        self._command(f"set_irq_in {self.device} unnamed-gpio-in {line} {level}")


class Console:
    """What the guest writes, as events and log lines, from a thread of its own."""

    def __init__(self, connection, copy):
        self.file = connection.makefile("rb")
        self.copy = copy
        self.condition = threading.Condition()
        self.events = []
        self.log = []
        self.other = []
        self.ended = False
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        try:
            with open(self.copy, "ab", buffering=0) as copy:
                for raw in self.file:
                    copy.write(raw)
                    self._take(raw.decode(errors="replace").strip("\r\n"))
        except (OSError, ValueError):
            pass
        with self.condition:
            self.ended = True
            self.condition.notify_all()

    def _take(self, line):
        words = line.split(" ", 3)
        with self.condition:
            try:
                if words[0] == "GUEST":
                    self.events.append(Event(words[1], float(words[2]), " ".join(words[3:])))
                elif words[0] == "LOG":
                    self.log.append(Log(float(words[1]), line.split(" ", 2)[2]))
                else:
                    self.other.append(line)
            except (IndexError, ValueError):
                self.other.append(line)
            self.condition.notify_all()

    def _wait(self, entries, since, fits, what, timeout):
        end = time.monotonic() + timeout
        with self.condition:
            at = since
            while True:
                while at < len(entries):
                    if fits(entries[at]):
                        return entries[at]
                    at += 1
                left = end - time.monotonic()
                if left <= 0 or self.ended:
                    tail = "\n".join([entry.text for entry in self.log[-8:]] + self.other[-8:])
                    raise MachineError(f"the guest did not say {what} in {timeout} s; last:\n{tail}")
                self.condition.wait(left)

    def event(self, name, since=0, timeout=60.0):
        """The first event of that name among those from number `since` on; waits for it."""
        return self._wait(self.events, since, lambda event: event.name == name, f"GUEST {name}", timeout)

    def line(self, pattern, since=0, timeout=60.0):
        """The first line of the program's output that has the pattern; waits for it."""
        return self._wait(self.log, since, lambda log: re.search(pattern, log.text), pattern, timeout)

    def plain(self, pattern, timeout=60.0):
        """The first line that is neither an event nor of the program's output and has the pattern; waits for it."""
        return self._wait(self.other, 0, lambda line: re.search(pattern, line), pattern, timeout)


class Machine:
    """QEMU's virt board. usb: names of usb-redir sockets, `Machine.path(name)`.

    guest_port: a UDP port of the guest that `Machine.port` leads to, which is host_port where one is named. watchdog: what it does when nobody kicks it, as
    -watchdog-action; None: there is none. icount: options of virtual time (never sleep=off together with devices that
    the host drives: time runs away while the guest waits). command_line: the kernel's, in place of that of this folder's
    guest. drive: a disk that the guest has, a file; drive_log gets every write
    of it, in their order (block_log.py).
    """

    def __init__(self, image, initramfs, *, append="", usb=(), guest_port=7560, serial=True, watchdog="none",
                 icount=None, processors=2, memory="512", reboot=False, log=None, command_line=None, drive=None,
                 host_port=None, drive_log=None):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="stof-"))
        self.log = pathlib.Path(log) if log else self.folder / "console.log"
        self.log.write_bytes(b"")
        self.port = host_port or (free_udp_port() if guest_port else 0)
        self.process = None
        self.sockets = []
        try:
            words = command_line or f"console=ttyAMA0 quiet loglevel=4 panic=-1 {append}"
            command = self._command(image, initramfs, words, usb, guest_port, serial, watchdog, icount, processors,
                                    memory, reboot)
            if drive:
                command += [*self._disk(drive, drive_log), "-device", "virtio-blk-pci,drive=disk"]
            self._start(command)
        except BaseException:
            self.close()
            raise

    def path(self, name):
        return self.folder / name

    @staticmethod
    def _disk(drive, log):
        if log is None:
            return ["-drive", f"if=none,id=disk,format=raw,file={drive}"]
        pathlib.Path(log).write_bytes(b"")
        return ["-blockdev", f"driver=file,node-name=card,filename={drive}",
                "-blockdev", f"driver=file,node-name=log,filename={log}",
                "-blockdev", "driver=blklogwrites,node-name=disk,file=card,log=log,log-sector-size=512"]

    def _command(self, image, initramfs, words, usb, guest_port, serial, watchdog, icount, processors, memory, reboot):
        def server(name):
            return f"socket,id={name},path={self.path(name)},server=on,wait=off"

        command = [*ENDS_WITH_US, QEMU, "-M", "virt", "-cpu", "cortex-a72", "-smp", str(processors),
                   "-m", memory, "-display", "none", "-nodefaults", "-S", "-kernel", str(image), "-initrd",
                   str(initramfs), "-append", words,
                   "-chardev", server("console"), "-serial", "chardev:console",
                   "-chardev", server("monitor"), "-mon", "chardev=monitor,mode=control",
                   "-qtest", f"unix:{self.path('qtest')},server=on,wait=off", "-qtest-log", os.devnull,
                   "-device", "virtio-serial-pci", "-chardev", server("command"), "-device",
                   "virtconsole,chardev=command"]
        forward = f",hostfwd=udp:127.0.0.1:{self.port}-:{guest_port}" if guest_port else ""
        command += ["-netdev", f"user,id=net,ipv6=off{forward}", "-device", "virtio-net-pci,netdev=net,romfile="]
        if serial:
            command += ["-chardev", server("serial"), "-device", "pci-serial,chardev=serial"]
        if usb:
            command += ["-device", "qemu-xhci,p2=8,p3=8"]
        for name in usb:
            command += ["-chardev", server(name), "-device", f"usb-redir,chardev={name},id=usb-{name}"]
        if watchdog:
            command += ["-device", "i6300esb", "-watchdog-action", watchdog]
        if icount:
            command += ["-icount", icount]
        return command + ([] if reboot else ["-no-reboot"])

    def _start(self, command):
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                        stderr=open(self.path("qemu.log"), "wb"))
        self.monitor = Monitor(self._connect("monitor"))
        tree = self.monitor.human("info qom-tree")
        found = re.search(r"/(device\[\d+\]) \(pl061\)", tree)
        if not found:
            raise MachineError("the board has no PL061")
        self.lines = Lines(self._connect("qtest"), f"/machine/unattached/{found[1]}")
        self.console = Console(self._connect("console"), self.log)
        self.command_socket = self._connect("command")
        self.commands = self.command_socket.makefile("rwb", buffering=0)

    def _connect(self, name):
        try:
            connection = connect(self.path(name), self.process)
        except MachineError as error:
            said = self.path("qemu.log").read_text(errors="replace").strip()
            raise MachineError(f"{error}; {QEMU} says: {said}") from error
        self.sockets.append(connection)
        return connection

    def go(self):
        """Lets the processors run; until then cameras may be plugged in and lines be watched."""
        self.monitor.execute("cont")

    def ask(self, line, timeout=ANSWER_S):
        """A command for the guest's init; the lines of its answer."""
        self.command_socket.settimeout(timeout)
        answer = []
        try:
            self.commands.write(line.encode() + b"\n")
            while True:
                raw = self.commands.readline()
                if not raw:
                    raise MachineError(f"the guest ended before it answered to {line}")
                text = raw.decode(errors="replace").strip()
                if text == "done":
                    return answer
                answer.append(text)
        except OSError as error:
            raise MachineError(f"the guest does not answer to {line}: {error}") from error

    def wait(self, timeout):
        """Until it has ended by itself, which a restart does, too (unless `reboot`)."""
        try:
            self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise MachineError(f"the machine did not restart in {timeout} s; last:\n" +
                               "\n".join(self.console.other[-8:])) from None

    def serial(self):
        """The host's end of the guest's /dev/ttyS0: a connected socket."""
        return connect(self.path("serial"), self.process)

    def close(self):
        if self.process:
            self.process.kill()
            self.process.wait()
        for connection in self.sockets:
            connection.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
