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
        _b("left", "pan", "alt", "shift"),
        _b("right", "dolly"),
        _b("left", "dolly", "alt", "ctrl"),
        _b("right", "environment", "shift"),
        _b("left", "select", "ctrl"),
    ),
}
#: what moves the pointer: a mouse, whose wheel zooms; a trackpad, on which two fingers do what the preset says
POINTERS = ("mouse", "trackpad")
#: what the wheel does with a modifier held; "zoom" goes to the pointer
WHEEL: dict[frozenset[str], str] = {
    frozenset(): "zoom",
    frozenset({"ctrl"}): "zoom",
    frozenset({"shift"}): "pan",
    frozenset({"alt"}): "orbit",
}
#: what two fingers do, by preset. Systems that tell of a pinch tell it as a wheel with Ctrl
FINGERS: dict[str, dict[frozenset[str], str]] = {
    "industry": {frozenset(): "pan", frozenset({"alt"}): "orbit"},  # beside one finger with Alt, which orbits
    "blender": {frozenset(): "orbit", frozenset({"alt"}): "orbit"},
    "viewer": {frozenset(): "pan", frozenset({"alt"}): "orbit"},  # one finger orbits
}
DEFAULT_PRESET = "industry"


def wheel_motion(preset: str, modifiers: frozenset[str], pointer: str = "mouse") -> str:
    """zoom, pan or orbit: what the wheel does, or two fingers do."""
    fingers = FINGERS.get(preset, FINGERS[DEFAULT_PRESET]) if pointer == "trackpad" else {}
    return {**WHEEL, **fingers}.get(modifiers, "zoom")


def motion_for(preset: str, button: str, modifiers: frozenset[str]) -> str:
    """The motion that a drag with `button` begins, or '' for none. A click without a drag always selects."""
    for binding in PRESETS.get(preset, PRESETS[DEFAULT_PRESET]):
        if binding.button == button and binding.modifiers == modifiers:
            return binding.motion
    return ""


def hints(preset: str, pointer: str = "mouse") -> list[tuple[str, str]]:
    """(gesture, what it does) for help cards, in reading order; the first binding of each motion, on a trackpad the
    first that one finger can do."""
    words = {
        "orbit": "Orbit",
        "pan": "Pan",
        "dolly": "Zoom",
        "fly": "Fly, with W A S D Q E",
        "environment": "Turn the light",
    }
    buttons = {"left": "left drag", "middle": "middle drag", "right": "right drag"}
    bindings = PRESETS.get(preset, PRESETS[DEFAULT_PRESET])
    if pointer == "trackpad":
        bindings = tuple(sorted(bindings, key=lambda b: ("left", "right", "middle").index(b.button)))
    found: dict[str, str] = {}
    for binding in bindings:
        if binding.motion in words and binding.motion not in found:
            modifiers = "".join(f"{m.capitalize()} + " for m in ("ctrl", "alt", "shift") if m in binding.modifiers)
            gesture = modifiers + buttons[binding.button]
            found[binding.motion] = gesture[:1].upper() + gesture[1:]
    rows = [(found[m], words[m]) for m in words if m in found]
    if pointer == "trackpad":
        two = words[wheel_motion(preset, frozenset(), pointer)]
        rows = [("Two fingers", two), ("Pinch, Ctrl + two fingers", "Zoom to the pointer"), *rows]
    else:
        rows.append(("Wheel", "Zoom to the pointer"))
    return [*rows, ("F  /  A", "Frame the selection / everything")]
