#define FRAME_SET 1
#include "capture/masked_vert.glsl"
