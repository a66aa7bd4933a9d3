"""The rig of the system test: the machine with stofd, its cameras and their world, receivers, expected frames."""

import array
import collections
import hashlib
import json
import pathlib
import queue
import statistics
import subprocess
import sys
import threading
import time

import initramfs
import machine
import pmd_camera
import triggered_camera
import uvc_camera

ROOT = initramfs.ROOT
STEREO, PMD = (320, 240), (64, 48)
STEPS = 8  # different pictures
BOTH = 3  # sensors that a frame stands on
PERIOD_S = 0.2
DISPARITIES = 32
LEFT_LINE, RIGHT_LINE, PMD_LINE = 0, 1, 2
LEFT_STROBE, RIGHT_STROBE = 4, 5
HOST = "10.0.2.2"  # as the guest sees it
# What guest and host compute alike: lossless, so that frames can be compared bit by bit.
COMMON = ["--disparities", str(DISPARITIES), "--set", "streams.depth=rvl", "--set", "streams.width=rvl", "--set",
          "streams.source=rvl", "--set", "discovery.mdns=false"]
# A camera on the rig: make(path of its socket, schedule), and what it is wired to. strobe may be None.
Plug = collections.namedtuple("Plug", "make trigger strobe", defaults=(None,))


def size_text(size):
    return f"{size[0]}x{size[1]}"


# And what stofd is told of the rig.
RIG_OPTIONS = ["--size", size_text(STEREO), "--pmd-size", size_text(PMD), "--period-ms", str(round(PERIOD_S * 1000)),
               *COMMON]


def read_pgm(path):
    """Width, height and the pixels' bytes; 16-bit ones big-endian."""
    data = pathlib.Path(path).read_bytes()
    fields, at = [], 0
    while len(fields) < 4:
        end = at
        while data[end] not in b" \t\n\r":
            end += 1
        if end > at:
            fields.append(data[at:end])
        at = end + 1
    return int(fields[1]), int(fields[2]), data[at:]


def samples(path):
    """A PMD recording's four planes, little-endian."""
    _, _, pixels = read_pgm(path)
    values = array.array("H", pixels)
    if sys.byteorder == "little":
        values.byteswap()
    return values.tobytes(), max(values)


