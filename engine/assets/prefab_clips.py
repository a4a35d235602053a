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
from engine.assets.scene import SceneAsset
from engine.core.errors import InputError
from engine.core.findings import Findings

SUFFIX = ".scene.json"


@dataclass(frozen=True, slots=True)
class PrefabClips:
    """`clips[i].channels[j].node` is a number in `keys`. `firsts`: those that play when the prefab is opened.

    `asset`: the prefab, and `own` its own clips, bound to the nodes of that, under the names that its file has for
    them: what its animation file is made of."""

    keys: list[str] = field(default_factory=list)
    clips: list[ClipAsset] = field(default_factory=list)
    firsts: list[int] = field(default_factory=list)
    asset: SceneAsset | None = None
    own: list[ClipAsset] = field(default_factory=list)


def prefab_clips(path: Path, findings: Findings, stack: Sequence[Path] = ()) -> PrefabClips:
    """What the prefab at `path` plays; a clip that cannot be read is a finding, and left out.

    Raises InputError for a prefab that cannot be read, or holds itself."""
    path = Path(os.path.normpath(path.absolute()))
    asset = load_prefab(path, stack)
    own = []
    for file in asset.clips:
        try:
            own.append(spread(read_lanim(path.parent / file), asset.nodes))
        except InputError as error:
            findings.error("clip.unreadable", str(error), hint=f"instances of {path.name} do without it")
    inner, firsts = _of_instances(asset, path.parent, findings, (*stack, path))
    name = path.name.removesuffix(SUFFIX)
    clips = [replace(clip, name=f"{name}/{clip.name}", channels=list(clip.channels)) for clip in (*own, *inner)]
    return PrefabClips(
        keys_of(asset.nodes), clips, [*range(min(len(own), 1)), *(len(own) + i for i in firsts)], asset, own
    )


def clips_of_instances(asset: SceneAsset, folder: Path, findings: Findings) -> list[ClipAsset]:
    """The clips that the prefabs bring whose instances stand in `asset`, a scene in `folder`; their channels count the
    nodes of `asset`, once for each instance. Raises InputError as prefab_clips."""
    return _of_instances(asset, folder, findings, ())[0]


def _of_instances(
    asset: SceneAsset, folder: Path, findings: Findings, stack: Sequence[Path]
) -> tuple[list[ClipAsset], list[int]]:
    """(clips, the numbers of those that play at first)."""
    roots = [i for i, node in enumerate(asset.nodes) if file_of(node) and NODE not in node.extras]
    files = {i: Path(os.path.normpath((folder / file_of(asset.nodes[i])).absolute())) for i in roots}
    clips: list[ClipAsset] = []
    firsts: list[int] = []
    for file in dict.fromkeys(files.values()):
        part = prefab_clips(file, findings, stack)
        places = [
            {str(asset.nodes[i].extras[NODE]): i for i in members(asset, root)} for root in roots if files[root] == file
        ]
        firsts += [len(clips) + i for i in part.firsts]
        for clip in part.clips:
            channels = [
                channel.of_node(place[part.keys[channel.node]])
                for place in places
                for channel in clip.channels
                if part.keys[channel.node] in place
            ]
            clips.append(replace(clip, channels=channels))
    return clips, firsts
