"""A frame as a graph of passes: declare, compile once per key, execute. Imports gpu, core (and the formats' sizes).

    resources.py  TextureSpec: format and size of a resource, relative to the view
    passes.py     Pass (needs, declare, execute), PassContext
    builder.py    Builder: what a pass may say about its resources; mistakes are collected
    planning.py   pure functions: reachability, lifetimes, aliasing
    pool.py       TransientPool, HistoryStore: the textures, kept between frames
    compiled.py   CompiledGraph: the passes that run, their textures
    graph.py      FrameGraph: the cache of compiled graphs
    dump.py       text drawing of a compiled graph (may be a golden file)
    explain.py    the lines of --explain

    passes, facts --needs--> declared --reachability--> kept --lifetimes--> aliased textures --> execute
                    |                       |
                    +----- left out, with the reason and what it saved

The rules:
- Passes run in the order in which they are given. A resource has versions: each write makes a new one, a read sees the
  last one written before it. So write-after-read needs no barrier and no sorting.
- `create` gives a texture with undefined content (it may be an alias of a dead one): the creating pass must write every
  texel, or clear. Nothing is cleared implicitly.
- A write keeps what was there (blending, loading), so it needs the version before it.
- A pass stays when a presented resource, a side effect, or an imported texture depends on it.
- The graph begins no GPU render passes; `execute` does, with `ctx.device.render_pass`.
"""
