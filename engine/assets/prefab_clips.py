"""The clips of a prefab as its instances play them: those of its own file and of the prefabs in it.

A clip of `hero.scene.json` is known as `hero/walk`; one of a prefab in it as `hero/horse/trot`. Its channels count the
prefab's nodes, each of which an instance has under a key (engine.assets.prefab.keys_of).
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from engine.assets.clip import ClipAsset
from engine.assets.clip_nodes import spread
from engine.assets.lanim import read_lanim
from engine.assets.prefab import NODE, file_of, keys_of, load_prefab, members
from engine.core.errors import InputError
from engine.core.findings import Findings

SUFFIX = ".scene.json"


@dataclass(frozen=True, slots=True)
class PrefabClips:
    """`clips[i].channels[j].node` is a number in `keys`."""

    keys: list[str] = field(default_factory=list)
    clips: list[ClipAsset] = field(default_factory=list)


def prefab_clips(path: Path, findings: Findings, stack: Sequence[Path] = ()) -> PrefabClips:
    """What the prefab at `path` plays; a clip that cannot be read is a finding, and left out.

    Raises InputError for a prefab that cannot be read, or holds itself."""
    path = Path(os.path.normpath(path.absolute()))
    asset = load_prefab(path, stack)
    keys, name = keys_of(asset.nodes), path.name.removesuffix(SUFFIX)
    clips = []
    for file in asset.clips:
        try:
            clip = spread(read_lanim(path.parent / file), asset.nodes)
        except InputError as error:
            findings.error("clip.unreadable", str(error), hint=f"instances of {path.name} do without it")
            continue
        clips.append(replace(clip, name=f"{name}/{clip.name}", channels=list(clip.channels)))
    roots = [i for i, node in enumerate(asset.nodes) if file_of(node) and NODE not in node.extras]
    files = {i: Path(os.path.normpath(path.parent / file_of(asset.nodes[i]))) for i in roots}
    for inner in dict.fromkeys(files.values()):
        part = prefab_clips(inner, findings, (*stack, path))
        places = [
            {str(asset.nodes[i].extras[NODE]): i for i in members(asset, root)}
            for root, file in files.items()
            if file == inner
        ]
        for clip in part.clips:
            channels = [
                channel.of_node(place[part.keys[channel.node]])
                for place in places
                for channel in clip.channels
                if part.keys[channel.node] in place
            ]
            clips.append(replace(clip, name=f"{name}/{clip.name}", channels=channels))
    return PrefabClips(keys, clips)
