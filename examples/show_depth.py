#!/usr/bin/env python3
"""show_depth.py HOST[:PORT] [FILE.png]: depth in colours, near is light, 0 to 8 m; live until Ctrl-C, or one picture to FILE."""

import sys

import stof
from matplotlib import pyplot  # python3-matplotlib

with stof.open(sys.argv[1]) as sensor:
    picture = None
    for frame in sensor:
        if frame.depth is None or frame.calibration is None:
            continue  # the calibration comes once a second
        metres = frame.depth_m()  # (height, width), NaN: none
        picture = picture or pyplot.imshow(metres, cmap="viridis_r", vmin=0, vmax=8)
        picture.set_data(metres)
        pyplot.title(f"frame {frame.number}")
        if len(sys.argv) > 2:
            pyplot.savefig(sys.argv[2])
            break
        pyplot.pause(0.001)
