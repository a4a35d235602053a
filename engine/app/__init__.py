"""What a program made with the engine is: a project, a running scene, a picture. May import everything in the engine.

    project.py           a folder with project.toml, made from project_template/
    sample_project.py    the same around a scene that code makes (atrium, poles)
    runtime.py           an opened scene: tables + residency + renderer + clips
    clip_deck.py         what poses it: clips, a timeline, or states; animation.py: an open *.animation.toml
    instance_clips.py    clips of prefabs on the instances that stand in it; instance_animation.py: their blends
    object_materials.py  parameters of materials that are other on one object
    rehearsal.py         programs of other paths and views, made while nothing else is to do
    posed.py             vertices as they are drawn, on the CPU
    headless.py          a runtime rendered into an array, no window
    look_card.py         a grey and a chrome ball and a colour chart under an open scene's surroundings
    feature_pixels.py    which features of shader variants never change a pixel of a scene
    doctor.py            what this machine has and lacks
    system_libraries.py  the shared libraries of the system; standard library only, also read by packaging/

    project.toml ──> load_project ──> start: Path ──> (importers.cache) ──> Runtime.open ──> render ──> array | window

The command line, the editor and the player call the same functions. Nothing is imported here: `import engine.app`
costs nothing.
"""
