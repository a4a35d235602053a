"""Lucarna's render engine. Packages import downwards only (the contract is in pyproject.toml):

app | experiments                project, loop, headless render | error-against-time experiments
render                           a frame = views + passes
simulation | animation
resources                        asset -> GPU residency
materials                        effects -> programs + state + parameter rows
framegraph                       declare / compile / execute
gpu | scene                      these two never see each other
assets                           our own file formats
math | report                    numpy kernels | timers, counters, image metrics
core                             errors with a place, parameters, paths, atomic files
"""

__version__ = "0.1.0"
