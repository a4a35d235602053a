// Morph targets: base + sum of weight * offsets (glTF 2.0, 3.7.2.2), over the targets whose weight is not 0.
//
// morph_data, u4 and floats as their bits:
//   [0]      where the table of objects begins
//   [1...]   offsets: per target, x y z of every vertex's position, then of normals and tangents where there are some
//   table    per object 0, or where its header stands:
//            first offset | the mesh's base vertex | its vertices | 1 normals + 2 tangents | n | n x (target, weight)

layout(std430, binding = 7) readonly buffer MorphBlock { uint morph_data[]; };

vec3 morph_offset(uint i)
{
    return uintBitsToFloat(uvec3(morph_data[i], morph_data[i + 1u], morph_data[i + 2u]));
}

void morph(uint object, inout vec3 position, inout vec3 normal, inout vec3 tangent)
{
    uint head = morph_data[morph_data[0] + object];
    if (head == 0u) return;
    uint vertices = morph_data[head + 2u];
    uint kinds = morph_data[head + 3u];
    uint count = morph_data[head + 4u];
    uint stream = 3u * vertices;
    uint target_size = stream * (1u + (kinds & 1u) + (kinds >> 1u));
    uint vertex = morph_data[head] + 3u * (uint(gl_VertexID) - morph_data[head + 1u]);
    for (uint k = 0u; k < count; ++k) {
        uint at = vertex + target_size * morph_data[head + 5u + 2u * k];
        float weight = uintBitsToFloat(morph_data[head + 6u + 2u * k]);
        position += weight * morph_offset(at);
        if ((kinds & 1u) != 0u) normal += weight * morph_offset(at + stream);
        if ((kinds & 2u) != 0u) tangent += weight * morph_offset(at + stream * (1u + (kinds & 1u)));
    }
    // unit again: between vertices normals are mixed as they are
    if (count != 0u && (kinds & 1u) != 0u) normal *= inversesqrt(max(dot(normal, normal), 1e-20));
}
