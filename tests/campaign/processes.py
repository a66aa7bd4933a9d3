"""The kinds of faults that take a system: the real `stofd` and a robot made of libstof, as processes.

Frames are judged by the machine's clock: whatever happens, none is older than promised, none comes twice, and none is
older than one before. That the pixels are those of their edge is what campaign_emulated judges.
"""

import contextlib
import json
import os
import pathlib
import random
import resource
import select
import signal
import socket
import struct
import subprocess
import tempfile
import threading
import time

PERIOD_S = 0.05
DETECTED_S = 3 * PERIOD_S + 0.02
TOLD_S, HEALED_S = 1.0, 2.0
# Three periods to its sending, 300 ms of sending, a period and 100 ms at the robot.
OLDEST_S = 3 * PERIOD_S + 0.3 + PERIOD_S + 0.1
# A robot looks every 5 ms, and what it prints is stamped then; a machine that is busy with others does so later.
LOOK_S = 0.005
AFTER_S = 2.5
START_S = 60
WORDS = ("condition", "health", "silent", "restarted", "forged")
BOTH = 3


class Failed(Exception):
    """The run cannot be judged, or a program ended."""


class Robot:
    """campaign_robot and all it said."""

    def __init__(self, build, port):
        self.process = subprocess.Popen([build / "tests/campaign_robot", f"127.0.0.1:{port}"], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, text=True)
        self.frames, self.signs = [], []
        self.thread = threading.Thread(target=self.read, daemon=True)
        self.thread.start()

    def read(self):
        for line in self.process.stdout:
            said = json.loads(line)
            if "frame" in said:
                self.frames.append(said)
            elif "sign" in said:
                self.signs.append(said)

    def end(self):
        self.process.stdin.write("end\n")
        self.process.stdin.flush()
        code = self.process.wait(20)
        self.thread.join(20)
        return code


class World:
    """A sensor, a robot and a folder, until the end of a run."""

    def __init__(self, build, seed, place):
        self.build, self.place, self.random = build, place, random.Random(f"{seed} {place}")
        self.stack = contextlib.ExitStack()
        self.folder = pathlib.Path(self.stack.enter_context(tempfile.TemporaryDirectory(prefix="stof_")))
        self.settings = self.folder / "settings.json"
        self.port_file = self.folder / "port"
        self.port = 0
        self.refuse_when = self.folder / "refuse"
        self.environment = {}
        self.sensor = self.robot = None
        self.restarts = 0
        self.kept = None  # the thread that starts the sensor again
        self.ending = threading.Event()

    def keep(self):
        """As board/systemd/stofd.service does: what ends by itself is started again 100 ms later."""
        while not self.ending.wait(0.1):
            if self.sensor.poll() is not None:
                if self.sensor.returncode < 0:
                    return  # a crash: whoever ends the run sees it
                self.restarts += 1
                with contextlib.suppress(Failed):
                    self.start_sensor()

    def start_sensor(self):
        self.port_file.unlink(missing_ok=True)
        words = [self.build / "bin/stofd", "--size", "64x48", "--pmd", "32x24", "--disparities", "16", "--port", self.port,
                 "--port-file", self.port_file, "--settings", self.settings, "--period-ms", round(PERIOD_S * 1000)]
        for setting in ("discovery.mdns=false", "discovery.beacon=false"):
            words += ["--set", setting]
        self.log = self.folder / "log"
        with self.log.open("a") as log:
            self.sensor = subprocess.Popen(list(map(str, words)), stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                           env={**os.environ, **self.environment})
        deadline = time.monotonic() + START_S
        while not (self.port_file.exists() and self.port_file.read_text().endswith("\n")):
            if self.sensor.poll() is not None or time.monotonic() > deadline:
                raise Failed(f"stofd does not start: {self.log.read_text()[-300:]}")
            time.sleep(0.005)
        self.port = int(self.port_file.read_text())

    def start(self):
        """Both; the fault of place `start` is there from the robot's first moment on."""
        self.start_sensor()
        self.kept = threading.Thread(target=self.keep, daemon=True)
        self.kept.start()
        self.robot = Robot(self.build, self.port)
        deadline = time.monotonic() + START_S
        while not (self.robot.signs if self.place == "start" else len(self.robot.frames) > 10):
            if time.monotonic() > deadline:
                raise Failed("the robot has no frames")
            time.sleep(0.005)
        if self.place == "start":
            return
        seen = len(self.robot.frames)
        while len(self.robot.frames) == seen:
            time.sleep(0.001)
        if self.place == "mid-frame":
            time.sleep(self.random.uniform(0.1, 0.9) * PERIOD_S)

    def config(self, *words):
        subprocess.run([self.build / "bin/stof", "config", f"127.0.0.1:{self.port}", *words, "--timeout", "3"],
                       capture_output=True, check=False, env={**os.environ, "XDG_CONFIG_HOME": str(self.folder / "user")})

    def leave(self):
        """Nobody starts the sensor again."""
        self.ending.set()
        if self.kept:
            self.kept.join(START_S)

    def close(self):
        self.leave()
        for process in (self.sensor, self.robot.process if self.robot else None):
            if process and process.poll() is None:
                process.send_signal(signal.SIGCONT)
                process.kill()
                process.wait()
        self.stack.close()


