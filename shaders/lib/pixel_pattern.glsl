// A place in a pattern of 4 x 4 pixels, 0 to 15, far from those beside it (Bayer 1973).
int pattern(ivec2 pixel)
{
    int x = pixel.x & 3;
    int y = pixel.y & 3;
    int z = x ^ y;
    return ((y >> 1) & 1) | (z & 2) | ((y & 1) << 2) | ((z & 1) << 3);
}
