"""Scene: the tables of one scene, kept in step."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.assets.scene import EnvironmentAsset, LookAsset, NodeAsset, SceneAsset
from engine.core.findings import Findings
from engine.math import bounds
from engine.scene.cameras import CameraTable
from engine.scene.copies import OwnPlaces
from engine.scene.instances import InstanceTable
from engine.scene.lights import LightTable
from engine.scene.morphs import MorphTable
from engine.scene.node import Node
from engine.scene.nodes import NodeTable
from engine.scene.skins import SkinTable
from engine.scene.table import Rows

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class SceneCounts:
    """What there is to draw: shining lights by type, drawn instances, cameras. Hashable."""

    directional: int
    point: int
    spot: int
    instances: int
    cameras: int
    #: rectangles and disks
    area: int = 0

    @property
    def lights(self) -> int:
        return self.directional + self.point + self.spot + self.area


class Scene:
    """Nodes, instances, lights, cameras, environment and look.

    scene = Scene.from_asset(asset)        # instances are added by who knows the mesh ids
    scene.nodes.set_translation(rows, values)
    changed = scene.update()               # world transforms, then spheres; nothing to do costs nothing
    mask = visible_instances(scene, planes)
    """

    def __init__(self, name: str = "") -> None:
        self.name = name
        self.nodes = NodeTable()
        self.instances = InstanceTable(self.nodes)
        self.skins = SkinTable(self.nodes, self.instances)
        self.morphs = MorphTable(self.nodes, self.instances, self.skins)
        self.lights = LightTable(self.nodes)
        self.cameras = CameraTable(self.nodes)
        self.environment = EnvironmentAsset()
        self.look = LookAsset()
        #: what relative paths (of light profiles) start from
        self.folder = Path()
        #: node row of the camera to use, or -1
        self.active_camera = -1
        #: row of each node of the asset this scene was made from; -1 once removed
        self.row_of_node: I8 = np.zeros(0, np.int64)
        #: what making it from an asset noticed
        self.findings = Findings()
        #: per living node that came from an asset or was given one: mesh, joints, weights, extras, for saving
        self.sources: dict[int, NodeAsset] = {}
        #: of copies that clips move about a place of their own: where that is; whoever plays clips sets it
        self.places: OwnPlaces | None = None
        self._counts: tuple[tuple[int, ...], SceneCounts] | None = None

    @classmethod
    def from_asset(cls, asset: SceneAsset) -> Scene:
        """Return the scene of `asset`, updated; `row_of_node` maps its node indices to rows.

        Values that no scene can hold (NaN, a parent after its child) are mended and noted in `findings`. Instances are
        not made: mesh ids come from whoever loads the meshes.
        """
        from engine.scene.convert import fill_scene

        scene = cls(asset.name)
        fill_scene(scene, asset)
        return scene

    def to_asset(self, base: SceneAsset | None = None) -> SceneAsset:
        """Return the scene as an asset, parents before children; clips and provenance are taken from `base`."""
        from engine.scene.convert import scene_asset

        return scene_asset(self, base)

    @property
    def structure_rev(self) -> int:
        """Rises when a row of any table is added, removed or hung elsewhere, or a material is changed."""
        tables = (self.nodes, self.instances, self.lights, self.cameras)
        return sum(table.structure_rev for table in tables) + self.skins.structure_rev + self.morphs.structure_rev

    @property
    def transform_rev(self) -> int:
        """Rises with every `update()` that changed a world transform."""
        return self.nodes.transform_rev

    def update(self) -> I8:
        """Bring world transforms, visibility and world spheres up to date; return the node rows whose world changed."""
        changed = self.nodes.update()
        self.instances.update()
        if self.skins.update():
            self.morphs.update_skinned()
        return changed

    def node(self, row: int) -> Node:
        """Return a view of `row`. Raises InputError if there is no such row."""
        return Node(self.nodes, row)

    def find(self, name: str) -> Node | None:
        """Return the first living node called `name`, or None. O(n): for editors and scripts."""
        start = 0
        while True:
            try:
                row = self.nodes.name.index(name, start)
            except ValueError:
                return None
            if self.nodes.alive[row]:
                return Node(self.nodes, row)
            start = row + 1

    def remove(self, rows: Rows) -> I8:
        """Remove nodes with everything below and on them: instances, lights, cameras. Return the node rows removed."""
        gone = self.nodes.remove(rows)
        for table in (self.instances, self.lights, self.cameras):
            table.remove_of_nodes(gone)
        self.skins.remove_of_nodes(gone)
        self.row_of_node[np.isin(self.row_of_node, gone)] = -1
        if self.active_camera in gone:
            self.active_camera = -1
        for row in gone.tolist():
            self.sources.pop(row, None)
        return gone

    def bounds(self) -> tuple[F8, F8]:
        """Return (min f8[3], max f8[3]) of the drawn instances' spheres in the world; both zero if there are none."""
        table = self.instances
        if len(table) and table.drawn.all():
            return bounds.of_spheres(table.world_center, table.world_radius)
        return bounds.of_spheres(table.world_center[table.drawn], table.world_radius[table.drawn])

    def counts(self) -> SceneCounts:
        """Return what there is, as of the last update. Cached until a table changes."""
        key = (self.structure_rev, self.nodes.visible_rev, self.lights.rev, self.instances.drawn_rev)
        if self._counts is None or self._counts[0] != key:
            kinds = np.bincount(self.lights.type[self.lights.shining()], minlength=5)
            drawn = int(np.count_nonzero(self.instances.drawn))
            area = int(kinds[3] + kinds[4])
            counts = SceneCounts(int(kinds[0]), int(kinds[1]), int(kinds[2]), drawn, self.cameras.alive_count, area)
            self._counts = (key, counts)
        return self._counts[1]