class Receiver:
    """stof_system_receive, and what it has printed."""

    def __init__(self, program, *arguments):
        self.process = subprocess.Popen([*machine.ENDS_WITH_US, program, *map(str, arguments)], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True)
        self.condition = threading.Condition()
        self.frames = []
        self.events = []
        if self.process.stderr.readline().strip() != "open":
            raise machine.MachineError("the receiver opens no port: " + self.process.stderr.read().strip())
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        for line in self.process.stdout:
            message = json.loads(line)
            message["seen"] = time.monotonic()
            with self.condition:
                (self.frames if "frame" in message else self.events).append(message)
                self.condition.notify_all()

    def wait(self, fits, since=0, timeout=30.0, what="a frame"):
        """The first of the frames from number `since` on that fits."""
        end = time.monotonic() + timeout
        with self.condition:
            at = since
            while True:
                for frame in self.frames[at:]:
                    if fits(frame):
                        return frame
                at = max(at, len(self.frames))
                left = end - time.monotonic()
                if left <= 0:
                    raise machine.MachineError(f"no {what} in {timeout} s; {self._told(since)} came")
                self.condition.wait(left)

    def _told(self, since):
        """How many others, and how the last three of them were."""
        others = self.frames[since:]
        last = ", ".join(f"{frame.get('sensors')} with {frame.get('missing')} tiles missing" for frame in others[-3:])
        return f"{len(others)} others" + (f" (the last: sensors {last})" if last else "")

    def count(self):
        with self.condition:
            return len(self.frames)

    def close(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.process.stderr.close()


class Scene:
    """What the cameras see, step by step, and what an appliance on this machine makes of it."""

    def __init__(self, programs, cache):
        """programs: the folder of stofd (board emu), stof_system_frames and stof_system_receive."""
        self.programs = pathlib.Path(programs)
        self.receive = self.programs / "stof_system_receive"
        # Rendered and computed once, for these programs.
        key = hashlib.sha256(" ".join([*COMMON, size_text(STEREO), size_text(PMD), str(STEPS)]).encode())
        for name in ("stof_system_frames", "stofd"):
            key.update((self.programs / name).read_bytes())
        self.folder = pathlib.Path(cache) / key.hexdigest()[:16]
        self.calibration = self.folder / "rig.cal"
        if not (self.folder / "hashes.json").exists():
            self.folder.mkdir(parents=True, exist_ok=True)
            subprocess.run([self.programs / "stof_system_frames", self.folder, str(STEPS), size_text(STEREO),
                            size_text(PMD)], check=True, timeout=600)
            (self.folder / "hashes.json").write_text(json.dumps(self._compute()))
        self.hashes = json.loads((self.folder / "hashes.json").read_text())
        if len(set(self.hashes)) != STEPS:
            raise machine.MachineError("two steps of the scene give the same frame: they cannot be told apart")
        self.left = [self._grey(k, "left.pgm") for k in range(STEPS)]
        self.right = [self._grey(k, "right.pgm") for k in range(STEPS)]
        planes = [samples(self.folder / str(k) / "pmd_raw.pgm") for k in range(STEPS)]
        self.pmd = [plane for plane, _ in planes]
        self.pmd_bits = min(max(max(most for _, most in planes).bit_length(), 10), 15)

    def _grey(self, k, name):
        return read_pgm(self.folder / str(k) / name)[2]

    def _compute(self):
        """The hash of each step's frame."""
        return [self._hash(k) for k in range(STEPS)]

    def _hash(self, k):
        port = machine.free_udp_port()
        receiver = Receiver(self.receive, "--listen", port)
        folder = self.folder / str(k)
        try:
            subprocess.run([self.programs / "stofd", "--dataset", folder, "--tof", folder / "pmd", "--calibration",
                            self.calibration, "--free-run", "--frames", "4", "--session", str(k + 1), "--port", "0",
                            "--to", f"127.0.0.1:{port}", *COMMON], check=True, stdout=subprocess.DEVNULL, timeout=120)
            return receiver.wait(lambda frame: frame["session"] == k + 1 and frame["missing"] == 0,
                                 what=f"frame of step {k} from the emulated rig")["hash"]
        finally:
            receiver.close()


def uvc(product, name, size, pictures, formats):
    return lambda path, schedule: uvc_camera.UvcCamera(path, schedule, product, name, size, pictures, formats)


def stereo_pair(scene, formats=("GREY",)):
    return {"left": Plug(uvc(0x51, "left", STEREO, scene.left, formats), LEFT_LINE, LEFT_STROBE),
            "right": Plug(uvc(0x52, "right", STEREO, scene.right, formats), RIGHT_LINE, RIGHT_STROBE)}


def usb_pmd(scene):
    def make(path, schedule):
        return pmd_camera.PmdCamera(path, schedule, 0x50, PMD, scene.pmd, scene.pmd_bits, 20_000)
    return {"pmd": Plug(make, PMD_LINE)}


class Rig:
    """stofd in the machine, its cameras plugged in, a receiver of every packet.

    plugs: Plugs by name; None: a pair and a PMD camera on USB. boot: kernel and initramfs of a whole image, which starts
    its own stofd; None: of the guest of this folder, with that stofd. port: where the program sends all packets.
    """

    def __init__(self, scene, stofd, work, *, arguments=(), plugs=None, common=True,
                 libraries=None, image_extra=None, boot=None, port=None, **machine_options):
        self.scene = scene
        self.folder = pathlib.Path(work)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.receiver = self.machine = None
        plugs = {**stereo_pair(scene), **usb_pmd(scene)} if plugs is None else plugs
        self.schedule = triggered_camera.Schedule()
        self.world = triggered_camera.World(PERIOD_S / 4)
        self.cameras = {}
        self.strobe_late = []  # seconds from where a strobe should change to where the machine has taken it
        self.edges = {line: [] for line in (LEFT_LINE, RIGHT_LINE, PMD_LINE)}
        try:
            self.port = port or machine.free_udp_port()
            if boot is None:
                words = [*arguments, *(["--calibration", "/rig.cal", *RIG_OPTIONS] if common else [])]
                boot = self._pack(stofd, words, libraries, image_extra)
            self.receiver = Receiver(scene.receive, "--listen", self.port)
            self.machine = machine.Machine(*boot, usb=tuple(plugs), log=self.folder / "console.log", **machine_options)
            if plugs:
                self._plug_in(plugs)
            self.machine.go()
        except BaseException:
            self.close()
            raise

    def _pack(self, stofd, words, libraries, image_extra):
        command = " ".join(["/bin/stofd", "--to", f"{HOST}:{self.port}", *words])
        initramfs.build(self.folder / "initramfs", [(command.encode(), "command"), (self.scene.calibration, "rig.cal")],
                        [(stofd, "bin/stofd")], libraries=libraries, extra=image_extra)
        return initramfs.KERNEL / "image", self.folder / "initramfs"

    def _plug_in(self, plugs):
        by_line = {}
        strobes = queue.Queue()
        for name, plug in plugs.items():
            camera = plug.make(self.machine.path(name), self.schedule)
            if plug.strobe is not None:
                camera.strobe = lambda level, line=plug.strobe: strobes.put((line, level, time.monotonic()))
            self.cameras[name] = by_line[plug.trigger] = camera
        threading.Thread(target=self._drive, args=(strobes,), daemon=True).start()

        def edge(line, level, at):
            if line in by_line and level:
                self.edges[line].append(at)
                by_line[line].edge(self.world.edge(at), at)

        self.machine.lines.listeners.append(edge)
        for camera in self.cameras.values():
            camera.plug()

    def _drive(self, strobes):
        try:
            while True:
                line, level, at = strobes.get()
                self.machine.lines.drive(line, level)
                self.strobe_late.append(time.monotonic() - at)
        except (OSError, machine.MachineError):
            pass  # the machine has ended

    def steps(self):
        """How many steps the world has made."""
        return len(self.world.steps)

    def at_step(self, number, timeout=60.0):
        end = time.monotonic() + timeout
        while self.steps() <= number:
            if time.monotonic() > end:
                raise machine.MachineError(f"{self.steps()} edges in {timeout} s, not {number}")
            time.sleep(0.01)

    def judge(self, frames):
        """Pairs frames with edges: those that show another step than that of their edge or that of none, those that
        show nothing that a step can give, and those that did not arrive whole. Of one sensor: only that they begin
        with an edge; the host knows the bits of both."""
        whole = [frame for frame in frames if frame["missing"] == 0 and frame["depth"] and "latency_ns" in frame]
        verdict = {"frames": len(frames), "incomplete": len(frames) - len(whole), "mispaired": 0, "different": 0,
                   "of_one": 0, "steps": []}
        if not whole:
            return verdict
        # The guest's clock runs as fast as the host's. A frame leaves when its exposure and latency are over.
        offset = statistics.median(frame["at_ns"] - frame["middle_ns"] - frame["latency_ns"] for frame in whole) * 1e-9
        times = list(self.world.steps)
        for frame in whole:
            begin = frame["begin_ns"] * 1e-9 + offset
            number = min(range(len(times)), key=lambda n, at=begin: abs(times[n] - at))
            verdict["steps"].append(number)
            if frame["sensors"] != BOTH:
                verdict["of_one"] += 1
                verdict["mispaired"] += abs(times[number] - begin) > PERIOD_S / 3
            elif frame["hash"] not in self.scene.hashes:
                verdict["different"] += 1
            elif abs(times[number] - begin) > PERIOD_S / 3 or self.scene.hashes[number % STEPS] != frame["hash"]:
                verdict["mispaired"] += 1
        return verdict

    def log(self):
        with self.machine.console.condition:
            return [entry.text for entry in self.machine.console.log]

    def close(self):
        self.schedule.end()
        for camera in self.cameras.values():
            camera.unplug()
        if self.machine:
            self.machine.close()
        if self.receiver:
            self.receiver.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
