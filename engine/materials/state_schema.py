"""The words of state in effect files: depth, stencil, blend, targets, raster; and of samplers (pydantic models).

    [states.marked]                       a named group; `states = ["marked"]` in a technique, level or pass
    depth   = { test, write, compare, bias, bias_slope }
    stencil = { test, reference, read_mask, write_mask, compare, fail, depth_fail, pass, front = {…}, back = {…} }
    blend   = "opaque" | "alpha" | "premultiplied" | "additive" | "multiply"
            | { src, dst, op, src_alpha, dst_alpha, op_alpha }
    blend_constant = [r, g, b, a]         of the factors `constant`, `one_minus_constant`, `constant_alpha` …
    write_mask = "rgba"                   channels that are written, of every target
    raster  = { cull, front, fill, depth_clamp, alpha_to_coverage, sample_mask, scissor = [x, y, width, height] }
    targets.gbuffer0 = { blend, write_mask }   of one target, by its name (roles.py) or number

    [samplers.detail]                     `sampler = "detail"` in a texture slot: where the material says nothing else
    min_filter, mag_filter, anisotropy, wrap (all axes), wrap_u, wrap_v, wrap_w, border = [r, g, b, a] or "#rrggbbaa",
    compare, lod_bias, lod_min, lod_max

`compare` of stencil: never less equal lequal greater notequal gequal always; what becomes of the stored value: keep
zero replace increment decrement invert increment_wrap decrement_wrap. Reversed depth: gequal is nearer or equal. `bias`
counts smallest steps of depth, `bias_slope` the surface's slope; positive is nearer. `scissor` is in parts of the
picture.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Discriminator, Field, FiniteFloat, Tag

from engine.core.color_text import parse_color
from engine.gpu.types import BlendState, DepthState, RasterState, SamplerDesc, StencilFace, StencilState

Compare = Literal["never", "less", "equal", "lequal", "greater", "notequal", "gequal", "always"]
StencilOp = Literal[
    "keep", "zero", "replace", "increment", "decrement", "invert", "increment_wrap", "decrement_wrap"
]  # fmt: skip
BlendWord = Literal["opaque", "alpha", "premultiplied", "additive", "multiply"]
Factor = Literal[
    "zero", "one", "src_alpha", "one_minus_src_alpha", "dst_alpha", "one_minus_dst_alpha", "src_color",
    "one_minus_src_color", "dst_color", "one_minus_dst_color", "src_alpha_saturate", "constant", "one_minus_constant",
    "constant_alpha", "one_minus_constant_alpha",
]  # fmt: skip
BlendOp = Literal["add", "subtract", "reverse_subtract", "min", "max"]
Wrap = Literal["repeat", "mirror", "clamp", "border", "mirror_once"]
MinFilter = Literal[
    "nearest", "linear", "nearest_mip_nearest", "linear_mip_nearest", "nearest_mip_linear", "linear_mip_linear"
]  # fmt: skip
Part = Annotated[float, Field(ge=0.0, le=1.0)]

#: tags that pydantic puts into the place of an error in `blend`; no key looks like them
TAGS = ("(word)", "(table)")


class Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class DepthModel(Table):
    test: bool = True
    write: bool = True
    compare: Compare = "gequal"
    bias: float = 0.0
    bias_slope: float = 0.0


class StencilFaceModel(Table):
    compare: Compare = "always"
    fail: StencilOp = "keep"
    depth_fail: StencilOp = "keep"
    passed: StencilOp = Field("keep", alias="pass")


class StencilModel(StencilFaceModel):
    test: bool = True
    reference: int = Field(0, ge=0, le=255)
    read_mask: int = Field(255, ge=0, le=255)
    write_mask: int = Field(255, ge=0, le=255)
    front: StencilFaceModel = StencilFaceModel()
    back: StencilFaceModel = StencilFaceModel()


class BlendModel(Table):
    src: Factor = "one"
    dst: Factor = "zero"
    op: BlendOp = "add"
    src_alpha: Factor | None = None
    dst_alpha: Factor | None = None
    op_alpha: BlendOp | None = None


Blend = Annotated[
    Annotated[BlendWord, Tag("(word)")] | Annotated[BlendModel, Tag("(table)")],
    Discriminator(lambda value: "(table)" if isinstance(value, (dict, BlendModel)) else "(word)"),
]
Mask = Annotated[str, Field(pattern=r"^r?g?b?a?$")]


class TargetModel(Table):
    blend: Blend | None = None
    write_mask: Mask | None = None


class RasterModel(Table):
    cull: Literal["none", "back", "front"] = "back"
    front: Literal["ccw", "cw"] = "ccw"
    fill: Literal["solid", "wireframe"] = "solid"
    depth_clamp: bool = False
    alpha_to_coverage: bool = False
    sample_mask: int = Field(0xFFFFFFFF, ge=0, le=0xFFFFFFFF)
    scissor: list[Part] | None = Field(None, min_length=4, max_length=4)


class StateModel(Table):
    """What a state group, a technique, a level and a pass may say of state."""

    depth: DepthModel = DepthModel()
    stencil: StencilModel = StencilModel(test=False)
    blend: Blend = "opaque"
    blend_constant: list[FiniteFloat] = Field([0.0, 0.0, 0.0, 0.0], min_length=4, max_length=4)
    write_mask: Mask = "rgba"
    raster: RasterModel = RasterModel()
    targets: dict[str, TargetModel] = Field(default_factory=dict)


class SamplerModel(Table):
    min_filter: MinFilter = "linear_mip_linear"
    mag_filter: Literal["nearest", "linear"] = "linear"
    anisotropy: float = Field(0.0, ge=0.0, le=16.0)
    wrap: Wrap | None = None
    wrap_u: Wrap | None = None
    wrap_v: Wrap | None = None
    wrap_w: Wrap | None = None
    border: Any = (0.0, 0.0, 0.0, 0.0)
    compare: Compare | Literal[""] = ""
    lod_bias: float = Field(0.0, ge=-16.0, le=16.0)
    lod_min: float = Field(-1000.0, ge=-1000.0, le=1000.0)
    lod_max: float = Field(1000.0, ge=-1000.0, le=1000.0)

    def to_desc(self) -> SamplerDesc:
        """Anisotropy 0: as the view's setting says (kept as 0 here). Raises UsageError for a border that is no
        colour."""
        wraps = [mine or self.wrap or "repeat" for mine in (self.wrap_u, self.wrap_v)]
        border = parse_color("border", self.border, 4)
        return SamplerDesc(
            wraps[0], wraps[1], self.wrap_w or self.wrap or "clamp", self.min_filter, self.mag_filter, self.anisotropy,
            self.compare, (border[0], border[1], border[2], border[3]), self.lod_bias, self.lod_min, self.lod_max,
        )  # fmt: skip


def combined(models: Sequence[Table]) -> StateModel:
    """State groups over each other, key by key: later ones win where they say something."""
    data: dict[str, Any] = {}
    for model in models:
        given = model.model_dump(exclude_unset=True, by_alias=True)
        data = _over(data, {key: value for key, value in given.items() if key in StateModel.model_fields})
    return StateModel.model_validate(data)


def _over(base: dict[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    result = dict(base)
    for key, value in over.items():
        old = result.get(key)
        result[key] = _over(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
    return result


def depth_state(model: DepthModel) -> DepthState:
    return DepthState(model.test, model.write, model.compare, model.bias, model.bias_slope)


def stencil_state(model: StateModel) -> StencilState | None:
    """None where nothing was said of stencil. Words beside `front` and `back` are for both."""
    stencil = model.stencil
    if not stencil.test or "stencil" not in model.model_fields_set:
        return None

    def face(own: StencilFaceModel) -> StencilFace:
        said = {**{n: getattr(stencil, n) for n in StencilFaceModel.model_fields}}
        said |= {name: getattr(own, name) for name in own.model_fields_set}
        return StencilFace(**said)

    return StencilState(
        face(stencil.front), face(stencil.back), stencil.reference, stencil.read_mask, stencil.write_mask
    )


def raster_state(model: RasterModel) -> RasterState:
    scissor = model.scissor
    part = (scissor[0], scissor[1], scissor[2], scissor[3]) if scissor else None
    return RasterState(
        model.cull,
        model.front == "ccw",
        model.fill,
        model.depth_clamp,
        model.alpha_to_coverage,
        model.sample_mask,
        part,
    )


def blend_state(model: BlendWord | BlendModel) -> str | BlendState:
    """A word stays one; alpha is blended as colour where nothing else is said of it."""
    if not isinstance(model, BlendModel):
        return model
    return BlendState(
        model.src, model.dst, model.op, model.src_alpha or model.src, model.dst_alpha or model.dst,
        model.op_alpha or model.op,
    )  # fmt: skip
