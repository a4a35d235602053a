"""A panel and an operation: how many nodes have which name, and selecting one kind."""

from __future__ import annotations

from collections import Counter
from typing import ClassVar

from imgui_bundle import imgui

from editor.arguments import Argument
from editor.panels.base import Panel
from editor.plugins.api import Plugin
from editor.session import Session
from editor.ui import Ui


def kinds(session: Session) -> Counter[str]:
    """Name without its number -> how many living nodes have it."""
    if session.document is None:
        return Counter()
    nodes = session.document.runtime.scene.nodes
    return Counter(name.rstrip(" 0123456789") for name, alive in zip(nodes.name, nodes.alive, strict=False) if alive)


def select_kind(session: Session, kind: str) -> None:
    assert session.document is not None
    names = session.document.runtime.scene.nodes.name
    session.document.selection = tuple(
        row for row, alive in enumerate(session.document.runtime.scene.nodes.alive)
        if alive and names[row].rstrip(" 0123456789") == kind
    )  # fmt: skip


class NodeCounter(Panel):
    title: ClassVar[str] = "Node counter"
    dock: ClassVar[str] = "Right"

    def draw(self, ui: Ui) -> None:
        for kind, count in kinds(ui.session).most_common():
            if imgui.selectable(f"{count:5d}  {kind}", False)[0]:
                ui.operations.run("node-counter.select", ui.session, kind=kind)


def register(plugin: Plugin) -> None:
    plugin.panel(NodeCounter)
    plugin.operation(
        "node-counter.select", "Select nodes of one kind", select_kind,
        enabled=lambda session: session.document is not None,
        arguments=(Argument("kind", "enum", choices=lambda session: tuple(kinds(session)), doc="a name, no number"),),
        doc="All that have the name, whatever their number",
    )  # fmt: skip
