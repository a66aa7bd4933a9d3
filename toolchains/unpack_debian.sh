# For `source`: unpack_debian PROGRAM SETUP SUITE DEST PACKAGE... unpacks packages of Debian for 64-bit ARM, and what they
# need, to DEST. Nothing of it is installed or run, root is not needed. Does nothing when DEST is whole and was made from the
# same list; an interrupted run leaves no DEST behind. PROGRAM begins messages; `scripts/setup SETUP` installs mmdebstrap.
# shellcheck shell=bash
unpack_debian() {
  local program=$1 setup=$2 suite=$3 dest=$4
  shift 4
  [ "$(cat "$dest/.packages" 2>/dev/null)" != "$*" ] || return 0

  fail() {
    echo "$program: $*" >&2
    exit 2
  }
  command -v mmdebstrap >/dev/null || fail "mmdebstrap is missing: run scripts/setup $setup"
  # The mirror this machine installs from has later releases too.
  local mirror
  mirror=$(apt-get update --print-uris 2>/dev/null |
    sed -n "s#^'\(.*\)/dists/\(bookworm\|trixie\)/InRelease'.*#\1#p" | head -n1)
  [ -n "$mirror" ] || fail "apt's sources on this machine name no archive of Debian 12 or 13 (suites bookworm, trixie)"

  local log=$dest.log include
  part=$dest.part.$$  # not local: the trap runs after this function
  mkdir -p "$(dirname "$dest")"
  trap 'rm -rf "$part"' EXIT
  include=$(IFS=, && echo "$*")
  mmdebstrap --mode=chrootless --variant=extract --architectures=arm64 \
    --aptopt='APT::Install-Recommends "false"' --aptopt='Acquire::Retries "3"' \
    --keyring=/usr/share/keyrings/debian-archive-keyring.gpg --include="$include" \
    "$suite" "$part" "deb $mirror $suite main" >"$log" 2>&1 ||
    fail "mmdebstrap failed: $(grep -m1 -i '^E: ' "$log" || tail -n1 "$log"); all of it is in $log"
  # libc.so is a linker script that names /lib; base-files is not unpacked.
  [ -e "$part/lib" ] || ln -s usr/lib "$part/lib"
  echo "$*" >"$part/.packages"
  rm -rf "$dest"
  mv "$part" "$dest"
}
