"""Fresh Debian systems in folders: packages are made in them, and tried. As root: chroot, apt and systemd-nspawn."""

import contextlib
import hashlib
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile

TRIAL = pathlib.Path(__file__).with_name("trial.sh")
PLACE = "var/tmp/stof"  # in the system: packages, newer ones, the trial and what it says
BOOT_LIMIT_S = 600
# What a system changes by itself, by apt and by dpkg.
OF_THE_SYSTEM = re.compile(r"(var/(cache|log|lib/(apt|dpkg|systemd|private|ucf|pam)|tmp)|tmp|run|root|proc|sys|dev)(/|$)"
                           r"|etc/(ld\.so\.cache|resolv\.conf|machine-id|\.updated|\.pwd\.lock|passwd|group|g?shadow|sub[ug]id)-?$|var/\.updated$|etc$")
UNIT = f"""[Service]
Type=oneshot
ExecStart=/bin/sh /{PLACE}/trial.sh
ExecStopPost=/bin/systemctl --no-block poweroff
"""


class CheckError(Exception):
    """One line: what does not work, and what to do."""


def run(*command, name=None, **options):
    ended = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL, **options)
    if ended.returncode != 0:
        said = [line for line in (ended.stderr + ended.stdout).splitlines() if line.strip()]
        first = next((line for line in said if line.startswith("E:")), said[-1] if said else "no message")
        raise CheckError(f"{name or ' '.join(map(str, command[:6]))}: {first}")
    return ended.stdout


def mirror():
    """The archive that this machine installs from has all releases."""
    found = re.search(r"^'(\S+)/dists/(?:bookworm|trixie)/InRelease'", run("apt-get", "update", "--print-uris"), re.MULTILINE)
    if found is None:
        raise CheckError("apt's sources on this machine name no archive of Debian 12 or 13")
    return found[1]


def base(suite, folder):
    """A tar archive of a bare system with its init, made once."""
    archive = folder / f"{suite}.tar"
    if not archive.exists():
        folder.mkdir(parents=True, exist_ok=True)
        unfinished = folder / f"{suite}.unfinished.tar"
        run("mmdebstrap", "--mode=root", "--variant=minbase", "--include=systemd-sysv", "--aptopt=Acquire::Retries \"3\"",
            "--keyring=/usr/share/keyrings/debian-archive-keyring.gpg", suite, unfinished, f"deb {mirror()} {suite} main")
        os.replace(unfinished, archive)
    return archive


def unpack(archive, root):
    run("tar", "-xf", archive, "-C", root, "--numeric-owner")
    shutil.copyfile("/etc/resolv.conf", root / "etc/resolv.conf")


@contextlib.contextmanager
def unpacked(archive):
    with tempfile.TemporaryDirectory(prefix="stof_root_", dir=archive.parent) as folder:
        root = pathlib.Path(folder, archive.stem)
        root.mkdir()
        unpack(archive, root)
        yield root


# In a mount namespace of its own: $1 the system, then FROM TO ro|rw of each bound folder, --, and the command.
ENTER = """set -e
root=$1; shift
mount -t proc proc "$root/proc"
mount --bind /dev/null "$root/dev/null" 2>/dev/null || true
while [ "$1" != -- ]; do
  mkdir -p "$root$2"
  mount --bind "$1" "$root$2"
  if [ "$3" = ro ]; then mount -o remount,bind,ro "$root$2"; fi
  shift 3
done
shift
exec chroot "$root" "$@"
"""


def inside(root, *command, binds=(), environment=None):
    """What a command says in the system. binds: (folder of this machine, where it is in the system, "ro" or "rw")."""
    words = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "DEBIAN_FRONTEND": "noninteractive", "LC_ALL": "C.UTF-8", **(environment or {})}
    return run("unshare", "--mount", "sh", "-c", ENTER, "sh", root, *(word for bind in binds for word in bind), "--",
               "env", "-i", *(f"{name}={value}" for name, value in words.items()), *command, name=" ".join(map(str, command[:6])))


def apt(root, *words):
    return inside(root, "apt-get", "-qq", "-o", "Acquire::Retries=3", *words)


def to_build(suite, tree, folder):
    """A system that has what scripts/package takes; made anew when scripts/setup has changed."""
    root = folder / f"{suite}-build"
    made_of = root / "var/tmp/stof-setup"
    wanted = hashlib.sha256((tree / "scripts/setup").read_bytes()).hexdigest()
    if not made_of.exists() or made_of.read_text() != wanted:
        shutil.rmtree(root, ignore_errors=True)
        root.mkdir(parents=True)
        unpack(base(suite, folder), root)
        inside(root, "/stof/scripts/setup", "package", binds=[(tree, "/stof", "ro")])
        made_of.write_text(wanted)
    return root


