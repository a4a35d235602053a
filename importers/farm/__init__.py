"""The farm: many sources at once, each in a worker process, and nothing done twice. May import importers, the engine.

    plan      files, folders, globs -> jobs (source, output folder, name)     job      Job, Outcome
    record    what a conversion was made of; reasons why it is out of date    trace    which files an import looked at
    task      one import, the worker's side: key, cache, or the work itself   publish  cache entry -> output folder
    run       jobs -> outcomes, by a pool of workers                          cluster  the same by a Dask cluster
    watch     again whenever something changes                                progress a line of a terminal
    single    one source, wanted now (render, play, the editor)               clean    outputs of sources that are gone

    plan ─> jobs ─> record: up to date? ── yes ─> nothing
                        │ no, because …
                        └─> pool ─> task: key ─> cache ── there ──────────────┐
                                           └─ load, stage, rename into cache ─┴─> publish ─> record

What is up to date is decided by the bytes of the source, of every dependency and of every file that the import opened
besides, by the names in the folders that it listed, the settings, the importer's and the writer's versions, and by the
outputs themselves. Time stamps of sources are not looked at.

The record of `DIR/fox.scene.json` is `DIR/.lucarna/fox.json`. It is written last: a run that is killed at any moment
leaves whole files alone, and the next one finds what is missing by it. Nothing here imports numpy: a run in which all
is up to date costs the hashing of its sources and little else.
"""
