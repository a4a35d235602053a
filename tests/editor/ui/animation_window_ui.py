"""Animation in a real window with the real renderer: `animation_window_ui.py FOLDER [SCENE]`.

Scrubs, blends, masks by a click on a bone, edits the state graph, takes everything back and does it again; a picture of
the window in FOLDER at every stage. Without SCENE: the tests' own figure. Run by test_animation_window.py, and by
`python -m tests.tools.animation_pictures`.
"""

from __future__ import annotations

import json
import sys
import traceback
from dataclasses import replace
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

import moderngl  # noqa: E402  (the path is set above)
import numpy as np  # noqa: E402  (the path is set above)
from animated_scene import write_animated_scene  # noqa: E402  (needs the path above)
from imgui_bundle import hello_imgui, imgui, immapp  # noqa: E402  (needs the path above)
from imgui_bundle.immapp import testing  # noqa: E402  (needs the path above)

from editor.animating.editing import AnimationEditor  # noqa: E402  (needs the path above)
from editor.animating.following import runtime_of  # noqa: E402  (needs the path above)
from editor.app import App  # noqa: E402  (needs the path above)
from editor.builtin_operations import builtin_operations  # noqa: E402  (needs the path above)
from editor.camera_controls import project  # noqa: E402  (needs the path above)
from editor.host import EngineHost  # noqa: E402  (needs the path above)
from editor.panels.animation_timeline import ROW, TimelinePanel  # noqa: E402  (needs the path above)
from editor.panels.blend_space import BlendSpacePanel, make_blend  # noqa: E402  (needs the path above)
from editor.panels.bone_masks import mask_weights  # noqa: E402  (needs the path above)
from editor.panels.state_graph import StateGraphPanel  # noqa: E402  (needs the path above)
from editor.panels.viewport import ViewportPanel  # noqa: E402  (needs the path above)
from editor.preferences import Preferences  # noqa: E402  (needs the path above)
from editor.screenshot import save_window  # noqa: E402  (needs the path above)
from editor.session import Session  # noqa: E402  (needs the path above)
from editor.widgets import em  # noqa: E402  (needs the path above)

SIZE = (1400, 900)
NOW = 0.4


