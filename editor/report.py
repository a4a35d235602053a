"""The Report panel's side without imgui: runs of experiments in steps, and what their results say about the settings.

offers(session)         what can be measured on what is open         engine.experiments.harness.live
ReportRun (a Work)      one run, a few milliseconds a frame     ->    session.reports[name]
answers(result)         the three questions, in words           ->    a change of settings, undoable
"""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from engine.core.errors import LucarnaError
from engine.report.advice import Advice, advise, dominated, totals
from engine.report.records import Point, Result

if TYPE_CHECKING:
    from editor.session import Session
    from engine.experiments.harness.live import LiveRun, Offer

#: seconds of a frame that a run may take: the window still follows the pointer
BUDGET = 0.02
#: what a setting begins with -> the pass that it is about
PASSES = {
    "samples": "opaque", "anisotropy": "opaque", "shadow": "shadow_cascades", "sun": "shadow_cascades",
    "translucent": "shadow_tints",
    "light_": "light_culling", "gi": "indirect", "reflection": "reflections",
}  # fmt: skip
#: so many dominated settings are named in the answer; the table has all
LISTED = 4
#: the experiment that measures the settings of the open view
OWN = "picture"


@dataclass(slots=True)
class ReportRun:
    """One experiment. Those that draw do so between the window's frames, the others in a thread."""

    offer: Offer
    quick: bool = True
    title: str = ""
    progress: float = 0.0
    text: str = "Starting"
    run: LiveRun | None = None
    _thread: threading.Thread | None = field(default=None, repr=False)
    _session: Session | None = field(default=None, repr=False)
    _settings: dict[str, Any] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        self.title = self.offer.title

    def step(self, session: Session) -> bool:
        if self.run is None:
            self._session, self.run = session, self._begin(session)
        run = self.run
        if self._thread is None:
            with session.device_frame():
                more = run.step(BUDGET)
        else:
            more = self._thread.is_alive()
        self.progress, self.text = run.done, run.text or self.text
        if more:
            return True
        session.image.invalidate()
        if run.error is not None:
            raise run.error
        if run.result is not None:
            session.reports[self.offer.name] = run.result
            session.report_settings[self.offer.name] = self._settings
        return False

    def close(self) -> None:
        if self.run is None or self._session is None:
            return
        self.run.cancel()  # a thread ends by itself, at its next part
        if self._thread is None:
            with self._session.device_frame():
                self.run.close()

    @property
    def points(self) -> Sequence[Point]:
        """What is judged so far."""
        return () if self.run is None else tuple(self.run.points)

    def _begin(self, session: Session) -> LiveRun:
        from engine.experiments.harness.live import LiveRun
        from engine.experiments.harness.scenes import LiveScene
        from importers.cli.report_tools import ImporterTools

        self._settings = dict(session.settings.values())
        drawing = self.offer.thread == "render"
        live = None
        if self.offer.own_scene and session.document is not None:
            runtime = session.document.runtime
            renderer: Any = getattr(runtime, "renderer", None)
            live = LiveScene(runtime.scene, runtime.residency, session.view(), renderer)
        run = LiveRun(
            self.offer.name, device=session.device if drawing else None, live=live, tools=ImporterTools(),
            quick=self.quick,
        )  # fmt: skip
        if not drawing:
            self._thread = threading.Thread(target=run.run, name="report", daemon=True)
            self._thread.start()
        return run


def offers(session: Session) -> list[Offer]:
    """All experiments, those of the open scene first; none where the device makes no pictures."""
    if session.null_pictures:
        return []
    from engine.experiments.harness.live import offers as all_offers
    from importers.cli.report_tools import ImporterTools

    return all_offers(device=session.device, scene_open=session.document is not None, tools=ImporterTools())


@dataclass(frozen=True, slots=True)
class Answer:
    """One of the three answers. `knobs`: what the button sets, empty where there is nothing to set."""

    question: str
    text: str
    knobs: Mapping[str, Any] = field(default_factory=dict)
    good: bool = False


