#!/usr/bin/env python3
"""obstacle.py HOST[:PORT] [FRAMES]: what is nearest ahead of a robot 0.6 m wide and 0.4 m high."""

import sys

import stof

if len(sys.argv) < 2:
    sys.exit("usage: obstacle.py HOST[:PORT] [FRAMES]")
frames = int(sys.argv[2]) if len(sys.argv) > 2 else 300
try:
    with stof.open(sys.argv[1]) as sensor:
        for _ in range(frames):
            try:
                frame = sensor.next(1)
                points = frame.points()  # fields x, y, z in metres: right, down, ahead
            except (stof.Timeout, stof.NotYet):  # the first calibration takes a second
                print("stop: no depth")
                continue
            ahead = points[(abs(points["x"]) < 0.3) & (abs(points["y"]) < 0.2)]
            if not len(ahead):
                print("stop: no depth")
                continue
            nearest = ahead[ahead["z"].argmin()]  # it is there within -+ half of its width, in 95 percent
            print(f"frame {frame.number}: {nearest['z']:.2f} m, -+ {nearest['z_width'] / 2:.2f} m")
except stof.Error as error:
    sys.exit(str(error))