def for_a_while(world, least=0.05, most=1.5):
    time.sleep(world.random.uniform(least, most))


def stopped_sensor(world):
    world.sensor.send_signal(signal.SIGSTOP)
    for_a_while(world, 0.02, 3)
    world.sensor.send_signal(signal.SIGCONT)


def stopped_robot(world):
    world.robot.process.send_signal(signal.SIGSTOP)
    for_a_while(world, 0.02, 4)
    world.robot.process.send_signal(signal.SIGCONT)


def killed(world):
    world.leave()
    world.sensor.kill()
    world.sensor.wait()
    for_a_while(world, 0.0, 0.5)
    world.start_sensor()


def busy(world):
    """Eight processes that compute."""
    others = [subprocess.Popen(["sh", "-c", "while :; do :; done"]) for _ in range(8)]
    for_a_while(world, 0.5, 1.5)
    for other in others:
        other.kill()
        other.wait()


def refused_at_run(call, error):
    def refuse(world):
        world.refuse_when.touch()
        world.config("set", "depth.max_range_mm=4000")
        for_a_while(world, 0.1, 1)
        world.refuse_when.unlink()
    refuse.environment = {"STOF_REFUSE": f"{call}:{error}:0"}
    return refuse


def disk_full(world):
    """No settings can be saved; frames do not care."""
    world.config("set", "depth.max_range_mm=9000")  # there is something to save
    world.refuse_when.touch()
    world.config("save")
    for_a_while(world, 0.1, 0.5)
    world.refuse_when.unlink()


disk_full.environment = {"STOF_REFUSE": "write:28:0"}  # ENOSPC


def read_only(world):
    disk_full(world)


read_only.environment = {"STOF_REFUSE": "write:30:0"}  # EROFS


def descriptors(world):
    soft, hard = resource.prlimit(world.sensor.pid, resource.RLIMIT_NOFILE)
    world.config("set", "depth.max_range_mm=9000")
    resource.prlimit(world.sensor.pid, resource.RLIMIT_NOFILE, (3, hard))
    world.config("save")
    for_a_while(world, 0.1, 1)
    resource.prlimit(world.sensor.pid, resource.RLIMIT_NOFILE, (soft, hard))


def forged_control(world):
    """Random and damaged requests, in anybody's name that loopback has."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        end = time.monotonic() + world.random.uniform(0.2, 1)
        while time.monotonic() < end:
            for _ in range(100):
                kind = world.random.choice((128, 129, 130, 131, 132, 140))
                head = b"STOF" + bytes((1, kind)) + struct.pack("<H", 52) + world.random.randbytes(world.random.randint(0, 120))
                out.sendto(head, ("127.0.0.1", world.port))
            time.sleep(0.01)


def checksum(data):
    total = sum(struct.unpack(f">{len(data) // 2}H", data))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    return ~total & 0xFFFF


def icmp(world):
    """"Port unreachable" and "fragmentation needed" for what the sensor sent to the robot; needs raw sockets."""
    robot_port = next((int(line.split()[1].split(":")[1], 16) for line in
                       pathlib.Path(f"/proc/{world.robot.process.pid}/net/udp").read_text().splitlines()[1:]
                       if int(line.split()[9]) in inodes(world.robot.process.pid)), 9)
    packet = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 1400, 1, 0x4000, 64, 17, 0, socket.inet_aton("127.0.0.1"),
                         socket.inet_aton("127.0.0.1")) + struct.pack(">HHHH", world.port, robot_port, 1380, 0)
    with socket.socket(socket.AF_INET, socket.SOCK_RAW, socket.IPPROTO_ICMP) as out:
        end = time.monotonic() + world.random.uniform(0.2, 1)
        while time.monotonic() < end:
            for code, rest in ((3, 0), (4, 68)):
                head = struct.pack(">BBHI", 3, code, 0, rest)
                whole = struct.pack(">BBHI", 3, code, checksum(head + packet), rest) + packet
                out.sendto(whole, ("127.0.0.1", 0))
            time.sleep(0.002)


def inodes(pid):
    found = set()
    for link in pathlib.Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(OSError):
            target = os.readlink(link)
            if target.startswith("socket:["):
                found.add(int(target[8:-1]))
    return found


KINDS = {"process sensor stopped": stopped_sensor, "process robot stopped": stopped_robot, "process killed": killed,
         "process 8 busy": busy, "process memory refused": refused_at_run("memory", 12),
         "process threads refused": refused_at_run("thread", 11), "process descriptors refused": descriptors,
         "process disk full": disk_full, "process disk read-only": read_only, "process forged control": forged_control,
         "process ICMP": icmp}
PLACES = ("start", "steady", "mid-frame")


def stolen_s():
    """What this machine's processors did for others since its start: of a guest, stolen; and its load now."""
    words = pathlib.Path("/proc/stat").read_text().split("\n", 1)[0].split()
    return int(words[8]) / os.sysconf("SC_CLK_TCK")


