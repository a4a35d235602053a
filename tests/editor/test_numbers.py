"""Going to a pixel that is no number: which texture is shown, and what is selected, without a window."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from fake_engine import FakeHost, FakeRuntime

from editor import numbers
from editor.document import Document
from editor.host import Resolved
from editor.preferences import Preferences
from editor.session import Session
from engine.framegraph.planning import Lifetime
from engine.gpu.types import TextureDesc
from engine.render.settings import RenderSettings
from engine.report.number_check import NumberReport, NumberRow

ROW = NumberRow("opaque", "hdr", 0, 40, 20, 3, 0, 0, 0, 3, (12, 5, 0), (float("nan"), 0.0, 0.0, 1.0))


def session(desc: TextureDesc, *, taken: bool = False) -> Session:
    """A session whose last picture is 40x20; `taken`: another texture took the memory of `hdr` later."""
    made = Session(FakeHost(), Preferences(welcome_seen=True))
    made.save_preferences = False
    made.device = made.host.open_device(False)
    made.adopt(Document(Resolved(Path("/nowhere/a.glb"), Path("/nowhere/a.scene.json")), FakeRuntime()))
    assert made.document is not None
    made.document.runtime.picked = 2
    made.width, made.height = 40, 20
    slots, spans = {"hdr": 0}, {"hdr": Lifetime(0, 1)}
    if taken:
        slots["blur"], spans["blur"] = 0, Lifetime(2, 3)
    plan = SimpleNamespace(descs={"hdr": desc}, slots=slots, spans=spans)
    found = NumberReport((ROW,))
    made.image.frame = SimpleNamespace(graph=SimpleNamespace(plan=plan), numbers=found)
    made.image.width, made.image.height = 40, 20
    return made


@pytest.mark.parametrize(
    ("desc", "taken", "shown", "why"),
    [
        (TextureDesc("rgba16f", 40, 20), False, "hdr", ""),
        (TextureDesc("rgba16f", 40, 20, samples=4), False, "color", "several samples"),
        (TextureDesc("rgba16f", 40, 20), True, "hdr", ""),
    ],
    ids=["readable", "multisampled", "overwritten"],
)
def test_the_texture_or_what_can_be_shown_in_its_place(desc: TextureDesc, taken: bool, shown: str, why: str) -> None:
    s = session(desc, taken=taken)
    numbers.go_to(s, ROW)
    wanted = s.ui.show_pixel
    assert (wanted.resource, wanted.x, wanted.y) == (shown, 12, 5)
    assert why in wanted.note
    assert s.ui.focus_panel == "Textures"
    assert s.document is not None
    assert s.document.selection == (2,)
    assert s.ui.notice == "lid lies under it"


def test_a_texel_of_a_shadow_map_selects_nothing() -> None:
    s = session(TextureDesc("rg32f", 64, 64, kind="2d-array", layers=4))
    row = NumberRow("blur", "hdr", 0, 64, 64, 1, 0, 0, 0, 1, (9, 9, 2), (0.0, 0.0, 0.0, 0.0))
    numbers.go_to(s, row)
    assert s.ui.show_pixel.layer == 2
    assert s.document is not None
    assert s.document.selection == ()
    numbers.go_to(s, NumberRow("a", "hdr", 0, 1, 1, 0, 0, 0, 0, 0))
    assert s.ui.show_pixel.layer == 2, "where there is none there is nowhere to go"


def test_switching_on_and_off() -> None:
    s = session(TextureDesc("rgba16f", 40, 20))
    assert not numbers.offered(s), "the fake's settings know no check"
    settings: Any = RenderSettings()
    s._settings = settings
    numbers.toggle_marks(s)
    assert (settings.view, settings.check_numbers) == ("nonfinite", True)
    numbers.toggle_marks(s)
    assert (settings.view, settings.check_numbers) == ("lit", True)
    numbers.toggle_marks(s)
    numbers.toggle(s)
    assert (settings.view, settings.check_numbers) == ("lit", False)
    assert not settings.wants_numbers
    assert numbers.summary(NumberReport((ROW,))) == "3 NaN/Inf, first in opaque"
    assert numbers.summary(NumberReport()) == "no NaN or Inf"
