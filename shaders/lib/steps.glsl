// REPEAT(what): what(0u) ... what(STEPS - 1). llvmpipe ends a shader's loops after 65,535 turns in all, so that loops over
// very many lights do several in a turn there (engine/render/lighting.py); elsewhere, and for fewer, STEPS is 1.
#ifndef LOOP_STEPS
#define LOOP_STEPS 1
#endif
#if LOOP_STEPS == 1
#define STEPS 1u
#define REPEAT(what) what(0u)
#elif LOOP_STEPS == 4
#define STEPS 4u
#define REPEAT(what) what(0u) what(1u) what(2u) what(3u)
#else
#define STEPS 16u
#define REPEAT(what) what(0u) what(1u) what(2u) what(3u) what(4u) what(5u) what(6u) what(7u) \
    what(8u) what(9u) what(10u) what(11u) what(12u) what(13u) what(14u) what(15u)
#endif
