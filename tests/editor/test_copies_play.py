"""Duplicated characters play along: the copy's bones and weights follow the clips, its place is its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from animated_scene import animated_session
from numpy.typing import NDArray

from editor import prefabs
from editor.animating.editing import AnimationEditor
from editor.commands import structure
from editor.saving import current_scene, save_document
from editor.session import Session
from engine.app.runtime import Runtime
from engine.assets.clip_nodes import spread
from engine.assets.lanim import read_lanim
from engine.assets.scene_json import format_scene
from engine.gpu import open_device

BONES = ("hips", "spine", "arm", "hand", "leg")


@pytest.fixture
def session(tmp_path: Path) -> Session:
    made = animated_session(tmp_path)
    yield made
    made.close()


def _rows(runtime: Runtime, head: int) -> list[int]:
    """The rows of the bones below `head`, in the order of BONES."""
    nodes = runtime.scene.nodes
    found = {}
    for row in range(len(nodes.name)):
        top = row
        while int(nodes.parent[top]) >= 0:
            top = int(nodes.parent[top])
        if top == head and nodes.alive[row]:
            found[nodes.name[row].split(" ")[0]] = row
    return [found[bone] for bone in BONES]


def _pose(runtime: Runtime, head: int) -> NDArray[np.float64]:
    nodes, rows = runtime.scene.nodes, _rows(runtime, head)
    return np.concatenate([nodes.translation[rows], nodes.rotation[rows], nodes.scale[rows]], axis=1)


def _duplicate(session: Session) -> int:
    document = session.document
    structure.duplicate(document, (0,))
    (copy,) = document.selection
    document.edit("nodes", "translation", (copy,), ((3.0, 0.0, 0.0),))
    return copy


def test_a_copy_moves_as_the_original_where_it_was_put(session: Session) -> None:
    copy = _duplicate(session)
    runtime = session.document.runtime
    runtime.play("run")
    rest = _pose(runtime, 0)
    for time in (0.1, 0.15, 0.4):
        session.seek(time)
        pose = _pose(runtime, 0)
        assert not np.allclose(pose, rest, atol=1e-3), "the clip moves nothing, so the test proves nothing"
        assert np.array_equal(_pose(runtime, copy), pose)
        assert runtime.scene.nodes.translation[copy].tolist() == [3.0, 0.0, 0.0]


def test_a_timeline_and_weights_reach_the_copy(session: Session) -> None:
    copy = _duplicate(session)
    runtime = session.document.runtime
    runtime.play("wave")
    session.seek(0.5)
    morphs = runtime.scene.morphs
    skins = [row for row in range(len(runtime.scene.nodes.name)) if runtime.scene.nodes.name[row].startswith("skin")]
    weights = [float(morphs.weights[morphs.first[int(morphs.of_nodes(np.array([row]))[0])]]) for row in skins]
    assert weights == [pytest.approx(0.5), pytest.approx(0.5)]
    editor = AnimationEditor(session)
    editor.create()
    editor.add_block("run", 0)
    session.seek(0.7)
    assert np.array_equal(_pose(runtime, copy), _pose(runtime, 0))


def test_a_saved_copy_plays_when_opened_again(session: Session, tmp_path: Path) -> None:
    copy = _duplicate(session)
    document = session.document
    document.runtime.play("run")
    session.seek(0.15)
    expected = _pose(document.runtime, copy)
    save_document(document, tmp_path / "saved" / "x.scene.json")
    again = Runtime(open_device("null"))
    again.open(tmp_path / "saved" / "x.scene.json")
    again.play("run")
    again.update(0.15)
    nodes = again.scene.nodes
    heads = [row for row in range(len(nodes.name)) if int(nodes.parent[row]) < 0]
    assert len(heads) == 2
    for head in heads:
        assert _pose(again, head) == pytest.approx(expected, abs=1e-12)
    again.close()


def _spinner(session: Session) -> tuple[int, int]:
    """The hips, which the clips turn and carry, and a copy of them that was put aside in the midst of the clip."""
    document = session.document
    document.runtime.play("walk")
    session.seek(0.3)
    hips = document.runtime.scene.nodes.name.index("hips")
    structure.duplicate(document, (hips,))
    (copy,) = document.selection
    nodes = document.runtime.scene.nodes
    document.edit("nodes", "translation", (copy,), (tuple((nodes.translation[copy] + [2.0, 0.0, 0.0]).tolist()),))
    return hips, copy


def _aside(runtime: Runtime, hips: int, copy: int) -> list[float]:
    nodes = runtime.scene.nodes
    assert nodes.rotation[copy] == pytest.approx(nodes.rotation[hips], abs=1e-12)
    return (nodes.translation[copy] - nodes.translation[hips]).tolist()


def test_a_copy_of_what_clips_move_itself_moves_about_its_own_place(session: Session) -> None:
    hips, copy = _spinner(session)
    runtime = session.document.runtime
    turned = [runtime.scene.nodes.rotation[hips].copy()]
    for time in (0.3, 0.55, 0.9):
        session.seek(time)
        assert _aside(runtime, hips, copy) == pytest.approx([2.0, 0.0, 0.0], abs=1e-12)
        turned.append(runtime.scene.nodes.rotation[copy].copy())
    assert np.ptp(turned, axis=0).max() > 0.05, "nothing turns, so the test proves nothing"
    # moved by hand again while time stands at 0.9
    at = runtime.scene.nodes.translation[copy] + [0.0, 0.0, 5.0]
    session.document.edit("nodes", "translation", (copy,), (tuple(at.tolist()),))
    session.seek(0.2)
    assert _aside(runtime, hips, copy) == pytest.approx([2.0, 0.0, 5.0], abs=1e-12)
    runtime.play()  # at rest
    runtime.update(0.25)
    assert _aside(runtime, hips, copy) == pytest.approx([2.0, 0.0, 5.0], abs=1e-12)


def test_its_own_place_is_what_is_saved_and_exported(session: Session, tmp_path: Path) -> None:
    _spinner(session)
    document = session.document
    session.seek(0.55)
    save_document(document, tmp_path / "saved" / "x.scene.json")
    again = Runtime(open_device("null"))
    again.open(tmp_path / "saved" / "x.scene.json")
    again.play("walk")
    both = [row for row, name in enumerate(again.scene.nodes.name) if name.startswith("hips")]
    assert len(both) == 2
    for time in (0.1, 0.7):
        again.update(time)
        assert _aside(again, *both) == pytest.approx([2.0, 0.0, 0.0], abs=1e-6)
    (clip,) = (read_lanim(tmp_path / "saved" / n) for n in again.asset.clips if "walk" in n)
    again.close()
    ways = {c.node: c.values for c in spread(clip, again.asset.nodes).channels if c.path == "translation"}
    nodes = [i for i, node in enumerate(again.asset.nodes) if node.name.startswith("hips")]
    assert ways[nodes[1]] - ways[nodes[0]] == pytest.approx(np.tile([2.0, 0.0, 0.0], (2, 1)), abs=1e-6)


def test_a_copy_of_the_mesh_alone_shares_the_joints_and_stands_where_it_is_put(
    session: Session, tmp_path: Path
) -> None:
    document = session.document
    scene = document.runtime.scene
    skin = scene.nodes.name.index("skin")
    structure.duplicate(document, (skin,))
    (copy,) = document.selection
    assert scene.skins.palette(np.zeros(3))[5:] == pytest.approx(scene.skins.palette(np.zeros(3))[:5])
    document.edit("nodes", "translation", (copy,), ((0.0, 0.0, 4.0),))
    document.runtime.play("run")
    save_document(document, tmp_path / "saved" / "x.scene.json")
    again = Runtime(open_device("null"))
    again.open(tmp_path / "saved" / "x.scene.json")
    again.play("run")
    for runtime in (document.runtime, again):
        runtime.update(0.15)
        palette = runtime.scene.skins.palette(np.zeros(3))
        assert not np.allclose(palette[:5, :, :3], np.eye(3), atol=1e-3)
        off = palette[5:] - palette[:5]
        assert off[:, :, 3] == pytest.approx(np.tile([0.0, 0.0, 4.0], (5, 1)), abs=1e-6)
        assert off[:, :, :3] == pytest.approx(np.zeros((5, 3, 3)), abs=1e-6)
    again.close()


def test_undo_leaves_nothing_behind(session: Session) -> None:
    before = len(session.document.runtime.scene.nodes.name)
    _duplicate(session)
    session.undo()
    session.undo()
    runtime = session.document.runtime
    runtime.play("run")
    session.seek(0.15)
    assert int(runtime.scene.nodes.alive.sum()) == before
    assert len(runtime.deck.copies) == 0


def test_clips_still_find_their_nodes_when_those_before_them_are_gone(session: Session, tmp_path: Path) -> None:
    """Nodes are numbered anew when a scene is saved; the clips are not."""
    copy = _duplicate(session)
    document = session.document
    document.runtime.play("run")
    session.seek(0.15)
    expected = _pose(document.runtime, 0)
    structure.delete(document, (0,))
    session.seek(0.4)
    session.seek(0.15)
    assert np.array_equal(_pose(document.runtime, copy), expected)
    save_document(document, tmp_path / "saved" / "x.scene.json")
    again = Runtime(open_device("null"))
    again.open(tmp_path / "saved" / "x.scene.json")
    again.play("run")
    again.update(0.15)
    (head,) = np.flatnonzero(again.scene.nodes.parent < 0)
    assert _pose(again, int(head)) == pytest.approx(expected, abs=1e-12)
    again.close()


def test_a_node_hung_on_a_bone_that_comes_later_leaves_the_clips_alone(session: Session, tmp_path: Path) -> None:
    """A sword in a hand: it is saved after the bone, and the nodes between move up."""
    document = session.document
    nodes = document.runtime.scene.nodes
    hand = nodes.name.index("hand")
    structure.add_empty(document, np.eye(4))
    (sword,) = document.selection
    structure.reparent(document, (sword,), hand)
    structure.delete(document, (nodes.name.index("leg"),))
    document.runtime.play("wave")
    session.seek(0.5)
    expected = {name: nodes.world_matrix(nodes.name.index(name)) for name in ("arm", "hand", nodes.name[sword])}
    save_document(document, tmp_path / "saved" / "x.scene.json")
    again = Runtime(open_device("null"))
    again.open(tmp_path / "saved" / "x.scene.json")
    again.play("wave")
    again.update(0.5)
    for name, place in expected.items():
        row = again.scene.nodes.name.index(name)
        assert again.scene.nodes.world_matrix(row) == pytest.approx(place, abs=1e-12), name
    again.close()


def test_what_drawing_notices_is_logged_once(session: Session) -> None:
    renderer = session.document.runtime.renderer
    renderer.skin_findings.warn("skin.effect", "'body' is skinned linearly")
    session.document.runtime.findings.error("light.profile", "no such file")
    renderer.light_findings.error("light.profile", "a.ies: no such file")
    for _ in range(3):
        session.tick(0.0)
    lines = [m.text for m in session.messages.snapshot()]
    assert lines.count("'body' is skinned linearly") == 1
    assert "a.ies: no such file" not in lines, "the log has had it since the scene was opened"


@pytest.mark.parametrize("what", ["figure", "hips", "leg"])
def test_what_is_saved_and_undone_does_not_depend_on_the_time(session: Session, what: str) -> None:
    """Of a copy made, moved, taken back and done again, each at another time of the clip."""
    document = session.document
    runtime = document.runtime
    runtime.play("run")

    def saved() -> str:
        return format_scene(current_scene(document))

    states = [saved()]
    session.seek(0.15)
    structure.duplicate(document, [runtime.scene.nodes.name.index(what)])
    states.append(saved())
    (copy,) = document.selection
    session.seek(0.25)
    assert saved() == states[-1]
    x, y, z = document.tables["nodes"].read("translation", (copy,))[0]
    document.edit("nodes", "translation", (copy,), ((x + 2.0, y, z),))
    states.append(saved())
    structure.delete(document, [copy])
    states.append(saved())
    assert len(set(states)) >= 3
    for time in (0.1, 0.4):
        session.seek(time)
        for at in (2, 1, 0, 1, 2, 3):
            document.history.go_to(at)
            assert saved() == states[at], (time, at)
            session.seek(time + 0.01 * at)
            assert saved() == states[at], (time, at)


def test_a_copy_that_is_moved_by_hand_in_the_midst_of_the_clip_goes_on_from_there(session: Session) -> None:
    document = session.document
    runtime = document.runtime
    runtime.play("run")
    session.seek(0.15)
    hips = runtime.scene.nodes.name.index("hips")
    structure.duplicate(document, [hips])
    (copy,) = document.selection
    nodes = runtime.scene.nodes
    assert nodes.translation[copy] == pytest.approx(nodes.translation[hips]), "it appears where its original is"
    document.edit("nodes", "translation", (copy,), (tuple(nodes.translation[copy] + (2.0, 0.0, 0.0)),))
    for time in (0.15, 0.25, 0.4):
        session.seek(time)
        assert nodes.translation[copy] == pytest.approx(nodes.translation[hips] + (2.0, 0.0, 0.0))
    session.undo()
    assert nodes.translation[copy] == pytest.approx(nodes.translation[hips])


def test_the_clips_of_an_instance_that_was_undone_move_nothing_that_came_in_its_rows(
    session: Session, tmp_path: Path
) -> None:
    document = session.document
    scene = document.runtime.scene
    save_document(document, tmp_path / "placed" / "x.scene.json")
    count = len(scene.nodes)
    assert prefabs.place(session, tmp_path / "placed/x.scene.json", np.eye(4))
    session.seek(0.15)
    session.undo()
    for _ in range(12):
        structure.add_empty(document, np.eye(4))
    others = slice(count, len(scene.nodes))
    rest = scene.nodes.translation[others].copy()
    assert prefabs.place(session, tmp_path / "placed/x.scene.json", np.eye(4))
    for time in (0.2, 0.4):
        session.seek(time)
        assert np.array_equal(scene.nodes.translation[others], rest)
    hips = [row for row, name in enumerate(scene.nodes.name) if name == "hips"]
    assert len(np.unique(scene.nodes.translation[hips], axis=0)) == 1, "the new instance plays"
    assert not np.array_equal(scene.nodes.translation[hips[0]], (0.0, 1.0, 0.0))