def answers(result: Result) -> list[Answer]:
    """Which setting gives the most error per millisecond, what is dominated, what would be gained."""
    advice = advise(result)
    if not advice:
        why = "there is no time to compare: " + (result.timed_on or "nothing was timed")
        return [Answer("What does it say?", why)]
    return [_most(advice, result), _dominated(result), _gain(advice, result)]


def _most(advice: Sequence[Advice], result: Result) -> Answer:
    """The trade that removes the most error for each millisecond spent."""
    what = "pass" if "setting" in result.default else "setting"
    question = f"Which {what} gives the most error per millisecond?"
    trades = [a for a in advice if a.kind in ("better", "take") and a.error_removed > 0.0]
    if not trades:
        return Answer(question, "No setting removes any more error")
    best = max(trades, key=lambda a: (a.per_ms if a.sure and a.ms_saved < 0.0 else math.inf, a.error_removed))
    rate = ""
    if not best.sure:
        spent = "in a time that cannot be told from the present one"
    elif best.ms_saved < 0.0:
        spent, rate = f"for {-best.ms_saved:.3g} ms more", f", {best.per_ms:.2g} {result.unit} per ms"
    else:
        spent = f"and saves {best.ms_saved:.3g} ms"
    where = pass_of(str(best.knobs.get("setting", "")))
    what = f"{f'Pass {where}: ' if where else ''}{changed(best.knobs, result.default)}"
    text = f"{what} removes {best.error_removed:.2g} {result.unit} {spent}{rate}"
    return Answer(question, text, best.knobs)


def _dominated(result: Result) -> Answer:
    question = "Which setting is dominated?"
    own = default_point(result)
    beaten = dominated(result)
    if result.default_on_front is not False and own is not None:
        beaten = [k for k in beaten if k != own.knobs]  # what beats it does so within the noise
    timed = sum(p.ms is not None for p in result.points)
    names = [changed(knobs, result.default) for knobs in beaten]
    listed = ", ".join(names[:LISTED]) + (", …" if len(names) > LISTED else "")
    others = f"{len(beaten)} of {timed} are: {listed}" if beaten else "All others buy something"
    if result.default_on_front is False and result.beaten_by:
        now = changed(result.beaten_by, result.default)
        return Answer(question, f"The present one is: {now} is no worse in anything. {others}", result.beaten_by)
    if not beaten:
        return Answer(question, "None: every setting buys something", good=True)
    return Answer(question, f"Not the present one. {others}", good=True)


def _gain(advice: Sequence[Advice], result: Result) -> Answer:
    question = "What would I gain?"
    saved, removed = totals(advice)
    take = [a for a in advice if a.kind == "take"]
    if take:
        best = max(take, key=lambda a: (a.error_removed / max(_error(result), 1e-30), a.ms_saved))
        text = f"{changed(best.knobs, result.default)}: {best.text}"
        more = f" ({saved:.3g} ms and {removed:.2g} {result.unit} at most by all {len(take)})" if len(take) > 1 else ""
        return Answer(question, text + more, best.knobs, good=True)
    cheaper = [a for a in advice if a.kind == "cheaper"]
    if cheaper:
        best = max(cheaper, key=lambda a: a.ms_saved)
        return Answer(question, f"Only by a trade. {changed(best.knobs, result.default)}: {best.text}", best.knobs)
    return Answer(question, "Nothing: the present setting is as good as they get here", good=True)


def _error(result: Result) -> float:
    default = default_point(result)
    return default.error.get(result.metric, 0.0) if default is not None else 0.0


def default_point(result: Result) -> Point | None:
    """The point of the setting that was current when it was measured."""
    return next((p for p in result.points if all(p.knobs.get(k) == v for k, v in result.default.items())), None)


