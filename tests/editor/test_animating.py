"""Animation in the session: every edit can be undone, is saved, and poses the scene."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from animated_scene import animated_session

from editor.animating import edits
from editor.animating.editing import AnimationEditor
from editor.animating.operations import keys_now
from editor.builtin_operations import builtin_operations
from editor.console import Console
from editor.panels.blend_space import make_blend
from editor.panels.bone_masks import tree_order
from editor.panels.timeline_pages import shown_clip
from editor.saving import save_document
from engine.assets.animation_toml import parse_animation
from engine.core.errors import FormatError, InputError


@pytest.fixture
def editor(tmp_path: Path) -> AnimationEditor:
    session = animated_session(tmp_path)
    yield AnimationEditor(session)
    session.close()


def _history(editor: AnimationEditor) -> list[str]:
    return [entry.describe() for entry in editor.session.document.history.entries]


def _angle(editor: AnimationEditor, bone: str) -> float:
    nodes = editor.session.document.runtime.scene.nodes
    q = nodes.rotation[nodes.name.index(bone)]
    return float(2.0 * np.arctan2(q[0], q[3]))


def test_a_timeline_is_built_undone_and_redone(editor: AnimationEditor) -> None:
    session = editor.session
    editor.create()
    assert session.document.runtime.drive == "timeline"
    assert session.playback.duration == pytest.approx(1.0)
    editor.add_block("run", 0, fade=0.4)
    assert session.playback.duration == pytest.approx(1.2)
    block = editor.model.tracks[0].blocks[1]
    assert (block.start, block.fade_in) == (pytest.approx(0.6), pytest.approx(0.4))
    assert editor.model.tracks[0].blocks[0].fade_out == pytest.approx(0.4)
    session.seek(0.25)
    quarter = _angle(editor, "leg")
    assert quarter == pytest.approx(0.6, abs=1e-3)
    session.undo()
    assert session.playback.duration == pytest.approx(1.0)
    session.undo()
    assert session.document.runtime.drive == "clips"
    assert session.document.runtime.animation is None
    session.redo()
    session.redo()
    session.seek(0.25)
    assert _angle(editor, "leg") == quarter
    assert len(editor.model.tracks[0].blocks) == 2


def test_a_drag_is_one_entry_and_makes_cross_fades(editor: AnimationEditor) -> None:
    editor.add_block("run", 0)
    count = len(_history(editor))
    for start in np.linspace(1.0, 0.7, 20):
        editor.move_block(0, 1, float(start), gesture="drag")
    editor.session.end_gesture()
    assert len(_history(editor)) == count + 1
    first, second = editor.model.tracks[0].blocks
    assert first.fade_out == pytest.approx(0.3)
    assert second.fade_in == pytest.approx(0.3)
    editor.move_block(0, 1, 2.0)
    first, second = editor.model.tracks[0].blocks
    assert (first.fade_out, second.fade_in) == (0.0, 0.0)
    editor.session.undo()
    assert editor.model.tracks[0].blocks[1].start == pytest.approx(0.7)
    editor.session.undo()
    assert editor.model.tracks[0].blocks[1].start == pytest.approx(1.0)


def test_trimming_and_splitting_leave_what_plays_where_it_is(editor: AnimationEditor) -> None:
    session = editor.session
    editor.create()
    session.seek(0.3)
    before = _angle(editor, "leg")
    editor.trim_block(0, 0, 0.2, 0.8)
    session.seek(0.3)
    assert _angle(editor, "leg") == pytest.approx(before, abs=1e-6)
    editor.split_block(0, 0, 0.25)
    session.seek(0.3)
    assert _angle(editor, "leg") == pytest.approx(before, abs=1e-6)
    assert [b.length for b in editor.model.tracks[0].blocks] == pytest.approx([0.05, 0.55])
    with pytest.raises(InputError, match="does not play"):
        editor.split_block(0, 0, 0.7)


def test_a_mask_lets_an_arm_wave_while_the_legs_walk(editor: AnimationEditor) -> None:
    session = editor.session
    editor.create()
    mask = editor.add_mask("upper", "spine", 1)
    track = editor.add_track("wave", mask=mask)
    editor.add_block("wave", track, 0.0)
    session.seek(0.25)
    assert _angle(editor, "leg") == pytest.approx(0.6, abs=1e-3)
    assert _angle(editor, "arm") == pytest.approx(1.0, abs=1e-3)
    editor.mask_bone(mask, "arm", 0.0)
    session.seek(0.25)
    assert _angle(editor, "arm") == pytest.approx(0.0, abs=1e-6)
    editor.mask_bone(mask, "arm", None)
    editor.mask_subtree(mask, "spine", 0.5)
    session.seek(0.25)
    assert _angle(editor, "arm") == pytest.approx(0.5, abs=2e-2)
    path = session.document.scene_path.with_name("upper.mask.toml")
    editor.save_mask(mask, path)
    assert editor.load_mask(path) == "upper 2"
    assert editor.model.masks["upper 2"] == editor.model.masks["upper"]


def test_morph_weights_follow_the_timeline_and_have_a_column(editor: AnimationEditor) -> None:
    session = editor.session
    scene = session.document.runtime.scene
    row = scene.nodes.name.index("skin")
    session.edit("nodes", "weights", [row], [(0.4,)])
    assert scene.morphs.of_node(row).tolist() == [0.4]
    session.undo()
    assert scene.morphs.of_node(row).tolist() == [0.0]
    editor.create()
    editor.add_block("wave", 0, 0.0)
    editor.remove_block(0, 0)
    session.seek(0.25)
    assert scene.morphs.of_node(row)[0] == pytest.approx(0.25)
    session.document.runtime.play("wave")
    session.document.runtime.update(0.75)
    assert scene.morphs.of_node(row)[0] == pytest.approx(0.75)
    session.document.runtime.play("walk")
    assert scene.morphs.of_node(row)[0] == 0.0


def test_states_fade_by_their_parameters_and_edits_keep_them_going(editor: AnimationEditor) -> None:
    session = editor.session
    editor.create()
    editor.add_param("fast", "bool", False)
    editor.add_state("walking", "walk")
    editor.add_state("running", "run")
    editor.add_transition("walking", "running", ["fast"], 0.5)
    editor.drive("states")
    session.playback.playing = True
    session.tick(0.25)
    assert _angle(editor, "leg") == pytest.approx(0.6, abs=1e-3)
    editor.set_param("fast", 1.0)
    for _ in range(4):
        session.tick(0.25)
    machine = session.document.runtime.animation.animator.machine
    assert machine.state_names() == ["running"]
    phase = float(machine.heads.phase[0])
    editor.set_transition(0, fade=0.1)
    machine = session.document.runtime.animation.animator.machine
    assert machine.state_names() == ["running"]
    assert machine.heads.phase[0] == pytest.approx(phase)
    editor.rename("states", "running", "sprint")
    assert editor.model.transitions[0].target == "sprint"
    editor.remove_state("sprint")
    assert editor.model.transitions == []


def test_layers_and_blend_spaces_can_be_made(editor: AnimationEditor) -> None:
    editor.add_param("speed")
    blend = editor.add_blend("move", ["speed"], [("walk", [1.0]), ("run", [2.0])])
    editor.add_state("moving", blend=blend)
    editor.drive("states")
    editor.set_param("speed", 1.5)
    assert editor.session.document.runtime.animation.animator.heard.weight.tolist() == pytest.approx([0.5, 0.5])
    editor.move_sample(blend, 1, [3.0], gesture="drag")
    editor.set_param("speed", 2.0)
    assert editor.session.document.runtime.animation.animator.heard.weight.tolist() == pytest.approx([0.5, 0.5])
    mask = editor.add_mask("arms", "arm")
    editor.add_layer("wave", mask=mask, weight=0.5)
    assert editor.session.document.runtime.animation.graph.layers[0].constant == 0.5
    editor.rename("params", "speed", "velocity")
    assert editor.model.blends["move"].params == ["velocity"]


def test_markers_are_logged_once_each(editor: AnimationEditor) -> None:
    session = editor.session
    editor.add_marker("foot", 0.5, clip="walk")
    editor.add_marker("cut", 0.9)
    session.seek(0.0)
    session.playback.playing, session.playback.speed = True, 1.0
    for _ in range(60):
        session.tick(1.0 / 20.0)  # three turns
    lines = [m.text for m in session.messages.snapshot() if m.text.startswith("Event")]
    assert sum("foot" in line for line in lines) == 3
    assert sum("cut" in line for line in lines) == 3
    editor.set_marker(0, time=5.0)  # beyond the blocks: the timeline grows
    assert session.playback.duration == 5.0
    editor.remove_marker(0)
    assert session.playback.duration == 1.0


def test_root_motion_carries_the_figure_along_the_timeline_and_can_be_switched_off(editor: AnimationEditor) -> None:
    session = editor.session
    editor.create()
    editor.set_block(0, 0, length=3.0)
    editor.put((("root",), "hips"), label="Root")
    nodes = session.document.runtime.scene.nodes
    session.seek(2.5)
    assert nodes.translation[0].tolist() == pytest.approx([0.0, 0.0, 3.0], abs=1e-3)
    assert nodes.translation[1][2] == pytest.approx(0.0, abs=1e-6)
    editor.root_motion(False)
    session.seek(2.5)
    assert nodes.translation[0].tolist() == pytest.approx([0.0, 0.0, 0.0])
    session.undo()
    session.seek(2.5)
    assert nodes.translation[0][2] == pytest.approx(3.0, abs=1e-3)


def test_what_is_not_allowed_changes_nothing(editor: AnimationEditor) -> None:
    editor.create()
    text = editor.text
    for bad in (
        lambda: editor.add_block("trot"), lambda: editor.set_block(0, 0, speed=float("nan")),
        lambda: editor.set_track(0, mask="none"), lambda: editor.add_transition("a", "b"),
        lambda: editor.set_block(0, 7),
        lambda: editor.mask_bone("m", "hips", 1.0), lambda: editor.rename("clips", "walk", "run"),
    ):  # fmt: skip
        with pytest.raises((InputError, FormatError)):
            bad()
        assert editor.text == text


def test_it_is_saved_beside_the_scene_and_opened_again(editor: AnimationEditor, tmp_path: Path, null_device) -> None:
    from engine.app.runtime import Runtime

    editor.add_block("run", 0, fade=0.2)
    editor.session.seek(0.9)
    pose = editor.session.document.runtime.scene.nodes.rotation.copy()
    written = save_document(editor.session.document, tmp_path / "saved" / "x.scene.json")
    assert (tmp_path / "saved" / "x.animation.toml") in written
    runtime = Runtime(null_device)
    runtime.open(tmp_path / "saved" / "x.scene.json")
    assert (runtime.drive, not list(runtime.findings)) == ("timeline", True)
    assert runtime.asset.drive == "timeline"
    runtime.update(0.9)
    np.testing.assert_allclose(runtime.scene.nodes.rotation, pose, atol=1e-12)
    # with states in the file too, what was chosen last is what plays, not what the file would play by itself
    before = editor.text
    editor.add_state("walk", clip="walk")
    for drive in ("clips", "timeline", "states"):
        editor.drive(drive)
        save_document(editor.session.document, tmp_path / "saved" / "x.scene.json")
        runtime.open(tmp_path / "saved" / "x.scene.json")
        assert (runtime.drive, runtime.animation is not None) == (drive, True)
    (tmp_path / "saved" / "x.animation.toml").write_text(before)
    runtime.open(tmp_path / "saved" / "x.scene.json")
    assert (runtime.drive, [f.code for f in runtime.findings]) == ("timeline", ["animation.drive"])
    runtime.close()


def test_the_console_edits_it(editor: AnimationEditor) -> None:
    console = Console(editor.session, builtin_operations())
    for line in ("animation.create()", "animation.add_block('run')", "len(animation.model.tracks[0].blocks)"):
        console.push(line)
    assert console.lines[-1].text == "2"
    console.push("animation.add_block('trot')")
    assert "no clip 'trot'" in console.lines[-1].text


def test_steps_by_key_and_modes(editor: AnimationEditor) -> None:
    session, ops = editor.session, builtin_operations()
    assert keys_now(session) == pytest.approx([0.0, 0.25, 0.5, 0.75, 1.0])
    session.seek(0.3)
    ops.run("play.next-key", session)
    assert session.playback.time == pytest.approx(0.5)
    ops.run("play.previous-key", session)
    assert session.playback.time == pytest.approx(0.25)
    ops.run("play.set-in", session)
    session.seek(0.75)
    ops.run("play.set-out", session)
    assert (session.playback.start, session.playback.stop) == (0.25, 0.75)
    ops.run("play.mode", session)
    assert session.playback.mode == "once"
    session.playback.playing = True
    session.playback.seek(0.5)
    session.tick(1.0)
    assert (session.playback.time, session.playback.playing) == (0.75, False)


def test_edits_keep_comments_and_move_things() -> None:
    text = 'schema = "lucarna.animation/1"\nname = "x"  # mine\n[clips.a]\n'
    text += '[[tracks]]\nname = "one"\n[[tracks]]\nname = "two"\n'
    changed = edits.put(text, (("tracks", 1, "weight"), 0.5))
    assert "# mine" in changed
    moved = edits.move(changed, ("tracks", 1), -1)
    model, _ = parse_animation(moved, "x")
    assert [(t.name, t.weight) for t in model.tracks] == [("two", 0.5), ("one", 1.0)]
    assert edits.move(moved, ("tracks", 0), -1) == moved
    renamed = edits.rename(edits.append(text, ("tracks", 0, "blocks"), {"clip": "a"}), "clips", "a", "b")
    model, _ = parse_animation(renamed, "x")
    assert model.tracks[0].blocks[0].clip == "b"
    assert model.clips["b"].source == "a"


def test_a_node_hung_on_a_bone_goes_with_it(editor: AnimationEditor) -> None:
    from editor.commands import structure

    session = editor.session
    document, nodes = session.document, session.document.runtime.scene.nodes
    hand = nodes.name.index("hand")
    place = np.eye(4)
    place[:3, 3] = nodes.world[hand, :, 3] + [0.0, 0.1, 0.0]
    structure.add_empty(document, place)
    sword = document.primary
    structure.reparent(document, [sword], hand)
    before = nodes.world[sword].copy()
    np.testing.assert_allclose(before[:, 3], place[:3, 3])
    document.runtime.play("wave")
    session.seek(0.25)
    assert np.linalg.norm(nodes.world[sword, :, 3] - before[:, 3]) > 0.1
    apart = np.linalg.norm(nodes.world[sword, :, 3] - nodes.world[hand, :, 3])
    assert apart == pytest.approx(0.1)


def test_the_journal_brings_every_edit_back(editor: AnimationEditor, tmp_path: Path) -> None:
    import json

    from editor.journal import edit_from_plain, edit_to_plain

    editor.add_block("run", 0, fade=0.2)
    editor.add_mask("upper", "spine")
    editor.drive("clips")
    told = [json.loads(json.dumps(edit_to_plain(e))) for e in editor.session.document.history.entries]
    other = AnimationEditor(animated_session(tmp_path / "again"))
    for line in told:
        other.session.document.history.do(edit_from_plain(line, other.session.document))
    assert other.text == editor.text
    assert other.session.document.runtime.drive == "clips"
    other.session.close()


def test_keys_are_shown_where_their_block_plays_them(editor: AnimationEditor) -> None:
    editor.create()
    editor.set_block(0, 0, start=0.5, length=2.0, offset=0.25, speed=2.0)
    session = editor.session
    session.animating.track, session.animating.block = 0, 0
    shown = shown_clip(session)
    assert shown is not None
    assert shown.span == (0.5, 2.5)
    # walk takes 1 s: the key at 0.5 s is met first at 0.5 + (0.5 - 0.25) / 2, then every half second
    places, which = shown.places(np.array([0.5]))
    np.testing.assert_allclose(places, [0.625, 1.125, 1.625, 2.125])
    assert which.tolist() == [0] * 4
    np.testing.assert_allclose(shown.clip_times(places), 0.5)


def test_blocks_that_play_together_mix_by_their_weights(editor: AnimationEditor) -> None:
    """Walk's leg is at 0.6 rad at a quarter, run's at 1.2 at 0.15 s: a third and two thirds of them."""
    editor.create()
    editor.add_block("run", 0, start=0.0, length=1.0)
    editor.set_block(0, 1, offset=-0.1)
    editor.session.seek(0.25)
    for first, second in ((1.0, 0.5), (0.5, 1.0), (1.0, 0.0)):
        editor.set_block(0, 0, weight=first)
        editor.set_block(0, 1, weight=second)
        expected = (0.6 * first + 1.2 * second) / (first + second)
        assert _angle(editor, "leg") == pytest.approx(expected, abs=0.02)


def test_a_blend_space_over_two_parameters_is_one_entry_and_stays_while_shown(editor: AnimationEditor) -> None:
    editor.create()
    count = len(_history(editor))
    make_blend(editor, ["walk", "run", "wave"], 2)
    assert len(_history(editor)) <= count + 2, "the space and what drives"
    assert [s.at for s in editor.model.blends["blend"].samples] == [[0.0, 0.0], [0.0, 1.0], [0.0, -1.0]]
    with pytest.raises(InputError, match="shown by blend"):
        editor.remove_blend("blend")
    editor.add_sample("blend", "walk", [1.0, 0.0])
    editor.set_sample("blend", 3, "run")
    assert editor.model.blends["blend"].samples[3].clip == "run"
    editor.remove_sample("blend", 3)
    editor.session.undo()
    assert len(editor.model.blends["blend"].samples) == 4


def test_layers_states_and_parameters_are_changed_and_taken_back(editor: AnimationEditor) -> None:
    editor.create()
    editor.add_state("walking", "walk")
    editor.add_param("armed", "bool", False)
    editor.add_mask("upper")
    editor.mask_subtree("upper", "arm")
    editor.mask_subtree("upper", "leg", 0.5)
    editor.mask_subtree("upper", "arm", 0.25, 1)
    assert [s.node for s in editor.model.masks["upper"].subtrees] == ["arm", "leg"], "a changed subtree keeps its place"
    editor.add_layer("wave", name="draw")
    before = editor.text
    editor.set_layer(0, mask="upper", mode="additive", reference="", weight="armed", clip="run")
    layer = editor.model.layers[0]
    assert (layer.mask, layer.mode, layer.reference, layer.weight, layer.clip) == (
        "upper", "additive", "", "armed", "run",
    )  # fmt: skip
    with pytest.raises(FormatError, match="armed"):
        editor.remove_param("armed")
    editor.session.undo()
    assert editor.text == before
    editor.set_state("walking", clip="wave", mode="once")
    assert (editor.model.states["walking"].clip, editor.model.states["walking"].mode) == ("wave", "once")
    editor.set_default("armed", True)
    editor.remove_layer(0)
    editor.remove_param("armed")
    assert editor.model.layers == []
    assert editor.model.params == {}


def test_bones_are_listed_as_a_tree_is_read() -> None:
    assert tree_order([-1, 0, 0, 1, -1, 3, 2]) == [0, 1, 3, 5, 2, 6, 4]
