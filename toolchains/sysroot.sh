#!/usr/bin/env bash
# toolchains/sysroot.sh [DEST]: unpacks a Debian 13 arm64 sysroot to DEST (default build/sysroot-arm64).
# Nothing of it is installed or run, root is not needed. Does nothing when DEST is whole and was made
# from the same list; an interrupted run leaves no DEST behind.
set -euo pipefail

fail() {
  echo "sysroot: $*" >&2
  exit 2
}

packages=(
  libc6-dev linux-libc-dev libstdc++-14-dev                           # the language
  libclang-rt-19-dev                                                  # sanitizers
  libgpiod-dev libusb-1.0-0-dev libcamera-dev                         # devices
  libeigen3-dev                                                       # dsp/calib
  libjsmn-dev                                                         # firmware/settings
  libcli11-dev nlohmann-json3-dev libpng-dev libgtest-dev  # host programs, tests
)
root=$(cd "$(dirname "$0")/.." && pwd)
dest=${1:-$root/build/sysroot-arm64}
stamp=$dest/.packages
[ "$(cat "$stamp" 2>/dev/null)" != "${packages[*]}" ] || exit 0

command -v mmdebstrap >/dev/null || fail "mmdebstrap is missing: run scripts/setup test"
# The mirror this machine installs from also has Debian 13.
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
  trixie "$part" "deb $mirror trixie main" >"$log" 2>&1 ||
  fail "mmdebstrap failed: $(grep -m1 -i '^E: ' "$log" || tail -n1 "$log"); all of it is in $log"
ln -s usr/lib "$part/lib"  # libc.so is a linker script that names /lib; base-files is not unpacked
echo "${packages[*]}" >"$part/.packages"
rm -rf "$dest"
mv "$part" "$dest"
