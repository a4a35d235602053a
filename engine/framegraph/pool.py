"""The textures behind a graph: transient ones shared by all compiled graphs of a device, history pairs per view."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, replace

from engine.framegraph.resources import texture_bytes
from engine.gpu.types import Device, Texture, TextureDesc


@dataclass(slots=True)
class Pooled:
    """A texture of the pool; `used` is the execution in which it was last used."""

    texture: Texture
    used: int


class TransientPool:
    """Textures whose content dies with the frame. Graphs run one after the other, so all of them share.

    `generation` grows when textures were freed: whoever holds some asks again.
    """

    def __init__(self, device: Device) -> None:
        self.device = device
        self.generation = 0
        self.clock = 0
        self._entries: dict[TextureDesc, list[Pooled]] = {}

    def acquire(self, descs: Sequence[TextureDesc]) -> list[Pooled]:
        """One texture for each desc, all different; made where there are too few."""
        taken: Counter[TextureDesc] = Counter()
        result = []
        for desc in descs:
            key = replace(desc, label="")
            entries = self._entries.setdefault(key, [])
            if taken[key] == len(entries):
                label = f"transient {desc.format} {desc.width}x{desc.height} #{len(entries)}"
                entries.append(Pooled(self.device.texture(replace(desc, label=label)), self.clock))
            result.append(entries[taken[key]])
            taken[key] += 1
        return result

    def trim(self, max_age: int = 8) -> None:
        """Free the textures that the last `max_age` executions did not use (0: all of them)."""
        for desc, entries in list(self._entries.items()):
            kept = [entry for entry in entries if self.clock - entry.used < max_age]
            if len(kept) < len(entries):
                self.generation += 1
                for entry in entries:
                    if entry not in kept:
                        entry.texture.release()
            if kept:
                self._entries[desc] = kept
            else:
                del self._entries[desc]

    @property
    def bytes(self) -> int:
        return sum(texture_bytes(desc) * len(entries) for desc, entries in self._entries.items())

    def __len__(self) -> int:
        return sum(map(len, self._entries.values()))


@dataclass(slots=True)
class History:
    """A pair of textures: `current` is written in this frame, `previous` was in the last one."""

    current: Texture
    previous: Texture
    reset: bool = True
    stamp: int = -1


class HistoryStore:
    """History pairs by view and name. They outlive a recompile of the view's graph unless their desc changes."""

    def __init__(self, device: Device) -> None:
        self.device = device
        self._pairs: dict[tuple[Hashable, str], tuple[TextureDesc, History]] = {}
        self._frames: dict[Hashable, int] = {}

    def begin_frame(self, view: Hashable) -> None:
        self._frames[view] = self._frames.get(view, 0) + 1

    def swap(self, view: Hashable, name: str, desc: TextureDesc) -> History:
        """The pair of this frame. `reset` when it is new or the view's last frame did not write it."""
        known = self._pairs.get((view, name))
        if known is None or known[0] != desc:
            if known is not None:
                _release(known[1])
            one, other = (self.device.texture(replace(desc, label=f"{name} history {i}")) for i in (0, 1))
            pair = History(one, other)
            self._pairs[view, name] = (desc, pair)
        else:
            pair = known[1]
            pair.current, pair.previous = pair.previous, pair.current
        frame = self._frames[view]
        pair.reset = pair.stamp != frame - 1
        pair.stamp = frame
        return pair

    def reset(self, view: Hashable) -> None:
        """Forget what the view's histories hold (a cut of the camera)."""
        self._frames[view] = self._frames.get(view, 0) + 1

    def keep_only(self, views: Iterable[Hashable]) -> None:
        """Free the histories of all other views."""
        wanted = set(views)
        for view, name in list(self._pairs):
            if view not in wanted:
                _release(self._pairs.pop((view, name))[1])
        for view in list(self._frames):
            if view not in wanted:
                del self._frames[view]


def _release(pair: History) -> None:
    pair.current.release()
    pair.previous.release()
