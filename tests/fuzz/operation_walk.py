"""A random walk over the operations of the editor, and what must hold at each step of it.

- what an operation changes in the document it changes through the history: without an entry nothing differs
- undo and redo bring back every state that was there before, whatever lies between
- an operation is done or refused in words (a LucarnaError): anything else is a failure

- several documents may be open: what is done in one leaves the others, and what their histories know, as they were
"""

from __future__ import annotations

import json
import random
import uuid
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import IO, Any

from editor import prefabs, tabs
from editor.builtin_operations import builtin_operations
from editor.document import Document
from editor.operations import Operations
from editor.session import Session
from engine.core.errors import LucarnaError
from tests.fuzz import operation_stage as stage
from tests.fuzz.operation_model import Broken, Model, Watched, stamp_of

#: operations that the walk leaves out, and why
LEFT_OUT = {
    "file.quit": "ends the window",
    "file.open-sample": "opens another document",
    "file.save-turntable": "writes pictures and no document",
    "help.export-keymap": "writes a file and no document",
    "shader.effect": "opens files of the installation in the text editor",
}

PREFABS = ("prefab.make", "prefab.apply", "prefab.revert", "prefab.place")


class Walk:
    """Random operations on the documents in `homes`. `trace` gets a line for each event of their histories."""

    def __init__(self, session: Session, trace: IO[str], homes: Sequence[Path]) -> None:
        self.session, self.trace, self.homes = session, trace, homes
        self.operations: Operations = builtin_operations()
        self.watched: list[Watched] = []
        self.counts: Counter[str] = Counter()
        #: how many documents were open at once
        self.most = 0
        #: a document that was saved, and not looked at since
        self.saved: Watched | None = None
        #: called with the number of the event that was just traced
        self.after_event: Callable[[str], None] = lambda event: None

    @property
    def front(self) -> Watched:
        return next(w for w in self.watched if w.document is self.session.document)

    def watch(self, document: Document, *, key: str = "", model: Model | None = None) -> None:
        """Follow this document from now on; with a `model` it must be what that says."""
        places = [path.resolve() for path in (document.source, document.scene_path)]
        home = next(home for home in self.homes if any(home.resolve() in path.parents for path in places))
        watched = Watched(key or uuid.uuid4().hex[:8], document, home)
        self.watched.append(watched)
        self.most = max(self.most, len(self.watched))
        history = document.history
        journal = history.listener

        def listen(what: str, edit: Any, gesture: Any) -> None:
            if journal is not None:
                journal(what, edit, gesture)
            self._tell(watched, what)

        history.listener = listen
        for written, _tab in tabs.journals(self.session):
            if written.document is document:  # so that leaving it finds its listener
                written.record = listen  # type: ignore[method-assign]  # what is compared there
        if model is None:
            self._tell(watched, "open")
            return
        watched.model = model
        if watched.content() != model.now:
            raise Broken("the restored document is not what it was when its process was killed")
        watched.entries = history.entries

    def _tell(self, watched: Watched, what: str) -> None:
        event = watched.event(what)
        self.write(event)
        self.saved = watched if what == "saved" else self.saved
        self.after_event(what)
        watched.model.follow(event)

    def write(self, event: dict[str, Any]) -> None:
        self.trace.write(json.dumps(event) + "\n")
        self.trace.flush()

    def forget_all(self, keys: Iterable[str]) -> None:
        """These documents were closed."""
        for key in keys:
            self.write({"e": "close", "key": key})

    # --- steps ---

    def step(self, dice: random.Random) -> str:
        """One random thing; returns what. Raises Broken."""
        front = self.front
        document, before, at = front.document, front.content(), front.model.at
        revision = document.history.revision
        stamps = {home: stamp_of(home) for home, count in Counter(w.home for w in self.watched).items() if count > 1}
        steps = {
            self._undo: 18, self._drag: 8, self._set: 18, self._select: 14, self._any: 42, self._prefab: 4,
            self._tab: 4, self._look: 2, self._move: 3, self._import: 2,
        }  # fmt: skip
        (do,) = dice.choices(list(steps), list(steps.values()))
        what = do.__name__[1:]
        try:
            what = do(dice)
        except LucarnaError:
            what += " (refused)"
        self.counts[what] += 1
        self._settle(dice)
        for watched in self.watched:
            changed = watched.home in stamps and stamp_of(watched.home) != stamps[watched.home]
            watched.shared = watched.shared or (watched is not front and changed)
        self.keep_up()
        self._compare(what, front)
        self._reopen(what, dice)
        quiet = front in self.watched and document.history.revision == revision
        if quiet and (front.content() != before or front.model.at != at):
            raise Broken(f"{what}: no edit was made, and the document is another")
        return what

    def keep_up(self) -> None:
        """Documents came and went."""
        session = self.session
        opened = tabs.documents(session)
        for watched in [w for w in self.watched if w.document not in opened]:
            self.watched.remove(watched)
            self.forget_all([watched.key])
        if session.document is None:
            self.open(self.homes[0])
        for document in tabs.documents(session):
            if all(w.document is not document for w in self.watched):
                self.watch(document)

    def open(self, home: Path) -> None:
        self.session.adopt(stage.opened(self.session, stage.scene_of(home)))
        self.session.playback.playing = False

    def _compare(self, what: str, front: Watched) -> None:
        """Each document is what its history says, whatever was done in which."""
        for watched in self.watched:
            now = watched.content()
            if now == watched.model.now:
                continue
            if watched.shared:
                watched.shared = False
                watched.model.forget(now)
                self.write(watched.event("open"))
                continue
            whose = "the document" if watched is front else f"another document ({watched.document.name})"
            raise Broken(f"{what}: {whose} changed, and its history does not know: {now}, and was {watched.model.now}")

    def _reopen(self, what: str, dice: random.Random) -> None:
        """What was saved just now is what shows."""
        watched, self.saved = self.saved, None
        if watched is None or watched not in self.watched or dice.random() < 0.5:
            return
        document = watched.document
        if document.saved_to is None or document.history.saved_at != len(document.history.entries):
            return
        shows, says = stage.reopened(self.session, document)
        if shows != says:
            raise Broken(f"{what}: the saved files do not say what shows:\n{shows}\n{says}")

    def _undo(self, dice: random.Random) -> str:
        assert self.session.document is not None
        history = self.session.document.history
        what = dice.choice(("edit.undo", "edit.redo", "jump"))
        if what == "jump":
            history.go_to(dice.randint(0, len(history.entries) + len(history.undone)))
            return what
        for _ in range(dice.randint(1, 6)):
            self.operations.run(what, self.session)
        return what

    def _set(self, dice: random.Random) -> str:
        return self._run("edit.set", dice)

    def _select(self, dice: random.Random) -> str:
        return self._run("select.nodes", dice)

    def _any(self, dice: random.Random) -> str:
        return self._run(dice.choice([o.id for o in self.operations if o.id not in LEFT_OUT]), dice)

    def _run(self, id: str, dice: random.Random) -> str:
        operation = self.operations[id]
        if not operation.enabled(self.session):
            return f"{id} (not now)"
        if operation.sample is not None:
            given = operation.sample(self.session, dice)
        else:
            given = {
                a.name: a.sample(self.session, dice) for a in operation.arguments if a.required or dice.random() < 0.5
            }
        for argument in operation.arguments:
            if argument.type == "path" and argument.name in given:
                given[argument.name] = self._path(id, dice)
        self.operations.run(id, self.session, **given)
        return id

    def _path(self, id: str, dice: random.Random) -> Path:
        """A file of the document in front; what is to be opened lies in a folder of its own."""
        if id == "file.open-path" and dice.random() < 0.8:
            return stage.scene_of(dice.choice(self.homes))
        home = self.front.home
        if id == "file.move" and dice.random() < 0.8:
            return self._movable(home, dice)
        return home / dice.choice(("other.scene.json", "sub/third.scene.json", "nowhere.glb"))

    def _movable(self, home: Path, dice: random.Random) -> Path:
        """A file of the project, or a place where it would be another; the scene that is opened stays."""
        kept = (".scene.json", stage.scene_of(home).name)
        files = [p for p in sorted(home.rglob("*")) if p.is_file() and not p.name.endswith(kept)]
        path = dice.choice(files or [home / "nowhere.png"])
        if dice.random() < 0.5:
            return path
        stem, dot, ending = path.name.partition(".")
        return dice.choice((home, home / "moved", home / "moved/deep")) / f"{stem[:8]}{dice.randrange(3)}{dot}{ending}"

    def _move(self, dice: random.Random) -> str:
        """Move a file; what is unsaved would be in the way, and mostly is saved first."""
        if dice.random() < 0.7 and self.session.document is not None:
            self.session.save()
        home = self.front.home
        given = self._movable(home, dice), self._movable(home, dice)
        if dice.random() < 0.7:
            given = given[0], home / dice.choice(("moved", "deep/er", ".")) / given[0].name
        self.operations.run("file.move", self.session, old=given[0], new=given[1])
        return "file.move"

    def _tab(self, dice: random.Random) -> str:
        """Open, show, move or close a document; no more than three stay open."""
        session = self.session
        what = dice.choice(("file.open-path", "show", "show", "move", "close"))
        if what == "file.open-path":
            return self._run(what, dice)
        index = dice.randrange(len(session.tabs))
        if what == "move":
            tabs.move(session, index, dice.randrange(len(session.tabs)))
        else:
            tabs.show(session, index)
        if what == "close" or len(session.tabs) > 3:
            session.close()
        return f"tab: {what}"

    def _look(self, dice: random.Random) -> str:
        """What a panel does to show something that the scene does not use: it loads it."""
        document = self.session.document
        assert document is not None
        residency = document.runtime.residency
        kind = dice.choice(("*.lmesh", "*.material.toml"))
        path = dice.choice(sorted(self.homes[0].rglob(kind)))  # also of another document
        with self.session.device_frame():
            if kind == "*.lmesh":
                residency.load_mesh_file(path)
            else:
                residency.load_material(path)
        return "load what a panel shows"

    def _import(self, dice: random.Random) -> str:
        """A source changes, or how it is imported; where a document has none, one with a source comes to the front."""
        session = self.session
        document = session.document
        assert document is not None
        if document.imported_from is None or not document.imported_from.name.endswith(".gltf"):
            self.operations.run("file.open-path", session, path=stage.scene_of(self.homes[2]))
            return "file.open-path"
        if dice.random() < 0.5:
            text = document.imported_from.read_text()
            said = json.loads(text)
            said["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = dice.choice((0.1, 0.4, 0.9))
            said["nodes"][0]["name"] = dice.choice(("crate", "box"))
            document.imported_from.write_text(json.dumps(said))
            return self._run("file.reimport", dice)
        return self._run(dice.choice([o.id for o in self.operations if o.id.startswith("import.")]), dice)

    def _prefab(self, dice: random.Random) -> str:
        """An operation on an instance that there is, more often than chance selects one."""
        document = self.session.document
        assert document is not None
        nodes = document.runtime.scene.nodes
        rows = [int(row) for row in range(len(nodes)) if nodes.alive[row] and prefabs.root_of(document, row) == row]
        if rows and dice.random() < 0.7:
            document.select(dice.choice(rows))
        return self._run(dice.choice(PREFABS) if rows else "prefab.make", dice)

    def _drag(self, dice: random.Random) -> str:
        """A gesture of some steps on one target, as a widget makes it; now and then back to where it began."""
        assert self.session.document is not None
        given = self.operations["edit.set"].sample
        assert given is not None
        order = given(self.session, dice)
        table, column, rows = order["table"], order["column"], order["rows"]
        start = self.session.document.tables[table].read(column, rows)
        for number in range(dice.randint(2, 6)):
            value = order["value"] if number % 2 == 0 else start[0] if start else None
            if table in ("lights", "cameras", "nodes", "materials"):
                self.session.edit(table, column, rows, [value] * len(rows), gesture=("drag", table))
        self.session.end_gesture()
        return f"drag {table}"

    def _settle(self, dice: random.Random) -> None:
        """What a window does between frames, and a user with what it asks."""
        session = self.session
        self._wait()
        if session.work is not None:
            from editor import work

            work.cancel(session)
        requests = session.ui
        while requests.after_discard is not None:
            after, requests.after_discard = requests.after_discard, None
            if dice.random() < 0.05:
                after()
        self._wait()
        requests.quit = False
        if requests.paste is not None:
            paste, requests.paste = requests.paste, None
            paste(dice.choice((requests.copy_text, "roughness = 0.3", "", "no = [toml")))
        session.playback.playing = False
        session.tick(0.05)

    def _wait(self) -> None:
        """Let what is being opened and imported come in."""
        session = self.session
        for _ in range(4):
            for job in (session.job, session.importing):
                if job is not None:
                    job.wait(20)
            session.poll()
