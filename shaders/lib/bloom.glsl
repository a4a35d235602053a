// The quadratic B-spline: its translates by 1 sum to 1 everywhere, and those of its halved samples do, too. So going to a
// texture of half the size and back keeps both what is constant and the sum of all light.
float spline(float t)
{
    t = abs(t);
    return t < 0.5 ? 0.75 - t * t : t < 1.5 ? 0.5 * (1.5 - t) * (1.5 - t) : 0.0;
}
