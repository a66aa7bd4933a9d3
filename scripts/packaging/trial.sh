#!/bin/sh
# In a booted container that has stof's packages and, in `newer` beside this file, the same in a newer version: tries them,
# upgrades and purges them. A line each goes to `trial`: `ok WHAT` or `FAILED WHAT`. scripts/package --check starts it.
here=$(dirname "$0")
exec >>"$here/trial" 2>"$here/trial.log"
set -x
export DEBIAN_FRONTEND=noninteractive

try() { # WHAT COMMAND...
  what=$1
  shift
  if "$@" >&2; then echo "ok $what"; else echo "FAILED $what"; fi
}
soon() { # COMMAND...: it succeeds within a minute
  for _ in $(seq 60); do
    if "$@" >/dev/null; then return 0; fi
    sleep 1
  done
  return 1
}
pid() { systemctl show -P MainPID stofd.service; }

try "stofd.service is enabled" systemctl -q is-enabled stofd.service
try "stofd.service runs" soon systemctl -q is-active stofd.service
try "stofd runs as user stof" sh -c 'test "$(stat -c %U /proc/$(systemctl show -P MainPID stofd.service))" = stof'
if command -v stof >/dev/null; then
  try "stof discover finds it" soon sh -c "stof discover | tee /dev/stderr | grep -q '127.0.0.1:7560: emu'"
  try "stof view gets frames" timeout 60 stof view 127.0.0.1 --frames 5
  try "man pages are there" test -s /usr/share/man/man1/stof.1.gz -a -s /usr/share/man/man1/stof-view.1.gz -a -s /usr/share/man/man1/stofd.1.gz
  try "bash completes stof" bash -c '. /usr/share/bash-completion/completions/stof && complete -p stof'
fi
try "import stof" python3 -c 'import stof; print(stof.__file__)'
try "Python gets depth" timeout 60 python3 -c '
import stof
with stof.open("127.0.0.1") as sensor:
    for frame in sensor.frames(timeout=30):
        if frame.complete and frame.calibration:
            assert frame.depth.max() > 0
            break'

echo '# of its owner' >>/etc/default/stofd
before=$(pid)
try "it is upgraded" dpkg -i "$here"/newer/*.deb
try "the upgrade starts it anew" soon sh -c "systemctl -q is-active stofd.service && test \$(systemctl show -P MainPID stofd.service) != $before"
try "an edited conffile stays" grep -q '# of its owner' /etc/default/stofd
# shellcheck disable=SC2046
try "it is purged" dpkg --purge $(dpkg-query -W -f '${Package} ${Source}\n' | awk '/^(libstof|stof|python3-stof)/ { print $1 }')
try "the service is gone" sh -c '! systemctl cat stofd.service && ! pgrep -x stofd'
try "the user is gone" sh -c '! getent passwd stof && ! getent group stof'
echo end
