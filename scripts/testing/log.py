"""A step's log file, and how its commands are run."""

import functools
import os
import pathlib
import shutil
import signal
import subprocess
import threading

ROOT = pathlib.Path(__file__).resolve().parents[2]
LOGS = ROOT / "build" / "logs"
LIMIT_S = 30 * 60  # of a command
TAIL_LINES = 60
# What runs so has only the processors that nobody else wants.
IDLE = ("chrt", "--idle", "0")

_running = set()
_ended = threading.Event()


@functools.cache
def aside():
    """What is put before a command that has to leave the processors to others; not every container lets it."""
    idle = shutil.which(IDLE[0]) and subprocess.run((*IDLE, "true"), capture_output=True, check=False).returncode == 0
    return IDLE if idle else ("nice", "-n", "19")


def indented(lines):
    return "\n".join("    " + line for line in lines)


def end_all():
    """Ends what runs, in any thread; nothing begins after that."""
    _ended.set()
    for process in list(_running):
        _kill(process)


def _kill(process):
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)


class Log:
    """Of one step. While `aside` is set, the commands that begin leave the processors to others."""

    def __init__(self, step):
        self.path = LOGS / f"{step}.log"
        self.path.write_text("")
        self.aside = False

    def run(self, *command):
        """True when the command ended with 0 in time."""
        with self.path.open("a") as log:
            log.write(f"$ {' '.join(map(str, command))}\n")
            log.flush()
            if _ended.is_set():
                return False
            with subprocess.Popen((*(aside() if self.aside else ()), *command), cwd=ROOT, stdin=subprocess.DEVNULL,
                                  stdout=log, stderr=subprocess.STDOUT, start_new_session=True) as process:
                _running.add(process)
                if _ended.is_set():  # end_all() may have looked before we were listed
                    _kill(process)
                try:
                    return process.wait(LIMIT_S) == 0
                except subprocess.TimeoutExpired:
                    log.write(f"ended after {LIMIT_S} s\n")
                    print(f"    {' '.join(map(str, command))} took longer than {LIMIT_S // 60} minutes: ended. "
                          "Is the machine busy?", flush=True)
                    return False
                finally:  # also when we are told to end ourselves
                    _kill(process)
                    _running.discard(process)

    def lines(self):
        return self.path.read_text(errors="replace").splitlines()

    def excerpt(self):
        """The first error of a build, else the end."""
        lines = self.lines()
        errors = [i for i, line in enumerate(lines) if line.startswith(("FAILED: ", "CMake Error"))]
        return indented(lines[errors[0]:][:TAIL_LINES] if errors else lines[-TAIL_LINES:])
