"""AnimationEditor: every edit of an animation as one call: panels, keys, console and tests go through it.

Each call is one entry of the undo history; those with the same `gesture` are one together. What is not allowed raises
InputError or FormatError and changes nothing.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from editor.animating import edits
from editor.animating.following import animation_of, drive_of, follow
from engine.core.errors import InputError

if TYPE_CHECKING:
    from editor.session import Session

#: no block or fade is shorter
SHORTEST = 1.0 / 240.0


class AnimationEditor:
    def __init__(self, session: Session) -> None:
        self.session = session

    # -- the file -----------------------------------------------------------------------------------------------------

    @property
    def model(self) -> Any:
        """The open animation's content (AnimationModel), or None."""
        animation = animation_of(self.session)
        return animation.model if animation is not None else None

    @property
    def text(self) -> str:
        """The open animation; where there is none, a fresh one that plays the first clip."""
        animation = animation_of(self.session)
        return animation.text if animation is not None else self._fresh()

    def _fresh(self) -> str:
        from engine.app.animation import fresh_text

        document = self._document()
        runtime: Any = document.runtime
        own = runtime.clips[: runtime.own_clips] or runtime.clips
        return fresh_text(runtime.scene.name or document.name, own)

    def create(self) -> None:
        """Open a fresh animation where there is none."""
        if animation_of(self.session) is None:
            self.apply(self._fresh(), "New animation")

    def close(self) -> None:
        """Take the animation off the scene."""
        self.apply("", "Remove the animation")

    def apply(self, text: str, label: str, gesture: Hashable | None = None) -> None:
        """Make `text` the animation."""
        self._document().edit("animation", "text", [0], [text], gesture=gesture, label=label)
        follow(self.session)

    def put(self, *values: tuple[edits.Path, Any], label: str, gesture: Hashable | None = None) -> None:
        """Set what stands at each place; None takes it away."""
        self.apply(edits.put(self.text, *values), label, gesture)

    def drive(self, drive: str) -> None:
        """What poses the scene: clips, timeline or states."""
        if drive != "clips" and animation_of(self.session) is None:
            self.create()
        if drive != drive_of(self.session):
            self._document().edit("animation", "drive", [0], [drive], label=f"Play {drive}")
        follow(self.session)

    def root_motion(self, on: bool) -> None:
        self._document().edit("animation", "root_motion", [0], [on], label=f"Root motion {'on' if on else 'off'}")

    def rename(self, kind: str, old: str, new: str) -> None:
        """Another name for one of the clips, masks, states, params or blends, everywhere."""
        self.apply(edits.rename(self.text, kind, old, new), f"Rename {old} to {new}")

    # -- tracks and blocks --------------------------------------------------------------------------------------------

    def add_track(self, name: str = "", *, mask: str = "", mode: str = "override", reference: str | None = None) -> int:
        """A track over all others; its number."""
        self.create()
        names = [t.name for t in self.model.tracks]
        value = {"name": edits.free_name(name or "track", names), "mask": mask or None, "mode": mode}
        value["reference"] = reference if mode == "additive" else None
        self.apply(edits.append(self.text, ("tracks",), {**value, "blocks": []}), f"Add track {value['name']}")
        return len(names)

    def set_track(self, track: int, *, gesture: Hashable | None = None, **values: Any) -> None:
        """`name`, `mask`, `mode`, `weight`, `muted`, `reference`."""
        label = f"Change track {self._track(track).name}"
        self.put(*((("tracks", track, k), v) for k, v in values.items()), label=label,
                 gesture=gesture)  # fmt: skip

    def remove_track(self, track: int) -> None:
        name = self._track(track).name
        self.apply(edits.remove(self.text, ("tracks", track)), f"Remove track {name}")

    def move_track(self, track: int, by: int) -> None:
        self.apply(edits.move(self.text, ("tracks", track), by), f"Move track {self._track(track).name}")

    def add_block(
        self, clip: str, track: int = 0, start: float | None = None, length: float | None = None, *,
        fade: float = 0.0, curve: str = "smooth", sync: bool = False,
    ) -> int:  # fmt: skip
        """A block of the scene's clip `clip` on a track: after all others where `start` is not given, `fade` seconds
        over the last. Its number."""
        self.create()
        text, key = self._with_clip(self.text, clip)
        blocks = self._track(track).blocks
        last = max(blocks, key=lambda b: b.start + b.length, default=None)
        end = last.start + last.length if last is not None else 0.0
        fade = min(fade, last.length) if last is not None else 0.0
        begin = max(end - fade, 0.0) if start is None else max(start, 0.0)
        seconds = self._clip_seconds(clip) if length is None else length
        value: dict[str, Any] = {"clip": key, "start": begin, "length": max(seconds, SHORTEST)}
        if fade > 0.0:
            text = edits.put(
                text, (("tracks", track, "blocks", blocks.index(last), "fade_out"), fade),
                (("tracks", track, "blocks", blocks.index(last), "curve"), curve),
            )  # fmt: skip
            value["fade_in"] = fade
        value["curve"] = curve if curve != "smooth" or fade > 0.0 else None
        value["sync"] = True if sync else None
        self.apply(edits.append(text, ("tracks", track, "blocks"), value), f"Add {clip}")
        return len(blocks)

    def set_block(self, track: int, block: int, *, gesture: Hashable | None = None, **values: Any) -> None:
        """`start`, `length`, `offset`, `speed`, `fade_in`, `fade_out`, `curve`, `play`, `sync`, `weight`, `clip`."""
        name = self._block(track, block).clip
        if "clip" in values:
            text, values["clip"] = self._with_clip(self.text, values["clip"])
            self.apply(text, f"Use {name}", gesture)
        self.put(*((("tracks", track, "blocks", block, k), v) for k, v in values.items()), label=f"Change {name}",
                 gesture=gesture)  # fmt: skip

    def move_block(self, track: int, block: int, start: float, gesture: Hashable | None = None) -> None:
        """Put a block elsewhere in its track; what it overlaps with there, it cross-fades with."""
        own = self._block(track, block)
        self._place(track, block, max(start, 0.0), own.length, own.offset, f"Move {own.clip}", gesture)

    def trim_block(self, track: int, block: int, start: float, end: float, gesture: Hashable | None = None) -> None:
        """Move a block's ends; what plays in it stays where it is in time."""
        own = self._block(track, block)
        start = max(start, 0.0)
        end = max(end, start + SHORTEST)
        offset = own.offset + (start - own.start) * own.speed
        self._place(track, block, start, end - start, offset, f"Trim {own.clip}", gesture)

    def split_block(self, track: int, block: int, time: float) -> None:
        """Cut a block in two at `time`."""
        own = self._block(track, block)
        if not own.start < time < own.start + own.length:
            raise InputError(f"{own.clip} does not play at {time:g} s")
        path = ("tracks", track, "blocks", block)
        tail = own.model_dump(exclude_defaults=True) | {
            "start": time, "length": own.start + own.length - time,
            "offset": own.offset + (time - own.start) * own.speed,
            "fade_in": None, "fade_out": own.fade_out or None,
        }  # fmt: skip
        text = edits.put(self.text, ((*path, "length"), time - own.start), ((*path, "fade_out"), None))
        self.apply(edits.append(text, ("tracks", track, "blocks"), tail), f"Split {own.clip}")

    def remove_block(self, track: int, block: int) -> None:
        name = self._block(track, block).clip
        self.apply(edits.remove(self.text, ("tracks", track, "blocks", block)), f"Remove {name}")

    def _place(
        self, track: int, block: int, start: float, length: float, offset: float, label: str, gesture: Hashable | None
    ) -> None:
        """Move a block, and let fades with its neighbours be as long as they overlap."""
        path = ("tracks", track, "blocks", block)
        changes: list[tuple[edits.Path, Any]] = [
            ((*path, "start"), float(start)), ((*path, "length"), float(length)),
            ((*path, "offset"), float(offset) or None),
        ]  # fmt: skip
        own = self._block(track, block)
        before_end, after_start = start, start + length
        for i, other in enumerate(self._track(track).blocks):
            if i == block:
                continue
            end, touched = (
                other.start + other.length,
                other.start < own.start + own.length and own.start < other.start + other.length,
            )
            if other.start < start < end < start + length:
                before_end = max(before_end, end)
                changes.append((("tracks", track, "blocks", i, "fade_out"), end - start))
            elif start < other.start < start + length < end:
                after_start = min(after_start, other.start)
                changes.append((("tracks", track, "blocks", i, "fade_in"), start + length - other.start))
            elif touched and own.start > other.start:
                changes.append((("tracks", track, "blocks", i, "fade_out"), None))
            elif touched:
                changes.append((("tracks", track, "blocks", i, "fade_in"), None))
        overlapped = any(
            b.start < own.start < b.start + b.length for i, b in enumerate(self._track(track).blocks) if i != block
        )
        if before_end > start or overlapped:
            changes.append(((*path, "fade_in"), before_end - start or None))
        overlaps = any(
            own.start < b.start < own.start + own.length for i, b in enumerate(self._track(track).blocks) if i != block
        )
        if after_start < start + length or overlaps:
            changes.append(((*path, "fade_out"), start + length - after_start or None))
        self.put(*changes, label=label, gesture=gesture)

    # -- markers ------------------------------------------------------------------------------------------------------

    def add_marker(self, name: str, time: float, clip: str = "") -> None:
        """A marker on the timeline, or on a clip, seconds from its start."""
        self.create()
        text, path = self.text, ("markers",)
        if clip:
            text, key = self._with_clip(text, clip)
            path = ("clips", key, "markers")  # type: ignore[assignment]  # a longer path is a path
        self.apply(edits.append(text, path, {"name": name, "time": max(float(time), 0.0)}), f"Add marker {name}")

    def set_marker(self, number: int, clip: str = "", *, gesture: Hashable | None = None, **values: Any) -> None:
        """`name`, `time` of a marker of the timeline, or of a clip."""
        path = ("clips", clip, "markers", number) if clip else ("markers", number)
        self.put(*(((*path, k), v) for k, v in values.items()), label="Change marker", gesture=gesture)

    def remove_marker(self, number: int, clip: str = "") -> None:
        path = ("clips", clip, "markers", number) if clip else ("markers", number)
        self.apply(edits.remove(self.text, path), "Remove marker")

    # -- masks --------------------------------------------------------------------------------------------------------

    def add_mask(self, name: str = "mask", bone: str = "", fall_off: int = 0) -> str:
        """A mask, of a bone and what is below it where one is given; its name."""
        self.create()
        name = edits.free_name(name, list(self.model.masks))
        subtrees = [{"node": bone, "fall_off": fall_off}] if bone else []
        self.put((("masks", name), {"subtrees": subtrees}), label=f"Add mask {name}")
        return name

    def mask_subtree(self, mask: str, bone: str, weight: float = 1.0, fall_off: int = 0,
                     gesture: Hashable | None = None) -> None:  # fmt: skip
        """Let a bone and all below it follow; the same bone again replaces what was said of it."""
        parts = [s.model_dump(exclude_defaults=True) for s in self._mask(mask).subtrees]
        value = {"node": bone, "weight": float(weight) if weight != 1.0 else None, "fall_off": fall_off or None}
        known = [part["node"] for part in parts]
        at = known.index(bone) if bone in known else len(parts)
        self.put(
            (("masks", mask, "subtrees"), [*parts[:at], value, *parts[at + 1 :]]), label=f"Mask {bone}", gesture=gesture
        )

    def unmask_subtree(self, mask: str, bone: str) -> None:
        kept = [s.model_dump(exclude_defaults=True) for s in self._mask(mask).subtrees if s.node != bone]
        self.put((("masks", mask, "subtrees"), kept), label=f"Take {bone} out of {mask}")

    def mask_bone(self, mask: str, bone: str, weight: float | None, gesture: Hashable | None = None) -> None:
        """One bone's own weight, whatever its subtree says; None: as its subtree says."""
        self._mask(mask)
        self.put((("masks", mask, "nodes", bone), None if weight is None else float(weight)), label=f"Weight of {bone}",
                 gesture=gesture)  # fmt: skip

    def remove_mask(self, mask: str) -> None:
        self.apply(edits.remove(self.text, ("masks", mask)), f"Remove mask {mask}")

    def save_mask(self, mask: str, path: Path) -> None:
        """Write a mask as a file of its own, for other animations."""
        from engine.assets.mask_toml import write_mask

        write_mask(path, mask, self._mask(mask))

    def load_mask(self, path: Path) -> str:
        """Take a mask file's mask over; its name here."""
        from engine.assets.mask_toml import read_mask

        self.create()
        name, model = read_mask(path)
        name = edits.free_name(name, list(self.model.masks))
        self.put((("masks", name), model.model_dump(exclude_defaults=True)), label=f"Load mask {name}")
        return name

    # -- layers, states, parameters -----------------------------------------------------------------------------------

    def add_layer(
        self, clip: str, *, name: str = "", mask: str = "", mode: str = "override", weight: Any = 1.0
    ) -> None:
        """A layer over the states' pose."""
        self.create()
        text, key = self._with_clip(self.text, clip)
        value = {
            "name": edits.free_name(name or clip, [la.name for la in self.model.layers]), "clip": key,
            "mask": mask or None, "mode": mode if mode != "override" else None, "weight": weight,
        }  # fmt: skip
        self.apply(edits.append(text, ("layers",), value), f"Add layer {value['name']}")

    def set_layer(self, number: int, *, gesture: Hashable | None = None, **values: Any) -> None:
        """`name`, `clip`, `blend`, `mask`, `mode`, `weight`, `speed`, `play`, `reference`, `reference_time`."""
        self._set(("layers", number), values, f"Change layer {self.model.layers[number].name}", gesture)

    def remove_layer(self, number: int) -> None:
        self.apply(edits.remove(self.text, ("layers", number)), f"Remove layer {self.model.layers[number].name}")

    def move_layer(self, number: int, by: int) -> None:
        self.apply(edits.move(self.text, ("layers", number), by), f"Move layer {self.model.layers[number].name}")

    def add_state(
        self, name: str, clip: str = "", blend: str = "", at: Sequence[float] | None = None,
        gesture: Hashable | None = None,
    ) -> str:  # fmt: skip
        """A state that plays a clip or a blend; its name."""
        self.create()
        text = self.text
        name = edits.free_name(name, list(self.model.states))
        value: dict[str, Any] = {"at": [float(v) for v in at] if at is not None else None}
        if blend:
            value["blend"] = blend
        else:
            text, value["clip"] = self._with_clip(text, clip)
        self.apply(edits.put(text, (("states", name), value)), f"Add state {name}", gesture)
        return name

    def set_state(self, state: str, *, gesture: Hashable | None = None, **values: Any) -> None:
        """`clip` (one of the scene's), `blend`, `speed`, `mode`, `at`."""
        self._set(("states", state), values, f"Change state {state}", gesture)

    def remove_state(self, state: str) -> None:
        """With the transitions from and to it."""
        text = self.text
        for i in reversed(range(len(self.model.transitions))):
            transition = self.model.transitions[i]
            if state in (transition.source, transition.target):
                text = edits.remove(text, ("transitions", i))
        if self.model.start == state:
            text = edits.remove(text, ("start",))
        self.apply(edits.remove(text, ("states", state)), f"Remove state {state}")

    def add_transition(self, source: str, target: str, when: Sequence[str] = (), fade: float = 0.2) -> None:
        value = {"from": source, "to": target, "when": list(when), "fade": float(fade)}
        self.apply(edits.append(self.text, ("transitions",), value), f"Add transition {source} to {target}")

    def set_transition(self, number: int, *, gesture: Hashable | None = None, **values: Any) -> None:
        """`when`, `fade`, `curve`, `exit`, `sync`."""
        self.put(
            *((("transitions", number, k), v) for k, v in values.items()), label="Change transition", gesture=gesture
        )

    def remove_transition(self, number: int) -> None:
        self.apply(edits.remove(self.text, ("transitions", number)), "Remove transition")

    def add_param(self, name: str, kind: str = "float", default: Any = 0.0) -> str:
        self.create()
        name = edits.free_name(name, list(self.model.params))
        self.put((("params", name), {"type": kind, "default": default}), label=f"Add parameter {name}")
        return name

    def remove_param(self, name: str) -> None:
        """Raises FormatError where something asks for it."""
        self.apply(edits.remove(self.text, ("params", name)), f"Remove parameter {name}")

    def set_default(self, name: str, value: float | bool, gesture: Hashable | None = None) -> None:
        """What a parameter is at the start."""
        self.put((("params", name, "default"), value), label=f"Default of {name}", gesture=gesture)

    def set_param(self, name: str, value: float) -> None:
        """Steer the character now; not part of the file."""
        animation = animation_of(self.session)
        if animation is None or animation.animator is None:
            raise InputError(f"nothing is steered by {name!r}", hint="let states drive")
        animation.animator.set(name, value)
        if not self.session.playback.playing:
            self.session.seek(self.session.playback.time)

    def add_blend(
        self, name: str, params: Sequence[str], samples: Sequence[tuple[str, Sequence[float]]],
        gesture: Hashable | None = None,
    ) -> str:  # fmt: skip
        """A blend space: (clip, place) of each sample; its name."""
        self.create()
        text, made = self.text, []
        for clip, at in samples:
            text, key = self._with_clip(text, clip)
            made.append({"clip": key, "at": [float(v) for v in at]})
        name = edits.free_name(name, list(self.model.blends))
        value = {"params": list(params), "samples": made}
        self.apply(edits.put(text, (("blends", name), value)), f"Add blend {name}", gesture)
        return name

    def move_sample(self, blend: str, sample: int, at: Sequence[float], gesture: Hashable | None = None) -> None:
        self.put((("blends", blend, "samples", sample, "at"), [float(v) for v in at]), label="Move sample",
                 gesture=gesture)  # fmt: skip

    def set_sample(self, blend: str, sample: int, clip: str) -> None:
        """Let another of the scene's clips stand at a sample's place."""
        text, key = self._with_clip(self.text, clip)
        self.apply(edits.put(text, (("blends", blend, "samples", sample, "clip"), key)), f"Use {clip}")

    def add_sample(self, blend: str, clip: str, at: Sequence[float]) -> None:
        """Put one of the scene's clips into a blend space."""
        text, key = self._with_clip(self.text, clip)
        value = {"clip": key, "at": [float(v) for v in at]}
        self.apply(edits.append(text, ("blends", blend, "samples"), value), f"Add {clip}")

    def remove_sample(self, blend: str, sample: int) -> None:
        if len(self.model.blends[blend].samples) == 1:
            raise InputError(f"the last clip of {blend} stays", hint="delete the blend space")
        self.apply(edits.remove(self.text, ("blends", blend, "samples", sample)), "Remove sample")

    def remove_blend(self, blend: str) -> None:
        """Raises InputError while a state or layer shows it."""
        users = [name for name, state in self.model.states.items() if state.blend == blend]
        users += [layer.name for layer in self.model.layers if layer.blend == blend]
        if users:
            raise InputError(f"{blend} is shown by {', '.join(users)}", hint="change or delete that first")
        self.apply(edits.remove(self.text, ("blends", blend)), f"Remove blend {blend}")

    # -- inside -------------------------------------------------------------------------------------------------------

    def _document(self) -> Any:
        if self.session.document is None:
            raise InputError("no document is open")
        return self.session.document

    def _with_clip(self, text: str, clip: str) -> tuple[str, str]:
        """(the text in which the scene's clip `clip` is declared, its key there)."""
        model = self.model
        for key, use in model.clips.items():
            if (use.source or key) == clip:
                return text, key
        self._document().runtime.deck.find(clip)
        if clip in model.clips:  # the name is taken by another clip
            key = edits.free_name(clip, list(model.clips))
            return edits.put(text, (("clips", key, "source"), clip)), key
        return edits.put(text, (("clips", clip, "source"), clip)), clip

    def _set(self, place: edits.Path, values: Mapping[str, Any], label: str, gesture: Hashable | None) -> None:
        """Set several values of one thing as one edit; a clip is one of the scene's, declared where it is not yet."""
        text, wanted = self.text, dict(values)
        if wanted.get("clip"):
            text, wanted["clip"] = self._with_clip(text, wanted["clip"])
        self.apply(edits.put(text, *(((*place, k), v) for k, v in wanted.items())), label, gesture)

    def _clip_seconds(self, clip: str) -> float:
        runtime = self._document().runtime
        return float(runtime.clips[runtime.deck.find(clip)].duration)

    def _track(self, track: int) -> Any:
        model = self.model
        if model is None or not 0 <= track < len(model.tracks):
            raise InputError(f"there is no track {track}")
        return model.tracks[track]

    def _block(self, track: int, block: int) -> Any:
        blocks = self._track(track).blocks
        if not 0 <= block < len(blocks):
            raise InputError(f"track {track} has no block {block}")
        return blocks[block]

    def _mask(self, mask: str) -> Any:
        masks: Mapping[str, Any] = self.model.masks if self.model is not None else {}
        if mask not in masks:
            raise InputError(f"there is no mask {mask!r}")
        return masks[mask]
