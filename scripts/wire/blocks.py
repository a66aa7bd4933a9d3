"""What is generated inside a file that is otherwise written by hand: between two lines of comment,
`made: NAME` and `made: end`."""

import re


def filled(text, comment, found):
    """The text with every block as it should be. comment: what begins one. found: {name: lines}.
    KeyError: a block that nothing is made for, or none for what is made."""
    block = re.compile(rf"^({re.escape(comment)} made: (\w+).*\n)(?:.*\n)*?({re.escape(comment)} made: end\n)",
                       re.MULTILINE)
    if {match[2] for match in block.finditer(text)} != set(found):
        raise KeyError(f"needs the blocks {', '.join(found)}")
    return block.sub(lambda match: match[1] + "\n".join([*found[match[2]], ""]) + match[3], text)
