#!/usr/bin/env python3
"""record_test.py COMMAND...: stof record, info, export and recover (COMMAND is stof, with an emulator before it in a
cross build) as a user runs them, against stofd. STOFD and RECORDING_SAMPLE hold the commands of stofd and of what writes a
recording with messages of every kind, their words separated by |. Where node or the modules of mcap_reader.mjs are not
installed, what reads recordings with them is skipped."""

import json
import os
import pathlib
import random
import re
import resource
import select
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
SAMPLE = [word for word in os.environ.get("RECORDING_SAMPLE", "").split("|") if word]
NODE = os.environ.get("NODE", "node")
READER = pathlib.Path(__file__).with_name("mcap_reader.mjs")
WIDTH, HEIGHT = 160, 120
STREAMS = ("disparity", "pmd_raw", "grey_left", "grey_right")
OF_A_FRAME = {"/stof/frame_info", "/stof/depth/image_raw", "/stof/depth/camera_info", "/stof/depth/exact", "/stof/depth/width",
              "/stof/depth/source", "/stof/disparity", "/stof/pmd/raw", "/stof/left/image_rect", "/stof/right/image_rect"}
BESIDE = {"/stof/calibration", "/stof/health", "/stof/event", "/stof/settings", "/diagnostics"}
RAW = {"/stof/raw/edge", "/stof/raw/left", "/stof/raw/right", "/stof/raw/pmd"}


