"""What GLSL 4.50 itself offers to a shader, with how it is called: for completion. Names as in the specification."""

from __future__ import annotations

#: name -> its call, or what it is. T: float or a vector of them; I: int, uint or vectors; S: a sampler
_CALLS = """
radians(T degrees)|degrees(T radians)|sin(T)|cos(T)|tan(T)|asin(T)|acos(T)|atan(T y, T x)|sinh(T)|cosh(T)|tanh(T)
asinh(T)|acosh(T)|atanh(T)|pow(T x, T y)|exp(T)|log(T)|exp2(T)|log2(T)|sqrt(T)|inversesqrt(T)|abs(T)|sign(T)
floor(T)|trunc(T)|round(T)|roundEven(T)|ceil(T)|fract(T)|mod(T x, T y)|modf(T x, out T whole)|min(T, T)|max(T, T)
clamp(T x, T low, T high)|mix(T a, T b, T t)|step(T edge, T x)|smoothstep(T edge0, T edge1, T x)|isnan(T)|isinf(T)
floatBitsToInt(T)|floatBitsToUint(T)|intBitsToFloat(I)|uintBitsToFloat(I)|fma(T a, T b, T c)|frexp(T, out I)
ldexp(T, I)|packUnorm2x16(vec2)|packSnorm2x16(vec2)|packUnorm4x8(vec4)|packSnorm4x8(vec4)|unpackUnorm2x16(uint)
unpackSnorm2x16(uint)|unpackUnorm4x8(uint)|unpackSnorm4x8(uint)|packHalf2x16(vec2)|unpackHalf2x16(uint)|length(T)
distance(T, T)|dot(T, T)|cross(vec3, vec3)|normalize(T)|faceforward(T n, T i, T ng)|reflect(T i, T n)
refract(T i, T n, float eta)|matrixCompMult(M, M)|outerProduct(T column, T row)|transpose(M)|determinant(M)
inverse(M)|lessThan(T, T)|lessThanEqual(T, T)|greaterThan(T, T)|greaterThanEqual(T, T)|equal(T, T)|notEqual(T, T)
any(bvec)|all(bvec)|not(bvec)|bitfieldExtract(I, int offset, int bits)
bitfieldInsert(I base, I insert, int offset, int bits)|bitfieldReverse(I)|bitCount(I)|findLSB(I)|findMSB(I)
uaddCarry(uint, uint, out uint)|usubBorrow(uint, uint, out uint)|umulExtended(uint, uint, out uint, out uint)
textureSize(S, int lod)|textureQueryLod(S, T p)|textureQueryLevels(S)|texture(S, T p)|textureProj(S, T p)
textureLod(S, T p, float lod)|textureOffset(S, T p, ivec offset)|texelFetch(S, ivec p, int lod)
textureGrad(S, T p, T dx, T dy)|textureGather(S, T p)|textureSamples(S)|imageLoad(image, ivec p)
imageStore(image, ivec p, vec4)|imageSize(image)|imageAtomicAdd(image, ivec p, I)|imageAtomicMax(image, ivec p, I)
imageAtomicMin(image, ivec p, I)|atomicAdd(inout I, I)|atomicMin(inout I, I)|atomicMax(inout I, I)
atomicAnd(inout I, I)|atomicOr(inout I, I)|atomicXor(inout I, I)|atomicExchange(inout I, I)
atomicCompSwap(inout I, I, I)|dFdx(T)|dFdy(T)|dFdxFine(T)|dFdyFine(T)|dFdxCoarse(T)|dFdyCoarse(T)|fwidth(T)
fwidthFine(T)|fwidthCoarse(T)|interpolateAtCentroid(T)|interpolateAtSample(T, int)|interpolateAtOffset(T, vec2)
barrier()|memoryBarrier()|memoryBarrierShared()|memoryBarrierBuffer()|groupMemoryBarrier()|EmitVertex()
EndPrimitive()
"""
_VARIABLES = """
gl_FragCoord|gl_FrontFacing|gl_PointCoord|gl_PrimitiveID|gl_SampleID|gl_SamplePosition|gl_SampleMask|gl_SampleMaskIn
gl_FragDepth|gl_Layer|gl_HelperInvocation|gl_Position|gl_PointSize|gl_VertexID|gl_InstanceID|gl_BaseInstance
gl_InvocationID|gl_PatchVerticesIn|gl_TessLevelOuter|gl_TessLevelInner|gl_TessCoord|gl_in|gl_out|gl_NumWorkGroups
gl_WorkGroupSize|gl_WorkGroupID|gl_LocalInvocationID|gl_GlobalInvocationID|gl_LocalInvocationIndex
"""
_TYPES = """
void|bool|int|uint|float|bvec2|bvec3|bvec4|ivec2|ivec3|ivec4|uvec2|uvec3|uvec4|vec2|vec3|vec4|mat2|mat3|mat4|mat3x4|mat4x3
sampler2D|sampler2DArray|sampler2DShadow|sampler2DArrayShadow|samplerCube|samplerCubeArray|sampler3D|usampler2D|isampler2D
sampler2DMS|samplerBuffer|image2D|uimage2D|image2DArray|image3D
"""
_KEYWORDS = """
const|uniform|buffer|shared|in|out|inout|layout|location|binding|std140|std430|flat|smooth|centroid|sample|patch|invariant
precise|readonly|writeonly|coherent|restrict|struct|if|else|for|while|do|switch|case|default|break|continue|return|discard
local_size_x|local_size_y|local_size_z|early_fragment_tests
"""


def _words(text: str) -> list[str]:
    return [word for line in text.split("\n") for word in line.split("|") if word]


#: word -> what stands beside it in a list of candidates
WORDS: dict[str, str] = {
    **{call.split("(")[0]: call for call in _words(_CALLS)},
    **dict.fromkeys(_words(_VARIABLES), "built-in variable"),
    **dict.fromkeys(_words(_TYPES), "type"),
    **dict.fromkeys(_words(_KEYWORDS), "keyword"),
}
DIRECTIVES = (
    "include",
    "define",
    "undef",
    "if",
    "ifdef",
    "ifndef",
    "elif",
    "else",
    "endif",
    "error",
    "extension",
    "pragma",
)
