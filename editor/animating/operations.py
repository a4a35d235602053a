"""The operations of animation: menu, palette, keys and console are doors to the same functions."""

from __future__ import annotations

from collections.abc import Callable

from editor.animating import rows
from editor.animating.editing import AnimationEditor
from editor.animating.following import animation_of, drive_of, runtime_of
from editor.operations import Operation, Operations, always
from editor.session import Session
from engine.core.errors import LucarnaError

Run = Callable[[Session], None]
Test = Callable[[Session], bool]


def add_animation_operations(ops: Operations) -> None:
    """Add them all to the registry."""

    def add(
        id: str, label: str, run: Run, *keys: str, enabled: Test = _has_clips, checked: Test | None = None,
        separator: bool = False, about: str = "",
    ) -> None:  # fmt: skip
        ops.add(Operation(id, label, run, "Playback", keys, enabled, checked, separator, about))

    add("play.next-key", "Next key", _key(1), "Shift+.", separator=True, about="Of the selected nodes, or of all")
    add("play.previous-key", "Previous key", _key(-1), "Shift+,")
    add("play.mode", "Loop, once, ping-pong", lambda s: s.playback.next_mode(), "Ctrl+L")
    add("play.set-in", "Set the in point here", lambda s: s.playback.set_range(s.playback.time, s.playback.stop), "I")
    add(
        "play.set-out", "Set the out point here", lambda s: s.playback.set_range(s.playback.start, s.playback.time), "O"
    )
    add("play.clear-range", "Play the whole", lambda s: s.playback.set_range(0.0, s.playback.duration), "Alt+X")
    for factor, name in ((0.5, "Half"), (2.0, "Double"), (-1.0, "Backwards")):
        add(
            f"play.speed-{name.lower()}",
            f"{name} speed" if factor > 0 else name,
            _speed(factor),
            separator=factor == 0.5,
        )
    add("play.speed-normal", "Normal speed", _normal)

    for drive, label in (("clips", "Play clips"), ("timeline", "Play the timeline"), ("states", "Play the states")):
        add(f"animation.{drive}", label, _drive(drive), checked=_driven(drive), separator=drive == "clips")
    add("animation.new", "New animation", guarded(lambda e: e.create()), enabled=_no_animation,
        about="A timeline that plays the first clip")  # fmt: skip
    add("animation.add-track", "Add track", guarded(lambda e: e.add_track()))
    add(
        "animation.add-marker",
        "Add marker here",
        guarded(lambda e: e.add_marker("marker", e.session.playback.time)),
        "Shift+M",
    )
    add("animation.split", "Split block here", guarded(_split), "Shift+S", enabled=_has_block)
    add("animation.delete-block", "Delete block", guarded(_delete), "Shift+Delete", enabled=_has_block)
    add("animation.root-motion", "Root motion", guarded(_toggle_root), checked=_root_on, enabled=_has_animation)

    for name, label, keys in (
        ("skeleton", "Show skeletons", ("Shift+B",)), ("names", "Names of bones", ()), ("axes", "Axes of bones", ()),
        ("root_path", "Path of root motion", ()), ("snap", "Snap in the timeline", ()),
    ):  # fmt: skip
        run, checked = _toggle(name)
        add(
            f"animation.show-{name.replace('_', '-')}", label, run, *keys, checked=checked, separator=name == "skeleton"
        )
    add("animation.ghosts", "Onion skin", _ghosts, "Shift+G", checked=lambda s: s.animating.ghosts > 0,
        about="Poses before and after now, as skeletons")  # fmt: skip
    for title in ("Timeline", "Blend space", "State graph", "Masks"):
        id = f"view.panel-{title.lower().replace(' ', '-')}"
        add(id, f"Show {title.lower()}", _panel(title), separator=title == "Timeline", enabled=always)


def guarded(change: Callable[[AnimationEditor], object]) -> Run:
    """An operation that edits; what it refuses is logged and shown."""

    def run(session: Session) -> None:
        try:
            change(AnimationEditor(session))
        except LucarnaError as error:
            session.fail(error)

    return run


def selected_names(session: Session) -> list[str]:
    """Names of the selected nodes, with all below them."""
    document = session.document
    if document is None or not document.selection:
        return []
    names = document.runtime.scene.nodes.name
    return [names[r] for row in document.selection for r in document.subtree(row)]


def keys_now(session: Session) -> list[float]:
    """Times of keys of what plays: of the selected nodes where they have some. On a timeline, the blocks' ends."""
    if session.document is None:
        return []
    if drive_of(session) == "timeline":
        blocks = [b for t in animation_of(session).model.tracks for b in t.blocks]
        return sorted({b.start for b in blocks} | {b.start + b.length for b in blocks})
    deck = runtime_of(session).deck
    clips = [deck.clips[i] for i in deck.active]
    names = selected_names(session)
    own = sorted({t for c in clips for t in rows.key_times(c, names)}) if names else []
    return own or sorted({t for c in clips for t in rows.key_times(c)})


def _key(direction: int) -> Run:
    def run(session: Session) -> None:
        session.playback.step_key(keys_now(session), direction)
        session.seek(session.playback.time)

    return run


def _speed(factor: float) -> Run:
    def run(session: Session) -> None:
        session.playback.speed = min(max(session.playback.speed * factor, -100.0), 100.0)

    return run


def _normal(session: Session) -> None:
    session.playback.speed = 1.0


def _drive(drive: str) -> Run:
    return guarded(lambda editor: editor.drive(drive))


def _driven(drive: str) -> Test:
    return lambda session: session.document is not None and drive_of(session) == drive


def _split(editor: AnimationEditor) -> None:
    view = editor.session.animating
    editor.split_block(view.track, view.block, editor.session.playback.time)


def _delete(editor: AnimationEditor) -> None:
    view = editor.session.animating
    editor.remove_block(view.track, view.block)
    view.block = -1


def _toggle_root(editor: AnimationEditor) -> None:
    editor.root_motion(not _root_on(editor.session))


def _root_on(session: Session) -> bool:
    return _has_animation(session) and bool(runtime_of(session).deck.root_motion)


def _toggle(name: str) -> tuple[Run, Test]:
    def run(session: Session) -> None:
        setattr(session.animating, name, not getattr(session.animating, name))

    return run, lambda session: bool(getattr(session.animating, name))


def _ghosts(session: Session) -> None:
    session.animating.ghosts = 0 if session.animating.ghosts else 3


def _panel(title: str) -> Run:
    def run(session: Session) -> None:
        session.ui.focus_panel = title

    return run


def _has_clips(session: Session) -> bool:
    return session.document is not None and bool(getattr(session.document.runtime, "clips", ()))


def _has_animation(session: Session) -> bool:
    return animation_of(session) is not None


def _no_animation(session: Session) -> bool:
    return _has_clips(session) and not _has_animation(session)


def _has_block(session: Session) -> bool:
    return _has_animation(session) and session.animating.block >= 0
