#!/usr/bin/env bash
# toolchains/sysroot.sh [DEST]: unpacks a Debian 13 arm64 sysroot to DEST (default build/sysroot-arm64).
# Does nothing when DEST is whole and was made from the same list.
set -euo pipefail

packages=(
  libc6-dev linux-libc-dev libstdc++-14-dev                           # the language
  libclang-rt-19-dev                                                  # sanitizers
  libgpiod-dev libusb-1.0-0-dev libcamera-dev libcamera-ipa           # devices
  libsodium-dev                                                       # firmware/wire/crypto
  libeigen3-dev                                                       # dsp/calib
  libzstd-dev                                                         # recordings, which board emu replays
  libcli11-dev nlohmann-json3-dev libpng-dev libgtest-dev  # host programs, tests
)
root=$(cd "$(dirname "$0")/.." && pwd)
source "$root/toolchains/unpack_debian.sh"
unpack_debian sysroot test trixie "${1:-$root/build/sysroot-arm64}" "${packages[@]}"
