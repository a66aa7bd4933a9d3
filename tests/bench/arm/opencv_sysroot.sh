#!/usr/bin/env bash
# tests/bench/arm/opencv_sysroot.sh [DEST]: unpacks Debian 12's OpenCV for 64-bit ARM and what a
# program needs to be linked with it to DEST (default build/opencv-arm64). Does nothing when DEST is whole.
set -euo pipefail

packages=(libopencv-calib3d406 libopencv-imgproc406 libopencv-core406 libc6-dev libstdc++-12-dev)
root=$(cd "$(dirname "$0")/../../.." && pwd)
source "$root/toolchains/unpack_debian.sh"
unpack_debian bench bench bookworm "${1:-$root/build/opencv-arm64}" "${packages[@]}"
