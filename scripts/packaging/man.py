"""Man pages of what programs say with --help: their one source is the program itself."""

import re
import subprocess


class NoPage(Exception):
    """One line: whose help cannot be had."""


def help_of(command, words):
    ended = subprocess.run([*command, *words, "--help"], capture_output=True, text=True, check=False)
    if ended.returncode != 0 or not ended.stdout.strip():
        raise NoPage(f"{' '.join(command + words)} --help: ended with {ended.returncode}")
    return ended.stdout


def escaped(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def paragraphs(text):
    """Of a program's help its blocks: ("text", line), ("head", line), ("item", left, right). An item begins with two blanks;
    what stands behind two more, or is indented further, is its text."""
    blocks = []
    for line in text.splitlines():
        indent = len(line) - len(line.lstrip())
        words = line.strip()
        if not words:
            blocks.append(("gap",))
        elif indent == 0:
            blocks.append(("head", words[:-1]) if re.fullmatch(r"[A-Z][\w -]*:", words) else ("text", words))
        elif indent <= 4:
            left, _, right = re.sub(r" {2,}", "\0", words, count=1).partition("\0")
            blocks.append(("item", left, right))
        elif blocks and blocks[-1][0] == "item":
            kind, left, right = blocks[-1]
            blocks[-1] = (kind, left, f"{right} {words}".strip())
        else:
            blocks.append(("text", words))
    return blocks


def summaries(text):
    """[(name, summary)] of what stands below `Subcommands:`."""
    found, inside = [], False
    for kind, *words in paragraphs(text):
        if kind == "head":
            inside = words[0] == "Subcommands"
        elif kind == "item" and inside:
            found.append((words[0].split()[0], words[1]))
    return found


def body(text, heads):
    """roff of a help text; heads: macro of its headings."""
    lines, after_item = [], False
    for kind, *words in paragraphs(text):
        if kind == "gap":
            lines.append(".PP")
        elif kind == "head":
            lines.append(f"{heads} {escaped(words[0])}")
        elif kind == "text":
            usage = words[0].startswith("Usage: ")
            lines += [".PP"] * (after_item or usage) + [f"\\fB{escaped(words[0][7:])}\\fR" if usage else escaped(words[0])]
        else:
            lines += [".TP", f"\\fB{escaped(words[0])}\\fR"] + ([escaped(words[1])] if words[1] else ["\\&"])
        after_item = kind == "item"
    tidy = []
    for line in lines:  # no empty paragraph
        if line == ".PP" and (not tidy or tidy[-1].startswith((".PP", ".SH", ".SS"))):
            continue
        if line.startswith((".SH", ".SS", ".TP", ".PP")) and tidy and tidy[-1] == ".PP":
            tidy.pop()
        tidy.append(line)
    if tidy and tidy[-1] == ".PP":
        tidy.pop()
    return tidy


def commands_below(command, words, text):
    """(words, help) of all commands, depth first."""
    for name, _ in summaries(text):
        below = words + [name]
        said = help_of(command, below)
        yield below, said
        yield from commands_below(command, below, said)


def example_and_end(lines):
    """Examples in bold, and a heading before the exit codes: of the lines of a command's page."""
    made = []
    for line in lines:
        if line.startswith("Example: "):
            made += [] if made[-1:] == [".PP"] else [".PP"]
            made += ["Example:", f"\\fB{line[9:]}\\fR"]
        elif line.startswith("Ends with "):
            made += [".SH EXIT STATUS", line]
        else:
            made.append(line)
    return made


def heading(name, summary, version, date):
    return [f'.TH {name.upper()} 1 "{date}" "stof {version}" "User Commands"', ".SH NAME", f"{escaped(name)} \\- {escaped(summary)}",
            ".SH DESCRIPTION"]


def pages(command, name, summary, version, date, see_also):
    """{page's name: roff} of a program and of each of its commands, such as stof-view; command: how it is started here."""
    command = [str(word) for word in command]
    text = help_of(command, [])
    verbs = summaries(text)
    others = ", ".join([f".BR {name}-{verb} (1)".replace("-", "\\-") for verb, _ in verbs] + [see_also]).replace(", .BR", ",\n.BR")
    found = {name: "\n".join(heading(name, summary, version, date) + example_and_end(body(text, ".SS")) + [".SH SEE ALSO", others]) + "\n"}
    for verb, of_verb in verbs:
        said = help_of(command, [verb])
        lines = heading(f"{name}-{verb}", of_verb, version, date) + example_and_end(body(said, ".SS"))
        for words, below in commands_below(command, [verb], said):
            lines.append(f".SH {name.upper()} {escaped(' '.join(words).upper())}")
            lines += [line.replace(".SH EXIT STATUS", ".PP") for line in example_and_end(body(below, ".SS"))]
        found[f"{name}-{verb}"] = "\n".join([*lines, ".SH SEE ALSO", f".BR {name} (1)"]) + "\n"
    return found
