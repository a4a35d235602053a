"""What the worker sends: the scene as JSON and arrays, checked where something depends on it.

    nodes[i]      {"name", "parent", "kind", "visible", "mesh", "light", "camera", "materials", "root", "helper"}
    translation, rotation, scale     f8[nodes, 3|4|3], local;  node_from_geometry f8[nodes,3,4]
    meshes[i]     see extract_meshes.py          materials[i], textures[i]   see extract_materials.py
    stacks[i]     see extract_animation.py       lights[i], cameras[i]       see extract.py

References are indices, -1 for none. Arrays stand in the JSON by their names.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import FormatError
from engine.core.findings import Findings
from importers.workers.runner import WorkerResult

Json = dict[str, Any]

#: coordinates beyond this are no places; float32 squares of them would overflow
LARGEST = 1e18


class FbxDocument:
    """The worker's answer, with what the host needs to find its way: the hierarchy, and findings to add to."""

    def __init__(self, result: WorkerResult, findings: Findings) -> None:
        self.data = result.data
        self.findings = findings
        self._arrays = result.arrays
        self.nodes: list[Json] = self.data["nodes"]
        self.meshes: list[Json] = self.data["meshes"]
        self.materials: list[Json] = self.data["materials"]
        self.textures: list[Json] = self.data["textures"]
        self.parents: list[int] = [int(node["parent"]) for node in self.nodes]
        if any(not -1 <= parent < index for index, parent in enumerate(self.parents)):
            raise FormatError("a node does not come after its parent")
        self.names = self._names()
        self.sequence = self._sequence()

    def array(self, name: str) -> NDArray[Any]:
        return self._arrays[name]

    def floats(self, name: str, components: int) -> NDArray[np.float64]:
        """f8[n, components] with what is no number, or too large, as 0."""
        values = np.asarray(self._arrays[name], np.float64).reshape(-1, components)
        bad = ~(np.abs(values) < LARGEST)
        return np.where(bad, 0.0, values) if bad.any() else values

    def bytes_of(self, name: str) -> bytes:
        return self._arrays[name].tobytes()

    def _names(self) -> list[str]:
        names: list[str] = []
        for index, node in enumerate(self.nodes):
            parent = names[self.parents[index]] if self.parents[index] >= 0 else ""
            helper = node["helper"]
            names.append(f"{parent}.{helper}" if helper else str(node["name"]) or f"node_{index}")
        return names

    def _sequence(self) -> list[int]:
        """All nodes depth first."""
        children: list[list[int]] = [[] for _ in self.nodes]
        roots: list[int] = []
        for index, parent in enumerate(self.parents):
            (children[parent] if parent >= 0 else roots).append(index)
        order: list[int] = []
        stack = roots[::-1]
        while stack:
            index = stack.pop()
            order.append(index)
            stack.extend(reversed(children[index]))
        return order
