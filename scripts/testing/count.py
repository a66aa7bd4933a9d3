"""How many cases passed, and what is said about the others."""

import dataclasses


@dataclasses.dataclass
class Count:
    passed: int = 0
    failed: int = 0
    skipped: int = 0
    notes: list[str] = dataclasses.field(default_factory=list)  # failed cases, one line each
    skips: dict[str, list[str]] = dataclasses.field(default_factory=dict)  # skipped cases by their reason
    details: list[str] = dataclasses.field(default_factory=list)  # what failed cases said

    def add(self, other):
        self.passed += other.passed
        self.failed += other.failed
        self.skipped += other.skipped
        self.notes += other.notes
        for reason, names in other.skips.items():
            self.skips.setdefault(reason, []).extend(names)
        self.details += other.details

    def __str__(self):
        return f"{self.passed} passed, {self.failed} failed" + (
            f", {self.skipped} skipped" if self.skipped else "")
