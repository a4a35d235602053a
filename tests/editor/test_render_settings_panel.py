"""The panel of render settings: every parameter under a heading; what is off hides its parts and nothing else."""

from __future__ import annotations

from editor.panels.render_settings import GROUPS, grouped, means
from engine.render.settings import RenderSettings


def shown(**settings: object) -> set[str]:
    values = RenderSettings(**settings).values()
    return {name for name in values if means(name, values)}


def test_every_parameter_has_one_place() -> None:
    found = grouped(RenderSettings.PARAMS)
    assert list(found) == list(GROUPS)
    assert sorted(p.name for params in found.values() for p in params) == sorted(p.name for p in RenderSettings.PARAMS)
    assert {"taa_thin", "smaa_patterns", "samples"} <= {p.name for p in found["Edges"]}
    assert {"ao_radius", "ambient_occlusion"} == {p.name for p in found["Ambient occlusion"]} & {
        "ao_radius", "ambient_occlusion", "gi"
    }  # fmt: skip


def test_parts_of_what_is_off_are_hidden_and_come_back() -> None:
    plain = shown()
    assert not {"taa_frames", "smaa_patterns", "ao_radius", "gi_radius", "focus", "f_stop", "bloom_radius"} & plain
    assert {"antialias", "ambient_occlusion", "gi", "depth_of_field", "bloom", "auto_exposure", "reflections"} <= plain
    for settings, part in (
        ({"antialias": "taa"}, "taa_thin"), ({"antialias": "smaa"}, "smaa_patterns"),
        ({"ambient_occlusion": "gtao"}, "ao_radius"), ({"gi": "one"}, "gi_radius"), ({"bloom": 0.1}, "bloom_calm"),
        ({"reflections": True}, "gi_separation"), ({"reflections": True}, "reflection_distance"),
        ({"depth_of_field": True}, "focus_taps"), ({"auto_exposure": True}, "auto_limit"),
    ):  # fmt: skip
        assert part not in plain
        assert part in shown(**settings), settings
