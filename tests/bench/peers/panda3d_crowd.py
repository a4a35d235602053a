"""Panda3D's part of the bench `characters`: a script of its own, run by an interpreter that has panda3d.

    python panda3d_crowd.py FILE.json COUNT … -> one JSON line a count: {"count", "ms": […], "joints": [[x, y, z] …]}

FILE.json: {"fps", "parent" [n], "clips": [[joint][frame] of 3 translations, 4 rotation xyzw]}. Each character is one
Actor with both clips looping at its own phase and rate, blended half and half: quaternions component by component,
with interpolation between frames, as Lucarna blends. A frame is what the clock and PartBundle.force_update take, which
samples, blends, and updates the joints' net transforms and skinning matrices; nothing is drawn.
"""

import json
import math
import sys
import time
from array import array
from pathlib import Path

import panda3d.core as p
from direct.actor.Actor import Actor

FRAMES = 25


def table(channel, name, values):
    channel.set_table(name, p.CPTA_stdfloat(p.PTA_stdfloat(array("f", values))))


def clip(data, number, firsts):
    # clips are bound to joints by walking both, so that siblings have to be in the order of their names
    frames = len(data["clips"][number][0])
    bundle = p.AnimBundle("body", data["fps"][number], frames)
    above = [p.AnimGroup(bundle, "<skeleton>")]
    for joint, parent in enumerate(data["parent"]):
        keys = data["clips"][number][joint]
        made = p.AnimChannelMatrixXfmTable(above[parent + 1], f"joint {joint:03}")
        for i, axis in enumerate("xyz"):
            table(made, axis, [k[i] for k in keys])
        angles = []
        for k in keys:
            hpr = p.LQuaternionf(k[6], k[3], k[4], k[5]).get_hpr()
            # turns of 360 degrees change a quaternion's sign, which Panda's blend heeds: no jumps, nor between clips
            before = angles[-1] if angles else firsts.setdefault(joint, list(hpr))
            angles.append([unrolled(a, b) for a, b in zip(hpr, before, strict=True)])
        for i, axis in enumerate("hpr"):
            table(made, axis, [a[i] for a in angles])
        above.append(made)
    return bundle


def unrolled(angle, before):
    return angle + 360.0 * round((before - angle) / 360.0)


def character(data):
    made = p.Character("body")
    bundle = made.get_bundle(0)
    parts = [p.PartGroup(bundle, "<skeleton>")]
    for joint, parent in enumerate(data["parent"]):
        parts.append(p.CharacterJoint(made, bundle, parts[parent + 1], f"joint {joint:03}", p.LMatrix4.ident_mat()))
    return made


def crowd(data, count):
    firsts = {}
    anims = [p.AnimBundleNode(f"clip {i}", clip(data, i, firsts)) for i in range(len(data["clips"]))]
    bundles, kept = [], []
    for i in range(count):
        model = p.NodePath(p.ModelRoot("model"))
        model.attach_new_node(character(data))
        actor = Actor(model, {f"clip {k}": p.NodePath(node) for k, node in enumerate(anims)}, copy=False)
        actor.set_blend(animBlend=True, frameBlend=True, blendType=p.PartBundle.BT_componentwise_quat)
        for k in range(len(anims)):
            name = f"clip {k}"
            actor.set_control_effect(name, 1.0 / len(anims))
            control = actor.get_anim_control(name)
            control.set_play_rate(1.0 + 0.003 * (i % 100))
            control.loop(True)
        bundles.append(actor.get_part_bundle("modelRoot"))
        kept.append(actor)
    return bundles, kept


def main():
    data = json.loads(Path(sys.argv[1]).read_text("utf-8"))
    clock = p.ClockObject.get_global_clock()
    clock.mode = p.ClockObject.M_non_real_time
    clock.dt = 1.0 / 60.0
    for count in map(int, sys.argv[2:]):
        bundles, actors = crowd(data, count)
        taken = []
        for frame in range(FRAMES + 5):
            start = time.perf_counter()
            clock.tick()
            for bundle in bundles:
                bundle.force_update()
            if frame >= 5:
                taken.append((time.perf_counter() - start) * 1e3)
        for k in range(len(data["clips"])):
            actors[0].get_anim_control(f"clip {k}").pose(0)
        bundles[0].force_update()
        joints = []
        for joint in range(len(data["parent"])):
            matrix = p.LMatrix4()
            bundles[0].find_child(f"joint {joint:03}").get_net_transform(matrix)
            joints.append([round(v, 5) for v in matrix.get_row3(3)])
        print(json.dumps({"count": count, "ms": taken, "joints": joints, "version": p.PandaSystem.version_string}))
        assert all(math.isfinite(t) for t in taken)


if __name__ == "__main__":
    main()
