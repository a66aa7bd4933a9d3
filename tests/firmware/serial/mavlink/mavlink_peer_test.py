#!/usr/bin/env python3
"""mavlink_peer_test.py FOLDER -- COMMAND...: what mavlink_frames (COMMAND, with an emulator before it in a cross build)
writes is read by node-mavlink, which npm fetches into FOLDER once. Ends with 77 where there is no node, no npm or
no network."""

import json
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "support"))
from npm_packages import fetch  # noqa: E402

PACKAGES = ("node-mavlink@2.3.0", "mavlink-mappings@1.0.21-20250824-1")
COUNT = 1000
KINDS = ("HEARTBEAT", "OBSTACLE_DISTANCE", "DISTANCE_SENSOR")
SCRIPT = pathlib.Path(__file__).resolve().with_name("mavlink_peer.mjs")


def skip(why):
    print(f"mavlink_peer_test: skipped: {why}")
    sys.exit(77)


def main():
    split = sys.argv.index("--")
    folder = pathlib.Path(sys.argv[1]).resolve()
    command = sys.argv[split + 1:]
    missing = fetch(folder, PACKAGES)
    if missing is not None:
        skip(missing)
    with tempfile.TemporaryDirectory(prefix="stof_") as scratch:
        frames, expected = (str(pathlib.Path(scratch) / name) for name in ("frames", "expected"))
        subprocess.run([*command, str(COUNT), frames, expected], check=True, timeout=60)
        ended = subprocess.run(["node", str(SCRIPT), frames, expected], cwd=folder, capture_output=True, text=True,
                               timeout=60)
    if ended.returncode != 0:
        sys.exit(f"mavlink_peer_test: {ended.stdout}{ended.stderr}")
    counts = json.loads(ended.stdout.strip().split("\n")[-1])
    if counts != dict.fromkeys(KINDS, COUNT):
        sys.exit(f"mavlink_peer_test: {counts} in place of {COUNT} of each of {', '.join(KINDS)}")
    print(f"mavlink_peer_test: {COUNT} each of {', '.join(KINDS)} were read and equal")


if __name__ == "__main__":
    main()
