// How many places of a filter's disc tints are looked up at: as many as depths, where those are not more.
#if SHADOW_FILTER < 2
const int TINT_TAPS = 1;
#elif SHADOW_FILTER == 2 || SHADOW_FILTER == 5
const int TINT_TAPS = 8;
#else
const int TINT_TAPS = 16;
#endif
