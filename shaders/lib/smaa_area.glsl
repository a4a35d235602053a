// How much of the two pixels on either side of an edge lies beyond the line that the edge stands for (Reshetov 2009,
// "Morphological Antialiasing"; Jimenez et al. 2012). The edge runs along y = 0 from x = 0 to `length`; where it ends, it
// goes on half a pixel up or down, or not at all. The pixel is [at, at + 1].

// Between a line from (x0, y0) to (x1, y1) and y = 0, within the pixel: above, below.
vec2 area_of_line(float x0, float y0, float x1, float y1, float at)
{
    float a = max(x0, at);
    float b = min(x1, at + 1.0);
    if (b <= a) return vec2(0.0);
    float slope = (y1 - y0) / (x1 - x0);
    float ya = y0 + slope * (a - x0);
    float yb = y0 + slope * (b - x0);
    if (ya * yb >= 0.0) {
        float area = 0.5 * (ya + yb) * (b - a);
        return vec2(max(area, 0.0), max(-area, 0.0));
    }
    float meets = ya / (ya - yb);
    vec2 areas = 0.5 * (b - a) * vec2(ya * meets, yb * (1.0 - meets));
    return ya > 0.0 ? vec2(areas.x, -areas.y) : vec2(areas.y, -areas.x);
}

// `first`, `last`: whether an edge goes on above (x) and below (y) at either end.
vec2 smaa_area(vec2 first, vec2 last, float length, float at)
{
    float h0 = 0.5 * (first.x - first.y);
    float h1 = 0.5 * (last.x - last.y);
    // one that goes on both ways is taken to go on away from the other end's side
    if (first.x * first.y > 0.5) h0 = -h1;
    if (last.x * last.y > 0.5) h1 = -h0;
    if (h0 * h1 < 0.0) return area_of_line(0.0, h0, length, h1, at);
    float middle = 0.5 * length;
    return area_of_line(0.0, h0, middle, 0.0, at) + area_of_line(middle, 0.0, length, h1, at);
}

// edges of a stair that is taken for a slanted line: below that its steps are as well lines of their own
const float SHORTEST = 4.0;

// The same for a stair: edges of one pixel, along and across by turns, `length` of them, of which the one in question is
// number `at`. The line goes through their middles, at 45 degrees; where a stair ends because an edge goes on, the next
// stair is off by a pixel along it, and the line goes half of that: `first`, `last` in [-1, 1]. Off by h pixels along the
// edge, the line cuts a right triangle from the pixel at each corner, with sides of 1/2 - h on one side and 1/2 + h on the
// other.
vec2 smaa_stair(float first, float last, float length, float at)
{
    float h0 = 0.5 * first;
    float h1 = 0.5 * last;
    vec2 t = vec2(at, at + 1.0) / length;
    vec2 h;
    if (h0 * h1 < 0.0) h = mix(vec2(h0), vec2(h1), t);
    else h = mix(h0 * max(1.0 - 2.0 * t, 0.0), h1 * max(2.0 * t - 1.0, 0.0), step(0.5, t));
    vec2 sides = vec2(0.5 + h.x, 0.5 - h.y);
    return 0.5 * sides * sides;
}
