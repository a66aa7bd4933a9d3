"""Packages of npm for tests that read what others read."""

import shutil
import subprocess


def fetch(folder, packages):
    """Installs the packages (NAME@VERSION: what was tested, and what a later release cannot change) into the folder, unless they are
    there. Returns None, or why they are not."""
    if shutil.which("node") is None or shutil.which("npm") is None:
        return "there is no node or no npm on this machine"
    done = folder / "fetched"
    if done.is_file() and done.read_text(encoding="utf-8").split() == list(packages):
        return None
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.json").write_text('{"private": true}\n', encoding="utf-8")
    command = ["npm", "install", "--no-audit", "--no-fund", "--ignore-scripts", "--save-exact", *packages]
    try:
        ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    except subprocess.TimeoutExpired:
        return "npm did not answer within two minutes"
    if ended.returncode != 0:
        return "npm could not fetch " + " and ".join(packages) + ": " + ended.stderr.strip().split("\n")[-1]
    done.write_text(" ".join(packages), encoding="utf-8")
    return None
