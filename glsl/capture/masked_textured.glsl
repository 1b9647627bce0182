#define TEXTURED
#define FRAME_SET 2
#include "capture/masked_vert.glsl"
