"""Inspector: what the selected node is made of, every value of it editable; without a selection, the scene itself."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from imgui_bundle import imgui

from editor import icons, theme
from editor.document import Document
from editor.panels.base import Panel
from editor.panels.inspector_deforming import draw_deforming
from editor.panels.inspector_fields import CAMERA, LOOK, SLOW_OF_SKY, environment_fields
from editor.panels.inspector_light import LightEditor
from editor.panels.inspector_material import draw_materials
from editor.panels.inspector_prefab import PrefabPart
from editor.param_widgets import param_row
from editor.rotation import euler_from_quaternion, quaternion_from_euler
from editor.ui import Ui
from editor.vector_field import drag3
from editor.widgets import bold, em, empty_state, icon_button, property_grid, property_row, property_text, section, text
from engine.core.param import Param

#: of more nodes than this, the angles are not compared
MIXED_LIMIT = 64
LABELS = {"translation": "Move", "rotation": "Rotate", "scale": "Scale"}


class InspectorPanel(Panel):
    title: ClassVar[str] = "Inspector"
    icon: ClassVar[str] = icons.INSPECT
    dock: ClassVar[str] = "Right"

    def __init__(self) -> None:
        #: the angles shown, kept while they still mean the node's rotation: many triples mean the same one
        #: and values shown but not applied yet, see SLOW_OF_SKY
        self._pending: dict[tuple[str, str, int], Any] = {}
        self._lights = LightEditor()
        self._prefab = PrefabPart()
        self._euler: dict[int, tuple[tuple[float, ...], tuple[float, float, float]]] = {}

    def draw(self, ui: Ui) -> None:
        document = ui.session.document
        if document is None:
            empty_state(icons.INSPECT, "Nothing to inspect")
        elif document.primary < 0:
            self._scene(ui, document)
        else:
            self._node(ui, document, document.primary)

    def _node(self, ui: Ui, document: Document, row: int) -> None:
        session, scene = ui.session, document.runtime.scene
        visible = bool(scene.nodes.visible[row])
        if icon_button(f"{icons.VISIBLE if visible else icons.HIDDEN}###visible", "Show or hide this node (H)"):
            session.set_visible(document.selection, not visible)
        imgui.same_line(0, em(0.3))
        imgui.align_text_to_frame_padding()
        more = len(document.selection) - 1
        imgui.set_next_item_width(-em(5.0) if more else -1)
        with bold(ui):
            flags = imgui.InputTextFlags_.auto_select_all
            _changed, name = imgui.input_text("##name", str(scene.nodes.name[row]), flags)
        if imgui.is_item_deactivated_after_edit() and name.strip():
            session.edit("nodes", "name", [row], [name.strip()], label=f"Rename {session.node_name(row)}")
        if more:
            imgui.same_line()
            text(f"+ {more} more", theme.DIM)
        imgui.spacing()
        if section(ui, "Transform"):
            self._transform(ui, document, row)
        self._prefab.draw(ui, document, row)
        instances = np.flatnonzero(np.asarray(scene.instances.node) == row)
        if len(instances):
            self._mesh(ui, document, instances)
        draw_deforming(ui, document, row)
        for light in np.flatnonzero(np.asarray(scene.lights.node) == row):
            self._lights.draw(ui, document, int(light))
        for camera in np.flatnonzero(np.asarray(scene.cameras.node) == row):
            if section(ui, f"{icons.CAMERA}  Camera"):
                self._fields(ui, document, "cameras", int(camera), CAMERA)
        draw_materials(ui, document)

    def _transform(self, ui: Ui, document: Document, row: int) -> None:
        nodes = document.runtime.scene.nodes
        size = max(float(np.abs(nodes.translation[row]).max()), 0.2 * ui.session.camera.distance)
        with property_grid("transform") as shown:
            if not shown:
                return
            self._vector(
                ui, document, row, "translation", "Position", "Metres, in the parent's frame", size * 0.002, "%.3f"
            )
            quaternion = tuple(float(v) for v in nodes.rotation[row])
            property_row("Rotation", "Degrees about X, then Y, then Z")
            self._rotation(ui, document, row, quaternion)
            self._vector(ui, document, row, "scale", "Scale", "Factor along each own axis", 0.005, "%.3f")
        imgui.spacing()

    def _rotation(self, ui: Ui, document: Document, row: int, quaternion: tuple[float, ...]) -> None:
        """The angles; of several nodes those that differ show a dash, and only the edited one is set for all."""
        nodes = document.runtime.scene.nodes
        rows = document.selection[-MIXED_LIMIT:]
        all_angles = {r: self._angles(r, tuple(float(v) for v in nodes.rotation[r])) for r in rows}
        shown = all_angles.get(row) or self._angles(row, quaternion)
        mixed = [any(abs(angles[i] - shown[i]) > 0.05 for angles in all_angles.values()) for i in range(3)]
        new, touched = drag3("##rotation", shown, 0.5, "%.1f°", mixed)
        if not any(touched):
            return
        wanted = {}
        for r in document.selection:
            own = all_angles.get(r) or self._angles(r, tuple(float(v) for v in nodes.rotation[r]))
            x, y, z = (n if t else o for n, t, o in zip(new, touched, own, strict=True))
            wanted[r] = (x, y, z)
        self._edit(ui, document, "rotation", [quaternion_from_euler(wanted[r]) for r in document.selection])
        for r, angles in wanted.items():
            self._euler[r] = (tuple(float(v) for v in nodes.rotation[r]), angles)

    def _angles(self, row: int, quaternion: tuple[float, ...]) -> tuple[float, float, float]:
        known = self._euler.get(row)
        if known is None or any(abs(a - b) > 1e-7 for a, b in zip(known[0], quaternion, strict=True)):
            known = self._euler[row] = (quaternion, euler_from_quaternion(quaternion))
        return known[1]

    def _vector(
        self, ui: Ui, document: Document, row: int, column: str, label: str, doc: str, speed: float, format: str
    ) -> None:
        value = [float(v) for v in getattr(document.runtime.scene.nodes, column)[row]]
        mixed = self._mixed(document, column)
        property_row(label, f"{doc}\nThe selected ones differ" if any(mixed) else doc, changed=any(mixed))
        new: tuple[float, ...]
        new, touched = drag3(f"##{column}", value, speed, format, mixed)
        if any(touched) and all(math.isfinite(v) for v in new):
            if column == "scale":  # a zero scale has no inverse, and nothing to see
                new = tuple(v if abs(v) > 1e-6 else math.copysign(1e-6, v) for v in new)
            old = document.tables["nodes"].read(column, document.selection)
            rows = [tuple(n if t else o for n, o, t in zip(new, own, touched, strict=True)) for own in old]
            self._edit(ui, document, column, rows)

    def _edit(self, ui: Ui, document: Document, column: str, values: list[tuple[float, ...]]) -> None:
        """Set `column` of all selected nodes, as one entry."""
        nodes, rows = document.runtime.scene.nodes, document.selection
        name = ui.session.node_name(rows[0]) if len(rows) == 1 else f"{len(rows)} nodes"
        label = f"{LABELS[column]} {name}"
        if bool(nodes.has_matrix[list(rows)].any()):
            locals_ = [list(local) for local in document.tables["nodes"].read("local", rows)]
            for local, value in zip(locals_, values, strict=True):
                local[("translation", "rotation", "scale").index(column)], local[3] = value, None
            whole = [tuple(local) for local in locals_]
            ui.session.edit("nodes", "local", rows, whole, gesture=("nodes", "local", rows), label=label)
        else:
            ui.session.edit("nodes", column, rows, values, gesture=("nodes", column, rows), label=label)

    @staticmethod
    def _mixed(document: Document, column: str) -> list[bool]:
        """Which components differ among the selected nodes: what is edited is set for all of them."""
        values = getattr(document.runtime.scene.nodes, column)[list(document.selection)]
        return [bool(differs) for differs in (values != values[:1]).any(axis=0)]

    def _mesh(self, ui: Ui, document: Document, instances: Any) -> None:
        if not section(ui, f"{icons.MESH}  Mesh", opened=False):
            return
        scene, residency = document.runtime.scene, document.runtime.residency
        mesh = residency.meshes[int(scene.instances.mesh[instances[0]])].asset
        submeshes = [mesh.submeshes[int(scene.instances.submesh[i])] for i in instances]
        triangles = sum(s.index_count // 3 for s in submeshes if s.topology == "triangles")
        low, high = document.bounds((document.primary,))
        with property_grid("mesh") as shown:
            if shown:
                property_text("Name", mesh.name or "(unnamed)")
                property_text("Parts", str(len(submeshes)))
                property_text("Triangles", f"{triangles:,}")
                property_text("Vertices", f"{mesh.vertex_count:,}")
                property_text("Streams", ", ".join(mesh.layout))
                property_text("Size", " × ".join(f"{v:.3g}" for v in high - low) + " m", "World box, with children")
        imgui.spacing()

    def _scene(self, ui: Ui, document: Document) -> None:
        scene = document.runtime.scene
        with bold(ui):
            imgui.text_unformatted(document.name)
        text("Select a node to see what it is made of", theme.DIM)
        imgui.spacing()
        if section(ui, f"{icons.ENVIRONMENT}  Environment"):
            self._fields(ui, document, "environment", 0, environment_fields(scene.environment))
        if section(ui, f"{icons.LOOK}  Look of the scene"):
            self._fields(ui, document, "look", 0, LOOK)
        if section(ui, f"{icons.INFO}  Contents"):
            low, high = document.bounds()
            with property_grid("contents") as shown:
                if shown:
                    property_text("Nodes", f"{len(scene.nodes.name):,}")
                    property_text("Drawn parts", f"{len(scene.instances.node):,}")
                    property_text("Lights", f"{len(scene.lights.node):,}")
                    property_text("Cameras", f"{len(scene.cameras.node):,}")
                    if np.isfinite(low).all() and np.isfinite(high).all():
                        property_text("Size", " × ".join(f"{v:.3g}" for v in high - low) + " m")
                    property_text("Source", str(document.source))
                    property_text("Scene file", str(document.scene_path))

    @staticmethod
    def _sky(document: Document) -> bool:
        return bool(document.runtime.scene.environment.kind == "sky")

    def _fields(
        self, ui: Ui, document: Document, table: str, row: int, fields: tuple[Param, ...], more: Sequence[int] = ()
    ) -> None:
        """`more`: other rows that get what is edited."""
        rows = [row, *more]
        with property_grid(f"{table}{row}") as shown:
            for field in fields if shown else ():
                key = (table, field.name, row)
                slow = table == "environment" and field.name in SLOW_OF_SKY and self._sky(document)
                value = document.tables[table].read(field.name, (row,))[0]
                shown = self._pending.get(key, value) if slow else value
                changed, new = param_row(field, shown, id=f"{table}{row}", degrees=field.unit == "rad")
                if changed and slow:
                    self._pending[key] = new
                elif changed:
                    ui.session.edit(table, field.name, rows, [new] * len(rows), gesture=key)
                if key in self._pending and not imgui.is_mouse_down(imgui.MouseButton_.left):
                    ui.session.edit(table, field.name, [row], [self._pending.pop(key)])
        imgui.spacing()


PANEL = InspectorPanel
