"""`lucarna inspect X.effect.toml`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from engine.core.errors import UsageError
from engine.core.paths import shaders_dir
from importers.cli.main import main
from importers.effect_inspection import describe_effect

SURFACE = shaders_dir() / "effects/surface.effect.toml"


def test_describes_parameters_and_sources_with_origins() -> None:
    described = describe_effect(SURFACE, features=("normal_map",))
    assert described["name"] == "surface"
    roughness = next(p for p in described["params"] if p["name"] == "roughness")
    assert (roughness["min"], roughness["max"]) == (0.0, 1.0)
    assert "struct MaterialParams {" in [line.rstrip() for line in described["generated"]]
    fragment = described["sources"]["fragment"]
    assert "<defines>:1 | #define STAGE_FRAGMENT 1" in fragment
    assert any(line.startswith("<defines>:") and line.endswith("#define NORMAL_MAP 1") for line in fragment)
    assert any(line.startswith("brdf.glsl:") for line in fragment)


def test_an_unknown_feature_is_refused() -> None:
    with pytest.raises(UsageError, match="did you mean 'normal_map'"):
        describe_effect(SURFACE, features=("normal_mp",))


def test_the_command_prints_json_and_sources(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", str(SURFACE), "--json"]) == 0
    described = json.loads(capsys.readouterr().out)
    assert described["kind"] == "effect"
    assert {"meshes", "clips", "materials", "nodes", "lights", "cameras", "findings"} <= set(described), "alike"
    assert described["variants_possible"] > 1
    assert main(["inspect", str(SURFACE), "--source"]) == 0
    out = capsys.readouterr().out
    assert "surface.frag:2" not in out.split("fragment:")[0]
    assert "surface.frag:" in out


@pytest.mark.gl
def test_a_scene_tells_which_variants_it_uses(tmp_path: Path, gl_device: object) -> None:
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "editor" / "support"))
    from small_scene import write_small_scene

    scene = write_small_scene(tmp_path)
    described = describe_effect(SURFACE, scene=scene)
    forward = [v for v in described["variants"] if v["role"] == "forward"]
    assert len(forward) == 1
    assert forward[0]["used_by"] == ["grey", "red"]
    assert forward[0]["compile_ms"] > 0.0
    assert forward[0]["error"] == ""
    assert "normal_map" in forward[0]["absent"]


@pytest.mark.gl
def test_features_that_change_no_pixel_of_the_scene(
    tmp_path: Path, gl_device: object, capsys: pytest.CaptureFixture[str]
) -> None:
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "editor" / "support"))
    from small_scene import write_small_scene

    from engine.assets.material_toml import update_material

    scene = write_small_scene(tmp_path)
    update_material(tmp_path / "boxes.red.material.toml", {"features": ["unlit"]})
    described = describe_effect(SURFACE, scene=scene, pixels=True)
    unlit = next(item for item in described["feature_pixels"] if item["feature"] == "unlit")
    assert unlit["verdict"] == "changes pixels"
    assert unlit["changed"] > 0
    assert described["never_change_a_pixel"] == []
    with pytest.raises(UsageError, match="--pixels needs a scene"):
        describe_effect(SURFACE, pixels=True)
    assert main(["inspect", str(SURFACE), "--scene", str(scene), "--pixels"]) == 0
    out = capsys.readouterr().out
    assert "feature unlit, verdict changes pixels" in out