class Tour:
    """One walk through the window. `seen`: what the test looks at."""

    def __init__(self, ctx: Any, app: App, folder: Path, asked: list[Path]) -> None:
        self.ctx, self.app, self.folder, self.asked = ctx, app, folder, asked
        self.session = app.ui.session
        self.editor = AnimationEditor(self.session)
        self.seen: dict[str, Any] = {"pictures": []}

    # -- doing --------------------------------------------------------------------------------------------------------

    def shot(self, name: str) -> None:
        """A picture of the window as it is once all has settled; the pointer out of the way."""
        self.ctx.mouse_move_to_pos(imgui.ImVec2(5, 5))
        self.ctx.yield_(4)
        self.asked.append(self.folder / f"{name}.png")
        self.ctx.yield_(2)
        self.seen["pictures"].append(name)

    def show(self, panel: str) -> None:
        self.session.ui.focus_panel = panel
        self.ctx.yield_(4)

    def drag(self, start: Any, end: Any, *keys: Any) -> None:
        for key in keys:
            self.ctx.key_down(key)
        self.ctx.mouse_move_to_pos(imgui.ImVec2(*start))
        self.ctx.yield_(3)
        self.ctx.mouse_down(0)
        self.ctx.yield_(2)
        for share in (0.3, 0.7, 1.0):
            self.ctx.mouse_move_to_pos(imgui.ImVec2(*[a + share * (b - a) for a, b in zip(start, end, strict=True)]))
            self.ctx.yield_(2)
        self.ctx.mouse_up(0)
        for key in keys:
            self.ctx.key_up(key)
        self.ctx.yield_(3)

    def state(self) -> dict[str, Any]:
        """All that the edits may change, at one time of the clock."""
        for time in (0.0, NOW):  # posed anew, whatever was set by hand since
            self.session.seek(time)
            self.ctx.yield_(2)
        runtime = runtime_of(self.session)
        nodes, animation = runtime.scene.nodes, runtime.animation
        return {
            "text": animation.text if animation is not None else "", "drive": runtime.drive,
            "nodes": np.concatenate([nodes.translation, nodes.rotation, nodes.scale], axis=1).copy(),
            "duration": self.session.playback.duration, "root": bool(runtime.deck.root_motion),
            "morphs": [float(w) for n in runtime.scene.morphs.node for w in runtime.scene.morphs.of_node(int(n))],
        }  # fmt: skip

    # -- the walk -----------------------------------------------------------------------------------------------------

    def walk(self) -> None:
        session, history = self.session, self.session.document.history
        clips = [clip.name for clip in runtime_of(session).clips]
        before = self.state()
        self.scrub()
        self.seen["scrub_edits"] = len(history.entries)
        self.timeline(clips)
        self.masks()
        self.root(clips)
        self.blends(clips)
        self.graph(clips)
        self.skins()
        after, count = self.state(), len(history.entries)
        self.seen["entries"] = [e.describe() for e in history.entries]
        while history.undo_label:
            session.undo()
        undone = self.state()
        self.seen["restored"] = differences(before, undone)
        while history.redo_label:
            session.redo()
        self.seen["redone"] = [d for d in differences(after, self.state()) if d != "nodes"]  # a machine starts anew
        self.seen["count"] = (count, len(history.entries))

    def scrub(self) -> None:
        self.show("Timeline")
        canvas = self.app.panel(TimelinePanel).canvas
        y = canvas.y + 0.3 * canvas.ruler
        self.drag((canvas.px(0.05), y), (canvas.px(0.3), y))
        self.seen["scrubbed"] = self.session.playback.time

    def timeline(self, clips: list[str]) -> None:
        editor, view = self.editor, self.session.animating
        editor.create()
        editor.add_block(clips[1 % len(clips)], 0, fade=0.2)
        editor.add_track("upper", mode="additive", reference="")
        editor.add_block(clips[2 % len(clips)], 1, start=0.3)
        editor.add_marker("step", 0.25)
        editor.add_marker("turn", 0.6, clips[0])
        view.fitted, view.snap = False, False
        self.ctx.yield_(3)
        panel = self.app.panel(TimelinePanel)
        canvas = panel.canvas
        first = editor.model.tracks[0].blocks[1]
        y = panel._row_y(canvas, 2, 0) + 0.7 * em(ROW)
        middle = canvas.px(first.start + 0.5 * first.length)
        self.drag((middle, y), (middle - 0.15 * canvas.scale.scale, y))
        self.seen["moved"] = first.start - editor.model.tracks[0].blocks[1].start
        self.session.seek(NOW)
        view.track, view.block, view.skeleton, view.ghosts = 0, 1, False, 0
        self.shot("timeline")
        view.page = "dope"
        self.shot("dope_sheet")
        view.page, view.channel = "curves", self._moving_channel()
        self.shot("curves")
        view.page, view.skeleton, view.ghosts = "tracks", True, 3
        self.shot("onion_skin")
        view.ghosts = 0

    def _moving_channel(self) -> int:
        """The channel of the shown clip that turns farthest."""
        from editor.panels.timeline_pages import shown_clip

        shown = shown_clip(self.session)
        assert shown is not None
        spans = [
            float(np.ptp(np.asarray(c.values), axis=0).max()) if c.path == "rotation" else 0.0
            for c in shown.clip.channels
        ]
        return int(np.argmax(spans))

    def masks(self) -> None:
        """A mask by a click on a bone in the picture, with a fall-off."""
        editor, view, session = self.editor, self.session.animating, self.session
        self.show("Masks")
        editor.add_mask("upper")
        view.mask, view.picking_bone, view.fall_off = "upper", True, 2
        editor.set_track(1, mask="upper")
        rig = runtime_of(session).animation.rig
        below = [int((rig.below(i) >= 0).sum()) for i in range(len(rig))]
        rows = runtime_of(session).node_rows[rig.source]
        left, top, width, height = self.app.panel(ViewportPanel).area
        for _ in range(6):  # far enough away to see the skeleton, whatever the mesh is
            pixels, _ = project(session.camera, runtime_of(session).scene.nodes.world[rows, :, 3], width, height)
            inside = (pixels > 30.0).all(axis=1) & (pixels < np.array([width, height]) - 30.0).all(axis=1)
            if inside.all():
                break
            session.camera = replace(session.camera, distance=1.25 * session.camera.distance)
        bone = min(np.flatnonzero(inside).tolist(), key=lambda i: abs(below[i] - 0.5 * len(rig)))
        self.ctx.mouse_move_to_pos(imgui.ImVec2(left + float(pixels[bone, 0]), top + float(pixels[bone, 1])))
        self.ctx.yield_(3)
        self.ctx.mouse_click(0)
        self.ctx.yield_(3)
        weights = mask_weights(session, "upper")
        self.seen["masked"] = (int((weights > 0).sum()), len(weights))
        self.seen["fall_off"] = [s.fall_off for s in editor.model.masks["upper"].subtrees]
        self.shot("bone_masks")
        view.picking_bone = False

    def root(self, clips: list[str]) -> None:
        """The clip that walks farthest, on the character instead of in it."""
        editor, runtime = self.editor, runtime_of(self.session)
        names, best = runtime.animation.rig.names, (0.0, clips[0], runtime.animation.rig.names[0])
        for clip in runtime.clips:
            for channel in clip.channels:
                if channel.path == "translation" and channel.target in names:
                    way = float(np.ptp(np.asarray(channel.values)[:, [0, 2]], axis=0).max())
                    best = max(best, (way, clip.name, channel.target))
        self.seen["travels"] = best[0]
        editor.add_track("walks")
        track = len(editor.model.tracks) - 1
        editor.add_block(best[1], track, start=0.0)
        editor.put((("root",), best[2]), label=f"Root {best[2]}")
        editor.root_motion(True)
        block = editor.model.tracks[track].blocks[0]
        self.show("Timeline")
        self.session.animating.fitted = False
        self.session.seek(0.7 * block.length)
        self.session.frame_all()
        self.shot("root_motion")
        editor.remove_track(track)
        self.session.frame_all()

    def blends(self, clips: list[str]) -> None:
        editor, session = self.editor, self.session
        self.show("Blend space")
        panel = self.app.panel(BlendSpacePanel)
        make_blend(editor, [clips[i % len(clips)] for i in range(5)], 2)
        self.ctx.yield_(4)
        x, y, width, height = panel.area
        self.drag((x + 0.5 * width, y + 0.5 * height), (x + 0.65 * width, y + 0.35 * height))
        self.shot("blend_space_2d")
        make_blend(editor, [clips[i % len(clips)] for i in range(3)], 1)
        self.ctx.yield_(4)
        x, y, width, height = panel.area
        self.drag((x + 0.1 * width, y + 0.8 * height), (x + 0.4 * width, y + 0.8 * height))
        animator = runtime_of(session).animation.animator
        self.seen["puck"] = float(animator.machine.values[animator.machine.param("speed"), 0])
        at = panel._px(np.array([[2.0, 0.0]]))[0].tolist()
        self.drag(at, (at[0] - 0.15 * width, at[1]), imgui.Key.mod_ctrl)
        self.seen["sample"] = editor.model.blends[session.animating.blend].samples[2].at[0]
        self.shot("blend_space_1d")

    def graph(self, clips: list[str]) -> None:
        editor, view = self.editor, self.session.animating
        self.show("State graph")
        editor.add_state("idle", clips[0])
        editor.add_state("act", clips[2 % len(clips)])
        editor.add_param("armed", "bool", False)
        editor.add_layer(clips[1 % len(clips)], name="draw", mask="upper")
        self.ctx.yield_(4)
        panel = self.app.panel(StateGraphPanel)
        self.drag(panel._middle("idle"), panel._middle("act"), imgui.Key.mod_shift)
        editor.set_transition(0, when=["armed", "speed > 0.5"])
        editor.add_transition("any", "idle", ["!armed"])
        start = panel._middle("act")
        self.drag(start, (start[0] + panel._em(1), start[1] + panel._em(2)))
        self.seen["joined"] = [(t.source, t.target) for t in editor.model.transitions]
        self.seen["put"] = editor.model.states["act"].at
        view.transition, view.state = 0, ""
        self.shot("state_graph")
        self.editor.drive("timeline")

    def skins(self) -> None:
        """What bends the mesh: the skeleton, weights, how many bones, and morph targets where there are some."""
        session, scene = self.session, runtime_of(self.session).scene
        session.animating.names = session.animating.axes = True
        self.shot("skeleton")
        session.animating.names = session.animating.axes = False
        for view in ("weights", "influences"):
            session.settings.view = view
            self.shot(view)
        session.settings.view = "lit"
        if len(scene.morphs.node):
            row = int(scene.morphs.node[0])
            session.document.select(row)
            weights = [float(w) for w in scene.morphs.of_node(row)]
            session.edit("nodes", "weights", [row], [(0.8, *weights[1:])], label="Weight of a morph target")
            self.show("Inspector")
            self.shot("morph_targets")


