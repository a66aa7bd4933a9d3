#!/usr/bin/env python3
"""bridge_test.py STOF: stof bridge ros2 as a user runs it, read by another implementation of DDS (fast_dds_reader) and by a reader of
npm. STOFD, BRIDGE_SAMPLE, FAST_DDS_READER and NPM_FOLDER name the programs and where packages of npm lie; without FAST_DDS_READER what
reads is skipped."""

import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from bridge_support import (ENVIRONMENT, FRAME_TOPICS, TOPICS, TYPES, domain, read_by_npm, result_of, start_reader, start_sensor)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from udp_ports import lasting_port  # noqa: E402

STOF = sys.argv[1]
STOFD = [os.environ["STOFD"]]
SAMPLE = os.environ["BRIDGE_SAMPLE"]
READER = [word for word in os.environ.get("FAST_DDS_READER", "").split() if word]
HASHES = {  # of ROS 2 Jazzy
    "depth/image_raw": "d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47",
    "depth/camera_info": "b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275",
    "depth/points": "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5",
    "tf_static": "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"}
SMALL = ("--period-ms", "100", "--size", "64x48", "--pmd", "44x36")
SECONDS = 120  # for what has to come


class Bridge(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.said = []

    def needs_reader(self):
        if not READER:
            self.skipTest("Fast DDS is not installed: scripts/setup ci")

    def sensor(self, **more):
        sensor, place = start_sensor(STOFD, self.folder, *SMALL, **more)
        self.addCleanup(sensor.wait)
        self.addCleanup(sensor.kill)
        return sensor, place

    def bridge(self, source, *more):
        bridge = subprocess.Popen([STOF, "bridge", "ros2", str(source), "--domain", str(domain()), *more], env=ENVIRONMENT,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(bridge.communicate)
        self.addCleanup(bridge.kill)
        self.listener = threading.Thread(target=lambda: self.said.extend(bridge.stdout), daemon=True)
        self.listener.start()
        return bridge

    def read(self, name_space, counts, *more):
        code, told = result_of(start_reader(READER, domain(), name_space, SECONDS, counts, *more))
        self.assertEqual(code, 0, (told, self.said))
        for topic, found in told.items():
            self.assertEqual((found["errors"], found["error"]), (0, ""), topic)
        return told

    def diagnostics_until(self, name_space, pattern):
        """What diagnostics say when they say that: a busy computer may be silent for a moment."""
        end = time.monotonic() + SECONDS
        while True:
            told = self.read(name_space, {"diagnostics": 1})["diagnostics"]["newest"]
            if re.search(pattern, told) or time.monotonic() > end:
                self.assertRegex(told, pattern)
                return

    def test_other_programs_read_every_topic(self):
        self.needs_reader()
        count = 20
        payloads = self.folder / "payloads"
        sample = subprocess.Popen([SAMPLE, str(domain()), "robot/front", str(count)], env=ENVIRONMENT)
        self.addCleanup(sample.wait)
        self.addCleanup(sample.kill)
        told = self.read("robot/front", dict.fromkeys(TOPICS, count), "--payloads", payloads)
        self.assertEqual(sample.wait(timeout=SECONDS), 0)
        self.assertEqual({topic: found["count"] for topic, found in told.items()}, dict.fromkeys(TOPICS, count))
        for topic, found in told.items():
            package, kind = TYPES[topic].split("/")
            self.assertEqual(found["type"], f"{package}::msg::dds_::{kind}_")
            self.assertRegex(found["user_data"], "^typehash=RIHS01_[0-9a-f]{64};$")
            if topic in HASHES:
                self.assertEqual(found["user_data"], f"typehash=RIHS01_{HASHES[topic]};")
            self.assertEqual((found["reliable"], found["transient_local"]), (True, topic == "tf_static"), topic)
        counts, missing = read_by_npm(payloads, pathlib.Path(os.environ["NPM_FOLDER"]))
        if missing is not None:
            self.skipTest(missing)
        self.assertEqual(counts, {TYPES[topic]: count for topic in TOPICS})

    def test_sensor_goes_and_comes_again(self):
        self.needs_reader()
        begun = time.time_ns()
        sensor, place = self.sensor(port=str(lasting_port()))
        bridge = self.bridge(place, "--namespace", "front", "--mount", "base_link:0.2,0,0.3,0,0,1.5707963267948966")
        arrivals = self.folder / "arrivals"
        # A reader that takes what comes without asking again is served as well, and one that comes late gets the transforms.
        told = self.read("front", dict.fromkeys(FRAME_TOPICS, 5), "--best-effort", "--arrivals", arrivals)
        self.assertTrue(told["depth/image_raw"]["newest"].startswith("front_left_optical_frame 64x48 16UC1 "))
        for line in arrivals.read_text().splitlines():
            _, stamp, arrived = line.split()
            self.assertTrue(begun < int(stamp) <= int(arrived), line)
        told = self.read("front", {"tf_static": 1})
        self.assertEqual(told["tf_static"]["newest"], "base_link>front_link 0.200 0.000 0.300 0.000 0.000 0.707 0.707; "
                         "front_link>front_left_optical_frame 0.000 0.000 0.000 -0.500 0.500 -0.500 0.500; ")
        self.diagnostics_until("front", "front: link=0 frames come; sensor_clock free; stamp_bound_us [0-9]+; ")

        sensor.kill()
        sensor.wait()
        self.diagnostics_until("front", "front: health=3 .*front: link=3 no frame for ")
        told = self.read("front", {"diagnostics": 3, "depth/image_raw": 0})
        self.assertEqual(told["depth/image_raw"]["count"], 0)
        self.assertIn("front: link=3 no frame for ", told["diagnostics"]["newest"])
        self.assertIn("front: health=3 ", told["diagnostics"]["newest"])

        self.sensor(port=place.rsplit(":", 1)[1])
        self.read("front", dict.fromkeys(FRAME_TOPICS, 5))
        self.diagnostics_until("front", "front: link=0 frames come")
        bridge.send_signal(signal.SIGTERM)
        self.assertEqual(bridge.wait(timeout=SECONDS), 0, self.said)
        self.listener.join(SECONDS)
        self.assertIn("frames of sensor 1, which has started again\n", self.said)

    def test_recording_is_published_with_the_stamps_of_then(self):
        self.needs_reader()
        begun = time.time_ns()
        sensor, place = self.sensor()
        file = self.folder / "file.mcap"
        subprocess.run([STOF, "record", place, str(file), "--frames", "30", "--timeout", "60"], check=True, timeout=SECONDS, stdout=subprocess.DEVNULL)
        ended = time.time_ns()
        sensor.kill()
        bridge = self.bridge(file)
        arrivals = self.folder / "arrivals"
        told = self.read("stof", {"depth/image_raw": 5, "diagnostics": 1}, "--arrivals", arrivals)
        self.assertEqual(bridge.wait(timeout=SECONDS), 0, self.said)
        self.assertIn("stof: link=1 REPLAY: nothing of it is new", told["diagnostics"]["newest"])
        stamps = [int(line.split()[1]) for line in arrivals.read_text().splitlines() if line.startswith("depth/")]
        second = 1_000_000_000
        self.assertTrue(all(begun - second < stamp < ended for stamp in stamps), (begun, ended, stamps))

    def test_bad_input_is_one_line(self):
        broken = self.folder / "broken.mcap"
        broken.write_bytes(b"nothing of a recording")
        for fact, words, environment in (
                ("--namespace", ("x", "--namespace", "9a"), {}), ("--mount", ("x", "--mount", "base"), {}),
                ("--mount", ("x", "--mount", "base:1,2"), {}), ("--mount", ("x", "--mount", "base:1,2,nan,0"), {}),
                ("--domain", ("x", "--domain", "233"), {}), ("ROS_DOMAIN_ID", ("x",), {"ROS_DOMAIN_ID": "one"}),
                ("--loop", ("127.0.0.1:9", "--loop"), {}), ("--signed", ("-", "--signed"), {}), ("--cloud-step", ("x", "--cloud-step", "65"), {}),
                ("MCAP", (broken,), {}), ("--times", ("127.0.0.1:9", "--times", self.folder, "--domain", str(domain())), {}),
                ("nowhere.invalid", ("nowhere.invalid", "--domain", str(domain())), {})):
            ended = subprocess.run([STOF, "bridge", "ros2", *map(str, words)], env={**ENVIRONMENT, **environment}, capture_output=True,
                                   text=True, timeout=SECONDS)
            self.assertEqual(ended.returncode, 2, (words, ended.stderr))
            self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
            self.assertIn(fact, ended.stderr)


if __name__ == "__main__":
    sys.argv = sys.argv[:1] + ["-v"]
    unittest.main()
