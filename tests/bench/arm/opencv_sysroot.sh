#!/usr/bin/env bash
# tests/bench/arm/opencv_sysroot.sh [DEST]: unpacks Debian 12's OpenCV for 64-bit ARM and what a
# program needs to be linked with it to DEST (default build/opencv-arm64). Nothing of it is installed,
# root is not needed. Does nothing when DEST is whole; an interrupted run leaves no DEST behind.
set -euo pipefail

fail() {
  echo "bench: $*" >&2
  exit 2
}

packages=(libopencv-calib3d406 libopencv-imgproc406 libopencv-core406 libc6-dev libstdc++-12-dev)
root=$(cd "$(dirname "$0")/../../.." && pwd)
dest=${1:-$root/build/opencv-arm64}
[ "$(cat "$dest/.packages" 2>/dev/null)" != "${packages[*]}" ] || exit 0

command -v mmdebstrap >/dev/null || fail "mmdebstrap is missing: run scripts/setup bench"
mirror=$(apt-get update --print-uris 2>/dev/null |
  sed -n "s#^'\(.*\)/dists/bookworm/InRelease'.*#\1#p" | head -n1)
[ -n "$mirror" ] || fail "apt's sources on this machine name no archive of Debian 12 (suite bookworm)"

log=$dest.log
part=$dest.part.$$
mkdir -p "$(dirname "$dest")"
trap 'rm -rf "$part"' EXIT
include=$(IFS=, && echo "${packages[*]}")
mmdebstrap --mode=chrootless --variant=extract --architectures=arm64 \
  --aptopt='APT::Install-Recommends "false"' --aptopt='Acquire::Retries "3"' \
  --keyring=/usr/share/keyrings/debian-archive-keyring.gpg --include="$include" \
  bookworm "$part" "deb $mirror bookworm main" >"$log" 2>&1 ||
  fail "mmdebstrap failed: $(grep -m1 -i '^E: ' "$log" || tail -n1 "$log"); all of it is in $log"
[ -e "$part/lib" ] || ln -s usr/lib "$part/lib"
echo "${packages[*]}" >"$part/.packages"
rm -rf "$dest"
mv "$part" "$dest"
