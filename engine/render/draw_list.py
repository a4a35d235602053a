"""DrawList: which instances are drawn, as batches of indirect commands; no Python per object in a frame.

Built when the scene's structure changes:
    every instance row gets a *command*: (pipeline, texture group, arena, submesh). Rows are sorted by command once;
    commands are sorted by the draw key's static bits: queue | pipeline | texture group | arena, so that a *batch* (a
    run of commands with equal state) is one multi-draw-indirect call.
Each frame:
    visible rows -> counts per command (one bincount) and one compacted list of object ids (the per-instance attribute).
Opaque batches are not sorted by depth: their order is static, and what that costs in overdraw is less than an argsort
of every instance in numpy. Blended rows are sorted back to front and become runs.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from engine.gpu.types import Buffer, Device
from engine.materials.features import resolve_features
from engine.render.draw_commands import COMMAND_DTYPE, Template, chosen, empty_template, fit_buffer, runs_of
from engine.render.draw_states import (
    QUEUE_ORDER,
    Batch,
    DrawState,
    caster_state,
    casts_shadow,
    sides_of,
    sort_key,
    tints_light,
)
from engine.resources.material_store import MaterialRecord
from engine.resources.residency import Residency
from engine.scene.scene import Scene

#: why a skinned instance's variant has that feature
SKINNED = {"skinning": "the mesh hangs on a skeleton"}
#: flag of a combo -> what it switches on, and why
BENT = {
    2: SKINNED,
    4: {"morph": "morph targets of the mesh have had a weight"},
    8: {"dual_quaternion": "the skin is blended as dual quaternions"},
}


class DrawList:
    """`objects`: uvec4 per instance row (node, material row, pick, first joint). `ids`: object ids in draw order.
    `opaque`, `blended`: batches of this frame; their commands lie in `commands`."""

    def __init__(self, device: Device, residency: Residency) -> None:
        self._device = device
        self._residency = residency
        self.objects: Buffer = device.buffer(16, label="objects")
        self.ids: Buffer = device.buffer(4, label="object ids")
        self.commands: Buffer = device.buffer(20, label="commands")
        self.opaque: list[Batch] = []
        self.blended: list[Batch] = []
        self.instances_drawn = 0
        self.triangles_drawn = 0
        self._built_for: tuple[object, ...] = ()
        #: what is drawn: (mesh, submesh, material, 1 mirrored + keys of BENT), each once
        self._combos: list[tuple[int, int, int, int]] = []
        self._mirrored = np.zeros(0, np.bool_)
        self._mirrored_seen = (0, -1, -1)
        self._solid = empty_template()
        self._solid_batches: list[tuple[int, int]] = []
        self._glass = empty_template()
        self._casters = empty_template()
        self._caster_batches: list[tuple[int, int]] = []
        self.caster_ids: Buffer = device.buffer(4, label="caster ids")
        self.caster_commands: Buffer = device.buffer(20, label="caster commands")
        #: bool[instances]: what casts shadows, and what shows them
        self.casting = np.zeros(0, np.bool_)
        self.receiving = np.zeros(0, np.bool_)
        #: batches of each shadow map; their commands lie in `caster_commands`
        self.caster_batches: list[list[Batch]] = []
        #: bool[instances]: what tints the light that it lets through, and the same of the sun's maps of that
        self.tinting = np.zeros(0, np.bool_)
        self._tints = empty_template()
        self._tint_batches: list[tuple[int, int]] = []
        self.tint_ids: Buffer = device.buffer(4, label="tint ids")
        self.tint_commands: Buffer = device.buffer(20, label="tint commands")
        self.tint_batches: list[list[Batch]] = []
        #: the same of the tiles of local lights
        self.lamp_ids: Buffer = device.buffer(4, label="lamp caster ids")
        self.lamp_commands: Buffer = device.buffer(20, label="lamp caster commands")
        self.lamp_batches: list[list[Batch]] = []
        self.lamp_tint_ids: Buffer = device.buffer(4, label="lamp tint ids")
        self.lamp_tint_commands: Buffer = device.buffer(20, label="lamp tint commands")
        self.lamp_tint_batches: list[list[Batch]] = []
        #: rises when the templates were built again
        self.built_rev = 0
        self._stencil: tuple[tuple[int, int], bool] = ((-1, -1), False)

    @property
    def has_blended(self) -> bool:
        """Whether the scene has any blended surface, seen or not: facts must not change as the camera turns."""
        return len(self._glass.row_order) > 0

    @property
    def has_transmissive(self) -> bool:
        """Whether the scene has any surface that shows what is behind it, seen or not."""
        return any(state.transmissive for state in self._glass.states)

    @property
    def solid(self) -> tuple[Template, list[tuple[int, int]]]:
        """The commands of all that is opaque or alpha-tested, seen or not, and their runs of one state."""
        return self._solid, self._solid_batches

    @property
    def has_solid(self) -> bool:
        """Whether the scene has any opaque or alpha-tested surface, seen or not."""
        return len(self._solid.row_order) > 0

    @property
    def has_cutouts(self) -> bool:
        """Whether the scene has any alpha-tested surface, seen or not."""
        return any("alpha_test" in state.features for state in self._solid.states)

    @property
    def materials(self) -> frozenset[int]:
        """The materials of all that the scene draws, seen or not."""
        return frozenset(material for _, _, material, _ in self._combos)

    @property
    def uses_stencil(self) -> bool:
        """Whether an effect of what the scene draws, seen or not, tests or writes the stencil."""
        effects = self._residency.effects
        key = (self.built_rev, effects.revision)
        if self._stencil[0] != key:
            names = {state.effect for template in (self._solid, self._glass) for state in template.states}
            self._stencil = (key, any(effects.get(name).uses_stencil for name in names))
        return self._stencil[1]

    @property
    def solid_effects(self) -> frozenset[str]:
        """The effects of all that is opaque or alpha-tested, seen or not."""
        return frozenset(state.effect for state in self._solid.states)

    # --- structure ---

    def build(self, scene: Scene, *, everything: bool = False) -> bool:
        """Rebuild the templates if the structure changed; True if it did. `everything`: morph what rests too."""
        turned = self._update_mirrored(scene)
        key = (id(scene), scene.structure_rev, self._residency.structure_rev, everything)
        if key == self._built_for and not turned:
            return False
        self._built_for = key
        self.built_rev += 1
        table = scene.instances
        count = len(table.node)
        self._write_objects(scene)
        if count == 0:
            self._solid, self._glass, self._casters = empty_template(), empty_template(), empty_template()
            self._tints = empty_template()
            self._caster_batches, self._tint_batches = [], []
            self.casting = self.receiving = self.tinting = np.zeros(0, np.bool_)
            self._solid_batches, self._combos = [], []
            return True
        mirrored = self._mirrored[_placing_nodes(scene)]
        skin = scene.skins.of_nodes(table.node)
        row = scene.morphs.of_nodes(table.node)
        bent = 2 * (skin >= 0) + 4 * ((row >= 0) & (np.append(scene.morphs.active, False)[row] | everything))
        bent += 8 * ((skin >= 0) & np.append(scene.skins.blends_dual, False)[skin])
        combos, inverse = np.unique(
            np.stack([table.mesh, table.submesh, table.material, mirrored + bent], axis=1),
            axis=0, return_inverse=True,
        )  # fmt: skip
        inverse = inverse.reshape(-1)
        states: list[DrawState] = []
        shapes: list[tuple[int, int, int]] = []
        self._combos = [tuple(combo) for combo in combos.tolist()]
        known: dict[tuple[int, int, int, int], DrawState] = {}
        for mesh, submesh, material, flags in self._combos:
            like = (mesh, submesh, self._residency.materials.base_of(material), flags)  # they differ in values
            if like not in known:
                known[like] = self._state(mesh, submesh, self._residency.material(material), flags)
            states.append(known[like])
            info = self._residency.meshes[mesh]
            part = info.asset.submeshes[submesh]
            shapes.append((part.index_count, info.place.first_index + part.first_index, info.place.base_vertex))
        alive = table.alive
        blended = np.array([s.blended for s in states])
        self._solid = self._template(states, shapes, inverse, alive & ~blended[inverse])
        self._solid_batches = runs_of(self._solid.states)
        self._glass = self._template(states, shapes, inverse, alive & blended[inverse])
        self._build_casters(states, shapes, inverse, alive)
        return True

    def _build_casters(
        self, states: list[DrawState], shapes: list[tuple[int, int, int]], inverse: NDArray[np.intp],
        alive: NDArray[np.bool_],
    ) -> None:  # fmt: skip
        """What casts is drawn with as few states as make a difference in a depth map."""
        effects = {s.effect: self._residency.effects.get(s.effect) for s in states}
        self.casting = alive & np.array([casts_shadow(s, effects[s.effect]) for s in states])[inverse]
        self.receiving = alive & np.array(["unlit" not in s.features for s in states])[inverse]
        plain = [caster_state(s, effects[s.effect]) if casts_shadow(s, effects[s.effect]) else s for s in states]
        self._casters = self._template(plain, shapes, inverse, self.casting)
        self._caster_batches = runs_of(self._casters.states)
        self.tinting = alive & np.array([tints_light(s, effects[s.effect]) for s in states])[inverse]
        self._tints = self._template(states, shapes, inverse, self.tinting) if self.tinting.any() else empty_template()
        self._tint_batches = runs_of(self._tints.states)

    def _update_mirrored(self, scene: Scene) -> bool:
        """Which nodes turn their meshes inside out (negative determinant); True when that changed."""
        nodes = scene.nodes
        seen = self._mirrored_seen
        if seen == (id(scene), nodes.transform_rev, len(nodes)):
            return False
        known = seen[0] == id(scene) and seen[2] == len(nodes)
        self._mirrored_seen = (id(scene), nodes.transform_rev, len(nodes))
        before = self._mirrored if known else np.zeros(len(nodes), np.bool_)
        rows = np.flatnonzero(nodes.turn_rev > seen[1]) if known else np.arange(len(nodes))
        if known and len(rows) == 0:
            return False
        m = nodes.world[rows, :, :3]
        with np.errstate(over="ignore", invalid="ignore"):  # too large for a determinant is too large to be seen
            determinant = np.einsum("ij,ij->i", m[:, 0], np.cross(m[:, 1], m[:, 2]))
        self._mirrored = before.copy()
        self._mirrored[rows] = determinant < 0.0
        return not known or bool((self._mirrored != before).any())

    def states_of(self, records: Mapping[int, MaterialRecord]) -> list[tuple[int, DrawState]]:
        """(material, state) of all that these materials draw, if they were as in `records`. Raises InputError."""
        found: dict[tuple[int, DrawState], None] = {}
        for mesh, submesh, material, flags in self._combos:
            if material in records:
                state = self._state(mesh, submesh, records[material], flags)
                found.update(
                    dict.fromkeys((material, side) for side in (sides_of(state) if state.blended else (state,)))
                )
        return list(found)

    def _state(self, mesh: int, submesh: int, record: MaterialRecord, flags: int) -> DrawState:
        info = self._residency.meshes[mesh]
        bends = {name: why for flag, reasons in BENT.items() if flags & flag for name, why in reasons.items()}
        features = resolve_features(record.effect, record.asset, info.asset.layout, bends)
        double_sided = "double_sided" in features
        return DrawState(
            record.effect.name, features, info.arena, record.group,
            info.asset.submeshes[submesh].topology, "none" if double_sided else "back", not flags & 1,
            record.asset.queue, record.asset.level,
        )  # fmt: skip

    def _template(
        self, states: list[DrawState], shapes: list[tuple[int, int, int]],
        inverse: NDArray[np.intp], wanted: NDArray[np.bool_],
    ) -> Template:  # fmt: skip
        """Merge combos that differ in nothing but the material row into commands, sort commands by state."""
        keys = sorted(
            {(s, shape) for s, shape in zip(states, shapes, strict=True)},
            key=lambda k: (QUEUE_ORDER[k[0].queue], *sort_key(k[0]), k[1]),
        )
        index = {key: i for i, key in enumerate(keys)}
        command_of_combo = np.array([index[key] for key in zip(states, shapes, strict=True)], np.intp)
        rows = np.flatnonzero(wanted)
        commands_of_rows = command_of_combo[inverse[rows]]
        order = np.argsort(commands_of_rows, kind="stable")
        commands = np.zeros(len(keys), COMMAND_DTYPE)
        for i, (_, (index_count, first_index, base_vertex)) in enumerate(keys):
            commands[i] = (index_count, 0, first_index, base_vertex, 0)
        return Template([k[0] for k in keys], commands, rows[order], commands_of_rows[order])

    def _write_objects(self, scene: Scene) -> None:
        table = scene.instances
        count = len(table.node)
        rows_of = np.array([r.row for r in self._residency.materials.records] or [0], np.uint32)
        data = np.zeros((max(count, 1), 4), np.uint32)
        if count:
            data[:, 0] = np.maximum(table.node, 0)
            data[:, 1] = rows_of[np.maximum(table.material, 0)]
            data[:, 2] = table.node
            skin = scene.skins.of_nodes(table.node)
            if len(scene.skins):
                data[:, 3] = scene.skins.first[skin]  # what has no skin does not read it
        self.objects = fit_buffer(self._device, self.objects, data)

    # --- frame ---

    def update(
        self, scene: Scene, visible: NDArray[np.bool_], eye: NDArray[np.float64], forward: NDArray[np.float64]
    ) -> None:
        """Fill batches, commands and ids for this frame. `visible` bool[instances]; `eye`, `forward` in world space."""
        all_commands, ids, self.opaque, self.blended = self.seen_from(scene, visible, eye, forward)
        self.instances_drawn = len(ids)
        self.triangles_drawn = int(
            (all_commands["index_count"].astype(np.int64) * all_commands["instance_count"]).sum() // 3
        )
        if len(ids):
            self.ids = fit_buffer(self._device, self.ids, ids)
            self.commands = fit_buffer(self._device, self.commands, all_commands)

    def seen_from(
        self, scene: Scene, visible: NDArray[np.bool_], eye: NDArray[np.float64], forward: NDArray[np.float64],
        first_command: int = 0, first_id: int = 0,
    ) -> tuple[NDArray[np.void], NDArray[np.uint32], list[Batch], list[Batch]]:  # fmt: skip
        """Commands and object ids of what an eye sees, and the batches that draw it: solid, then blended back to
        front. `first_command`, `first_id`: where in their buffers both will lie."""
        commands, ids, opaque = chosen(self._solid, self._solid_batches, visible, first_command, first_id)
        glass_commands, glass_ids, blended = self._sorted_glass(
            scene, visible, eye, forward, first_command + len(commands), first_id + len(ids)
        )
        return (
            np.concatenate([commands, glass_commands]), np.concatenate([ids, glass_ids]).astype(np.uint32),
            opaque, blended,
        )  # fmt: skip

    def _sorted_glass(
        self, scene: Scene, visible: NDArray[np.bool_], eye: NDArray[np.float64], forward: NDArray[np.float64],
        first_command: int, first_id: int,
    ) -> tuple[NDArray[np.void], NDArray[np.intp], list[Batch]]:  # fmt: skip
        """Blended rows back to front, one command each; equal neighbours in state form a batch."""
        glass = self._glass
        drawn = visible[glass.row_order]
        rows, of_command = glass.row_order[drawn], glass.row_command[drawn]
        if len(rows) == 0:
            return np.zeros(0, COMMAND_DTYPE), rows, []
        depth = (scene.instances.world_center[rows] - eye) @ forward
        queue = np.array([QUEUE_ORDER[s.queue] for s in glass.states])[of_command]
        order = np.lexsort((-depth, queue))
        rows, of_command = rows[order], of_command[order]
        # A double-sided body is drawn twice: its far faces, then its near ones, so that it shows through itself.
        states = list(dict.fromkeys(side for s in glass.states for side in sides_of(s)))
        index = {state: i for i, state in enumerate(states)}
        sides = np.array([[index[side] for side in (sides_of(s) * 2)[:2]] for s in glass.states])
        twice = np.array([len(sides_of(s)) for s in glass.states])[of_command]
        source = np.repeat(np.arange(len(rows)), twice)
        second = np.concatenate([[False], source[1:] == source[:-1]])
        state_of_command = sides[of_command[source], second.astype(int)]
        commands = glass.commands[of_command[source]].copy()
        commands["instance_count"] = 1
        commands["base_instance"] = first_id + source
        starts = np.concatenate([[0], np.flatnonzero(np.diff(state_of_command)) + 1, [len(source)]])
        batches = [
            Batch(states[state_of_command[a]], first_command + a, b - a) for a, b in itertools.pairwise(starts.tolist())
        ]
        return commands, rows, batches

    def update_casters(self, masks: NDArray[np.bool_]) -> None:
        """Fill the batches of each shadow map: `masks` bool[maps, instances] of what is drawn into it."""
        self.caster_batches, self.caster_ids, self.caster_commands = self._fill_casters(
            masks, self._casters, self._caster_batches, self.caster_ids, self.caster_commands
        )

    def update_tints(self, masks: NDArray[np.bool_]) -> None:
        """As `update_casters`, of what tints light."""
        self.tint_batches, self.tint_ids, self.tint_commands = self._fill_casters(
            masks, self._tints, self._tint_batches, self.tint_ids, self.tint_commands
        )

    def update_lamp_casters(self, masks: NDArray[np.bool_]) -> None:
        """As `update_casters`, for the tiles of local lights."""
        self.lamp_batches, self.lamp_ids, self.lamp_commands = self._fill_casters(
            masks, self._casters, self._caster_batches, self.lamp_ids, self.lamp_commands
        )

    def update_lamp_tints(self, masks: NDArray[np.bool_]) -> None:
        """As `update_tints`, for the tiles of local lights."""
        self.lamp_tint_batches, self.lamp_tint_ids, self.lamp_tint_commands = self._fill_casters(
            masks, self._tints, self._tint_batches, self.lamp_tint_ids, self.lamp_tint_commands
        )

    def _fill_casters(
        self, masks: NDArray[np.bool_], template: Template, runs: list[tuple[int, int]], id_buffer: Buffer,
        command_buffer: Buffer,
    ) -> tuple[list[list[Batch]], Buffer, Buffer]:  # fmt: skip
        parts: list[tuple[NDArray[np.void], NDArray[np.intp]]] = []
        found: list[list[Batch]] = []
        first_command = first_id = 0
        for mask in masks:
            commands, ids, batches = chosen(template, runs, mask, first_command, first_id)
            parts.append((commands, ids))
            found.append(batches)
            first_command += len(commands)
            first_id += len(ids)
        if first_id:
            ids = np.concatenate([ids for _, ids in parts]).astype(np.uint32)
            id_buffer = fit_buffer(self._device, id_buffer, ids)
            commands = np.concatenate([commands for commands, _ in parts])
            command_buffer = fit_buffer(self._device, command_buffer, commands)
        return found, id_buffer, command_buffer

    def release(self) -> None:
        for buffer in (
            self.objects, self.ids, self.commands, self.caster_ids, self.caster_commands, self.lamp_ids,
            self.lamp_commands, self.tint_ids, self.tint_commands, self.lamp_tint_ids, self.lamp_tint_commands,
        ):  # fmt: skip
            buffer.release()


def _placing_nodes(scene: Scene) -> NDArray[np.int64]:
    """The node that turns each instance: its own, or for a skinned one its first joint."""
    table, skins = scene.instances, scene.skins
    node = np.maximum(table.node, 0).astype(np.int64)
    skin = skins.of_nodes(table.node)
    rows = np.flatnonzero(skin >= 0)
    node[rows] = skins.joint[skins.first[skin[rows]]]
    return node
