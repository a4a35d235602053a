"""The status bar's hints: what the mouse does with the keys that are held now, and with the tool in use. No imgui."""

from __future__ import annotations

from collections.abc import Set as AbstractSet

from editor.navigation import DEFAULT_PRESET, PRESETS, WHEEL, hints, wheel_motion

#: motion -> what it does
MOTIONS = {
    "orbit": "Orbit", "pan": "Pan", "dolly": "Zoom", "fly": "Fly", "environment": "Turn the light",
    "select": "Select more",
}  # fmt: skip
BUTTONS = {"left": "Left drag", "middle": "Middle drag", "right": "Right drag"}
WHEELS = {"zoom": "Zoom to the pointer", "pan": "Pan", "orbit": "Orbit"}
#: tool -> held key -> what it does to a drag of the gizmo
SNAPS = {
    "move": {"ctrl": "Snap to the grid", "shift": "Stand on surfaces"},
    "rotate": {"ctrl": "Snap to steps"}, "scale": {"ctrl": "Snap to steps"},
}  # fmt: skip


def live_hints(
    preset: str,
    held: AbstractSet[str],
    *,
    tool: str = "",
    flying: bool = False,
    measuring: bool = False,
    pointer: str = "mouse",
) -> list[tuple[str, str]]:
    """(gesture, what it does): of the held modifiers (ctrl, alt, shift) where there are some, else the usual ones."""
    if flying:
        return [("W A S D Q E", "Fly"), ("Shift", "Faster"), ("Wheel", "Speed")]
    if measuring:
        return [("Click", "Set a point"), ("M", "Stop measuring")]
    if not held:
        found = hints(preset, pointer)[:3]
        return [*found, *((key.capitalize(), what) for key, what in SNAPS.get(tool, {}).items())]
    found = [
        (BUTTONS[b.button], MOTIONS[b.motion])
        for b in PRESETS.get(preset, PRESETS[DEFAULT_PRESET])
        if b.modifiers == held and b.motion in MOTIONS
    ]
    if frozenset(held) in WHEEL:
        wheel = "Two fingers" if pointer == "trackpad" else "Wheel"
        found.append((wheel, WHEELS[wheel_motion(preset, frozenset(held), pointer)]))
    if len(held) == 1:
        found += [("Gizmo", what) for key, what in SNAPS.get(tool, {}).items() if key in held]
    return found
