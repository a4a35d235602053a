"""MeasureFeatures: switches each feature of the scene's variants off, a few pictures between two frames of the window,
and tells which never change a pixel. No imgui."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from engine.app.feature_pixels import FeatureEffect, feature_effects, idle_features, views_of

if TYPE_CHECKING:
    from editor.session import Session


@dataclass(slots=True)
class MeasureFeatures:
    """A Work (editor.work). `result`: when it is done."""

    title: str = "Measuring what features change"
    progress: float = 0.0
    text: str = ""
    result: list[FeatureEffect] | None = None
    _run: Generator[tuple[float, str], None, list[FeatureEffect]] | None = None

    def step(self, session: Session) -> bool:
        document = session.document
        if document is None:
            return False
        with session.device_frame():
            if self._run is None:
                runtime: Any = document.runtime
                self._run = feature_effects(runtime, views_of(runtime))
            try:
                self.progress, self.text = next(self._run)
                return True
            except StopIteration as end:
                self.result = end.value
        session.feature_effects = self.result
        session.image.invalidate()
        return False

    def close(self) -> None:
        if self._run is not None:
            self._run.close()
            self._run = None


def told(found: list[FeatureEffect]) -> str:
    """One line of the whole."""
    idle = idle_features(found)
    if not found:
        return "No variant in use has a feature"
    names = "; ".join(f"{effect}: {', '.join(features)}" for effect, features in idle.items())
    return f"Never change a pixel here: {names}" if names else "Each feature in use changes pixels"


def verdict_of(found: list[FeatureEffect], effect: str, features: frozenset[str], feature: str) -> FeatureEffect | None:
    """What was measured of a feature of the variant, if anything."""
    mine = (item for item in found if item.effect == effect and item.feature == feature)
    return next((item for item in mine if features <= item.features), None)
