"""Which gesture in the viewport does what: keymap presets as tables. No imgui.

A preset lists, in order, (button, modifiers) -> motion; the first that matches wins. Modifiers match exactly, so
that Shift+MMB never also orbits.
"""

from __future__ import annotations

from dataclasses import dataclass

MOTIONS = ("orbit", "pan", "dolly", "fly", "environment", "select")


@dataclass(frozen=True, slots=True)
class Binding:
    button: str  # left | middle | right
    modifiers: frozenset[str]  # of shift, ctrl, alt
    motion: str


def _b(button: str, motion: str, *modifiers: str) -> Binding:
    return Binding(button, frozenset(modifiers), motion)


#: name -> drag bindings. Each motion can be reached with one button and Alt, for trackpads and pens.
PRESETS: dict[str, tuple[Binding, ...]] = {
    "industry": (
        _b("left", "orbit", "alt"),
        _b("middle", "pan", "alt"),
        _b("left", "pan", "alt", "shift"),
        _b("right", "dolly", "alt"),
        _b("left", "dolly", "alt", "ctrl"),
        _b("middle", "orbit"),
        _b("middle", "pan", "shift"),
        _b("middle", "dolly", "ctrl"),
        _b("right", "fly"),
        _b("right", "environment", "shift"),
        _b("left", "select"),
        _b("left", "select", "ctrl"),
    ),
    "blender": (
        _b("middle", "orbit"),
        _b("middle", "pan", "shift"),
        _b("middle", "dolly", "ctrl"),
        _b("left", "orbit", "alt"),
        _b("left", "pan", "alt", "shift"),
        _b("left", "dolly", "alt", "ctrl"),
        _b("right", "fly"),
        _b("right", "environment", "shift"),
        _b("left", "select"),
        _b("left", "select", "ctrl"),
    ),
    "viewer": (
        _b("left", "orbit"),
        _b("left", "orbit", "alt"),
        _b("middle", "pan"),
        _b("left", "pan", "shift"),
        _b("right", "dolly"),
        _b("left", "dolly", "alt", "ctrl"),
        _b("right", "environment", "shift"),
        _b("left", "select", "ctrl"),
    ),
}
#: what the wheel (or two fingers) does by preset and modifier; "zoom" goes to the cursor
WHEEL: dict[frozenset[str], str] = {
    frozenset(): "zoom",
    frozenset({"ctrl"}): "zoom",
    frozenset({"shift"}): "pan",
    frozenset({"alt"}): "orbit",
}
DEFAULT_PRESET = "industry"


def motion_for(preset: str, button: str, modifiers: frozenset[str]) -> str:
    """The motion that a drag with `button` begins, or '' for none. A click without a drag always selects."""
    for binding in PRESETS.get(preset, PRESETS[DEFAULT_PRESET]):
        if binding.button == button and binding.modifiers == modifiers:
            return binding.motion
    return ""


def hints(preset: str) -> list[tuple[str, str]]:
    """(gesture, what it does) for help cards, in reading order; the first binding of each motion."""
    words = {
        "orbit": "Orbit",
        "pan": "Pan",
        "dolly": "Zoom",
        "fly": "Fly, with W A S D Q E",
        "environment": "Turn the light",
    }
    buttons = {"left": "left drag", "middle": "middle drag", "right": "right drag"}
    found: dict[str, str] = {}
    for binding in PRESETS.get(preset, PRESETS[DEFAULT_PRESET]):
        if binding.motion in words and binding.motion not in found:
            modifiers = "".join(f"{m.capitalize()} + " for m in ("ctrl", "alt", "shift") if m in binding.modifiers)
            gesture = modifiers + buttons[binding.button]
            found[binding.motion] = gesture[:1].upper() + gesture[1:]
    rows = [(found[m], words[m]) for m in words if m in found]
    return [*rows, ("Wheel", "Zoom to the pointer"), ("F  /  A", "Frame the selection / everything")]
