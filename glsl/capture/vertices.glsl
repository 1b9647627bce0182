// Opaque triangles by their vertices. Wants TRIANGLE, the number of the vertex's triangle or what the fragment shader adds to.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.glsl"
#define FRAME_SET 0
#define CONSTANTS 0
#include "capture/frames.glsl"

layout(location = 0) in vec3 position;
layout(location = 0) flat out uint triangle;

void main() {
    uint number = frame_number();
    Frame frame = frames[number];
    place(number, frame, projected(frame, position), position);
    triangle = TRIANGLE;
}
