"""Work that may crash, hang or eat memory, done in a process of its own. May import engine.assets, engine.core.

    process  limits, environment and words that both ways share      limits  what a worker sets on itself
    runner   run_in_worker(task, request) -> arrays: one process per file, for bindings that survive only one
    child    its other side; in warm workers on Linux a fork server makes such processes (forker, forkserver)
    pool     WorkerPool.run(task, request) -> JSON: warm processes, replaced when they crash, hang, grow or get old
    server   its other side

    request (JSON) ─> python -m importers.workers.child ─> task(request) -> (JSON, arrays) ─> result file ─> runner
    requests (JSON lines) ─> python -m importers.workers.server ─> task(request, progress) -> JSON lines ─> pool

Either way what goes wrong is a FormatError that names the file and says what became of the worker. Nothing is pickled.
It is the same on every system but for what limits.py says of Windows, and for the time that forking saves on Linux.
"""
