#!/usr/bin/env python3
"""sender_test.py -- SENDER...: tests/host/receiver/receiver.py gets 30 frames from our sender.

Both print what they sent and saw; the lines must be equal. The sender waits for each frame to be
seen, so that nothing depends on speed or on the size of a socket's buffer.
"""

import pathlib
import subprocess
import sys

FRAMES = 30


def line_of(process, name):
    line = process.stdout.readline()
    if not line:
        sys.exit(f"{name} ended early, exit code {process.wait()}")
    return line.strip()


def main():
    sender_command = sys.argv[sys.argv.index("--") + 1 :]
    script = pathlib.Path(__file__).resolve().parent / "receiver.py"
    pipes = {"stdout": subprocess.PIPE, "text": True}
    command = [sys.executable, "-B", str(script), "--address", "127.0.0.1", "--port", "0"]
    with subprocess.Popen([*command, "--frames", str(FRAMES)], **pipes) as receiver:
        try:
            port = line_of(receiver, "receiver").removeprefix("listening ")
            command = [*sender_command, port, str(FRAMES)]
            with subprocess.Popen(command, stdin=subprocess.PIPE, **pipes) as sender:
                for _ in range(FRAMES + 1):  # and the line of what was refused
                    sent = line_of(sender, "sender")
                    seen = line_of(receiver, "receiver")
                    if sent != seen:
                        sender.kill()
                        sys.exit(f"sent: {sent}\nseen: {seen}")
                    print(seen)
                    if sent.startswith("frame"):
                        sender.stdin.write("\n")
                        sender.stdin.flush()
        finally:
            receiver.kill()
    if sender.returncode != 0:
        sys.exit(f"the sender ended with exit code {sender.returncode}")


if __name__ == "__main__":
    main()
