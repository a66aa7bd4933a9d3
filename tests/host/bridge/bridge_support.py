"""What bridge_test.py and scripts/bridge_check share: a bridge and readers of other programs, on loopback alone."""

import json
import os
import pathlib
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from npm_packages import fetch  # noqa: E402

PAYLOADS = pathlib.Path(__file__).with_name("dds_payloads.mjs")
# Pinned: what was tested, and what a later release cannot change.
PACKAGES = ("@foxglove/rosmsg2-serialization@3.1.0", "@foxglove/rosmsg-msgs-common@3.2.3")
FRAME_TOPICS = ("depth/image_raw", "depth/camera_info", "depth/points")
TOPICS = (*FRAME_TOPICS, "diagnostics", "tf_static")
TYPES = {"depth/image_raw": "sensor_msgs/Image", "depth/camera_info": "sensor_msgs/CameraInfo", "depth/points": "sensor_msgs/PointCloud2",
         "diagnostics": "diagnostic_msgs/DiagnosticArray", "tf_static": "tf2_msgs/TFMessage"}
# Neither multicast nor a network: two programs of this machine find each other by their ports.
CYCLONE = ("<General><Interfaces><NetworkInterface address='127.0.0.1'/></Interfaces><AllowMulticast>false</AllowMulticast></General>"
           "<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address='127.0.0.1'/></Peers></Discovery>")
ENVIRONMENT = {**os.environ, "CYCLONEDDS_URI": CYCLONE}
ENVIRONMENT.pop("ROS_DOMAIN_ID", None)


def domain():
    """One of this process; the ports of all these lie below those that systems give away."""
    return 10 + os.getpid() % 90


def start_reader(reader, number, name_space, seconds, counts, *more):
    """fast_dds_reader, of {topic: how many messages}."""
    words = [f"{topic}={count}" for topic, count in counts.items()]
    return subprocess.Popen([*reader, str(number), name_space, str(seconds), *words, *map(str, more)], stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True)


def result_of(reading):
    """(its exit code, its JSON object)."""
    out, error = reading.communicate(timeout=600)
    lines = out.strip().split("\n")
    if not lines[-1].startswith("{"):
        raise AssertionError(f"fast_dds_reader: {out}{error}")
    return reading.returncode, json.loads(lines[-1])


def start_sensor(stofd, folder, *flags, port="0"):
    """(stofd on an emulated rig, HOST:PORT)."""
    file = folder / f"sensor{time.monotonic_ns()}.port"
    sensor = subprocess.Popen([*stofd, "--port", port, "--port-file", str(file), *flags], cwd=folder, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL)
    for _ in range(1200):
        if file.is_file() and file.read_text().strip():
            return sensor, "127.0.0.1:" + file.read_text().strip()
        if sensor.poll() is not None:
            break
        time.sleep(0.1)
    sensor.kill()
    raise AssertionError("stofd did not start")


def read_by_npm(payloads, folder):
    """({type: messages}, None), or (None, why it cannot be tried)."""
    missing = fetch(folder, PACKAGES)
    if missing is not None:
        return None, missing
    ended = subprocess.run(["node", str(PAYLOADS), str(payloads)], cwd=folder, capture_output=True, text=True, timeout=300)
    if ended.returncode != 0:
        raise AssertionError(ended.stdout + ended.stderr)
    return json.loads(ended.stdout), None
