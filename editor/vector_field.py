"""Three numbers in a row of which some differ among the selected nodes: those show a dash, and only what is edited
changes."""

from __future__ import annotations

from collections.abc import Sequence

from imgui_bundle import imgui

from editor.param_widgets import MIXED

Vec3 = tuple[float, float, float]


def drag3(
    label: str, values: Sequence[float], speed: float, format: str, mixed: Sequence[bool] = (False, False, False)
) -> tuple[Vec3, tuple[bool, bool, bool]]:
    """Over the next item width; (the new values, which of them were edited)."""
    now = (float(values[0]), float(values[1]), float(values[2]))
    if not any(mixed):
        changed, edited = imgui.drag_float3(label, list(now), speed, 0, 0, format)
        new = (float(edited[0]), float(edited[1]), float(edited[2]))
        one, two, three = (bool(changed) and a != b for a, b in zip(new, now, strict=True))
        return new, (one, two, three)
    parts = []
    imgui.push_id(label)
    imgui.internal.push_multi_items_widths(3, imgui.calc_item_width())
    for index in range(3):
        if index:
            imgui.same_line(0, imgui.get_style().item_inner_spacing.x)
        shown = MIXED if mixed[index] else format
        imgui.push_id(index)  # the names that drag_float3 gives its parts
        changed, value = imgui.drag_float("", now[index], speed, 0, 0, shown)
        imgui.pop_id()
        parts.append((float(value) if changed else now[index], bool(changed)))
        imgui.pop_item_width()
    imgui.pop_id()
    (x, a), (y, b), (z, c) = parts
    return (x, y, z), (a, b, c)
