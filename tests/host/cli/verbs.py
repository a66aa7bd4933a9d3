"""Every command of `stof` in one table, and what its tests share. COMMAND: stof, with an emulator before it in a cross build."""

import dataclasses
import json
import os
import pathlib
import subprocess
import tempfile
import unittest
import unittest.mock

COMMAND = []


@dataclasses.dataclass(frozen=True)
class Verb:
    """words: that make a command line which is understood. {s}: a sensor. lost: its exit code where nobody answers there; None: it
    asks no sensor. live, file: words whose output is JSON, of a sensor, of a recording ({f})."""

    words: str
    lost: int | None = None
    live: tuple[str, ...] = ()
    file: tuple[str, ...] = ()


# Who has no --json. Of those that this build has not, nobody can tell.
TALKERS = {"view", "bridge ros2", "completion", "evaluate chapter"}
WAIT = "--timeout 0.4"
LONG = "--timeout 60"  # of what has to come
VERBS = {
    "view": Verb(f"{{s}} {WAIT} --frames 1", lost=1),
    "record": Verb(f"{{s}} new.mcap {WAIT} --frames 1", lost=1, live=(f"{{s}} live.mcap --frames 2 --json {LONG}",)),
    "info": Verb(f"{{s}} {WAIT}", lost=1, live=(f"{{s}} --json {LONG}",), file=("{f} --json",)),
    "stats": Verb(f"{{s}} {WAIT}", lost=1, live=(f"{{s}} --seconds 0.5 --json {LONG}",), file=("{f} --json",)),
    "health": Verb(f"{{s}} {WAIT}", lost=1, live=(f"{{s}} --json {LONG}",), file=("{f} --json",)),
    "check": Verb(f"{{s}} {WAIT}", lost=1, live=(f"{{s}} --seconds 0.5 --json {LONG}",), file=("{f} --json",)),
    "report": Verb(f"{{s}} new.tar {WAIT}", lost=1, live=(f"{{s}} live.tar --seconds 0.5 --json {LONG}",), file=("{f} file.tar --json",)),
    "export": Verb(f"{{s}} --to new --as csv {WAIT}", lost=1, live=(f"{{s}} --to live --as tum --frames 2 --json {LONG}",),
                   file=("{f} --to file --as ply --json",)),
    "recover": Verb("absent.mcap", file=("{f} --json",)),
    "replay": Verb("absent.mcap", file=("{f} --port 0 --bind 127.0.0.1 --timeout 0.2 --json",)),
    "fault": Verb("absent.socket pmd:vanish:60"),
    "bridge ros2": Verb("absent.mcap"),
    "discover": Verb("--timeout 0.3", live=("--timeout 4 --address {s} --json",)),
    "address": Verb("{s} 192.168.7.2/24 --timeout 0.05 --keys keys", lost=1),
    "config": Verb("{s} get --timeout 0.05", lost=1, live=("{s} get --json --timeout 10", "{s} diff --json --timeout 10", "{s} schema --timeout 10")),
    "pair": Verb("{s} --timeout 0.05 --keys keys --digits 123456", lost=1),
    "unpair": Verb("{s} --timeout 0.05 --keys mine --list", lost=1),
    "update": Verb("{s} absent.update --timeout 0.05 --keys keys"),
    "proxy": Verb("--listen 0 --to {s}"),
    "completion": Verb("bash"),
    "calib pmd": Verb("absent --out new.cal"),
    "calib install": Verb("absent.cal {s} --timeout 0.05 --keys keys"),
    "calib stereo": Verb("--planes absent --out new.cal"),
    "calib extrinsics": Verb("absent --calibration absent.cal --out new.cal"),
    "calib check": Verb("absent --calibration absent.cal"),
    "calib import": Verb("ros absent.yaml --out new.cal"),
    "calib export": Verb("ros absent.cal --out new.yaml"),
    "calib target": Verb("--board absent --out new.pdf"),
    "evaluate stereo": Verb("absent"),
    "evaluate fusion": Verb("absent absent"),
    "evaluate floor": Verb("absent"),
    "evaluate pmd": Verb("absent"),
    "evaluate sequence": Verb("absent"),
    "evaluate chapter": Verb("absent --out new.html"),
}


class Program(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory(prefix="stof_")
        cls.addClassCleanup(scratch.cleanup)
        cls.folder = pathlib.Path(scratch.name)
        # Nobody's keys.
        environment = unittest.mock.patch.dict(os.environ, {"XDG_CONFIG_HOME": scratch.name})
        environment.start()
        cls.addClassCleanup(environment.stop)
        made = cls.stof("pair", "--into", "theirs", "--keys", "mine")
        assert made.returncode == 0, made.stderr

    @classmethod
    def stof(cls, *words, **more):
        return subprocess.run([*COMMAND, *map(str, words)], **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True,
                                                               "timeout": 240, "cwd": cls.folder, **more})

    def refused(self, ended, code, *facts):
        """It ended with the code and one line that holds all facts."""
        self.assertEqual(ended.returncode, code, f"{ended.stdout} {ended.stderr}")
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertTrue(ended.stderr.startswith("stof: "), ended.stderr)
        for fact in facts:
            self.assertIn(fact, ended.stderr)

    def nothing_but_json(self, ended):
        """Who does nothing prints nothing; else each line is a document, or all of them are one."""
        if ended.stdout:
            try:
                json.loads(ended.stdout)
            except ValueError:
                for line in ended.stdout.splitlines():
                    json.loads(line)

    def words_of(self, name, **places):
        return [*name.split(), *VERBS[name].words.format(**{"s": "127.0.0.1:9", **places}).split()]
