#!/usr/bin/env python3
"""stof_sensor_test.py: how the Python package stof finds, asks and changes a sensor, and what it says of errors, against emulated sensors. The
environment is that of package_sensor.py."""

import math
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

import package_support as support
from package_sensor import LONG_S, WithSensor, stof

sys.path.insert(0, str(support.ROOT / "tests/support"))
from udp_ports import lasting_port  # noqa: E402


class Errors(WithSensor):
    def test_wrong_addresses_are_refused_in_one_line(self):
        for address in ("127.0.0.1:99999", "127.0.0.1:", "[::1", "127.0.0.1:-1", "", "a\0b"):
            with self.subTest(address=address):
                self.one_line(stof.BadArgument, stof.open, address)
        self.one_line(stof.Unreachable, stof.open, "nowhere.invalid", holds="nowhere.invalid")
        self.one_line(stof.BadArgument, stof.open, 7560, holds="7560")

    def test_wrong_options_are_refused_in_one_line(self):
        self.one_line(stof.BadArgument, stof.open, self.address, port=65536, holds="port")
        self.one_line(stof.BadArgument, stof.open, self.address, key_id=-1, holds="key_id")
        self.one_line(stof.BadArgument, stof.open, self.address, serial="1", holds="one of them")
        with tempfile.NamedTemporaryFile("w", prefix="stof_") as junk:
            junk.write("junk\n")
            junk.flush()
            self.one_line(stof.BadArgument, stof.open, self.address, signed_streams=True, keys=junk.name, holds=junk.name)
        sensor = self.open()
        for timeout in (-1, math.nan, math.inf):
            self.one_line(stof.BadArgument, sensor.next, timeout, holds="timeout")

    def test_who_does_not_answer_is_a_timeout(self):
        with stof.open("127.0.0.1:9") as sensor:
            began = time.monotonic()
            error = self.one_line(stof.Timeout, sensor.next, 0.3, holds="127.0.0.1:9")
            self.assertIsInstance(error, TimeoutError)
            self.assertEqual(error.status, 1)
            self.assertLess(time.monotonic() - began, 30)
            self.one_line(stof.Timeout, sensor.next, 0)
            self.one_line(stof.Timeout, lambda: list(sensor.frames(0.2)))
            self.one_line(stof.Unreachable, sensor.get)
            self.assertIsNone(sensor.health())
            self.assertIsNone(sensor.link().frame_age_s)

    def test_a_closed_sensor_says_so(self):
        sensor = self.open()
        sensor.next(LONG_S)
        sensor.close()
        sensor.close()
        self.assertTrue(sensor.closed)
        for call in (sensor.next, sensor.health, sensor.link, sensor.statistics, sensor.advice, sensor.get, sensor.next_event,
                     sensor.fileno, sensor.due):
            self.one_line(stof.Closed, call, holds="closed")
        self.assertEqual(list(sensor), [])

    def test_points_take_a_calibration(self):
        with self.open() as sensor:
            frame = sensor.next(LONG_S)
            while frame.calibration is None:
                frame = sensor.next(LONG_S)
            frame._raw.has_calibration = 0
            self.one_line(stof.NotYet, frame.depth_m, holds="calibration")


class Settings(WithSensor):
    def test_reads_and_changes(self):
        with self.open(keys="") as sensor:
            self.assertEqual(sensor.get()["streams"]["grey_left"], "off")
            before = sensor.set({"streams": {"parity": False}}).revision
            answer = sensor.set({"streams": {"parity": True}})
            self.assertEqual((answer.revision, answer.restart), (before + 1, False))
            self.assertTrue(sensor.get()["streams"]["parity"])
            sensor.set({"streams.parity": False, "streams": {"cloud_step": sensor.get()["streams"]["cloud_step"]}})
            self.assertFalse(sensor.get()["streams"]["parity"])
            self.one_line(stof.BadArgument, sensor.set, {"streams.parity.more": 1, "streams.parity": True}, holds="value")
            sensor.set({"streams.parity": True})
            self.assertFalse(sensor.get(stof.Document.DEFAULTS)["streams"]["parity"])
            self.assertIn("properties", sensor.get(stof.Document.SCHEMA))
            error = self.one_line(stof.Refused, sensor.set, {"streams": {"depth": "foo"}}, holds="streams.depth: takes")
            self.assertEqual(error.status, 8)
            self.one_line(stof.Refused, sensor.preset, "moon")
            parity, depth, period = (sensor.setting(path) for path in ("streams.parity", "streams.depth", "period_ms"))
            self.assertEqual((parity.value, parity.default, parity.choices), (True, False, ()))
            self.assertEqual((depth.value, depth.choices), ("fit", ("off", "raw", "rvl", "fit")))
            self.assertEqual((period.minimum, period.maximum, period.unit), (0, 60000, "ms"))
            self.one_line(stof.BadArgument, sensor.setting, "depth.moon", holds="no such setting")
            self.one_line(stof.BadArgument, sensor.set, {"a": {1, 2}})
            self.one_line(stof.BadArgument, sensor.set, ["period_ms"], holds="no JSON object")
            self.one_line(stof.BadArgument, sensor.set, {"a": math.nan})

    def test_without_a_named_sensor_it_is_not_supported(self):
        with stof.open(bind="127.0.0.1", port=lasting_port()) as sensor:
            self.one_line(stof.Unsupported, sensor.get, holds="name the sensor")


