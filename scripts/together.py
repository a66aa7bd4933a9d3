#!/usr/bin/env python3
"""scripts/together.py SOURCE...: which sources can be compiled as one: none uses a name that another has for itself.

Prints a line `GROUP SOURCE` for each, in the order of the sources. What it cannot see, such as an overload that
becomes ambiguous, the compiler tells.
"""

import pathlib
import re
import sys

MOST = 16  # sources of a group
# What a line of the first column declares: a function, a constant or a type.
DECLARED = re.compile(r"(?:[^=({;]*\W)?([A-Za-z_]\w*)\s*(?:\[\w*\])?(?:[({;=]|:[^:]|$)")
USED = re.compile(r"(?<![.>:\w])[A-Za-z_]\w*")  # but of members and of namespaces


def file_local_names(text):
    """Names that a source gives to what others do not see, and its macros; too many do no harm."""
    names, hidden = set(), False
    for line in text.splitlines():
        if line.startswith("namespace {"):
            hidden = True
        elif line.startswith("}  // namespace"):
            hidden = False
        elif line.startswith("#define "):
            names.add(re.split(r"\W", line[len("#define "):])[0])
        elif hidden and line.startswith("using ") and "=" in line:
            names.add(line.split()[1])
        elif hidden and line[:1].isalpha() and not line.startswith(("using ", "static_assert")):
            declared = DECLARED.match(line)
            names.update(declared.groups() if declared else ())
    return names


def groups_of(sources, place_of=lambda source: None):
    """Lists of sources of one place, none of which uses a name that another has for itself."""
    groups = []  # (place, names of its sources, what they use, sources)
    for source in sorted(sources):
        text = source.read_text(errors="replace")
        place, names, used = place_of(source), file_local_names(text), set(USED.findall(text))
        for there, taken, all_used, members in groups:
            if there == place and len(members) < MOST and not names & all_used and not used & taken:
                taken |= names
                all_used |= used
                members.append(source)
                break
        else:
            groups.append((place, names, used, [source]))
    return [members for _, _, _, members in groups]


def main():
    sources = [pathlib.Path(name) for name in sys.argv[1:]]
    if not sources or sys.argv[1] == "--help":
        print(__doc__.strip())
        return
    number = {source: k for k, members in enumerate(groups_of(sources)) for source in members}
    print("\n".join(f"{number[source]} {source}" for source in sources))


if __name__ == "__main__":
    main()
