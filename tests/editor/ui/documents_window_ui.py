"""Documents in a real window: `documents_window_ui.py FOLDER`: tabs, the import card and its fixes, a source that
changes under the user's edits, files that move. Run by test_documents_window.py."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support"), str(ROOT / "tests" / "support")]

from imgui_bundle import imgui  # noqa: E402  (the path is set above)
from small_scene import write_small_scene  # noqa: E402  (needs the path above)
from small_source import write_small_source  # noqa: E402  (needs the path above)
from window_run import WindowRun  # noqa: E402  (needs the path above)


def steps(run: WindowRun, seen: dict[str, Any]) -> None:
    session, root = run.session, run.folder / "game"
    source = root / "assets/crate.gltf"
    run.do(lambda: run.app.dropped([root / "scenes/boxes.scene.json", source]))
    assert run.until(lambda: len(session.tabs) == 2 and session.image.frame is not None), session.ui.error_bar
    run.ctx.yield_(8)
    seen["card"] = session.ui.import_card
    run.shot("dropped")
    document = session.document
    assert document is not None
    height = float((document.bounds()[1] - document.bounds()[0])[1])
    run.ctx.item_click("//###import-card/###z-up")
    assert run.until(lambda: session.importing is None and "turn" in _sidecar(source)), session.ui.error_bar
    run.ctx.yield_(6)
    seen["heights"] = [height, float((document.bounds()[1] - document.bounds()[0])[1])]
    session.edit("materials", "roughness", (0,), (0.125,), label="Change roughness")
    session.frame_all()
    data = json.loads(source.read_text())
    data["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = 0.75
    data["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 0.9
    data["nodes"].append({"name": "second", "mesh": 0, "translation": [1.5, 0.0, 0.0]})
    data["scenes"][0]["nodes"].append(1)
    run.write(source, json.dumps(data))
    assert run.until(
        lambda: document.news is not None and document.news.report is not None and session.importing is None
    )
    assert run.until(lambda: len(document.runtime.scene.nodes.name) == 2), session.ui.error_bar
    run.ctx.yield_(6)
    run.shot("changed")
    params = document.runtime.residency.material(0).asset.params
    seen["params"] = [params["roughness"], params["metallic"]]
    seen["conflicts"] = document.news.report.conflicts
    seen["history"] = [e.describe() for e in document.history.entries]
    session.ui.import_card = False
    run.ctx.key_press(imgui.Key.mod_ctrl.value | imgui.Key.tab.value)
    run.ctx.yield_(6)
    seen["front"] = session.document.name
    run.do(lambda: setattr(session.ui, "rename_asset", root / "scenes/boxes.red.material.toml"))
    run.ctx.yield_(4)
    run.ctx.item_click("//Rename or move/##path")
    run.ctx.key_chars_replace("materials/crimson.material.toml")
    run.ctx.yield_(3)
    run.shot("rename")
    run.ctx.item_click("//Rename or move/Move")
    run.ctx.yield_(6)
    seen["moved"] = (root / "materials/crimson.material.toml").is_file()
    seen["error"] = session.ui.error_bar
    run.shot("moved")
    run.do(session.undo)
    seen["back"] = (root / "scenes/boxes.red.material.toml").is_file()
    document = session.document
    document.select(list(document.runtime.scene.nodes.name).index("cube"))
    run.do(lambda: run.app.ui.operations.run("prefab.make", session))
    place = {"path": root / "prefabs/cube.scene.json", "at": (1.4, 0.4, 0.6)}
    run.do(lambda: run.app.ui.operations.run("prefab.place", session, **place))
    session.frame_all()
    run.ctx.yield_(8)
    run.shot("prefab")
    inner = document.subtree(document.primary)[1]
    session.edit("nodes", "scale", (inner,), ((0.4, 0.4, 0.4),), label="Scale the second")
    document.select(inner)
    run.ctx.yield_(4)
    run.do(lambda: run.app.ui.operations.run("prefab.apply", session))
    run.ctx.yield_(8)
    run.shot("applied")
    nodes = document.runtime.scene.nodes
    seen["scales"] = [round(float(nodes.scale[r][0]), 3) for r in range(len(nodes.name)) if nodes.name[r] == "cube"]
    seen["drawn"] = int(document.runtime.scene.instances.drawn.sum())
    seen["prefab_error"] = session.ui.error_bar


def _sidecar(source: Path) -> str:
    path = source.with_name(f"{source.name}.import")
    return path.read_text() if path.is_file() else ""


def main(folder: Path) -> dict[str, Any]:
    root = folder / "game"
    write_small_scene(root / "scenes")
    write_small_source(root / "assets/crate.gltf")
    (root / "project.toml").write_text('[project]\nname = "Game"\nstart = "scenes/boxes.scene.json"\n')
    run, seen = WindowRun(folder, size=(1300, 800)), {}
    run.play(lambda r: steps(r, seen))
    return {**seen, "shots": run.shots, "error": run.error or seen.get("error", "")}


if __name__ == "__main__":
    sys.stdout.write("\n" + json.dumps(main(Path(sys.argv[1]))) + "\n")
