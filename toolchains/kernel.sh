#!/usr/bin/env bash
# toolchains/kernel.sh [DEST] [SUITE]: unpacks the newest PREEMPT_RT kernel for arm64 of SUITE
# (default trixie) and a static busybox to DEST (default build/kernel-arm64), which gets:
#   image    the kernel, as QEMU and boot loaders take it
#   modules  its modules (a link; below kernel/, with modules.builtin)
#   busybox  for the initramfs
# Nothing of it is installed or run, root is not needed. Does nothing when DEST is whole and was
# made of the same list; an interrupted run leaves no DEST behind. Remove DEST for a newer kernel.
set -euo pipefail

fail() {
  echo "kernel: $*" >&2
  exit 2
}

meta=linux-image-rt-arm64
tools=(busybox-static)
root=$(cd "$(dirname "$0")/.." && pwd)
dest=${1:-$root/build/kernel-arm64}
suite=${2:-trixie}
wanted="$suite $meta ${tools[*]}"
[ "$(cat "$dest/.packages" 2>/dev/null)" != "$wanted" ] || exit 0

keyring=/usr/share/keyrings/debian-archive-keyring.gpg
[ -r "$keyring" ] || fail "$keyring is missing: install debian-archive-keyring"
# The mirror this machine installs from also has Debian 13.
mirror=$(apt-get update --print-uris 2>/dev/null |
  sed -n "s#^'\(.*\)/dists/bookworm/InRelease'.*#\1#p" | head -n1)
[ -n "$mirror" ] || fail "apt's sources on this machine name no archive of Debian 12 (suite bookworm)"

log=$dest.log
part=$dest.part.$$
apt=$part/.apt
trap 'rm -rf "$part"' EXIT
mkdir -p "$apt"/{lists/partial,archives/partial,etc,parts,debs}
: >"$apt/status"
echo "deb [arch=arm64 signed-by=$keyring] $mirror $suite main" >"$apt/etc/sources.list"
options=(
  -o Dir::State="$apt" -o Dir::State::status="$apt/status" -o Dir::State::lists="$apt/lists"
  -o Dir::Cache="$apt" -o Dir::Cache::archives="$apt/archives"
  -o Dir::Etc::sourcelist="$apt/etc/sources.list" -o Dir::Etc::sourceparts="$apt/parts"
  -o APT::Architecture=arm64 -o APT::Architectures::=arm64 -o Acquire::Languages=none
  -o Acquire::Retries=3 -o APT::Sandbox::User=root
)

# unpack PACKAGE...: downloads them, and unpacks them to $part.
unpack() {
  (cd "$apt/debs" && rm -f ./*.deb && apt-get -q "${options[@]}" download "$@") >>"$log" 2>&1 ||
    fail "a download failed: $(grep -m1 '^E: ' "$log" || tail -n1 "$log"); all of it is in $log"
  for package in "$apt"/debs/*.deb; do
    dpkg -x "$package" "$part"
  done
}

apt-get -q "${options[@]}" update >"$log" 2>&1 ||
  fail "apt-get update failed: $(grep -m1 '^E: ' "$log" || tail -n1 "$log"); all of it is in $log"
kernel=$(apt-cache "${options[@]}" depends "$meta" |
  sed -n 's/.*Depends: \(linux-image-[0-9].*\)/\1/p' | head -n1)
[ -n "$kernel" ] || fail "suite $suite has no $meta"
packages=("$kernel")
version=${kernel#linux-image-}
# Since 7.x the image, its modules and what both share are packages of their own.
for name in linux-binary linux-modules linux-base; do
  if apt-cache "${options[@]}" show "$name-$version" >/dev/null 2>&1; then
    packages+=("$name-$version")
  fi
done
unpack "${packages[@]}" "${tools[@]}"
mkdir -p "$part/boot"

image=$(cd "$part" && find boot usr/lib/modules -name 'vmlinuz*' | head -n1)
[ -n "$image" ] || fail "$kernel has no kernel image"
modules=$(cd "$part" && find usr/lib/modules -mindepth 1 -maxdepth 1 | head -n1)
[ -n "$modules" ] || fail "$kernel has no modules"
rm -rf "$apt"
ln -s "$image" "$part/image"
ln -s "$modules" "$part/modules"
ln -s usr/bin/busybox "$part/busybox"
echo "$wanted" >"$part/.packages"
rm -rf "$dest"
mv "$part" "$dest"