def make(suite, tree, folder, out, words, environment):
    """What scripts/package with these words says in a Debian `suite`; its packages are in `out` then."""
    builds = folder / f"{suite}-tree"  # is what it makes below build/
    for place in (out, builds / "packages"):
        place.mkdir(parents=True, exist_ok=True)
    return inside(to_build(suite, tree, folder), "/stof/scripts/package", *words, environment=environment,
                  binds=[(tree, "/stof", "ro"), (builds, "/stof/build", "rw"), (out, "/stof/build/packages", "rw")])


def files(root):
    return {str(path.relative_to(root)) for path in root.rglob("*") if not OF_THE_SYSTEM.match(str(path.relative_to(root)))}


def accounts(root):
    return {line.split(":")[0] for name in ("passwd", "group") for line in (root / "etc" / name).read_text().splitlines()}


def booted(root):
    """Boots the system, which runs the trial and powers off; the trial's lines."""
    shutil.copyfile(TRIAL, root / PLACE / "trial.sh")
    unit = root / "etc/systemd/system/stof-trial.service"
    unit.write_text(UNIT)
    wanted = root / "etc/systemd/system/multi-user.target.wants/stof-trial.service"
    wanted.parent.mkdir(exist_ok=True)
    wanted.symlink_to("../stof-trial.service")
    # nspawn keeps files of its own in /run, which has to be no disk.
    with open(root.parent / "console", "wb") as console, subprocess.Popen(
            ["unshare", "--mount", "sh", "-c", 'mount -t tmpfs tmpfs /run && exec systemd-nspawn --register=no --keep-unit --boot '
             '--private-network --directory="$1"', "sh", root], stdin=subprocess.DEVNULL, stdout=console, stderr=console,
            start_new_session=True) as container:
        try:
            container.wait(BOOT_LIMIT_S)
        except subprocess.TimeoutExpired:
            pass
        finally:
            if container.poll() is None:
                os.killpg(container.pid, signal.SIGKILL)
    wanted.unlink()
    unit.unlink()
    trial = root / PLACE / "trial"
    if not trial.exists():
        raise CheckError(f"the container did not boot: {(root.parent / 'console').read_text(errors='replace').strip().splitlines()[-1:]}")
    return trial.read_text().splitlines()


def newer(packages, folder):
    """The same packages with a later version."""
    folder.mkdir()
    for package in packages:
        tree = folder / "tree"
        run("dpkg-deb", "-R", package, tree)
        control = tree / "DEBIAN/control"
        text = control.read_text()
        version = re.search(r"^Version: (.*)$", text, re.MULTILINE)[1]
        control.write_text(text.replace(version, version + "+later"))
        run("dpkg-deb", "--root-owner-group", "-b", tree, folder / package.name)
        shutil.rmtree(tree)


def needed_by(root, packages):
    """Names of Debian's packages that an installation of these brings along."""
    own = {run("dpkg-deb", "-f", package, "Package").strip() for package in packages}
    said = apt(root, "install", "--simulate", "-y", *(f"/{PLACE}/packages/{package.name}" for package in packages))
    return sorted(set(re.findall(r"^Inst (\S+)", said, re.MULTILINE)) - own)


def check(suite, packages, folder):
    """Lines `ok WHAT` and `FAILED WHAT` of packages in a fresh Debian `suite`."""
    with unpacked(base(suite, folder)) as root:
        debs = root / PLACE / "packages"
        debs.mkdir(parents=True)
        for package in packages:
            shutil.copyfile(package, debs / package.name)
        apt(root, "update")
        # First what they need: it has to stay as it is when they go.
        needed = needed_by(root, packages)
        if needed:
            apt(root, "install", "-y", "--no-install-recommends", *needed)
        before, known = files(root), accounts(root)
        apt(root, "install", "-y", *(f"/{PLACE}/packages/{package.name}" for package in packages))
        lines = ["ok apt install ./*.deb"]
        newer(packages, root / PLACE / "newer")
        lines += booted(root)
        if lines[-1:] != ["end"]:
            lines.append("FAILED the trial came to its end")
        left = sorted(files(root) - before)
        lines.append(f"FAILED purge leaves nothing: {', '.join(left[:10])}" if left else "ok purge leaves nothing")
        new = sorted(accounts(root) - known)
        lines.append(f"FAILED purge leaves no user: {', '.join(new)}" if new else "ok purge leaves no user")
        shutil.copyfile(root / PLACE / "trial.log", folder / f"{suite}.log")
        return [line for line in lines if line != "end"]
