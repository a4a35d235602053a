"""Work that may crash, hang or eat memory, done in a process of its own. May import engine.assets, engine.core.

    runner   run_in_worker(task, request) -> WorkerResult, or a FormatError that says what became of it
    child    the worker's side: limits, the task, the result file

    request (JSON) ─> python -m importers.workers.child ─> task(request) -> (JSON, arrays) ─> result file ─> runner

One task per process: native parsers are not trusted to survive a second file. Nothing is pickled.
"""
