"""The session's clock and log follow what drives the scene: durations, markers, events."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from editor.session import Session


def runtime_of(session: Session) -> Any:
    """The open document's runtime (engine.app.runtime.Runtime). Only with a document."""
    assert session.document is not None
    return session.document.runtime


def animation_of(session: Session) -> Any:
    """The open animation (engine.app.animation.Animation), or None."""
    return getattr(session.document.runtime, "animation", None) if session.document is not None else None


def drive_of(session: Session) -> str:
    """clips, timeline or states."""
    return str(getattr(session.document.runtime, "drive", "clips")) if session.document is not None else "clips"


def follow(session: Session) -> None:
    """After an edit or another choice of what plays: bring the clock up to date."""
    document = session.document
    if document is None:
        return
    animation, drive = animation_of(session), drive_of(session)
    deck = getattr(document.runtime, "deck", None)
    beside = tuple(getattr(document.runtime, "beside", ()))
    state = (drive, (*deck.active, *beside) if deck is not None else ())
    if session.followed is not None and session.followed[0] is animation and session.followed[1:] == state:
        return
    if session.followed is None or session.followed[1] != drive:
        session.animating.fitted = False
    if session.followed is None:
        rates = [clip.frame_rate for clip in getattr(deck, "clips", ()) if clip.frame_rate > 0.0]
        session.playback.frame_rate = float(rates[0]) if rates else session.playback.frame_rate
    session.followed = (animation, *state)
    playback = session.playback
    if animation is not None and drive != "clips":
        playback.set_duration(animation.duration)
    elif deck is not None:
        playback.set_duration(float(document.runtime.duration))
    playback.set_markers(*markers(session))
    if drive == "states":
        runtime_of(session).pose_again()
        document.runtime.update(playback.elapsed)
    else:
        session.seek(playback.time)


def markers(session: Session) -> tuple[Any, list[str]]:
    """(times, names) of what the playhead passes; where states drive, the animator tells of its own."""
    animation, drive = animation_of(session), drive_of(session)
    if animation is None or drive == "states":
        return np.zeros(0), []
    if drive == "timeline" and animation.sequence is not None:
        times, names = animation.sequence.occurrences()
        return times, list(names)
    deck = runtime_of(session).deck
    found = []
    for number in deck.active:
        for key, clip in animation.model.clips.items():
            if (clip.source or key) == deck.clips[number].name:
                found += [(m.time, m.name) for m in clip.markers]
    found.sort()
    return np.array([t for t, _ in found]), [n for _, n in found]


def report(session: Session) -> None:
    """Write the markers passed since the last time to the log, each once, and what drawing noticed, once for as long
    as it is so."""
    document, playback = session.document, session.playback
    if document is None:
        return
    _report_drawing(session)
    for name, time, direction in playback.passed:
        session.messages.info(f"Event {name!r} at {time:.3f} s{'' if direction > 0 else ', backwards'}")
    playback.passed.clear()
    deck = getattr(document.runtime, "deck", None)
    animator = deck.animator if deck is not None else None
    if deck is not None and animator is not None and len(deck.fired):
        names = animator.marker_names
        for number, direction in zip(deck.fired.marker.tolist(), deck.fired.direction.tolist(), strict=True):
            session.messages.info(f"Event {names[number]!r}{'' if direction > 0 else ', backwards'}")
        deck.fired = type(deck.fired)()


def _report_drawing(session: Session) -> None:
    renderer = getattr(runtime_of(session), "renderer", None)
    parts = [getattr(renderer, name, None) for name in ("skin_findings", "light_findings")]
    if all(part is before for part, before in zip(parts, session.drawing_noted, strict=True)):
        return  # whoever looks makes a new list when the scene has changed
    known = {finding for part in session.drawing_noted if part is not None for finding in part}
    opened = [(f.code, f.message) for f in runtime_of(session).findings]  # in the log since then
    new = dict.fromkeys(finding for part in parts if part is not None for finding in part)
    session.messages.findings(
        f for f in new if f not in known and not any(f.code == code and text in f.message for code, text in opened)
    )
    session.drawing_noted = (parts[0], parts[1])