def judge(world, begin, end, slept):
    """As campaign_emulated does."""
    frames, signs = world.robot.frames, world.robot.signs
    false, oldest, before = 0, 0.0, None
    for frame in frames:
        age = frame["at"] - frame["exposure"]
        # What the robot does with a frame after libstof gave it, it does a moment later on a busy machine.
        given = min(frame["at"], frame["arrived"] + PERIOD_S + 0.1 + LOOK_S) if not slept else frame["at"]
        oldest = max(oldest, age)
        stale = given - frame["exposure"] > OLDEST_S
        not_newer = before is not None and frame["exposure"] <= before
        false += stale or not_newer
        before = frame["exposure"]
    whole = [frame["at"] for frame in frames if frame["whole"] and frame["sensors"] == BOTH]
    gaps = [(a, b) for a, b in zip(whole, whole[1:]) if b > begin and b - max(a, end if slept and a <= end <= b else a) > DETECTED_S + LOOK_S]
    longest = max((b - a for a, b in gaps), default=0.0)
    never = not whole
    at_start = not never and whole[0] > begin and whole[0] - begin > 0.5 + 2 * PERIOD_S
    effect = never or bool(gaps) or at_start
    since = gaps[0][0] if gaps else begin
    since = max(since, end) if slept else since
    words = [sign["at"] for sign in signs if sign["sign"] in WORDS and sign["value"] and sign["at"] >= since]
    flagged = [frame["at"] for frame in frames if frame["at"] >= since and (not frame["whole"] or frame["health"])]
    detected = 0.0 if at_start and not gaps else min(words + flagged, default=None)
    detected = detected - since if detected else detected
    told = min(words, default=None) if longest > 1 else min(words + flagged, default=None)
    told = told - since if told is not None else 0.5 if at_start and not gaps else None
    states = {}
    unwell = begin
    for sign in signs:
        if sign["sign"] in ("silent", "health"):
            if states.get(sign["sign"]):
                unwell = max(unwell, sign["at"])
            states[sign["sign"]] = sign["value"]
    well = not any(states.values()) and bool(whole) and whole[-1] > end + AFTER_S / 2
    healed = unwell - end if well else AFTER_S  # not within what was watched
    return {"effect": effect, "detected_ms": None if detected is None else 1000 * detected,
            "told_ms": None if told is None else 1000 * told, "healed_ms": max(1000 * healed, 0.0),
            "outage_ms": 1000 * longest, "oldest_ms": 1000 * oldest, "false": false, "frames": len(frames),
            "in_time": not effect or (detected is not None and detected <= DETECTED_S + LOOK_S),
            "told": not effect or (told is not None and told <= TOLD_S), "healed": healed <= HEALED_S}


def waited_s(pid):
    """How long a process's threads have waited for a processor since their start."""
    total = 0
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        with contextlib.suppress(OSError, IndexError, ValueError):
            total += int((task / "schedstat").read_text().split()[1])
    return total * 1e-9


def resident_kib(pid):
    return int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1]) * resource.getpagesize() // 1024


