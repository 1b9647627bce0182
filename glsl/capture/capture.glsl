// Vertices are shared: the fragment shader adds gl_PrimitiveID.
#define TRIANGLE first_triangle()
#include "capture/vertices.glsl"
