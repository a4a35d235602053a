"""Line ends: a text is edited with \\n alone, and goes back into its file with the ends that its lines had."""

from __future__ import annotations

import re
from itertools import takewhile

_END = re.compile(r"\r\n|\n|\r")


def split_ends(raw: str) -> tuple[str, list[str]]:
    """(the text with \\n, the end of each of its lines); the last line has none."""
    ends = _END.findall(raw)
    return (raw if all(end == "\n" for end in ends) else _END.sub("\n", raw)), ends


def join_ends(text: str, before: str, ends: list[str]) -> str:
    """`text` (with \\n) as it is to be written, where `before` was read with `ends`: lines of the unchanged beginning
    and end keep theirs, others get that which most lines have."""
    if all(end == "\n" for end in ends):
        return text
    usual = max(dict.fromkeys(ends), key=ends.count)
    if all(end == usual for end in ends):
        return text.replace("\n", usual)
    old, new = before.split("\n"), text.split("\n")
    shorter = min(len(old), len(new))
    head = sum(1 for _ in takewhile(lambda i: old[i] == new[i], range(shorter)))
    tail = sum(1 for _ in takewhile(lambda i: old[-i] == new[-i], range(1, shorter - head + 1)))
    lines = len(new) - 1  # ends
    kept = [ends[i] if i < min(head, len(ends)) else usual for i in range(lines)]
    for i in range(1, tail):  # the end of the line i before the last one
        kept[lines - i] = ends[len(ends) - i]
    return "".join(line + end for line, end in zip(new, [*kept, ""], strict=True))
