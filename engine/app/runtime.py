"""Runtime: an open scene on a device. The editor, the player, the CLI and the tests all drive this one object."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.animation.animator import Animator
from engine.animation.morph import target_reach
from engine.animation.reach import joint_reach
from engine.animation.sample import ClipPlayer
from engine.app.animation import DRIVES, Animation, open_animation
from engine.app.clip_deck import ClipDeck, Seers
from engine.app.framing import AZIMUTH, ELEVATION, frame_points, scene_box, scene_points
from engine.app.instance_clips import InstanceClips
from engine.app.object_materials import ObjectMaterials
from engine.app.picking import pick_hits, pick_node, view_ray
from engine.app.project import shader_folders
from engine.app.rehearsal import Rehearsal
from engine.assets.clip import ClipAsset
from engine.assets.clip_nodes import ClipNodes, clip_nodes
from engine.assets.lanim import read_lanim
from engine.assets.prefab import refresh
from engine.assets.scene import NodeAsset, SceneAsset
from engine.assets.scene_json import read_scene
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.core.paths import shaders_dir
from engine.gpu.types import Device
from engine.materials.library import EffectLibrary
from engine.render.camera import Camera
from engine.render.environments import Baker
from engine.render.frame import Frame
from engine.render.renderer import Renderer
from engine.render.view import View
from engine.report.number_check import NumberReport
from engine.resources.hot_reload import HotReload
from engine.resources.residency import Residency
from engine.scene.copies import copies_of
from engine.scene.drift import DRIFT
from engine.scene.light_profiles import check_profiles
from engine.scene.scene import Scene
from engine.scene.skins import METHODS

#: what sleeps is sampled all the same every so many updates
SLEEP = 15
#: for Runtime(pixels=…): as many as a window draws
MANY_PICTURES = 1 << 40


class Runtime:
    """`scene`: the tables; `asset`: what was read; `clips`: its animation, of which it plays the first and drifting
    lights, then that of the prefabs in it (instance_clips.py); `findings`: what went wrong on the way.

    `node_rows[i]` is the scene row of the asset's node i. `pixels`: how many it will draw, about:
    MANY_PICTURES for a window; a software rasteriser prepares textures accordingly.
    """

    def __init__(self, device: Device, *, profile: bool = True, pixels: int = 0) -> None:
        self.device = device
        self._pixels = pixels
        self._profile = profile
        self._reset()

    def _reset(self, shaders: Sequence[Path] = ()) -> None:
        effects = EffectLibrary([*shaders, shaders_dir()])
        self.residency = Residency(self.device, effects, pixels=self._pixels)
        self.renderer = Renderer(self.device, self.residency, profile=self._profile)
        self.hot_reload = HotReload(self.residency, self.renderer)
        self.rehearsal = Rehearsal(self)
        self.scene = Scene()
        self.objects = ObjectMaterials(self.scene, self.residency)
        self.asset = SceneAsset("empty")
        self.path: Path | None = None
        self.node_rows: NDArray[np.int64] = np.zeros(0, np.int64)
        self.clips: list[ClipAsset] = []
        self.players: list[ClipPlayer] = []
        self.deck = ClipDeck(self.scene.nodes, self.clips, self.players)
        #: clips made since the scene was opened, by whoever made them: they play beside what the deck plays
        self.beside: dict[Hashable, tuple[ClipAsset, ClipPlayer]] = {}
        self.animation: Animation | None = None
        #: leave out sampling what nobody saw in the last picture; for windows: pictures of a sequence must not depend
        #: on those before
        self.sleepy = False
        self._seers: tuple[tuple[int, ...], Seers] | None = None
        self._updates = 0
        self.findings = Findings()
        self._posed_at = math.nan
        self._lead: ClipNodes | None = None
        #: the nodes that clips know by number, those of the asset first, and their rows as they were when they came
        self.cast: list[NodeAsset] = []
        self.cast_rows: NDArray[np.int64] = np.zeros(0, np.int64)
        #: how many of the clips are not those of prefabs
        self.own_clips = 0
        self.instance_clips = InstanceClips(self)
        self._copied_rev = -1

    # --- opening ---

    def open(
        self, path: Path, *, baker: Baker | None = None, root: Path | None = None, base: Path | None = None
    ) -> None:
        """Open a `*.scene.json`. Raises FormatError and leaves what was open as it is; missing parts are findings.

        `baker` gives the baked file of an environment image or sky (importers.opening has one). `root`: the folder of
        the project that it belongs to, whose effects and shaders go before the built-in ones. `base`: a file with
        the scene as it once was, to be opened in its place and with its neighbours; its instances stay as they are."""
        notes = Findings(str(path))
        asset = read_scene(base) if base else refresh(read_scene(path), path.parent, notes, (path.absolute(),))
        self.load(asset, path.parent, path, baker=baker, shaders=shader_folders(root or path.parent))
        self.findings.items.extend(notes.items)

    def load(
        self, asset: SceneAsset, base: Path, path: Path | None = None, *, baker: Baker | None = None,
        shaders: Sequence[Path] = (),
    ) -> None:  # fmt: skip
        """Open a scene from memory; its files are relative to `base`. `shaders`: folders with effects and shaders that
        go before the built-in ones."""
        self.close()
        self._reset(shaders)
        self.renderer.environments.baker = baker
        self.asset, self.path = asset, path
        self.findings.file = str(path or asset.name)
        self.scene = Scene.from_asset(asset)
        self.scene.folder = base
        self.node_rows = self.scene.row_of_node
        self.cast, self.cast_rows = list(asset.nodes), self.node_rows.copy()
        self._lead = clip_nodes(asset.nodes)
        self.findings.items.extend(self.scene.findings)
        check_profiles(self.scene.lights.profiles, base, self.findings)
        self._add_instances(asset, base)
        self.objects = ObjectMaterials(self.scene, self.residency)
        self.objects.load(self.findings)
        for name in asset.clips:
            try:
                clip = read_lanim(base / name)
                clip = clip if self._lead is None else self._lead.bind(clip)
                player = ClipPlayer(clip, self.node_rows)
                self.findings.items.extend(player.findings)
                self.players.append(player)
                self.clips.append(clip)
            except InputError as error:
                self.findings.error("clip.unreadable", str(error), hint="the scene is shown without it")
        self.deck = ClipDeck(self.scene.nodes, self.clips, self.players, self.scene.morphs, self.node_rows)
        self.scene.places = self.deck.places
        self.own_clips = len(self.clips)
        self.deck.active = self._at_first()
        self.instance_clips.follow()
        if asset.animation:
            try:
                self._animate(base / asset.animation, asset.drive)
            except InputError as error:
                self.findings.error("animation.unreadable", str(error), hint="the clips are played without it")
        self.scene.update()

    def _animate(self, path: Path, drive: str) -> None:
        try:
            self.animate(path, drive)
        except InputError:
            if not drive:
                raise
            self.animate(path)
            self.findings.warn("animation.drive", f"{path.name} has no {drive}", "drive", f"posed by its {self.drive}")

    def _add_instances(self, asset: SceneAsset, base: Path) -> None:
        """One instance row per node x submesh, with materials by slot."""
        files: dict[str, list[int]] = {}
        for node in asset.nodes:
            if node.mesh is not None and node.mesh.file not in files:
                try:
                    files[node.mesh.file] = self.residency.load_mesh_file(base / node.mesh.file)
                except InputError as error:
                    self.findings.error("mesh.unreadable", str(error), hint="convert the source again")
                    files[node.mesh.file] = []
        names = dict.fromkeys(m for node in asset.nodes if node.mesh for m in node.mesh.materials if m)
        ids = dict(zip(names, self.residency.load_materials([base / m for m in names]), strict=True))
        rows: list[tuple[int, int, int, int]] = []
        for i, node in enumerate(asset.nodes):
            if node.mesh is None or not files[node.mesh.file]:
                continue
            meshes = files[node.mesh.file]
            if not 0 <= node.mesh.index < len(meshes):
                self.findings.error(
                    "mesh.index",
                    f"mesh {node.mesh.index} of {node.mesh.file}, which has {len(meshes)}",
                    f"nodes[{i}].mesh",
                )
                continue
            mesh = meshes[node.mesh.index]
            for s, part in enumerate(self.residency.meshes[mesh].asset.submeshes):
                slot = part.material_slot
                name = node.mesh.materials[slot] if 0 <= slot < len(node.mesh.materials) else ""
                rows.append((int(self.node_rows[i]), mesh, s, ids[name] if name else self.residency.default_material))
        self.add_instances(rows)
        self._add_skins(asset, files)
        self._add_morphs(asset, files)
        for finding in self.residency.findings:
            self.findings.items.append(finding)

    def add_nodes(self, nodes: list[NodeAsset], base: Path, parent: int = -1) -> NDArray[np.int64]:
        """Add nodes to the open scene, with all that hangs on them; returns their rows. Parents and joints are numbers
        in `nodes`, files relative to `base`; a node without a parent hangs below the row `parent`."""
        scene = self.scene
        rows = scene.nodes.add_many(
            [n.name for n in nodes],
            [parent if n.parent < 0 else -1 for n in nodes],
            np.array([n.translation for n in nodes], np.float64),
            np.array([n.rotation for n in nodes], np.float64),
            np.array([n.scale for n in nodes], np.float64),
            batch_parents=[n.parent for n in nodes],
        )
        for node, row in zip(nodes, rows.tolist(), strict=True):
            scene.sources[row] = node
            if node.matrix is not None:
                scene.nodes.set_matrix(row, np.array(node.matrix, np.float64).reshape(4, 4).T)
            if node.light is not None:
                scene.lights.add(row, node.light)
            if node.camera is not None:
                scene.cameras.add(row, node.camera)
        scene.nodes.set_visible(rows, [n.visible for n in nodes])
        kept, known = self.node_rows, len(self.findings.items)
        self.node_rows = rows
        try:
            self._add_instances(SceneAsset("", nodes), base)
        finally:
            self.node_rows = kept
        self.findings.items[known:] = [f for f in self.findings.items[known:] if f not in self.findings.items[:known]]
        scene.update()
        return rows

    def _add_skins(self, asset: SceneAsset, files: dict[str, list[int]]) -> None:
        reach: dict[int, NDArray[np.float64]] = {}
        for i, node in enumerate(asset.nodes):
            if node.mesh is None or not node.joints or not 0 <= node.mesh.index < len(files[node.mesh.file]):
                continue
            mesh_id = files[node.mesh.file][node.mesh.index]
            mesh = self.residency.meshes[mesh_id].asset
            if mesh.skeleton is None or len(mesh.skeleton.names) != len(node.joints):
                bones = 0 if mesh.skeleton is None else len(mesh.skeleton.names)
                self.findings.error(
                    "skin.joints", f"{len(node.joints)} joints for a mesh with {bones} bones", f"nodes[{i}].joints",
                    "it stays rigid; convert the source again",
                )  # fmt: skip
                continue
            if mesh_id not in reach:
                names = [n for n in ("joints", "joints1") if n in mesh.streams]
                joints = np.concatenate([mesh.streams[n] for n in names], axis=1)
                weights = np.concatenate([mesh.streams[n.replace("joints", "weights")] for n in names], axis=1)
                reach[mesh_id] = joint_reach(mesh.streams["position"], joints, weights, mesh.skeleton.inverse_bind)
            rows = self.node_rows[np.array(node.joints)]
            bind = node.extras.get("skin_bind_world")
            bind_world = np.array(bind, np.float64).reshape(4, 4).T if isinstance(bind, (list, tuple)) else None
            node_row = int(self.node_rows[i])
            skin = self.scene.skins.add(node_row, rows, mesh.skeleton.inverse_bind, reach[mesh_id], bind_world)
            method = node.extras.get("skinning", mesh.extras.get("skinning", "linear"))
            if method in METHODS:
                self.scene.skins.set_method(skin, str(method))

    def _add_morphs(self, asset: SceneAsset, files: dict[str, list[int]]) -> None:
        for i, node in enumerate(asset.nodes):
            if node.mesh is None or not 0 <= node.mesh.index < len(files[node.mesh.file]):
                continue
            targets = self.residency.meshes[files[node.mesh.file][node.mesh.index]].asset.morphs
            if targets:
                names = [t.name or f"target {k}" for k, t in enumerate(targets)]
                self.scene.morphs.add(int(self.node_rows[i]), names, target_reach(targets), node.weights)

    def add_instances(self, rows: list[tuple[int, int, int, int]]) -> NDArray[np.int64]:
        """Add drawables (node row, mesh id, submesh, material id); returns their instance rows."""
        if not rows:
            return np.zeros(0, np.int64)
        table = np.array(rows, np.int32)
        bounds = np.array([self.residency.meshes[mesh].bounds[submesh] for _, mesh, submesh, _ in rows])
        return self.scene.instances.add_many(
            table[:, 0], table[:, 1], table[:, 2], table[:, 3], bounds[:, :3], bounds[:, 3].astype(np.float32)
        )

    # --- time ---

    @property
    def duration(self) -> float:
        """Seconds of the longest clip that plays; 0 where none does."""
        others = [player.duration for _clip, player in self.beside.values()]
        return max([self.deck.duration, self.instance_clips.duration, *others])

    def play(self, *clips: int | str, mode: str = "loop", speed: float = 1.0) -> None:
        """Play these clips (numbers or names) instead; see ClipDeck.play. A scene opens playing its first."""
        self.follow_structure()  # what played so far goes to rest, copies too
        self.instance_clips.hush()
        self.deck.play(*clips, mode=mode, speed=speed)
        self._posed_at = math.nan

    def play_beside(self, key: Hashable, clip: ClipAsset | None) -> None:
        """Play a clip whose channels count nodes by scene rows, beside all else, until it is None for that `key`."""
        self.beside.pop(key, None)
        if clip is not None:
            self.beside[key] = (clip, ClipPlayer(clip, np.arange(len(self.scene.nodes))))
        self._posed_at = math.nan

    def animate(self, path: Path, drive: str = "") -> Animator | None:
        """Let an animation file (`*.animation.toml`) pose the scene, and return the animator of its states.

        Raises InputError and FormatError with file:line:column; then what played goes on.
        """
        try:
            text = path.read_text("utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"cannot read {path}: {error}") from error
        animation = self.set_animation(text, str(path), drive=drive)
        self.findings.items.extend(animation.findings)
        return animation.animator

    def set_animation(self, text: str, file: str = "animation", *, drive: str = "") -> Animation:
        """Let the animation that `text` describes pose the scene: what it was before goes on where it is.

        `drive`: `timeline`, `states` or `clips` (the animation stands by). Raises FormatError with file:line:column;
        then what played goes on.
        """
        standing_by = drive == "clips"
        animation = open_animation(text, file, self.cast, self.clips, self.animation, "" if standing_by else drive)
        self.animation = animation
        if not standing_by:
            self.set_drive(animation.drive)
        return animation

    def set_drive(self, drive: str) -> None:
        """What poses the scene: `clips`, or the open animation's `timeline` or `states`. Raises InputError for what it
        has not."""
        animation = self.animation
        if drive not in DRIVES or (drive != "clips" and animation is None):
            raise InputError(f"nothing here is driven by {drive!r}", hint=f"choose one of {', '.join(DRIVES)}")
        self._posed_at = math.nan
        self.follow_structure()
        if drive == "clips" or animation is None:
            if self.deck.animator is not None or self.deck.sequence is not None:
                self.deck.play(*self._at_first())
            return
        self.instance_clips.hush()
        rows = self.cast_rows[animation.rig.source][None]
        top = int(self.cast_rows[animation.top]) if animation.top >= 0 else -1
        if drive == "timeline" and animation.sequence is not None:
            self.deck.follow(animation.sequence, rows, top)
        elif drive == "states" and animation.animator is not None:
            self.deck.animate(animation.animator, rows, top)
        else:
            raise InputError(f"{animation.file} has no {drive}", hint="timeline needs [[tracks]], states [states.NAME]")
        self.deck.active = self.instance_clips.beside(self.deck.posed)
        animation.drive = drive

    def _at_first(self) -> list[int]:
        """The clips that a scene opens playing."""
        own = [i for i in range(self.own_clips) if i == 0 or self.clips[i].name == DRIFT]
        return own + self.instance_clips.beside(np.zeros(0, np.int64))

    @property
    def drive(self) -> str:
        """`clips`, `timeline` or `states`."""
        if self.deck.sequence is not None:
            return "timeline"
        return "states" if self.deck.animator is not None else "clips"

    def pose_again(self) -> None:
        """Pose at the next update even where time stands."""
        self._posed_at = math.nan

    def seek(self, time_s: float) -> None:
        """Pose the scene at `time_s` without passing what lies between; that far into its state where states drive."""
        if self.deck.animator is not None:
            self.follow_structure()
            self.deck.animator.seek(time_s)
            self._pose(self.deck.time)
            self.scene.update()
        else:
            self.update(time_s)

    def update(self, time_s: float = 0.0) -> None:
        """Pose the scene at `time_s` and bring the world transforms up to date.

        An unchanged time poses nothing, so what was moved by hand stays moved until time goes on.
        """
        self.follow_structure()
        if time_s != self._posed_at:
            self._posed_at = time_s
            self._pose(time_s, *self._seen())
        self.scene.update()

    def _pose(self, time_s: float, visible: NDArray[np.bool_] | None = None, seers: Seers | None = None) -> None:
        self.instance_clips.pose(time_s * self.deck.speed, visible, seers)
        self.deck.apply(time_s, visible, seers)
        for _clip, player in self.beside.values():
            player.apply(self.scene.nodes, time_s * self.deck.speed, self.deck.mode)

    def follow_structure(self) -> None:
        """After structural changes: which nodes play along with which, and what instances bring with them. Whatever
        poses the scene does so by itself."""
        if self._copied_rev != self.scene.nodes.structure_rev:
            self._copied_rev = self.scene.nodes.structure_rev
            self.instance_clips.follow()
            self.deck.copies = copies_of(self.scene, self._lead, self.cast_rows).and_(self.instance_clips.copies)

    def _seen(self) -> tuple[NDArray[np.bool_] | None, Seers | None]:
        """What the last picture showed; now and then nothing, so that what walks into view by its clip is found."""
        self._updates += 1
        if not self.sleepy or self._updates % SLEEP == 0:
            return None, None
        scene = self.scene
        key = (scene.structure_rev, len(scene.nodes))
        if self._seers is None or self._seers[0] != key:
            skins = scene.skins
            ends = skins.first + skins.count
            joints = [(int(n), skins.joint[a:b]) for n, a, b in zip(skins.node, skins.first, ends, strict=True)]
            self._seers = (key, Seers(scene.nodes.parent, scene.instances.node, joints))
        return self.renderer.seen, self._seers[1]

    # --- looking ---

    def default_camera(self, aspect: float) -> Camera:
        """The scene's own camera if it names one, else one that frames everything."""
        node = self.asset.active_camera
        if 0 <= node < len(self.asset.nodes):
            camera = self.asset.nodes[node].camera
            if camera is not None:
                return Camera.from_asset(camera, self.scene.nodes.world_matrix(int(self.node_rows[node])))
        return self.framing_camera(aspect)

    def framing_camera(self, aspect: float, azimuth: float = AZIMUTH, elevation: float = ELEVATION) -> Camera:
        """A camera that sees everything drawn from that direction (degrees)."""
        points = scene_points(self.scene, self.residency)
        return frame_points(points, aspect, azimuth=azimuth, elevation=elevation)

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The box (min, max: f8[3], world) of everything drawn; infinite and empty when nothing is."""
        return scene_box(self.scene, self.residency)

    def render(self, view: View, *, hdr: bool = False) -> Frame:
        """One picture; its counters also say how many animations the last update posed, and how many were asleep."""
        fresh = self.hot_reload.unproven
        frame = self._proven(view, hdr) if fresh else self.renderer.render(self.scene, view, hdr=hdr)
        frame.stats.counters |= {"animations": self.deck.playing, "animations_asleep": self.deck.asleep}
        return frame

    def follow(self, view: View, patience: float) -> Frame | None:
        """As `render`, for windows: None while shader programs are made, for about `patience` seconds a call."""
        if self.hot_reload.unproven:
            return self.render(view)
        frame = self.renderer.follow(self.scene, view, patience)
        if frame is not None:
            frame.stats.counters |= {"animations": self.deck.playing, "animations_asleep": self.deck.asleep}
        return frame

    def _proven(self, view: View, hdr: bool) -> Frame:
        """The first picture after edited shaders came in: by those, or by the last good ones if they write NaN."""
        wanted = view.settings.wants_numbers
        settings = type(view.settings)(**{**view.settings.values(), "check_numbers": True})
        # pictures that nobody sees take no time: nothing adapts to them
        checked = replace(view, settings=settings, seconds=None if view.seconds is None else 0.0)
        first_bad = self.renderer.first_bad
        drawn: list[Frame] = []

        def draw() -> NumberReport | None:
            drawn.append(self.renderer.render(self.scene, checked, hdr=hdr))
            return drawn[-1].numbers

        stands = self.hot_reload.prove(draw)
        if not wanted:
            self.renderer.first_bad = first_bad
        if not stands:
            return self.renderer.render(self.scene, view, hdr=hdr)
        return drawn[-1] if wanted else replace(drawn[-1], numbers=None)

    def pick(self, view: View, x: float, y: float) -> int:
        """The node row seen at pixel (x, y) from the top left, or -1."""
        return pick_node(self.scene, self.residency, view, x, y)

    def pick_hits(self, view: View, x: float, y: float) -> list[tuple[int, NDArray[np.float64]]]:
        """Every node under pixel (x, y) with the point f8[3] (world) where it is hit, the nearest first."""
        origin, direction = view_ray(view, x, y)
        hits = pick_hits(self.scene, self.residency, view, x, y)
        return [(node, origin + direction * distance) for distance, node in hits]

    def close(self) -> None:
        """Free everything on the device."""
        self.rehearsal.release()
        self.renderer.release()
        self.residency.effects.release()
        self.residency.release()
