#!/usr/bin/env python3
"""stof_frames_test.py: frames, streams and threads of the Python package stof, against emulated sensors. The environment is that of
package_sensor.py."""

import contextlib
import gc
import importlib.util
import os
import pathlib
import queue
import select
import subprocess
import sys
import tempfile
import threading
import time
import tracemalloc
import unittest

import package_support as support
from package_sensor import LONG_S, WithSensor, numpy, stof


def resident_bytes():
    return int(pathlib.Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")


class Frames(WithSensor):
    def test_depth_equals_what_a_c_client_gets(self):
        frames = 60
        with tempfile.TemporaryDirectory(prefix="stof_") as folder:
            client = subprocess.Popen([support.CLIENT, self.address, str(frames), folder], stdout=subprocess.PIPE)
            got = {}
            with self.open() as sensor:
                for frame in sensor.frames(LONG_S):
                    if frame.complete:
                        got[frame.number] = frame.depth
                    if client.poll() is not None:
                        break
            client.stdout.close()
            self.assertEqual(client.returncode, 0)
            compared = 0
            for file in pathlib.Path(folder).iterdir():
                depth = got.get(int(file.stem))
                if depth is not None:
                    self.assertEqual((depth.shape, depth.dtype), ((48, 64), numpy.dtype("u2")))
                    self.assertEqual(depth.tobytes(), file.read_bytes(), file.name)
                    self.assertTrue(depth.any())
                    compared += 1
        self.assertGreaterEqual(compared, frames // 2)
        self.assertGreater(len({depth.tobytes() for depth in got.values()}), frames // 2)  # they differ

    def test_1000_frames_do_not_grow(self):
        held = None
        with self.open() as sensor:
            for count, frame in enumerate(sensor.frames(LONG_S)):
                held = frame.depth, frame.interval_width[::2], frame.source, frame.cause, frame.info, frame.arrived("depth")
                if count % 50 == 0:
                    frame.depth_m()
                    sensor.health()
                    sensor.link()
                    list(sensor.events())
                if count == 200:
                    gc.collect()
                    tracemalloc.start()
                    before, traced = resident_bytes(), tracemalloc.get_traced_memory()[0]
                if count == 1200:
                    gc.collect()
                    grown, traced = resident_bytes() - before, tracemalloc.get_traced_memory()[0] - traced
                    tracemalloc.stop()
                    break
        # One frame's images have 31 kB: a thousand of them were 30 MB.
        self.assertLess(traced, 64 << 10)
        self.assertLess(grown, 3 << 20)
        self.assertEqual(held[0].shape, (48, 64))

    def test_what_is_held_stays_as_it_was(self):
        kept, parts = [], []
        with self.open() as sensor:
            for frame in sensor.frames(LONG_S):
                kept.append((frame, frame.depth, frame.depth.copy()))
                parts.append((frame.source[10:20, ::3].T, frame.source[10:20, ::3].T.copy()))  # nothing else holds this frame's memory
                if len(kept) == 40:
                    break
            for _ in range(20):
                sensor.next(LONG_S)
        del sensor
        gc.collect()
        for frame, depth, was in kept:
            numpy.testing.assert_array_equal(depth, was)
            numpy.testing.assert_array_equal(frame.depth, was)
        addresses = {depth.ctypes.data for _, depth, _ in kept}
        self.assertEqual(len(addresses), len(kept))
        del kept, frame, depth
        gc.collect()
        for part, was in parts:
            numpy.testing.assert_array_equal(part, was)

    def test_memory_goes_back_and_is_used_again(self):
        places = set()
        with self.open() as sensor:
            for _ in range(100):
                places.add(sensor.next(LONG_S).depth.ctypes.data)
        self.assertLessEqual(len(places), 8)

    def test_an_image_is_no_copy_and_cannot_be_written(self):
        with self.open() as sensor:
            frame = sensor.next(LONG_S)
            depth = frame.depth
            self.assertEqual(depth.ctypes.data, frame.depth.ctypes.data)
            self.assertFalse(depth.flags.owndata)
            with self.assertRaises(ValueError):
                depth[0, 0] = 1
            with self.assertRaises(ValueError):
                depth.flags.writeable = True
            copy = depth.copy()
            copy[0, 0] ^= 1
            self.assertNotEqual(copy[0, 0], depth[0, 0])

    def test_depth_in_metres_and_points_agree(self):
        with self.open() as sensor:
            frame = sensor.next(LONG_S)
            while frame.calibration is None:
                frame = sensor.next(LONG_S)
        unit = frame.calibration.depth_unit_m
        self.assertEqual(unit, 0.00025)
        metres = frame.depth_m()
        self.assertEqual(metres.dtype, numpy.dtype("f4"))
        numpy.testing.assert_array_equal(numpy.isnan(metres), frame.depth == 0)
        numpy.testing.assert_allclose(numpy.nan_to_num(metres), frame.depth * unit, rtol=1e-6)
        points = frame.points()
        self.assertEqual(len(points), numpy.count_nonzero(frame.depth))
        numpy.testing.assert_allclose(points["z"], metres[frame.depth != 0], rtol=1e-6)
        rows, columns = numpy.nonzero(frame.depth)
        calibration = frame.calibration
        numpy.testing.assert_allclose(points["x"], (columns - calibration.cx) / calibration.fx * points["z"], rtol=1e-4, atol=1e-6)
        numpy.testing.assert_allclose(points["y"], (rows - calibration.cy) / calibration.fy * points["z"], rtol=1e-4, atol=1e-6)
        numpy.testing.assert_array_equal(points["source"], frame.source[frame.depth != 0])

    def test_says_what_it_is(self):
        with self.open() as sensor:
            first, second = sensor.next(LONG_S), sensor.next(LONG_S)
            self.assertGreater(second.number, first.number)
            self.assertGreater(second.exposure_middle_ns, first.exposure_middle_ns)
            self.assertEqual(first.session_id, second.session_id)
            self.assertEqual((first.device_id, first.complete, first.missing("depth")), (1, True, 0))
            self.assertTrue(first.arrived("depth").all())
            self.assertLess(abs(second.last_packet_ns - time.monotonic_ns()), 60e9)
            self.assertEqual(first.info.sensors, stof.SensorSet.STEREO)
            self.assertEqual(sum(first.info.pixels_by_source), 64 * 48)
            self.assertIsNone(first.left)
            self.assertIsNone(first.cloud)
            self.assertIsNone(first.arrived("left"))
            self.assertIn("64x48", repr(first))
            self.one_line(stof.BadArgument, first.missing, "up", holds="depth")

    def test_a_program_that_ends_without_closing_says_nothing(self):
        code = ("import stof, sys\nsensor = stof.open(sys.argv[1])\nkept = [sensor.next(20) for _ in range(5)]\n"
                "depths = [frame.depth for frame in kept]\niterator = iter(sensor)\nnext(iterator)\n")
        ended = subprocess.run([sys.executable, "-B", "-c", code, self.address], capture_output=True, text=True, check=False, timeout=60,
                               env={**os.environ, "PYTHONPATH": str(support.ROOT / "host/python")})
        self.assertEqual((ended.returncode, ended.stdout, ended.stderr), (0, "", ""))

    def test_waits_in_a_poll_loop(self):
        with self.open() as sensor:
            frames = 0
            end = time.monotonic() + support.ENOUGH_S
            while frames < 5 and time.monotonic() < end:
                select.select([sensor], [], [], sensor.due())
                with contextlib.suppress(stof.Timeout):
                    sensor.next(0)
                    frames += 1
            self.assertEqual(frames, 5)


class Example(WithSensor):
    def test_shows_depth_as_a_picture(self):
        if importlib.util.find_spec("matplotlib") is None:
            self.skipTest("no matplotlib: install python3-matplotlib")
        with tempfile.TemporaryDirectory(prefix="stof_") as folder:
            picture = pathlib.Path(folder) / "depth.png"
            ended = subprocess.run([sys.executable, "-B", support.ROOT / "examples/show_depth.py", self.address, picture],
                                   capture_output=True, text=True, check=False, timeout=120,
                                   env={**os.environ, "PYTHONPATH": str(support.ROOT / "host/python"), "MPLBACKEND": "Agg"})
            self.assertEqual(ended.returncode, 0, ended.stderr)
            self.assertEqual(picture.read_bytes()[:4], b"\x89PNG")
            self.assertGreater(picture.stat().st_size, 5000)


class AllStreams(WithSensor):
    WORDS = tuple(word for setting in ("depth=raw", "grey_left=rvl", "grey_right=raw", "disparity=rvl", "pmd_raw=raw", "cloud=on", "cloud_step=8")
                  for word in ("--set", f"streams.{setting}"))
    OPTIONS = {"pmd": "32x24", "period_ms": 40}

    def test_each_has_its_shape_and_type(self):
        with self.open() as sensor:
            frame = sensor.next(LONG_S)
            while not frame.complete or frame.calibration is None:
                frame = sensor.next(LONG_S)
        for name, kind in {"depth": "u2", "interval_width": "u2", "source": "u1", "cause": "u1", "disparity": "i2", "left": "u1",
                           "right": "u1"}.items():
            image = getattr(frame, name)
            self.assertEqual((image.shape, image.dtype), ((48, 64), numpy.dtype(kind)), name)
            self.assertTrue(frame.arrived(name).all(), name)
        self.assertGreater(frame.left.std(), 5)
        self.assertGreater(frame.right.std(), 5)
        self.assertEqual([sample.shape for sample in frame.pmd], [(24, 32)] * 4)
        self.assertEqual(len({sample.tobytes() for sample in frame.pmd}), 4)
        self.assertEqual(frame.arrived("pmd3").shape, (24, 32))
        self.assertEqual(frame.cloud.shape, (6, 8))
        block = frame.cloud[3, 4]
        self.assertIn(block["depth"], frame.depth[24:32, 32:40])
        self.assertEqual((frame.calibration.pmd_width, frame.calibration.pmd_height), (32, 24))
        self.assertEqual(len(frame.calibration.r), 9)
        self.assertIn(stof.SensorSet.PMD, frame.info.sensors)

    def test_what_is_recorded_is_read_again(self):
        with tempfile.TemporaryDirectory(prefix="stof_") as folder, self.open() as sensor:
            file = pathlib.Path(folder) / "a.mcap"
            self.assertIsNone(sensor.recorded())
            sensor.record(file)
            self.one_line(stof.Busy, sensor.record, file)
            seen = {frame.number: frame.depth.copy() for frame in (sensor.next(LONG_S) for _ in range(5)) if frame.complete}
            told = sensor.end_recording()
            self.assertEqual((told.recording, told.frames, told.bytes, told.indexed), (False, 5, file.stat().st_size, True))
            self.assertEqual(sensor.recorded(), told)
            self.one_line(stof.FileFailed, sensor.record, file, holds=str(file))
            with stof.open(recording=file) as recording:
                frames = list(recording)
                with self.assertRaises(stof.End):
                    recording.next(0)
                self.assertEqual(recording.fileno(), -1)
                self.one_line(stof.Unsupported, recording.get)
            self.assertEqual(len(frames), 5)
            for frame in frames:
                self.assertTrue(frame.recorded and frame.recorded_ns)
                self.assertEqual((frame.left.shape, frame.disparity.shape, len(frame.pmd)), ((48, 64), (48, 64), 4))
                if frame.number in seen:
                    numpy.testing.assert_array_equal(frame.depth, seen[frame.number])
            self.one_line(stof.FileFailed, stof.open, recording=pathlib.Path(folder) / "absent", holds="absent")


class RawPictures(WithSensor):
    OPTIONS = {"pmd": "32x24", "period_ms": 50}

    def test_what_the_cameras_gave_comes_beside_frames(self):
        with self.open(keys="", raw=("left", "right", "pmd"), raw_every=2) as sensor:
            end = time.monotonic() + support.ENOUGH_S
            frames, exposures = {}, []
            while len(exposures) < 2 and time.monotonic() < end:
                frame = sensor.next(LONG_S)
                frames[frame.number] = frame
                while (exposure := sensor.next_raw()) is not None:
                    if exposure.complete:  # a busy machine may lose a packet
                        exposures.append(exposure)
            self.assertGreaterEqual(len(exposures), 2)
            for exposure in exposures:
                self.assertEqual((exposure.left.dtype, exposure.left.shape), ("uint8", exposure.right.shape))
                self.assertEqual([sample.dtype for sample in exposure.pmd], ["uint16"] * 4)
                self.assertGreater(int(exposure.left.max()), int(exposure.left.min()), "a picture")
                self.assertFalse((exposure.left == exposure.right).all())
                if exposure.frame_number in frames:
                    self.assertEqual(exposure.exposure_middle_ns, frames[exposure.frame_number].exposure_middle_ns)
            self.assertGreater(exposures[1].number, exposures[0].number)
        with self.open(keys="") as sensor:
            self.one_line(stof.Unsupported, sensor.next_raw)
        self.one_line(stof.BadArgument, lambda: self.open(raw="middle"), holds="left, right, pmd")


class Threads(WithSensor):
    def test_others_ask_while_one_waits_for_frames(self):
        failures, done = [], threading.Event()
        sensor = self.open(keys="")
        sensor.next(LONG_S)

        def ask():
            try:
                while not done.is_set():
                    sensor.health()
                    sensor.link()
                    sensor.statistics()
                    sensor.advice()
                    sensor.get()
            except Exception as error:  # noqa: BLE001: told below
                failures.append(error)

        threads = [threading.Thread(target=ask) for _ in range(3)]
        for thread in threads:
            thread.start()
        held = [sensor.next(LONG_S) for _ in range(60)]
        done.set()
        for thread in threads:
            thread.join()
        self.assertEqual(failures, [])
        self.assertEqual(len({frame.number for frame in held}), 60)

    def test_frames_may_be_given_to_other_threads_and_dropped_there(self):
        frames, sums = queue.Queue(4), []

        def work():
            while (frame := frames.get()) is not None:
                sums.append(int(frame.depth.sum()))

        threads = [threading.Thread(target=work) for _ in range(3)]
        for thread in threads:
            thread.start()
        with self.open() as sensor:
            for _ in range(60):
                frames.put(sensor.next(LONG_S))
        for _ in threads:
            frames.put(None)
        for thread in threads:
            thread.join()
        self.assertEqual(len(sums), 60)
        self.assertTrue(all(sums))

    def test_a_second_one_that_waits_is_told(self):
        with stof.open("127.0.0.1:9") as sensor:
            waiting = threading.Thread(target=self._wait, args=(sensor,))
            waiting.start()
            end = time.monotonic() + support.ENOUGH_S
            while not sensor._receiving and time.monotonic() < end:
                time.sleep(0.01)
            self.one_line(stof.Busy, sensor.next, 0.1, holds="another thread")
            sensor.close()
            waiting.join(support.ENOUGH_S)
            self.assertFalse(waiting.is_alive())

    def _wait(self, sensor):
        self.ended = None
        try:
            sensor.next(300)
        except stof.Error as error:
            self.ended = type(error)

    def test_close_ends_who_waits(self):
        sensor = stof.open("127.0.0.1:9")
        waiting = threading.Thread(target=self._wait, args=(sensor,))
        waiting.start()
        time.sleep(0.2)
        began = time.monotonic()
        sensor.close()
        waiting.join(support.ENOUGH_S)
        self.assertLess(time.monotonic() - began, 30)
        self.assertIs(self.ended, stof.Closed)

    def test_several_sensors_are_independent(self):
        numbers = {}

        def look(index):
            with stof.open(self.address) as sensor:
                numbers[index] = [sensor.next(LONG_S).number for _ in range(20)]

        threads = [threading.Thread(target=look, args=(index,)) for index in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(sorted(len(seen) for seen in numbers.values()), [20, 20, 20])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
