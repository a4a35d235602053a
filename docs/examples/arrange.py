"""Put copies of a node in a row and light them: lucarna run docs/examples/arrange.py SCENE NODE OUT.scene.json"""

# ruff: noqa: F821  (the names that are not defined here are those of scripts, see docs/scripting.md)
import sys

if len(sys.argv) != 4:
    sys.exit("usage: lucarna run arrange.py SCENE NODE OUT.scene.json")
source, name, out = sys.argv[1:]

open_file(source)
select(name)
for _ in range(4):
    run("edit.duplicate")
    run("edit.move-by", offset=(1.5, 0.0, 0.0))
run("select.matching", pattern=f"{name}*")
run("edit.group")
run("edit.rename-to", name="row")
run("add.directional-light")
save(out)
print(f"{len(scene().nodes.name)} nodes in {out}")
