"""What a glTF scene's extras may say about its light and look, and what happens when they say it wrongly."""

from __future__ import annotations

from typing import Any

import pytest

from engine.assets.scene import EnvironmentAsset, LookAsset
from engine.core.findings import Findings
from importers.gltf.document import Document
from importers.gltf.surroundings import read_surroundings


def read(wish: Any, scene: int = 0) -> tuple[EnvironmentAsset, LookAsset, list[str]]:
    findings = Findings("x.gltf")
    doc = Document({"scene": scene, "scenes": [{"extras": {"lucarna": wish}}]}, findings)
    environment, look = read_surroundings(doc)
    return environment, look, [str(f) for f in findings]


def test_it_is_read() -> None:
    environment, look, found = read(
        {"environment": {"kind": "sky", "background": "color"}, "look": {"tone_map": "agx", "exposure": -1}}
    )
    assert (environment.kind, environment.background) == ("sky", "color")
    assert (look.tone_map, look.exposure) == ("agx", -1.0)
    assert found == []


@pytest.mark.parametrize(
    ("wish", "words"),
    [
        ({"lock": {}}, "did you mean 'look'"),
        ({"look": {"tone_map": "agxx"}}, "did you mean 'agx'"),
        ({"look": {"exposure": "bright"}}, "extras.lucarna.look.exposure"),
        ({"environment": {"kind": "image", "path": "../../secret.hdr"}}, "cannot come along"),
        ([1], "extras.lucarna"),
    ],
)
def test_mistakes_are_findings_and_the_defaults_stay(wish: Any, words: str) -> None:
    environment, look, (finding,) = read(wish)
    assert words in finding
    assert environment == EnvironmentAsset()
    assert look == LookAsset()


@pytest.mark.parametrize("root", [{}, {"scenes": []}, {"scenes": [{}]}, {"scene": 7, "scenes": [{"extras": 3}]}])
def test_without_a_wish_there_is_nothing_to_say(root: dict[str, Any]) -> None:
    findings = Findings()
    assert read_surroundings(Document(root, findings)) == (EnvironmentAsset(), LookAsset())
    assert not len(findings)
