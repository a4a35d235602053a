"""Runs UI tests of the editor on imgui's null platform: real panels and events, no window, no GPU.

A script calls `main({name: test})`; each test gets (ctx of the imgui test engine, App) and asserts. All tests of a
script run in one process, one after the other, because a second null platform in a process fails; the results go to
stdout as one line of JSON, name -> what went wrong or "".
"""

from __future__ import annotations

import json
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fake_engine import FakeHost
from imgui_bundle import hello_imgui, imgui, immapp

from editor.app import App
from editor.builtin_operations import builtin_operations
from editor.preferences import Preferences
from editor.session import Session

UiTest = Callable[[Any, App], None]
#: what the engine's teardown says on the null platform although all is well
TEARDOWN = "UiContextTarget"


def make_app(folder: Path) -> App:
    session = Session(FakeHost(), Preferences(welcome_seen=True))
    session.save_preferences = False
    app = App(session, builtin_operations(), size=(1280, 800), remember_layout=False, null_platform=True)
    session.open(folder / "thing.glb")
    return app


def settle(ctx: Any, app: App) -> None:
    """Wait for the open job, pause the animation, let the panels see it."""
    for _ in range(400):
        if app.ui.session.job is None and app.ui.session.document is not None:
            break
        ctx.yield_()
    assert app.ui.session.document is not None, "the document did not open"
    app.ui.session.playback.playing = False
    ctx.yield_(2)


def fresh(ctx: Any, app: App) -> Any:
    """The document as just opened: nothing selected, nothing to undo."""
    session = app.ui.session
    session.close_all()
    session.open(Path("/nowhere/thing.glb"))
    settle(ctx, app)
    return session.document


def main(tests: dict[str, UiTest]) -> None:
    app = make_app(Path("/nowhere"))
    params = app.params
    params.use_imgui_test_engine = True
    params.callbacks.pre_new_frame = _fake_textures
    results: dict[str, str] = {}
    registered: list[Any] = []

    def register() -> None:
        engine = hello_imgui.get_imgui_test_engine()
        io = imgui.test_engine.get_io(engine)
        io.config_run_speed = imgui.test_engine.TestRunSpeed.fast
        for name, function in tests.items():
            test = imgui.test_engine.register_test(engine, "editor", name)
            test.test_func = _recorded(name, function, app, results)
            imgui.test_engine.queue_test(engine, test)
            registered.append((name, test))

    def leave_when_done() -> None:
        engine = hello_imgui.get_imgui_test_engine()
        if registered and imgui.test_engine.is_test_queue_empty(engine):
            for name, test in registered:
                if results.get(name) or test.output.status != imgui.test_engine.TestStatus.success:
                    results[name] = f"{results.get(name, '')}\n{test.output.log.get_text()}"
            params.app_shall_exit = True

    params.callbacks.register_tests = register
    params.callbacks.before_imgui_render = leave_when_done
    try:
        immapp.run(params, immapp.AddOnsParams())
    except RuntimeError as error:
        if TEARDOWN not in str(error):
            raise
    sys.stdout.write("\n" + json.dumps(results) + "\n")
    sys.stdout.flush()


def _recorded(name: str, function: UiTest, app: App, results: dict[str, str]) -> Callable[[Any], None]:
    def run(ctx: Any) -> None:
        results[name] = ""
        try:
            function(ctx, app)
        except BaseException:  # an exception must not unwind into the engine's coroutine
            results[name] = traceback.format_exc()

    return run


def _fake_textures() -> None:
    """The null renderer has no textures: say that each was made."""
    for texture in imgui.get_platform_io().textures:
        if texture.status in (imgui.ImTextureStatus.want_create, imgui.ImTextureStatus.want_updates):
            texture.set_tex_id(1)
            texture.set_status(imgui.ImTextureStatus.ok)
