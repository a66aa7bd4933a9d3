"""How the system test tells what it measured: figures with their bars, named cases, a count at the end."""

import time
import traceback


class Failure(Exception):
    """A case's promise was not kept."""


def check(good, what):
    if not good:
        raise Failure(what)


class Report:
    """Runs cases and prints a line for each; figures in between."""

    def __init__(self):
        self.passed = self.failed = 0
        self.missed = []

    def figure(self, name, value, bar, good):
        """One line `figure: name: value (bar)`; a figure outside of its bar fails the case, which goes on."""
        print(f"figure: {name}: {value} ({bar}){'' if good else ' MISSED'}", flush=True)
        if not good:
            self.missed.append(f"{name}: {value}, not {bar}")

    def at_most(self, name, value, bar, unit):
        self.figure(name, f"{value:.3g} {unit}", f"<= {bar:g} {unit}", value <= bar)

    def none(self, name, count):
        self.figure(name, count, "0", count == 0)

    def run(self, name, function, *arguments):
        self.missed = []
        begin = time.monotonic()
        why = ""
        try:
            function(*arguments)
        except Exception as error:  # a case must not keep the others from being run
            why = f"{type(error).__name__}: {error}"
            if not isinstance(error, Failure):
                why += "\n" + traceback.format_exc(limit=-3)
        why = "; ".join(filter(None, [why, *self.missed]))
        self.passed += not why
        self.failed += bool(why)
        print(f"{'FAILED' if why else 'ok'}: {name}, {time.monotonic() - begin:.1f} s{': ' + why if why else ''}",
              flush=True)
        return not why
