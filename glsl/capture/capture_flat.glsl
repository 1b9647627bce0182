// Every triangle has vertices of its own.
#define TRIANGLE gl_VertexIndex / 3
#include "capture/vertices.glsl"