class Health(WithSensor):
    def test_health_conditions_and_silence(self):
        with self.open() as sensor:
            end = time.monotonic() + support.ENOUGH_S
            while (sensor.health() is None or sensor.health().rate_hz == 0) and time.monotonic() < end:
                sensor.next(LONG_S)
            while (health := sensor.health()).silent and time.monotonic() < end:  # a busy machine is silent at times
                sensor.next(LONG_S)
            self.assertIn("unpaired", [str(condition) for condition in health.conditions])
            self.assertTrue(all(condition.text and condition.name != "unknown" for condition in health.conditions))
            self.assertIsInstance(health.severity, stof.Severity)
            self.assertIsInstance(health.reaction, stof.Reaction)
            self.assertEqual(health.subscribers, 1)
            self.assertGreater(health.rate_hz, 0)
            self.assertGreater(health.counters["edges"], 0)
            self.assertGreaterEqual(health.age_s, 0)
            self.assertFalse(health.silent)
            frame = sensor.next(LONG_S)
            while frame.calibration is None:
                frame = sensor.next(LONG_S)
            points = frame.pixel_points()
            self.assertEqual(len(points), (frame.depth > 0).sum())
            self.assertTrue((points["z"] == frame.points()["z"]).all())
            self.assertTrue((frame.depth[points["v"], points["u"]] > 0).all())
            # Its clock is this machine's: what was exposed was so before it came.
            self.assertLessEqual(frame.exposure_here_ns, frame.first_packet_ns)
            self.assertGreaterEqual(sensor.clock().spread_ns, 0)
            while stof.LinkCondition.SILENT in (link := sensor.link()).conditions and time.monotonic() < end:
                sensor.next(LONG_S)
            self.assertNotIn(stof.LinkCondition.SILENT, link.conditions)
            self.assertLess(link.frame_age_s, 60)
            statistics = sensor.statistics()
            self.assertGreater(statistics["frames_complete"], 0)
            self.assertGreater(statistics["socket_buffer"], 0)
            self.assertIsInstance(sensor.advice(), str)
            self.emulated.process.kill()
            while time.monotonic() < end:  # what is left in the socket
                try:
                    sensor.next(1)
                except stof.Timeout:
                    break
            self.assertIn(stof.LinkCondition.SILENT, sensor.link().conditions)
            told = []
            while (event := sensor.next_link_event()) is not None:
                told.append((event.condition, event.active))
            self.assertIn((stof.LinkCondition.SILENT, True), told)


class Finding(WithSensor):
    WORDS = ("--name", "left arm")

    @staticmethod
    def look(function):
        """What a function finds that listens for a second: a busy sensor may answer later."""
        end = time.monotonic() + support.ENOUGH_S
        while True:
            try:
                if (found := function()) or time.monotonic() > end:
                    return found
            except (stof.NotFound, AssertionError):
                if time.monotonic() > end:
                    raise

    def test_by_serial_number_and_by_name(self):
        here = {"addresses": [self.address], "find_timeout": 1.0}
        found = self.look(lambda: [one for one in stof.discover(1.0, [self.address]) if one.endpoint == self.address])
        self.assertEqual(len(found), 1)
        self.assertEqual((found[0].name, found[0].board, found[0].device_id), ("left arm", "emu", 1))
        self.assertIn(stof.FoundBy.DIRECTLY, found[0].found_by)
        for what in ({"serial": found[0].serial, "name": "left arm"}, {"name": "left arm"}):
            with self.look(lambda what=what: stof.open(**what, **here)) as sensor:
                self.assertTrue(sensor.next(LONG_S).depth.any())
        self.look(lambda: self.one_line(stof.NotFound, stof.open, serial="no\nsuch", **here, holds=self.address))

    def test_wrong_arguments(self):
        self.one_line(stof.BadArgument, stof.discover, 0.1, ["127.0.0.1:99999"])
        self.one_line(stof.BadArgument, stof.discover, -1)


class Signed(WithSensor):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        cls.addClassCleanup(folder.cleanup)
        cls.keys = pathlib.Path(folder.name) / "user"
        sensor_keys = pathlib.Path(folder.name) / "sensor"
        subprocess.run([support.STOF, "pair", "--into", sensor_keys, "--keys", cls.keys, "--role", "tune"], check=True, capture_output=True)
        cls.WORDS = ("--keys", sensor_keys)
        super().setUpClass()

    def test_takes_signed_frames(self):
        with self.open(signed_streams=True, keys=str(self.keys)) as sensor:
            for _ in range(10):
                self.assertTrue(sensor.next(LONG_S).depth.any())
            statistics = sensor.statistics()
            self.assertEqual((statistics["packets_not_signed"], statistics["packets_forged"]), (0, 0))

    def test_without_a_key_nothing_comes_and_why_is_told(self):
        with self.open(signed_streams=True, keys="/nowhere/keys") as sensor:
            end = time.monotonic() + support.ENOUGH_S
            while True:  # until the sensor has answered
                try:
                    self.one_line(stof.Timeout, sensor.next, 1, holds="none of your keys")
                    break
                except AssertionError:
                    if time.monotonic() > end:
                        raise

    def test_settings_take_the_key(self):
        with self.open(keys=str(self.keys)) as sensor:
            sensor.set({"streams": {"parity": True}})
        with self.open(keys="") as sensor:
            self.one_line(stof.Refused, sensor.set, {"streams": {"parity": False}}, holds="key")

    def test_stages_with_the_key(self):
        with self.open(keys=str(self.keys)) as sensor:
            sensor.set({"streams": {"parity": True}})
            sensor.stage({"streams": {"parity": False}})
            self.assertFalse(sensor.get(stof.Document.STAGED)["streams"]["parity"])
            self.assertTrue(sensor.get()["streams"]["parity"])
            sensor.revert()
            self.assertTrue(sensor.get(stof.Document.STAGED)["streams"]["parity"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
