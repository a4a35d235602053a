"""The words of the interface in other languages: English in the code is the key, `LANGUAGE.toml` beside this has the
translation; what has none stays English.

    widgets, menus, panels ─► imgui ◄─ doors.py: labels are translated on their way, where it is not English
                                            |
    tr("Select all") ◄──────────────────────┴─ table: "Select all" = "全选",  "Saved {}" = "已保存 {}"

    python -m editor.strings [zh]     lists what has no translation (listing.py)

A key with {} stands for any text there. Icons in front, `##id` behind, and the lines of a text are looked up apart.
"""

from __future__ import annotations

import locale
import os
import re
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

#: code -> its own name for itself
LANGUAGES = {"en": "English", "zh": "中文"}
_ICON = re.compile(r"^((?:[\ue000-\uf8ff]\s*)+)(.*)$", re.DOTALL)
_CACHE_LIMIT = 20_000


class Table:
    """Translations into one language."""

    def __init__(self, entries: dict[str, str]) -> None:
        self.entries = entries
        self._known: dict[str, str] = {}
        templates = sorted((key for key in entries if "{}" in key), key=lambda key: -len(key))
        self._templates = [(self._pattern(key), entries[key]) for key in templates]

    @staticmethod
    def _pattern(key: str) -> re.Pattern[str]:
        return re.compile("(.+?)".join(map(re.escape, key.split("{}"))) + r"\Z", re.DOTALL)

    def translate(self, text: str) -> str:
        """`text` in the language, or as it is."""
        found = self._known.get(text)
        if found is None:
            if len(self._known) > _CACHE_LIMIT:
                self._known.clear()
            found = self._known[text] = self._find(text)
        return found

    def _find(self, text: str) -> str:
        if text in self.entries:
            return self.entries[text]
        if "##" in text:
            shown, mark, id = text.partition("##")
            return f"{self.translate(shown)}{mark}{id}" if shown else text
        icon = _ICON.match(text)
        if icon is not None:
            return icon[1] + (self.translate(icon[2]) if icon[2] else "")
        if "\n" in text:
            return "\n".join(map(self.translate, text.split("\n")))
        if text != text.strip():
            inside = text.strip()
            return text.replace(inside, self.translate(inside), 1) if inside else text
        for pattern, translation in self._templates:
            match = pattern.match(text)
            if match is not None:
                parts = [self.entries.get(part, part) for part in match.groups()]
                return translation.format(*parts)
        return text


_tables: dict[str, Table] = {}
_language = "en"
_paused = 0


def load(language: str) -> Table:
    """The table of a language; English has none. Raises KeyError for one that there is not."""
    if language not in _tables:
        entries: dict[str, str] = {}
        if language != "en":
            data: dict[str, Any] = tomllib.loads(table_path(language).read_text(encoding="utf-8"))
            for section in data.values():
                entries.update(section)
        _tables[language] = Table(entries)
    return _tables[language]


def table_path(language: str) -> Path:
    if language not in LANGUAGES:
        raise KeyError(language)
    return Path(__file__).with_name(f"{language}.toml")


def language() -> str:
    return _language


def set_language(wanted: str) -> None:
    """`auto` takes the system's; an unknown one is English. What is drawn next is in it."""
    global _language
    _language = system_language() if wanted == "auto" else wanted if wanted in LANGUAGES else "en"
    load(_language)


def system_language() -> str:
    """One of LANGUAGES, by the settings of the system."""
    said = os.environ.get("LC_ALL") or os.environ.get("LC_MESSAGES") or os.environ.get("LANG") or ""
    if not said:
        try:
            said = locale.getlocale()[0] or ""
        except ValueError:
            said = ""
    return "zh" if said.lower().startswith(("zh", "chinese")) else "en"


def tr(text: str) -> str:
    """`text` in the language of the interface."""
    return text if _language == "en" or _paused else _tables[_language].translate(text)


@contextmanager
def verbatim() -> Iterator[None]:
    """What is drawn inside is the user's own (names, messages, code) and stays as it is."""
    global _paused
    _paused += 1
    try:
        yield
    finally:
        _paused -= 1