def changed(knobs: Mapping[str, Any], default: Mapping[str, Any]) -> str:
    """`shadow size 1024, samples 2`: only what differs from `default`."""
    if "setting" in knobs:
        return f"{knobs['setting'].replace('_', ' ')} {_short(knobs.get('value', ''))}".strip()
    differs = {k: v for k, v in knobs.items() if default.get(k) != v and k != "scene"} or dict(knobs)
    return ", ".join(f"{k.replace('_', ' ')} {_short(v)}" for k, v in differs.items())


def _short(value: Any) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else str(value)


def settings_of(session: Session, name: str, knobs: Mapping[str, Any]) -> dict[str, Any] | None:
    """All render settings as that point of result `name` was drawn with; None where its knobs are no settings.

    The experiment of the open view changes one at a time: its knobs are `setting` and `value`."""
    measured = session.report_settings.get(name)
    if measured is None:
        return None
    if "setting" in knobs:
        known = knobs["setting"] in measured
        return {**measured, knobs["setting"]: knobs["value"]} if known else dict(measured)
    found = {}
    for knob, value in knobs.items():
        setting = next((n for n in (knob, f"shadow_{knob}") if n in measured), "")
        if setting:
            found[setting] = value
        elif knob != "scene":
            return None
    return {**measured, **found} if found else None


def settable(session: Session, name: str, knobs: Mapping[str, Any]) -> dict[str, Any]:
    """What setting it would change now: name -> value; empty where there is nothing to set."""
    wanted = settings_of(session, name, knobs) if knobs else None
    now = session.settings.values()
    return {} if wanted is None else {k: v for k, v in wanted.items() if now.get(k) != v}


def is_current(session: Session, name: str, point: Point) -> bool:
    """Whether the viewport is drawn as this point was."""
    return settings_of(session, name, point.knobs) == session.settings.values()


def pass_of(setting: str) -> str:
    """The pass of the frame that a setting is about, in words for the answers; '' for no single one."""
    return next((name for prefix, name in PASSES.items() if setting.startswith(prefix)), "")


def apply(session: Session, name: str, knobs: Mapping[str, Any]) -> None:
    """Set them as one entry of the undo history."""
    values = settable(session, name, knobs)
    if values:
        session.apply_settings(values, f"Apply {changed(values, {})}")
        session.ui.notice = f"Set {changed(values, {})}"


def advised(session: Session) -> Mapping[str, Any]:
    """What the report on this view would set: its answer to what would be gained; empty where it has none."""
    result = session.reports.get(OWN)
    return answers(result)[-1].knobs if result is not None else {}


def apply_advice(session: Session) -> None:
    """Set what the report on this view advises."""
    knobs = advised(session)
    if settable(session, OWN, knobs):
        apply(session, OWN, knobs)
    else:
        session.ui.notice = "Nothing to gain: the report has no better setting"


def start(session: Session, name: str, *, quick: bool = True) -> None:
    """Run an experiment by name; a word to the user where it cannot be."""
    from editor import work

    offer = next((o for o in offers(session) if o.name == name), None)
    if offer is None or offer.why_not:
        session.ui.notice = f"{name} cannot run here: {offer.why_not if offer is not None else 'there is no such one'}"
        return
    work.start(session, ReportRun(offer, quick))


def write(session: Session) -> None:
    """Write the results at hand as `lucarna report` does, page and JSON: into `report/` of the project, or beside the
    opened file."""
    document = session.document
    if document is None or not session.reports:
        return
    beside = document.source if document.source.is_dir() else document.source.parent
    folder = (document.project_root or beside) / "report"
    from engine.experiments.harness.provenance import device_name, driver_name, machine_name, versions
    from engine.report.records import Report
    from engine.report.writing import write_report

    try:
        device, found = session.device, list(session.reports.values())
        write_report(
            Report(device_name(device), driver_name(device), versions(), found, True, 1, machine_name()), folder
        )
    except LucarnaError as error:
        session.fail(error)
        return
    session.messages.info("Wrote the report", where=str(folder))
    session.ui.notice = f"Wrote {folder}"