def realtime(build, minutes, robots=2, period_s=0.066):
    """A sensor of 640x480 with robots on sockets: what was missed in each second, and what the machine kept from it."""
    with tempfile.TemporaryDirectory(prefix="stof_") as folder:
        port_file, log = pathlib.Path(folder, "port"), pathlib.Path(folder, "log")
        with log.open("w") as out:
            words = [build / "bin/stofd", "--size", "640x480", "--period-ms", round(1000 * period_s), "--port", 0, "--port-file", port_file,
                     "--set", "discovery.mdns=false", "--set", "discovery.beacon=false"]
            sensor = subprocess.Popen(list(map(str, words)), stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT)
        with contextlib.ExitStack() as stack:
            stack.callback(sensor.kill)
            while not (port_file.exists() and port_file.read_text().endswith("\n")):
                if sensor.poll() is not None:
                    raise Failed(log.read_text()[-300:])
                time.sleep(0.05)
            watching = [Robot(build, int(port_file.read_text())) for _ in range(robots)]
            for robot in watching:
                stack.callback(robot.process.kill)
            time.sleep(10)  # it learns what frames cost, memory comes once
            rows, memory = [], resident_kib(sensor.pid)
            end = time.monotonic() + 60 * minutes
            while time.monotonic() < end and sensor.poll() is None:
                stolen, waited, at = stolen_s(), waited_s(sensor.pid), time.monotonic()
                time.sleep(1)
                rows.append((at, time.monotonic(), stolen_s() - stolen, waited_s(sensor.pid) - waited))
            if sensor.poll() is not None:
                raise Failed(f"stofd ended with {sensor.returncode}: {log.read_text()[-300:]}")
            grown = resident_kib(sensor.pid) - memory
            begin = rows[0][0] if rows else 0
            missed = unexplained = stale = 0
            frames = watching[0].frames
            for before, after in zip(frames, frames[1:]):
                gap = after["exposure"] - before["exposure"]
                if before["exposure"] > begin and gap > 1.5 * period_s:
                    missed += round(gap / period_s) - 1
                    near = [row for row in rows if row[1] > before["exposure"] - 0.5 and row[0] < after["at"] + 0.5]
                    # An eighth of a period is what a loop may be late.
                    unexplained += sum(row[2] + row[3] for row in near) < period_s / 8
            for robot in watching:
                stale += sum(b["exposure"] <= a["exposure"] for a, b in zip(robot.frames, robot.frames[1:]))
                stale += sum(frame["arrived"] - frame["exposure"] > 6 * period_s + 0.4 for frame in robot.frames)
            return {"minutes": minutes, "frames": len(frames), "missed": missed, "unexplained": unexplained, "stale": stale,
                    "memory_grown_kib": grown, "stolen_s": round(sum(row[2] for row in rows), 2),
                    "waited_s": round(sum(row[3] for row in rows), 2)}


def run(build, kind, place, seed):
    """The verdict of one run; raises Failed."""
    world = World(build, f"{kind} {seed}", place)
    try:
        strike = KINDS[kind]
        if refusal := getattr(strike, "environment", None):
            world.environment = {"LD_PRELOAD": str(build / "tests/campaign_refuse.so"), **refusal,
                                 "STOF_REFUSE_WHEN": str(world.refuse_when)}
        stolen = stolen_s()
        world.start()
        begin = time.monotonic()
        strike(world)
        end = time.monotonic()
        waited = {process.pid: waited_s(process.pid) for process in (world.sensor, world.robot.process)}
        time.sleep(AFTER_S)
        world.leave()
        waited_ms = sum(1000 * (waited_s(process.pid) - waited.get(process.pid, 0)) for process in (world.sensor, world.robot.process)
                        if process.poll() is None)
        if world.sensor.poll() is not None:
            raise Failed(f"stofd ended with {world.sensor.returncode}: {world.log.read_text()[-300:]}")
        code = world.robot.end()
        if code != 0:
            raise Failed(f"the robot ended with {code}")
        world.sensor.send_signal(signal.SIGTERM)
        code = world.sensor.wait(20)
        if code != 0:
            raise Failed(f"stofd ended with {code}: {world.log.read_text()[-300:]}")
        verdict = judge(world, begin, end, strike is stopped_robot)
        good = verdict["in_time"] and verdict["told"] and verdict["healed"]
        # More than a period of the 2.5 s behind the fault: another machine would have had it.
        explained = not good and waited_ms > 1000 * PERIOD_S
        return {**verdict, "explained": explained, "waited_ms": waited_ms, "stolen_s": stolen_s() - stolen,
                "restarts": world.restarts}
    finally:
        world.close()
