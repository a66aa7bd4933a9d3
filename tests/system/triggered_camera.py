"""What the emulated cameras share: edges of a trigger, exposures, a clock that delivers, faults on request."""

import collections
import heapq
import itertools
import threading
import time

import usbredir

# What may happen to the picture of one edge: Fault(kind, seconds).
DROP, DELAY, SHORT, CORRUPT = "drop", "delay", "short", "corrupt"
# What may happen to all pictures for a while.
FROZEN, DARK = "frozen", "dark"
Fault = collections.namedtuple("Fault", "kind seconds", defaults=(0.0,))
# at: seconds of time.monotonic(); settings: what the camera was told, as it holds for this exposure.
Exposure = collections.namedtuple("Exposure", "step at ignored settings")


class Schedule:
    """Calls functions at their times, on one thread."""

    def __init__(self):
        self.condition = threading.Condition()
        self.entries = []
        self.order = itertools.count()
        self.ended = False
        threading.Thread(target=self._run, daemon=True).start()

    def at(self, when, function, *arguments):
        with self.condition:
            heapq.heappush(self.entries, (when, next(self.order), function, arguments))
            self.condition.notify()

    def end(self):
        with self.condition:
            self.ended = True
            self.condition.notify()

    def _run(self):
        while True:
            with self.condition:
                now = time.monotonic()
                if self.ended:
                    return
                if not self.entries or self.entries[0][0] > now:
                    self.condition.wait(self.entries[0][0] - now if self.entries else None)
                    continue
                _, _, function, arguments = heapq.heappop(self.entries)
            function(*arguments)


class World:
    """What there is to be seen: one step further at each edge of the rig, however many lines carry it."""

    def __init__(self, gap_s):
        self.gap_s = gap_s  # edges nearer to each other are the same edge on several lines
        self.steps = []  # their times, seconds of time.monotonic()

    def edge(self, at):
        if not self.steps or at - self.steps[-1] > self.gap_s:
            self.steps.append(at)
        return len(self.steps) - 1


class TriggeredCamera(usbredir.Device):
    """Exposes at edges, ignores those that come during an exposure.

    A subclass overrides exposure_s(), settings() and deliver(). Readout begins when the exposure has ended.
    """

    readout_s = 0.002

    def __init__(self, path, schedule):
        super().__init__(path)
        self.schedule = schedule
        self.busy_until = 0.0
        self.out_until = 0.0  # when the last picture was ready: what is held up holds up the next one
        self.generation = 0  # of the power: what was exposed before is not delivered
        self.faults = collections.deque()  # for the next exposures, None: none
        self.ailment = None  # of all exposures until cure()
        self.ails_since = None  # when the first picture was exposed that shows it, seconds of time.monotonic()
        self.last_step = None  # of the last picture that was sent
        self.exposures = []
        self.delivered = 0
        self.overrun = 0  # ready before the guest had taken the one before
        self.strobe = None  # called with (line level) when an exposure begins and ends

    def exposure_s(self):
        raise NotImplementedError

    def settings(self):
        raise NotImplementedError

    def deliver(self, exposure, fault):
        """The picture of `exposure` is read out. Called with the lock held."""
        raise NotImplementedError

    def fail_next(self, kind, seconds=0.0):
        with self.lock:
            self.faults.append(Fault(kind, seconds))

    def fall_ill(self, ailment):
        """FROZEN: pictures are the last one's again, under new numbers. DARK: a PMD camera's lamp has gone out."""
        with self.lock:
            self.ailment, self.ails_since = ailment, None

    def cure(self):
        with self.lock:
            self.ailment = None

    def step_of(self, exposure):
        """The step whose picture is sent for this exposure. Called with the lock held."""
        if self.ailment and self.ails_since is None:
            self.ails_since = exposure.at
        if self.ailment != FROZEN or self.last_step is None:
            self.last_step = exposure.step
        return self.last_step

    def powered(self):
        self.generation += 1
        self.busy_until = 0.0
        self.out_until = 0.0

    def edge(self, step, at):
        """The trigger's active edge has come."""
        with self.lock:
            if not self.plugged:
                return
            ignored = at < self.busy_until
            exposure = Exposure(step, at, ignored, self.settings())
            self.exposures.append(exposure)
            if ignored:
                return
            fault = self.faults.popleft() if self.faults else None
            if fault and fault.kind == DROP:
                return
            end = at + self.exposure_s()
            self.busy_until = end
            late = fault.seconds if fault and fault.kind == DELAY else 0.0
            if self.strobe:
                self.strobe(1)
                self.schedule.at(end, self.strobe, 0)
            self.out_until = max(self.out_until, end + self.readout_s + late)
            self.schedule.at(self.out_until, self._read_out, exposure, fault, self.generation)

    def _read_out(self, exposure, fault, generation):
        with self.lock:
            if self.plugged and generation == self.generation:
                self.deliver(exposure, fault)
