"""The tree of nodes: parents found, cycles cut, everything walked without recursion.

Source: glTF 2.0 specification (Khronos, 2021), section 3.5.3 (the node hierarchy is a set of strict trees).
"""

from __future__ import annotations

from dataclasses import dataclass

from importers.gltf.document import Document


@dataclass(slots=True)
class Hierarchy:
    """All nodes of the file: `parents[n]` (-1: none), `children[n]`, and `sequence`, depth first, parents first."""

    parents: list[int]
    children: list[list[int]]
    sequence: list[int]

    def subtree(self, roots: list[int]) -> list[int]:
        """`roots` and everything below them, depth first, each once."""
        result: list[int] = []
        seen: set[int] = set()
        stack = list(reversed(roots))
        while stack:
            node = stack.pop()
            if node not in seen:
                seen.add(node)
                result.append(node)
                stack.extend(reversed(self.children[node]))
        return result

    def root_of(self, node: int) -> int:
        while self.parents[node] >= 0:
            node = self.parents[node]
        return node


def read_hierarchy(doc: Document) -> Hierarchy:
    """The strict trees in the file's nodes. A second parent and an edge that closes a cycle are findings, and cut."""
    nodes = doc.objects("nodes")
    parents = [-1] * len(nodes)
    children: list[list[int]] = [[] for _ in nodes]
    for index, node in enumerate(nodes):
        where = f"nodes[{index}]"
        for child in doc.indices(node, "children", where, "nodes"):
            if child == index:
                doc.findings.error("gltf.cycle", "the node is its own child; the link is cut", f"{where}.children")
            elif parents[child] >= 0:
                doc.findings.error(
                    "gltf.two-parents",
                    f"nodes[{child}] is already a child of nodes[{parents[child]}]; the second link is cut",
                    f"{where}.children", "copy the node if it should appear twice",
                )  # fmt: skip
            else:
                parents[child] = index
                children[index].append(child)
    _cut_cycles(doc, parents, children)
    hierarchy = Hierarchy(parents, children, [])
    hierarchy.sequence = hierarchy.subtree([n for n, parent in enumerate(parents) if parent < 0])
    return hierarchy


def _cut_cycles(doc: Document, parents: list[int], children: list[list[int]]) -> None:
    """With one parent each, nodes that no root reaches form rings with trees on them: cut each ring once."""
    state = [0] * len(parents)  # 0 unseen, 1 on this walk, 2 done
    for start in range(len(parents)):
        walk = []
        node = start
        while node >= 0 and state[node] == 0:
            state[node] = 1
            walk.append(node)
            node = parents[node]
        if node >= 0 and state[node] == 1:
            ring = walk[walk.index(node) :]
            first = min(ring)
            above = parents[first]
            parents[first] = -1
            children[above].remove(first)
            doc.findings.error(
                "gltf.cycle", f"a ring of {len(ring)} nodes, each the other's ancestor; cut above nodes[{first}]",
                f"nodes[{above}].children", "repair the hierarchy",
            )  # fmt: skip
        for visited in walk:
            state[visited] = 2


def choose_scene(doc: Document, wanted: str) -> None:
    """Make the scene of that name, or number, the default one. Unknown ones are a finding and change nothing."""
    if not wanted:
        return
    scenes = doc.objects("scenes")
    names = [doc.name(scene, f"scenes[{k}]", str(k)) for k, scene in enumerate(scenes)]
    found = [k for k, name in enumerate(names) if name.lower() == wanted.lower()]
    if not found and wanted.isdecimal() and int(wanted) < len(scenes):
        found = [int(wanted)]
    if found:
        doc.root["scene"] = found[0]
    else:
        listed = ", ".join(map(repr, names)) or "none"
        doc.findings.warn("gltf.scenes", f"there is no scene {wanted!r}; the default one is imported", "scenes",
                          f"scenes: {listed}")  # fmt: skip


def scene_roots(doc: Document, hierarchy: Hierarchy) -> list[int]:
    """The roots of the scene to import: the default one, else the first, else all nodes without a parent."""
    findings, scenes = doc.findings, doc.objects("scenes")
    all_roots = [n for n, parent in enumerate(hierarchy.parents) if parent < 0]
    if not scenes:
        if all_roots:
            findings.info("gltf.no-scene", "the file has no scene; all its nodes are taken")
        else:
            findings.warn("gltf.no-scene", "the file has no scene and no nodes", hint="the scene will be empty")
        return all_roots
    number = doc.index(doc.root, "scene", "", "scenes") or 0
    if len(scenes) > 1:
        findings.info("gltf.scenes", f"the file has {len(scenes)} scenes; scenes[{number}] is imported", "scenes")
    named = dict.fromkeys(doc.indices(scenes[number], "nodes", f"scenes[{number}]", "nodes"))
    covered: set[int] = set()  # nodes that a named root above brings along
    for node in hierarchy.sequence:
        parent = hierarchy.parents[node]
        if parent in named or parent in covered:
            covered.add(node)
    for node in named:
        if hierarchy.parents[node] >= 0:
            findings.warn(
                "gltf.scene-root", f"nodes[{node}] is named as a root but has a parent", f"scenes[{number}].nodes"
            )
    kept = [n for n in named if n not in covered]
    if not kept:
        findings.warn("gltf.empty-scene", "the scene has no nodes", f"scenes[{number}]", "nothing will be visible")
    return kept
