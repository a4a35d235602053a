"""The inspector's material section: parameters generated from the effect, textures by slot, features. One material, or
those of all selected nodes at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from imgui_bundle import imgui

from editor import icons, material_editing, object_editing, theme
from editor.document import Document
from editor.material_editing import Shared
from editor.panels.base import ASSET
from editor.param_groups import facts_of, grouped
from editor.param_widgets import format_value, param_row
from editor.picture_texture import PICTURES
from editor.requests import ChooseFile
from editor.tables import FEATURES, QUEUE
from editor.ui import Ui
from editor.widgets import (
    em,
    fitted_text,
    icon_button,
    pretty,
    property_grid,
    property_row,
    property_text,
    section,
    text,
    tooltip,
)
from engine.assets.material import QUEUES


def draw_materials(ui: Ui, document: Document) -> None:
    """The materials of the selection: several nodes' together, by effect; a single node's one by one."""
    all_of = material_editing.materials_of(document, document.selection)
    own = material_editing.materials_of(document, [document.primary])
    if len(document.selection) > 1 and len(all_of) > 1:
        by_effect: dict[str, list[int]] = {}
        for material in all_of:
            by_effect.setdefault(document.runtime.residency.material(material).effect.name, []).append(material)
        for materials in by_effect.values():
            _section(ui, document, materials)
        return
    for material in own:
        _section(ui, document, [material])


def _section(ui: Ui, document: Document, materials: Sequence[int]) -> None:
    residency = document.runtime.residency
    records = [residency.material(m) for m in materials]
    names = [record.asset.name or "material" for record in records]
    title = names[0] if len(names) == 1 else f"{len(names)} materials of {records[0].effect.name}"
    shown = section(ui, f"{icons.MATERIAL}  {title}###material{materials[0]}")
    if len(names) > 1:
        tooltip("\n".join(names[:24]))
    if not shown:
        return
    imgui.push_id(f"material{materials[0]}")
    _actions(ui, materials, records)
    shared = material_editing.shared_params(residency, materials)
    held = object_editing.holders(document, materials)
    _declared(ui, document, materials, records, shared, held)
    if len(materials) == 1:
        _features(ui, materials, records[0])
        _about(records[0])
    imgui.pop_id()
    imgui.spacing()


def _actions(ui: Ui, materials: Sequence[int], records: Sequence[Any]) -> None:
    session = ui.session
    if icon_button(f"{icons.COPY}###copy", "Copy the material, as text", enabled=len(materials) == 1):
        imgui.set_clipboard_text(material_editing.copy_text(session, materials[0]))
        session.ui.notice = f"Copied {material_editing.label_of(session, materials)}"
    imgui.same_line(0, em(0.1))
    if icon_button(f"{icons.PASTE}###paste", "Paste a material or a parameter"):
        material_editing.paste(session, materials, imgui.get_clipboard_text())
    imgui.same_line(0, em(0.1))
    if icon_button(f"{icons.RESET}###reset-all", "All parameters back to their defaults"):
        material_editing.reset(session, materials)
    imgui.same_line(0, em(0.1))
    only = session.ui.only_object
    about = "Edits are of this object only" if only else "Edit this object only: the material stays as it is elsewhere"
    if icon_button(f"{icons.PIN}###only-object", about, active=only):
        session.ui.only_object = not only
    if object_editing.has_own(session):
        imgui.same_line(0, em(0.1))
        if icon_button(f"{icons.ERASE}###clear-object", "The object as its material says, in all"):
            object_editing.clear(session)
    if len(materials) > 1:
        return
    imgui.same_line(0, em(0.1))
    if icon_button(f"{icons.EYE_POINT}###preview", "Show it in the material preview, and stay with it"):
        session.preview.pinned = materials[0]
        session.ui.focus_panel = "Material preview"
    imgui.same_line(0, em(0.1))
    if icon_button(f"{icons.CODE}###code", "Open its file as text", enabled=bool(records[0].path)):
        session.open_code(Path(records[0].path))


def _declared(
    ui: Ui, document: Document, materials: Sequence[int], records: Sequence[Any], shared: Sequence[Shared],
    held: Sequence[object_editing.Holder],
) -> None:  # fmt: skip
    """Parameters and texture slots by their groups, those that matter now."""
    effect = records[0].effect
    own = object_editing.own_values(document, held) if held else {}
    by_name = {s.param.name: s for s in shared}
    facts = facts_of(effect, records[0].asset, {s.param.name: s.values[0] for s in shared})
    params, slots = grouped([s.param for s in shared], facts), grouped(effect.textures, facts)
    for group in dict.fromkeys([*params, *slots]):
        flags = imgui.TreeNodeFlags_.default_open | imgui.TreeNodeFlags_.span_avail_width
        if group and not imgui.tree_node_ex(group, flags):
            continue
        with property_grid("params") as drawn:
            for param in params.get(group, ()) if drawn else ():
                if param.name in own:
                    _own_parameter(ui, materials, held, by_name[param.name], own[param.name])
                else:
                    _parameter(ui, materials, held, records, by_name[param.name])
        if group in slots:
            _slots(ui, materials, records, slots[group])
        if group:
            imgui.tree_pop()


def _own_parameter(
    ui: Ui, materials: Sequence[int], held: Sequence[object_editing.Holder], one: Shared, values: Sequence[Any]
) -> None:
    """One that a selected object says itself; back means: as the material says."""
    session, name, said = ui.session, one.param.name, one.values[0]
    told = f"On this object only; the material says {format_value(said)}"
    shown = [said if value is None else value for value in values]

    def menu() -> None:
        if imgui.menu_item_simple(f"{icons.RESET}  As the material says: {format_value(said)}"):
            object_editing.set_value(session, materials, held, name, None)

    usual = replace(one.param, default=said)
    changed, value = param_row(
        usual, shown[0], label=f"{icons.PIN} {pretty(name)}", mixed=any(v != shown[0] for v in shown), changed=True,
        menu=menu, degrees=one.param.unit == "rad", more=told,
    )  # fmt: skip
    if changed:
        object_editing.set_value(session, materials, held, name, None if value is usual.default else value)


def _parameter(
    ui: Ui, materials: Sequence[int], held: Sequence[object_editing.Holder], records: Sequence[Any], one: Shared
) -> None:
    param = one.param
    changed, value = param_row(
        param,
        one.values[0],
        mixed=one.mixed,
        changed=one.changed,
        menu=_menu(ui, materials, one),
        degrees=param.unit == "rad",
        more=_origin(records, f"params.{param.name}", one.changed),
    )
    if changed:
        object_editing.set_value(ui.session, materials, held, param.name, value)


def _origin(records: Sequence[Any], key: str, changed: bool) -> str:
    """Where an inherited value comes from."""
    if len(records) > 1 or not getattr(records[0].asset, "parent", ""):
        return ""
    origin = records[0].asset.origin.get(key)
    return f"Inherited from {Path(origin).name}" if origin is not None and not changed else ""


def _slots(ui: Ui, materials: Sequence[int], records: Sequence[Any], slots: Sequence[Any]) -> None:
    if len(materials) == 1:
        _textures(ui, materials[0], records[0], slots)
    else:
        _together(records, slots)


def _menu(ui: Ui, materials: Sequence[int], shared: Shared) -> Callable[[], None]:
    """What a right click on a parameter's label opens."""
    session, name = ui.session, shared.param.name

    def draw() -> None:
        if imgui.menu_item_simple(f"{icons.COPY}  Copy value"):
            imgui.set_clipboard_text(material_editing.copy_text(session, materials[0], name))
        if imgui.menu_item_simple(f"{icons.PASTE}  Paste value"):
            material_editing.paste(session, materials, imgui.get_clipboard_text())
        if imgui.menu_item_simple(
            f"{icons.RESET}  Back to {format_value(shared.param.default)}", "", False, shared.changed
        ):
            material_editing.reset(session, materials, [name])

    return draw


