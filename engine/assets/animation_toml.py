"""`*.animation.toml`: what a character does with its clips: states, transitions, blend spaces, layers, masks, markers.

    schema = "lucarna.animation/1"
    name = "soldier"
    start = "idle"
    root = "hips"                                  # root motion of this node; leave out for none
    [params]
    speed = { type = "float", default = 0.0 }
    [clips.walk]
    source = "Walk"                                # the clip's name in the scene; left out: the key itself
    markers = [{ name = "left foot", time = 0.2 }]
    [masks.upper]
    subtrees = [{ node = "spine", fall_off = 2 }]
    nodes = { "left hand" = 0.0 }
    [blends.locomotion]
    params = ["speed"]
    samples = [{ clip = "walk", at = [1.4] }, { clip = "run", at = [4.0] }]
    [states.idle]
    clip = "idle"
    [states.move]
    blend = "locomotion"
    [[transitions]]
    from = "idle"                                  # or "any"
    to = "move"
    when = ["speed > 0.1"]                         # all must hold; `armed` and `!armed` for bools and triggers
    fade = 0.2
    [[layers]]
    name = "draw"
    clip = "draw"
    mask = "upper"
    weight = "drawing"                             # a number, or the parameter that gives it
    [[tracks]]                                     # a timeline: what plays when; beside states or instead of them
    name = "body"
    mask = "upper"                                 # left out: all that its clips move
    blocks = [{ clip = "walk", start = 0.0, length = 3.0, fade_out = 1.0 }, { clip = "run", start = 2.0, length = 3.0 }]
    [[markers]]                                    # on the timeline itself
    name = "cut"
    time = 2.5

`read_animation` checks the file's shape and that its names mean something in it; the scene's nodes and clips are for
engine.animation to find. Every complaint stands at its line.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from engine.assets.records import did_you_mean
from engine.core.errors import FormatError
from engine.core.toml_source import KeyPath, TomlSource, load_toml, parse_toml

SCHEMA = "lucarna.animation/1"

Name = Annotated[str, Field(min_length=1, max_length=4096)]
Seconds = Annotated[FiniteFloat, Field(ge=0.0, le=1e6)]
Share = Annotated[FiniteFloat, Field(ge=0.0, le=1.0)]
Mode = Literal["loop", "once", "ping-pong"]
Curve = Literal["linear", "smooth", "smoother", "ease_in", "ease_out"]

_CONDITION = re.compile(r"\s*(\w+)\s*(>=|<=|==|!=|>|<)\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?|true|false)\s*")
_FLAG = re.compile(r"\s*(!?)\s*(\w+)\s*")


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class MarkerModel(_Table):
    name: Name
    time: Seconds


class ClipModel(_Table):
    source: str = ""
    markers: list[MarkerModel] = []


class SubtreeModel(_Table):
    node: Name
    weight: Share = 1.0
    fall_off: int = Field(0, ge=0, le=1000)


class MaskModel(_Table):
    subtrees: list[SubtreeModel] = []
    nodes: dict[Name, Share] = {}


class SampleModel(_Table):
    clip: Name
    at: list[FiniteFloat] = Field(min_length=1, max_length=2)


class BlendModel(_Table):
    params: list[Name] = Field(min_length=1, max_length=2)
    samples: list[SampleModel] = Field(min_length=1, max_length=256)


class ParamModel(_Table):
    type: Literal["float", "bool", "trigger"] = "float"
    default: FiniteFloat | bool = 0.0


class StateModel(_Table):
    clip: str = ""
    blend: str = ""
    speed: FiniteFloat = 1.0
    mode: Mode = "loop"
    #: where an editor draws it
    at: list[FiniteFloat] | None = Field(None, min_length=2, max_length=2)


class TransitionModel(_Table):
    source: Name = Field(alias="from")
    target: Name = Field(alias="to")
    when: list[Name] = []
    fade: Seconds = 0.2
    curve: Curve = "smooth"
    exit: Share | None = None
    sync: bool = False


class LayerModel(_Table):
    name: Name
    clip: str = ""
    blend: str = ""
    mask: str = ""
    mode: Literal["override", "additive"] = "override"
    weight: FiniteFloat | Name = 1.0
    speed: FiniteFloat = 1.0
    play: Mode = "loop"
    #: the additive reference pose: this clip at `reference_time`, the rest pose for ""; left out: the layer's own clip
    reference: str | None = None
    reference_time: Seconds = 0.0


class BlockModel(_Table):
    """A clip on a track: from `start` for `length` seconds, its own time beginning at `offset` and running at `speed`;
    `play` says what happens beyond its ends. `sync`: in step, by phase, with the track's other blocks that are.
    `weight`: its share among the blocks that play at the same time; less than 1 in all lets what lies below through."""

    clip: Name
    start: Seconds = 0.0
    length: Annotated[FiniteFloat, Field(gt=0.0, le=1e6)] = 1.0
    offset: FiniteFloat = 0.0
    speed: FiniteFloat = 1.0
    fade_in: Seconds = 0.0
    fade_out: Seconds = 0.0
    curve: Curve = "smooth"
    play: Mode = "loop"
    sync: bool = False
    weight: Share = 1.0


class TrackModel(_Table):
    """Blocks of one track are blended; each track lies over those before it."""

    name: Name
    blocks: list[BlockModel] = Field(default=[], max_length=4096)
    mask: str = ""
    mode: Literal["override", "additive"] = "override"
    weight: FiniteFloat = 1.0
    muted: bool = False
    #: as a layer's: the pose that an additive track is measured from
    reference: str | None = None
    reference_time: Seconds = 0.0


class AnimationModel(_Table):
    schema_: Literal["lucarna.animation/1"] = Field(alias="schema")
    name: Name
    start: str = ""
    root: str = ""
    params: dict[Name, ParamModel] = {}
    clips: dict[Name, ClipModel] = {}
    masks: dict[Name, MaskModel] = {}
    blends: dict[Name, BlendModel] = {}
    states: dict[Name, StateModel] = {}
    transitions: list[TransitionModel] = []
    layers: list[LayerModel] = []
    tracks: list[TrackModel] = []
    markers: list[MarkerModel] = []


def read_animation(path: Path) -> tuple[AnimationModel, TomlSource]:
    """The checked file, and its source for complaints that come later.

    Raises InputError when it cannot be read, FormatError with file:line:column, the line and a caret.
    """
    return _animation(load_toml(path))


def parse_animation(text: str, file: str) -> tuple[AnimationModel, TomlSource]:
    """The same from text; `file` names it in messages."""
    return _animation(parse_toml(text, file))


def condition(text: str) -> tuple[str, str, float] | None:
    """(parameter, operator, value) of `speed > 0.1`, `armed` (!= 0) or `!armed` (== 0); None for anything else."""
    found = _CONDITION.fullmatch(text)
    if found:
        name, op, value = found.groups()
        try:
            return name, op, {"true": 1.0, "false": 0.0}[value] if value in ("true", "false") else float(value)
        except ValueError:
            return None
    found = _FLAG.fullmatch(text)
    return (found.group(2), "==" if found.group(1) else "!=", 0.0) if found else None


def _animation(source: TomlSource) -> tuple[AnimationModel, TomlSource]:
    try:
        model = AnimationModel.model_validate(source.data)
    except ValidationError as error:
        raise _explain(source, error) from None
    for problem in _problems(model, source):
        raise problem
    return model, source


def _explain(source: TomlSource, error: ValidationError) -> FormatError:
    """A complaint of pydantic, at its line: an unknown key rather than the one that is missing for it."""
    found = error.errors()
    first = next((e for e in found if e["type"] == "extra_forbidden"), found[0])
    # pydantic adds the tried branch of a union, and [key] for a dictionary's key
    parts = [p for p in first["loc"] if p not in ("[key]", "constrained-str", "float", "str")]
    location: KeyPath = tuple("schema" if p == "schema_" else p for p in parts)
    last = str(location[-1]) if location else "schema"
    if first["type"] == "extra_forbidden":
        return source.error(location, f"unknown key {last!r}", hint=did_you_mean(last, _known(location)))
    if first["type"] == "missing":
        return source.error(location, f"the key {last!r} is missing")
    return source.error(location, str(first["msg"]).removeprefix("Value error, "), value=True)


def _known(location: KeyPath) -> list[str]:
    """The keys that could stand where `location` does."""
    models: dict[str, type[_Table]] = {
        "params": ParamModel, "clips": ClipModel, "masks": MaskModel, "blends": BlendModel, "states": StateModel,
        "transitions": TransitionModel, "layers": LayerModel, "markers": MarkerModel, "subtrees": SubtreeModel,
        "samples": SampleModel, "tracks": TrackModel, "blocks": BlockModel,
    }  # fmt: skip
    owner: type[_Table] = AnimationModel
    for part in location[:-1]:
        owner = models.get(str(part), owner)
    return [field.alias or name for name, field in owner.model_fields.items()]


def _problems(model: AnimationModel, source: TomlSource) -> Iterator[FormatError]:
    """What a schema cannot say: every name used must be declared, and fit."""

    def unknown(what: str, name: str, known: Collection[str], keys: KeyPath) -> Iterator[FormatError]:
        if name not in known:
            yield source.error(keys, f"there is no {what} {name!r}", hint=did_you_mean(name, known), value=True)

    for name, blend in model.blends.items():
        for i, param in enumerate(blend.params):
            yield from unknown("parameter", param, model.params, ("blends", name, "params", i))
        for i, sample in enumerate(blend.samples):
            yield from unknown("clip", sample.clip, model.clips, ("blends", name, "samples", i, "clip"))
            if len(sample.at) != len(blend.params):
                yield source.error(
                    ("blends", name, "samples", i, "at"),
                    f"a place of {len(sample.at)} numbers for {len(blend.params)} parameters", value=True,
                )  # fmt: skip
    if not model.states and not model.tracks:
        yield source.error((), "an animation needs states or tracks", hint="add [states.NAME] or [[tracks]]")
    for i, track in enumerate(model.tracks):
        if track.mask:
            yield from unknown("mask", track.mask, model.masks, ("tracks", i, "mask"))
        if track.reference:
            yield from unknown("clip", track.reference, model.clips, ("tracks", i, "reference"))
        if track.mode == "override" and not 0.0 <= track.weight <= 1.0:
            yield source.error(("tracks", i, "weight"), "the weight of an override is in [0, 1]", value=True)
        for j, block in enumerate(track.blocks):
            yield from unknown("clip", block.clip, model.clips, ("tracks", i, "blocks", j, "clip"))
    motions: list[tuple[KeyPath, StateModel | LayerModel]] = [(("states", n), s) for n, s in model.states.items()]
    motions += [(("layers", i), layer) for i, layer in enumerate(model.layers)]
    for keys, user in motions:
        if bool(user.clip) == bool(user.blend):
            yield source.error(keys, "expected either a clip or a blend", hint="name one of them")
        if user.clip:
            yield from unknown("clip", user.clip, model.clips, (*keys, "clip"))
        if user.blend:
            yield from unknown("blend", user.blend, model.blends, (*keys, "blend"))
    for i, layer in enumerate(model.layers):
        if layer.mask:
            yield from unknown("mask", layer.mask, model.masks, ("layers", i, "mask"))
        if isinstance(layer.weight, str):
            yield from unknown("parameter", layer.weight, model.params, ("layers", i, "weight"))
        if layer.reference:
            yield from unknown("clip", layer.reference, model.clips, ("layers", i, "reference"))
        if layer.mode == "override" and not isinstance(layer.weight, str) and not 0.0 <= layer.weight <= 1.0:
            yield source.error(("layers", i, "weight"), "the weight of an override is in [0, 1]", value=True)
        if layer.mode == "additive" and layer.reference is None and not layer.clip:
            yield source.error(("layers", i), "an additive layer of a blend needs a reference", hint='reference = ""')
    for i, transition in enumerate(model.transitions):
        yield from unknown("state", transition.target, model.states, ("transitions", i, "to"))
        if transition.source != "any":
            yield from unknown("state", transition.source, model.states, ("transitions", i, "from"))
        for j, text in enumerate(transition.when):
            parsed = condition(text)
            if parsed is None:
                yield source.error(
                    ("transitions", i, "when", j), f"{text!r} is no condition", hint="write `speed > 0.1` or `armed`"
                )
            else:
                yield from unknown("parameter", parsed[0], model.params, ("transitions", i, "when", j))
    if model.start:
        yield from unknown("state", model.start, model.states, ("start",))