class Record(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="stof_")
        cls.addClassCleanup(cls.scratch.cleanup)
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.sensor, cls.place = cls.start_sensor("sensor")
        cls.addClassCleanup(cls.sensor.wait)
        cls.addClassCleanup(cls.sensor.kill)
        cls.whole = cls.folder / "whole.mcap"
        ended = cls.stof("record", cls.place, cls.whole, "--frames", 12, "--json")
        assert ended.returncode == 0, ended.stderr
        cls.recorded = json.loads(ended.stdout)

    @classmethod
    def start_sensor(cls, name):
        port = cls.folder / f"{name}.port"
        streams = [word for stream in STREAMS for word in ("--set", f"streams.{stream}=rvl")]
        sensor = subprocess.Popen([*STOFD, "--port", "0", "--port-file", str(port), "--period-ms", "100", "--size", f"{WIDTH}x{HEIGHT}", "--pmd", "44x36", *streams],
                                  cwd=cls.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for _ in range(1200):
            if port.is_file() and port.read_text().strip():
                return sensor, "127.0.0.1:" + port.read_text().strip()
            time.sleep(0.1)
        sensor.kill()
        raise AssertionError("stofd did not start")

    @classmethod
    def stof(cls, *arguments, **more):
        return subprocess.run([*COMMAND, *map(str, arguments)], capture_output=True, text=True, timeout=120, cwd=cls.folder, **more)

    def succeed(self, *arguments):
        ended = self.stof(*arguments)
        self.assertEqual(ended.returncode, 0, ended.stdout + ended.stderr)
        self.assertEqual(ended.stderr, "")
        return ended.stdout

    def refuse(self, code, fact, *arguments, **more):
        ended = self.stof(*arguments, **more)
        self.assertEqual(ended.returncode, code, ended.stdout + ended.stderr)
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertTrue(ended.stderr.startswith("stof: "), ended.stderr)
        self.assertIn(fact, ended.stderr)

    def cut(self, name, size):
        path = self.folder / name
        path.write_bytes(self.whole.read_bytes()[:size])
        return path

    def test_each_verb_has_help_with_an_example(self):
        for verb in ("record", "info", "export", "recover", "replay"):
            self.assertIn(f"Example: stof {verb} ", self.succeed(verb, "--help"))

    def test_recording_has_every_channel(self):
        self.assertEqual(self.recorded["frames"], 12)
        self.assertTrue(self.recorded["whole"] and self.recorded["indexed"])
        info = json.loads(self.succeed("info", self.whole, "--json"))
        self.assertTrue(info["indexed"])
        self.assertEqual(info["frames"], 12)
        self.assertEqual(info["messages"], self.recorded["messages"])
        counts = {channel["topic"]: channel["messages"] for channel in info["channels"]}
        self.assertEqual(set(counts) - BESIDE, OF_A_FRAME)
        self.assertEqual({counts[topic] for topic in OF_A_FRAME}, {12})
        self.assertEqual(counts["/stof/calibration"], 1)
        self.assertEqual(counts["/stof/health"], counts["/diagnostics"])
        self.assertEqual(info["sensor"]["device_id"], "1")
        self.assertEqual(info["calibration"]["width"], WIDTH)
        self.assertEqual([one["name"] for one in info["attachments"]], ["settings.json"])
        text = self.succeed("info", self.whole)
        self.assertIn("whole, with index", text)

    def test_limits_end_it(self):
        begin = time.monotonic()
        file = self.folder / "second.mcap"
        self.succeed("record", self.place, file, "--seconds", "1")
        self.assertLess(time.monotonic() - begin, 100)
        self.assertGreaterEqual(json.loads(self.succeed("info", file, "--json"))["frames"], 1)

    def test_interrupt_and_a_closed_terminal_end_it_whole(self):
        for number in (signal.SIGINT, signal.SIGHUP):
            file = self.folder / f"interrupted_{number}.mcap"
            recording = subprocess.Popen([*COMMAND, "record", self.place, str(file)], cwd=self.folder, stdout=subprocess.PIPE, text=True,
                                         preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))
            for line in recording.stdout:
                if "frames recorded" in line:
                    break
            recording.send_signal(number)
            recording.communicate(timeout=60)
            self.assertEqual(recording.returncode, 0)
            self.assertTrue(json.loads(self.succeed("info", file, "--json"))["indexed"])

    def test_killed_recording_is_recovered(self):
        file = self.folder / "killed.mcap"
        recording = subprocess.Popen([*COMMAND, "record", self.place, str(file)], cwd=self.folder, stdout=subprocess.PIPE, text=True)
        told = []  # when, and how many frames had come
        for line in recording.stdout:
            if "frames recorded" in line:
                told.append((time.monotonic(), int(line.split()[0])))
                if told[-1][0] - told[0][0] > 6:
                    break
        recording.kill()
        recording.communicate()
        info = json.loads(self.succeed("info", file, "--json"))
        self.assertFalse(info["indexed"])
        self.assertIn("cut", info["state"])
        # Lost is what came within the last second; a busy computer gets three more.
        kept = max(frames for when, frames in told if when < told[-1][0] - 4)
        self.assertGreater(kept, 0)
        self.assertGreaterEqual(info["frames"], kept)
        self.succeed("recover", file)
        after = json.loads(self.succeed("info", file, "--json"))
        self.assertTrue(after["indexed"])
        self.assertEqual(after["frames"], info["frames"])

    def test_cut_recordings_are_recovered(self):
        choose = random.Random(3)
        size = self.whole.stat().st_size
        for point in [choose.randrange(100, size) for _ in range(10)]:
            file = self.cut("cut.mcap", point)
            before = json.loads(self.succeed("info", file, "--json"))
            self.assertFalse(before["indexed"], point)
            answer = json.loads(self.succeed("recover", file, "--json"))
            self.assertFalse(answer["was_whole"])
            self.assertEqual(answer["messages"], before["messages"], point)
            self.assertTrue(json.loads(self.succeed("info", file, "--json"))["indexed"], point)
        out = self.folder / "out.mcap"
        self.succeed("recover", self.cut("cut.mcap", size - 9), out)
        self.assertEqual(json.loads(self.succeed("info", out, "--json"))["messages"], self.recorded["messages"])
        self.assertIn("nothing was changed", self.succeed("recover", out))

    def test_full_disk_ends_it_with_what_was_written(self):
        file = self.folder / "full.mcap"
        limit = 2_500_000
        self.refuse(1, "make room", "record", self.place, file, "--frames", 1000,
                    preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
        self.assertLessEqual(file.stat().st_size, limit)
        info = json.loads(self.succeed("info", file, "--json"))
        self.assertTrue(info["indexed"])
        self.assertGreater(info["frames"], 0)

    def test_full_disk_names_the_frames_that_are_not_in_the_file(self):
        limit = 2_500_000
        full = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        file = self.folder / "full_json.mcap"
        ended = self.stof("record", self.place, file, "--frames", 1000, "--json", preexec_fn=full)
        told = json.loads(ended.stdout)
        info = json.loads(self.succeed("info", file, "--json"))
        self.assertEqual((ended.returncode, told["whole"], info["state"]), (1, True, "whole, with index"), ended.stderr)
        self.assertEqual(told["frames"], info["frames"])
        self.assertGreater(told["frames_not_written"], 0)
        file = self.folder / "full_text.mcap"
        ended = self.stof("record", self.place, file, "--frames", 1000, preexec_fn=full)
        left_out = re.search(r"wrote .*: (\d+) frames, .*; (\d+) frames that came are not in it", ended.stdout)
        received = re.search(r"(\d+) frames received", ended.stdout)
        self.assertTrue(left_out and received, ended.stdout)
        self.assertEqual(int(received[1]), int(left_out[1]) + int(left_out[2]), ended.stdout)

    def test_silence_is_told_at_once_also_beside_json(self):
        sensor, place = self.start_sensor("standing")
        self.addCleanup(sensor.wait)
        self.addCleanup(sensor.kill)
        for words in (("record", place, "standing.mcap"), ("export", place, "--to", "standing", "--as", "csv")):
            with self.subTest(words[0]):
                receiving = subprocess.Popen([*COMMAND, *words, "--json", "--timeout", "60"], cwd=self.folder, stdout=subprocess.PIPE,
                                             stderr=subprocess.PIPE, text=True)
                self.addCleanup(receiving.kill)
                told = []
                for _ in range(20):  # on a busy computer no frame may have come yet
                    time.sleep(2)
                    sensor.send_signal(signal.SIGSTOP)
                    told, _, _ = select.select([receiving.stderr], [], [], 5)
                    sensor.send_signal(signal.SIGCONT)
                    if told:
                        break
                self.assertTrue(told)
                self.assertIn("link: the sensor is silent, its last frame is ", receiving.stderr.readline())
                self.assertIn("link: the sensor sends again", receiving.stderr.readline())
                receiving.send_signal(signal.SIGINT)
                said, errors = receiving.communicate(timeout=120)
                self.assertEqual(receiving.returncode, 0, errors)
                answer = json.loads(said)
                self.assertGreaterEqual(answer["silences"], 1)
                self.assertEqual(answer["restarts"], 0)

    def test_disk_that_holds_no_frame_leaves_no_file(self):
        file = self.folder / "tiny.mcap"
        self.refuse(1, "no frame was kept", "record", self.place, file, "--frames", 1000,
                    preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000)))
        self.assertFalse(file.exists())

    def test_bad_files_are_found_before_frames_are_received(self):
        nobody = "127.0.0.1:9"  # where nothing answers: the file is looked at first
        self.refuse(2, "is not a file", "record", nobody, "/dev/full")
        self.refuse(2, "is not a file", "record", nobody, self.folder)
        self.refuse(2, "make the folder", "record", nobody, self.folder / "absent" / "r.mcap")
        self.refuse(2, "Not a directory", "record", nobody, self.whole / "r.mcap")
        self.refuse(2, "--force", "record", nobody, self.whole)
        self.refuse(2, "stdout", "record", nobody, "-")
        link = self.folder / "dangling.mcap"
        link.symlink_to(self.folder / "nowhere.mcap")
        for force in ((), ("--force",)):
            self.refuse(2, "dangling.mcap: is a link: a link is not written through", "record", nobody, link, *force)
        empty = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
        self.refuse(2, "make room", "record", nobody, self.folder / "r.mcap", preexec_fn=empty)
        self.assertFalse((self.folder / "r.mcap").exists(), "the same command has to work once there is room")
        for verb in ("info", "recover"):
            self.refuse(2, "does not exist", verb, self.folder / "absent")
            self.refuse(2, "is not a file", verb, self.folder)
            self.refuse(2, "not an MCAP file", verb, __file__)
        self.refuse(2, "does not exist", "export", "absent", "--to", "x", "--as", "ply")
        self.refuse(2, "--as", "export", self.whole, "--to", "x", "--as", "bmp")
        self.refuse(2, "--signed", "record", "-", "x.mcap", "--signed")

    def test_sensor_that_is_not_there_or_goes(self):
        file = self.folder / "lost.mcap"
        self.refuse(1, "no frame came", "record", "127.0.0.1:9", file, "--timeout", "0.5")
        self.assertFalse(file.exists())
        sensor, place = self.start_sensor("going")
        recording = subprocess.Popen([*COMMAND, "record", place, str(file), "--timeout", "1"], cwd=self.folder,
                                     stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for line in recording.stdout:
            if "frames recorded" in line:
                break
        sensor.kill()
        sensor.wait()
        _, error = recording.communicate(timeout=60)
        self.assertEqual(recording.returncode, 1)
        self.assertIn("the stream ended", error)
        self.assertEqual(error.count("\n"), 1)
        self.assertTrue(json.loads(self.succeed("info", file, "--json"))["indexed"])

    def test_exports_are_files_of_their_formats(self):
        for how in ("png16", "ply", "pcd", "csv", "tum"):
            answer = json.loads(self.succeed("export", self.whole, "--to", how, "--as", how, "--frames", 3, "--json"))
            self.assertEqual((answer["frames"], answer["exported"]), (3, 3))
        png = (self.folder / "png16" / "000002.png").read_bytes()
        self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(struct.unpack(">IIBB", png[16:26]), (WIDTH, HEIGHT, 16, 0))
        depths = self.png_values(png)
        for how, begin in (("ply", b"end_header\n"), ("pcd", b"DATA binary\n")):
            cloud = (self.folder / how / f"000002.{how}").read_bytes()
            body = cloud.split(begin, 1)[1]
            points = [struct.unpack_from("<4fB", body, at) for at in range(0, len(body), 17)]
            self.assertEqual(len(points), sum(depth != 0 for depth in depths))
            self.assertEqual([round(point[2] * 4000) for point in points], [depth for depth in depths if depth])
        frames = (self.folder / "csv" / "frames.csv").read_text().splitlines()
        self.assertEqual(len(frames), 4)
        self.assertEqual(int(frames[3].split(",")[8]), len(points))
        self.assertGreater(len((self.folder / "csv" / "health.csv").read_text().splitlines()), 1)
        stamp, name = (self.folder / "tum" / "depth.txt").read_text().splitlines()[3].split()
        self.assertEqual(name, f"depth/{stamp}.png")
        tum = self.png_values((self.folder / "tum" / name).read_bytes())
        expected = [value if value <= 65535 else 0 for value in ((depth * 250 + 100) // 200 for depth in depths)]
        self.assertEqual(tum, expected)
        self.assertEqual(len((self.folder / "tum" / "rgb.txt").read_text().splitlines()), 4)

    def damaged(self, name, *places):
        """The whole recording with other bytes at these places."""
        data = bytearray(self.whole.read_bytes())
        for place in places:
            data[place] ^= 0x10
        path = self.folder / name
        path.write_bytes(data)
        return path

    def chunks(self):
        """Begin and length of each chunk's record."""
        data, at, found = self.whole.read_bytes(), 8, []
        while data[at] != 0x0F:
            length = 9 + struct.unpack_from("<Q", data, at + 1)[0]
            found += [(at, length)] if data[at] == 6 else []
            at += length
        return found

    def test_damage_in_the_middle_is_the_same_to_all(self):
        """One bit of the first chunk's kind, of its length, and of its content."""
        chunks = self.chunks()
        if len(chunks) < 2:
            self.skipTest("all frames came at once")
        begin, length = chunks[0]
        for place in (begin, begin + 2, begin + length - 5):
            file = self.damaged("damaged.mcap", place)
            before = file.read_bytes()
            ended = self.stof("info", file, "--json")
            info = json.loads(ended.stdout)
            self.assertEqual((ended.returncode, info["damaged"]), (1, 1), ended.stderr)
            self.assertGreaterEqual(info["damaged_bytes"], length)
            self.assertLess(info["frames"], 12)
            ended = self.stof("export", file, "--to", "rest", "--as", "csv", "--json")
            exported = json.loads(ended.stdout)
            self.assertEqual((ended.returncode, exported["frames"], exported["damaged"]), (1, info["frames"], 1))
            ended = self.stof("stats", file, "--json")
            self.assertEqual((ended.returncode, json.loads(ended.stdout)["damaged"]), (1, 1), ended.stderr)
            self.assertIn("1 record in it is damaged", ended.stderr)
            ended = self.stof("check", file)
            self.assertEqual(ended.returncode, 1)
            self.assertIn("1 record in it is damaged", ended.stdout)
            self.assertNotIn("parity", ended.stdout)
            self.refuse(2, "give OUT", "recover", file)
            self.assertEqual(file.read_bytes(), before)
            out = self.folder / "sound.mcap"
            self.refuse(1, "1 record in it is damaged", "recover", file, out, "--force")
            self.assertEqual(json.loads(self.succeed("info", out, "--json"))["frames"], info["frames"])
        self.refuse(2, "--force", "recover", self.whole, out)
        self.refuse(2, "name it", "recover", self.whole, "--force")

    def test_cut_recording_is_told_by_check_and_stats(self):
        file = self.cut("told.mcap", self.whole.stat().st_size - 20)
        checks = {one["name"]: one for one in json.loads(self.stof("check", file, "--json").stdout)["checks"]}
        self.assertEqual(checks["file"]["verdict"], "note", checks)
        self.assertIn("stof recover FILE", checks["file"]["fix"])
        self.assertIn("cut: stof recover FILE", self.succeed("stats", file))
        self.assertEqual(json.loads(self.succeed("stats", file, "--json"))["state"], "cut: stof recover FILE")
        self.assertNotIn("  file ", self.succeed("stats", self.whole))

    def test_two_recordings_in_one_file_are_not_measured_as_one(self):
        file = self.folder / "two.mcap"
        file.write_bytes(2 * self.whole.read_bytes())
        one = json.loads(self.succeed("stats", self.whole, "--json"))
        ended = self.stof("stats", file, "--json")
        two = json.loads(ended.stdout)
        self.assertEqual((ended.returncode, two["files"], two["damaged"]), (1, 2, 1), ended.stderr)
        self.assertEqual(two["received_frames"], 2 * one["received_frames"])
        self.assertAlmostEqual(two["seconds"], 2 * one["seconds"], 6)
        self.assertAlmostEqual(two["rate_hz"], one["rate_hz"], 6)
        self.assertAlmostEqual(two["interval_ms"]["longest"], one["interval_ms"]["longest"], 6)
        self.assertEqual((two["restarts"], two["frames"]["lost"]), (0, 2 * one["frames"]["lost"]))
        checks = {one["name"]: one for one in json.loads(self.stof("check", file, "--json").stdout)["checks"]}
        self.assertIn("2 recordings lie in it, one behind the other", checks["file"]["found"])
        self.assertNotIn("stamps go back", checks["clock"]["found"])
        self.assertIn("2 recordings lie in it", self.stof("stats", file).stdout)

    def test_recording_without_a_sound_frame_says_why(self):
        file = self.damaged("none.mcap", *(begin + length - 5 for begin, length in self.chunks()))
        self.refuse(1, "records in it are damaged", "export", file, "--to", "nothing", "--as", "ply")

    def test_full_disk_ends_each_export_with_1(self):
        for how in ("png16", "ply", "pcd", "csv", "tum"):
            self.refuse(1, "make room", "export", self.whole, "--to", f"full_{how}", "--as", how,
                        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100)))

    def test_exports_follow_no_links_and_wait_at_no_pipes(self):
        target = self.folder / "target"
        target.write_text("kept")
        for how, name in (("png16", "000000.png"), ("ply", "000000.ply"), ("pcd", "000000.pcd"), ("csv", "frames.csv"), ("tum", "depth.txt")):
            for kind in ("link", "pipe"):
                folder = self.folder / f"{kind}_{how}"
                folder.mkdir()
                if kind == "link":
                    (folder / name).symlink_to(target)
                else:
                    os.mkfifo(folder / name)
                self.refuse(1, "cannot be written", "export", self.whole, "--to", folder, "--as", how, "--frames", 1)
        folder = self.folder / "link_folder"
        folder.mkdir()
        (folder / "depth").symlink_to(self.folder)
        self.refuse(2, "is a link", "export", self.whole, "--to", folder, "--as", "tum", "--frames", 1)
        (self.folder / "link.mcap").symlink_to(target)
        self.refuse(2, "a link is not written through", "record", "127.0.0.1:9", self.folder / "link.mcap", "--force")
        self.assertEqual(target.read_text(), "kept")

    def test_a_file_that_is_being_written_is_left_alone(self):
        file = self.folder / "busy.mcap"
        recording = subprocess.Popen([*COMMAND, "record", self.place, str(file)], cwd=self.folder, stdout=subprocess.PIPE, text=True)
        for line in recording.stdout:
            if "frames recorded" in line:
                break
        self.refuse(2, "being written", "record", self.place, file, "--force", "--frames", 1)
        self.refuse(2, "being written", "recover", file)
        self.assertEqual(json.loads(self.succeed("info", file, "--json"))["state"], "not whole yet: another program writes it")
        recording.send_signal(signal.SIGINT)
        recording.communicate(timeout=60)
        self.assertEqual(recording.returncode, 0)
        info = json.loads(self.succeed("info", file, "--json"))
        self.assertTrue(info["indexed"])
        self.assertGreater(info["frames"], 0)

    @staticmethod
    def png_values(png):
        """Pixels of a 16-bit grey picture."""
        data, at = b"", 8
        while at < len(png):
            length, kind = struct.unpack_from(">I4s", png, at)
            data += png[at + 8:at + 8 + length] if kind == b"IDAT" else b""
            at += length + 12
        raw, stride, width = zlib.decompress(data), 2 * WIDTH, 2
        before, values = bytearray(stride), []
        for row in range(HEIGHT):
            kind, *line = raw[row * (stride + 1):(row + 1) * (stride + 1)]
            line = bytearray(line)
            for x in range(stride):
                a, b = line[x - width] if x >= width else 0, before[x]
                c = before[x - width] if x >= width else 0
                p = a + b - c
                paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
                line[x] = (line[x] + (0, a, b, (a + b) // 2, paeth)[kind]) & 255
            values += struct.unpack(f">{stride // 2}H", bytes(line))
            before = line
        return values

    def test_other_programs_read_it(self):
        """@mcap/core by index and as a stream, @foxglove/rosmsg2-serialization every message."""
        cut = self.cut("other.mcap", self.whole.stat().st_size * 2 // 3)
        before = json.loads(self.succeed("info", cut, "--json"))
        for file, more, expected in ((self.whole, (), self.recorded["messages"]), (self.whole, ("--stream",), self.recorded["messages"]),
                                     (cut, ("--stream",), before["messages"])):
            self.assertEqual(sum(self.read_elsewhere(file, *more)["counts"].values()), expected)
        self.succeed("recover", cut)
        self.assertEqual(sum(self.read_elsewhere(cut)["counts"].values()), before["messages"])

    def test_other_programs_read_a_thousand_messages_of_each_channel(self):
        file = self.folder / "sample.mcap"
        subprocess.run([*SAMPLE, str(file), "1000"], check=True, timeout=120)
        for more in ((), ("--stream",)):
            counts = self.read_elsewhere(file, *more)["counts"]
            self.assertEqual(counts, {topic: 1000 for topic in OF_A_FRAME | BESIDE | RAW | {"/stof/depth/received"}})

    def read_elsewhere(self, *arguments):
        try:
            ended = subprocess.run([NODE, str(READER), *map(str, arguments)], capture_output=True, text=True, timeout=120)
        except FileNotFoundError:
            self.skipTest("node is not installed")
        if ended.returncode == 77:
            self.skipTest(f"{ended.stdout.strip()}: name its folder in STOF_NODE_MODULES")
        self.assertEqual(ended.returncode, 0, ended.stderr)
        return json.loads(ended.stdout)


if __name__ == "__main__":
    COMMAND = sys.argv[1:]
    sys.argv = sys.argv[:1] + ["-v"]
    unittest.main()
