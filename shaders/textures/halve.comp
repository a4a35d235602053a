// The next mip of a computed texture: the mean of 2 x 2 texels. NORMAL: directions, of length 1 again afterwards.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, FORMAT) uniform readonly image2DArray i_finer;
layout(binding = 1, FORMAT) uniform writeonly image2DArray i_coarser;

vec4 finer(ivec2 at)
{
    ivec2 inside = min(at, imageSize(i_finer).xy - 1);
    return imageLoad(i_finer, ivec3(inside, int(job.layer)));
}

void main()
{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, job.size))) return;
    vec4 sum = finer(2 * p) + finer(2 * p + ivec2(1, 0)) + finer(2 * p + ivec2(0, 1)) + finer(2 * p + ivec2(1, 1));
    vec4 mean = 0.25 * sum;
#if NORMAL
    vec3 n = vec3(2.0 * mean.xy - 1.0, 0.0);
    n.z = sqrt(max(1.0 - dot(n.xy, n.xy), 0.0));
    mean.xyz = 0.5 * n + 0.5;
#endif
    imageStore(i_coarser, ivec3(p, int(job.layer)), mean);
}
