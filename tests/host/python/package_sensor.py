"""The Python package stof and an emulated sensor, for the tests that ask it. They end with 77, and a line, where numpy or the programs
of a build (environment: STOF_LIBRARY, STOFD, STOF, DEPTH_CLIENT) are not there."""

import sys
import unittest

import package_support as support

support.skip_without("STOF_LIBRARY", "STOFD", "STOF", "DEPTH_CLIENT")
support.need_numpy()
sys.path.insert(0, str(support.ROOT / "host/python"))
import numpy  # noqa: E402, F401
import stof  # noqa: E402

LONG_S = 20  # a busy machine


class WithSensor(unittest.TestCase):
    WORDS = ()
    OPTIONS = {}

    @classmethod
    def setUpClass(cls):
        cls.emulated = support.EmulatedSensor(*cls.WORDS, **cls.OPTIONS)
        cls.addClassCleanup(cls.emulated.end)
        cls.address = cls.emulated.address

    def open(self, **options):
        sensor = stof.open(self.address, **options)
        self.addCleanup(sensor.close)
        return sensor

    def one_line(self, kind, function, *arguments, holds="", **options):
        with self.assertRaises(kind) as raised:
            function(*arguments, **options)
        text = str(raised.exception)
        self.assertNotIn("\n", text)
        self.assertIn(holds, text)
        self.assertTrue(text)
        return raised.exception
