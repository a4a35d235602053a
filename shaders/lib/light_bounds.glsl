// What a light can reach at most: engine/render/light_lists.py.
layout(std430, binding = 10) readonly buffer LightBoundsBlock { vec4 light_bounds[]; };

struct LightBound {
    vec3 center;
    float radius;     // at least ENDLESS: everywhere
    vec3 axis;
    float cos_angle;  // of the cone around the axis from the centre; -1: all around
};

const float ENDLESS = 1e18;

LightBound light_bound(uint i)
{
    vec4 a = light_bounds[2u * i];
    vec4 b = light_bounds[2u * i + 1u];
    return LightBound(a.xyz, a.w, b.xyz, b.w);
}

// Whether the light may add anything at p. Beyond its radius and cone it adds exactly 0; both are a bit wider here.
bool light_reaches(uint i, vec3 p)
{
    LightBound b = light_bound(i);
    vec3 to = p - b.center;
    float d2 = dot(to, to);
    return !(b.radius < ENDLESS) || (d2 <= b.radius * b.radius && dot(to, b.axis) >= (b.cos_angle - 1e-4) * sqrt(d2));
}
