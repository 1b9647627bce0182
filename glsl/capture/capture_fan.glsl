// Opaque triangles for devices that set triangles up whole: what the view sees of each is a fan of its own.
#include "shared/types.glsl"
#include "inc/scene.glsl"
#include "inc/triangles.glsl"
#define FRAME_SET 1
#define CONSTANTS 0
#include "capture/frames.glsl"
#include "capture/fans.glsl"

layout(location = 0) flat out uint triangle;

void main() {
    uint number = frame_number();
    Frame frame = frames[number];
    FanCorner corner = corner_of_fan(frame);
    place(number, frame, corner.clip, corner.positions * corner.weights);
    triangle = corner.triangle;
}
