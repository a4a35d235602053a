// What a tile shows: view depths of its solid pixels, and the boxes about those before and behind the middle of these
// depths (one may be empty, lo > hi), which a pillar before a wall fills better than one box.
// `bits`: which of 32 even parts of the depth are in use, then flags 1: something solid is there, 2: so is sky.
struct TileBounds {
    vec4 lo_near;
    vec4 hi_far;
    vec4 back_lo;
    vec4 back_hi;
    uvec4 bits;
};
