"""Which of the calibrations to believe that are told in a sensor's name, as docs/WIRE.md says ("What a receiver does")."""

import struct

SIZE = struct.Struct("<HH")
FINGERPRINT = slice(92, 96)  # of the payload


class Lens:
    def __init__(self, payload, now):
        self.payload, self.since, self.frames = payload, now, 0  # alone since then, in so many frames
        self.doubted = self.ever_doubted = self.stands = False
        self.rival = None  # payload, since when, in how many frames


class Lenses:
    """No clock: `now` in seconds is the caller's."""

    def __init__(self):
        self.lenses = {}  # by fingerprint and size
        self.named = None

    @staticmethod
    def same(one, other):
        def compared(payload):  # without the range and the period, which settings change
            return payload[:32] + payload[36:48] + payload[56:120]
        return compared(one) == compared(other)

    @staticmethod
    def key(payload):
        return int.from_bytes(payload[FINGERPRINT], "little"), *SIZE.unpack_from(payload)

    def take(self, payload, now):
        """Whether it is believed."""
        key = self.key(payload)
        lens = self.lenses.get(key)
        if lens is None or key[0] == 0:
            self.lenses[key] = Lens(payload, now)
            self.forget()
            return True
        if self.same(payload, lens.payload):
            lens.payload, lens.rival = payload, None
            short = now - lens.since < 3 or lens.frames < 3
            lens.doubted = lens.doubted and short
            lens.stands = lens.stands or not (lens.ever_doubted or short) or (now - lens.since >= 10 and lens.frames >= 10)
            return not lens.doubted
        if not lens.stands:
            lens.payload, lens.since, lens.frames = payload, now, 0
            lens.doubted = lens.ever_doubted = True
            return False
        if lens.rival is None or not self.same(payload, lens.rival[0]):
            lens.rival = [payload, now, 0]
        if now - lens.rival[1] < 10 or lens.rival[2] < 10:
            return False
        self.lenses[key] = Lens(payload, now)
        self.lenses[key].ever_doubted = True
        return True

    def forget(self):
        """Some are enough; never those that stand."""
        for key in [key for key, lens in self.lenses.items() if not lens.stands][:-8]:
            del self.lenses[key]

    def note_frame(self, fingerprint, width, height, now):
        """A frame with depth of this size (0: without) names it."""
        anew, self.named = fingerprint != self.named, fingerprint
        for key, lens in self.lenses.items():
            if key[0] == fingerprint and (key[1:] == (width, height) or width == 0):
                if anew:
                    lens.since, lens.frames = now, 0
                lens.frames += 1
                if lens.rival:
                    lens.rival[2] += 1

    def of(self, fingerprint, width, height):
        """The payload; None: not told, or in doubt."""
        lens = self.lenses.get((fingerprint, width, height))
        return lens.payload if lens and not lens.doubted else None