def _textures(ui: Ui, material: int, record: Any, slots: Sequence[Any]) -> None:
    """Each slot: the file in it, or that it is empty; takes a texture dragged from the assets."""
    with property_grid("textures") as shown:
        for slot in slots if shown else ():
            ref = record.asset.textures.get(slot.name)
            imgui.push_id(slot.name)
            property_row(
                pretty(slot.name.removesuffix("_map")), getattr(slot, "doc", ""), changed=ref is not None,
                menu=_slot_menu(ui, material, slot.name, ref, record),
            )  # fmt: skip
            imgui.begin_group()
            imgui.align_text_to_frame_padding()
            if slot.name in getattr(record.effect, "computed", {}) and not (ref is not None and ref.path):
                text("computed by the effect", theme.DIM)
                tooltip("From the parameters above; a texture put here takes its place")
            elif ref is None:
                text("none", theme.FAINT)
                imgui.same_line()
                imgui.dummy((max(imgui.get_content_region_avail().x - em(2), 1.0), imgui.get_frame_height()))
            elif not ref.path:
                text(f"{icons.WARNING} missing", theme.WARNING)
                tooltip("The source names a texture that is not there; it is drawn in magenta")
            else:
                _thumbnail(ui, material, slot.name)
                imgui.same_line(0, em(0.4))
                fitted_text(Path(ref.path).name, more=_describe(ref))
            imgui.end_group()
            _take_drop(ui, material, slot.name)
            imgui.pop_id()


def _take_drop(ui: Ui, material: int, slot: str) -> None:
    if imgui.begin_drag_drop_target():
        dropped = imgui.accept_drag_drop_payload_py_id(ASSET)
        if dropped is not None and ui.session.ui.dragged is not None:
            material_editing.set_texture(ui.session, [material], slot, ui.session.ui.dragged)
        imgui.end_drag_drop_target()