def differences(a: dict[str, Any], b: dict[str, Any]) -> list[str]:
    return [key for key in a if not np.array_equal(np.asarray(a[key]), np.asarray(b[key]))]


def run(folder: Path, scene: Path | None) -> dict[str, Any]:
    path = scene or write_animated_scene(folder / "scene")
    session = Session(EngineHost(), Preferences(welcome_seen=True, adaptive_resolution=False))
    session.save_preferences = False
    app = App(session, builtin_operations(), size=SIZE, remember_layout=False)
    session.open(path)
    seen: dict[str, Any] = {"error": ""}
    asked: list[Path] = []

    def take_pictures() -> None:
        """The test runs on a thread without the GL context: pictures are taken here, of what is about to be shown."""
        while asked:
            context = moderngl.create_context(require=430)
            pixels = np.frombuffer(context.detect_framebuffer().read(components=3, alignment=1), np.uint8)
            size = context.detect_framebuffer().size
            save_window(asked.pop(), pixels.reshape(size[1], size[0], 3)[::-1])

    app.params.callbacks.before_swap = take_pictures

    def guarded(ctx: Any) -> None:
        tour = Tour(ctx, app, folder, asked)
        io = imgui.test_engine.get_io(hello_imgui.get_imgui_test_engine())
        io.config_watchdog_warning = io.config_watchdog_kill_test = 600.0  # a busy machine may take its time
        try:
            for _ in range(3000):
                if session.document is not None and session.image.frame is not None:
                    break
                ctx.yield_()
            assert session.document is not None, session.ui.error_bar
            session.playback.playing = False
            tour.walk()
        except BaseException:  # an exception must not unwind into the engine's coroutine
            seen["error"] = traceback.format_exc()
        seen.update(tour.seen)

    try:
        testing.run(test_function=guarded, runner_params=app.params, add_ons_params=immapp.AddOnsParams())
    except RuntimeError as error:
        seen["error"] = f"{seen['error']}\n{error}"
    return seen


if __name__ == "__main__":
    given = Path(sys.argv[2]) if len(sys.argv) > 2 else None
    sys.stdout.write("\n" + json.dumps(run(Path(sys.argv[1]), given)) + "\n")
