// Alpha to coverage: which of a pixel's samples a cut-out covers. The alpha is sharpened to a slope of one pixel about the
// cutoff (Golus 2017, "Anti-aliased Alpha Test: The Esoteric Alpha To Coverage"), so that edges are smooth at any distance.
// In the shader, not by the API's state, so that the depth pre-pass and the picture cut the very same samples.
int alpha_coverage(float alpha, float cutoff)
{
    float width = clamp(fwidth(alpha), 1e-4, 0.5);  // beyond, a pixel at a triangle's edge would fade
    float covered = clamp((alpha - cutoff) / width + 0.5, 0.0, 1.0);
    return (1 << int(round(covered * float(ALPHA_TO_COVERAGE)))) - 1;
}