def _slot_menu(ui: Ui, material: int, slot: str, ref: Any, record: Any) -> Callable[[], None]:
    session = ui.session

    def draw() -> None:
        files = _textures_beside(record)
        if imgui.begin_menu("Choose", bool(files)):
            for path in files:
                if imgui.menu_item_simple(path.name, "", ref is not None and Path(ref.path).name == path.name):
                    material_editing.set_texture(session, [material], slot, path)
            imgui.end_menu()
        if imgui.menu_item_simple(f"{icons.FOLDER_OPEN}  Choose a file…"):
            session.ui.choose = ChooseFile(
                "Choose a texture or picture",
                (".dds", *PICTURES),
                Path(record.folder) / (ref.path if ref is not None else ""),
                lambda path: material_editing.set_texture(session, [material], slot, path),
            )
        if imgui.menu_item_simple("Empty", "", False, ref is not None):
            material_editing.set_texture(session, [material], slot, None)
        if ref is not None and imgui.menu_item_simple(f"{icons.COPY}  Copy path"):
            imgui.set_clipboard_text((Path(record.folder) / ref.path).as_posix())

    return draw


def _textures_beside(record: Any) -> list[Path]:
    """The textures in the material's folder."""
    folder = Path(getattr(record, "folder", ""))
    return sorted(folder.glob("*.dds"))[:200] if folder.is_dir() else []


def _features(ui: Ui, materials: Sequence[int], record: Any) -> None:
    """Those that are on by hand, to be ticked; those that a texture or the mesh switches on, and by what."""
    features = getattr(record.effect, "features", {})
    if not features or not imgui.tree_node_ex("Features", imgui.TreeNodeFlags_.span_avail_width):
        return
    chosen = list(record.asset.features)
    for name, feature in features.items():
        implied = feature.implied_by in record.asset.textures
        imgui.begin_disabled(implied)
        changed, on = imgui.checkbox(pretty(name), implied or name in chosen)
        imgui.end_disabled()
        why = (
            f"\nSwitched on by the texture {pretty(feature.implied_by.removesuffix('_map')).lower()}" if implied else ""
        )
        if imgui.is_item_hovered(imgui.HoveredFlags_.allow_when_disabled):
            tooltip(f"{feature.doc or name}{why}")
        if implied:
            imgui.same_line(0, em(0.6))
            text("by its texture", theme.FAINT)
        if changed:
            new = [*chosen, name] if on else [n for n in chosen if n != name]
            label = f"{'Switch on' if on else 'Switch off'} {name} of {record.asset.name}"
            material_editing.set_parts(ui.session, materials, {FEATURES: tuple(new)}, label)
    imgui.spacing()
    property_queue(ui, materials, record)
    imgui.tree_pop()


def property_queue(ui: Ui, materials: Sequence[int], record: Any) -> None:
    with property_grid("queue") as shown:
        if shown:
            property_row("Queue", "When it is drawn, and whether it blends")
            if imgui.begin_combo("##queue", pretty(record.asset.queue)):
                for queue in QUEUES:
                    if imgui.selectable(pretty(queue), queue == record.asset.queue)[0]:
                        label = f"Queue of {record.asset.name}"
                        material_editing.set_parts(ui.session, materials, {QUEUE: queue}, label)
                imgui.end_combo()


def _about(record: Any) -> None:
    with property_grid("about") as shown:
        if shown:
            property_text("Effect", record.effect.name)
            property_text("Queue", record.asset.queue)
            if record.asset.features:
                property_text("Features", ", ".join(record.asset.features))
            if getattr(record.asset, "parent", ""):
                property_text("Parent", record.asset.parent, "What this material does not say is as there")
            if record.path:
                property_text("File", Path(record.path).name, record.path)


def _together(records: Sequence[Any], slots: Sequence[Any]) -> None:
    """What several materials share besides parameters: which textures are in their slots."""
    with property_grid("textures") as shown:
        for slot in slots if shown else ():
            files = {getattr(record.asset.textures.get(slot.name), "path", "") for record in records}
            property_row(pretty(slot.name.removesuffix("_map")), getattr(slot, "doc", ""), changed=files != {""})
            imgui.align_text_to_frame_padding()
            if len(files) > 1:
                text("—", theme.DIM)
                tooltip("\n".join(Path(f).name or "none" for f in sorted(files)))
            else:
                fitted_text(Path(next(iter(files))).name or "none", theme.TEXT if files != {""} else theme.FAINT)


def _thumbnail(ui: Ui, material: int, slot: str) -> None:
    """A small picture of the texture, large while the pointer is on it; an icon where there can be none."""
    native = ui.session.thumbnail(material, slot)
    if not native:
        text(icons.PICTURE, theme.INFO)
        return
    size = imgui.get_frame_height()
    imgui.image(imgui.ImTextureRef(native), (size, size))
    if imgui.is_item_hovered():
        imgui.begin_tooltip()
        imgui.image(imgui.ImTextureRef(native), (em(12), em(12)))
        imgui.end_tooltip()


def _describe(ref: Any) -> str:
    lines = [ref.path, f"UV set {ref.uv_set}, wrap {ref.wrap_u} × {ref.wrap_v}"]
    lines.append(f"{ref.mag_filter} / {ref.min_filter}".replace("_", " "))
    if ref.scale != (1.0, 1.0) or ref.offset != (0.0, 0.0) or ref.rotation:
        lines.append(f"offset {ref.offset}, scale {ref.scale}, rotation {ref.rotation:g} rad")
    return "\n".join(lines)
