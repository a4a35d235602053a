"""Area lights of FBX files: a rectangle by its node's scale, of the same candela straight ahead."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from engine.core.findings import Findings
from importers.fbx.nodes import _light, _spread

AREA = {
    "type": "area", "shape": "rectangle", "color": [1.0, 0.5, 0.0], "intensity": 1.0, "on": True, "decay": "quadratic",
    "inner_angle": 0.0, "outer_angle": 90.0,
}  # fmt: skip


def light_of(light: dict[str, Any], sizes: tuple[float, float], application: str = "Maya") -> tuple[Any, Findings]:
    doc: Any = SimpleNamespace(
        findings=Findings(), names=["lamp"], data={"application": application, "unit_meters": 1.0}
    )
    asset = _light(doc, light, 2.0, 0)
    _spread(doc, light, asset, np.array(sizes), 0)
    return asset, doc.findings


def test_a_rectangle_has_the_size_of_its_node() -> None:
    light, findings = light_of(AREA, (0.5, 1.5))
    assert (light.type, light.width, light.height) == ("rectangle", 1.0, 3.0)
    assert light.intensity == pytest.approx(np.pi / 3.0), "nit: candela over area"
    assert [f.code for f in findings] == ["fbx.light"]


def test_the_power_that_blender_writes_leaves_from_one_side() -> None:
    point, _ = light_of({**AREA, "type": "point"}, (0.5, 0.5), "Blender (stable FBX IO)")
    area, _ = light_of(AREA, (0.5, 0.5), "Blender (stable FBX IO)")
    assert area.intensity == pytest.approx(4.0 * point.intensity)


@pytest.mark.parametrize("change", [{"shape": "sphere"}, {"type": "volume"}])
def test_other_shapes_stay_points(change: dict[str, str]) -> None:
    light, findings = light_of({**AREA, **change}, (0.5, 1.5))
    assert light.type == "point"
    assert "point light" in str(next(iter(findings)))


def test_a_flattened_node_gives_no_rectangle() -> None:
    light, _ = light_of(AREA, (0.0, 1.5))
    assert light.type == "point"
    assert np.isfinite(light.intensity)
