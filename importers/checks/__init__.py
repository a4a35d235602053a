"""What `lucarna check` finds in files of any kind. May import the importers' readers and the engine; imports no GPU.

files         any file that we know -> findings; our own files' references are followed
scene, mesh   numeric trouble: transforms, lights, depth range; weights, attributes, far origins
topology      non-manifold edges, boundaries, flipped neighbours
light_inside  lights that stand inside of solids
budgets       triangles, bones, texture bytes … against limits of a project or a call
sarif         findings as SARIF 2.1.0

file -> importers.contents / engine.assets -> rules -> Findings -> text, JSON, SARIF (importers/cli/check.py)
"""
