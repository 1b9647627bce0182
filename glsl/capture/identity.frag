// Which triangle is seen: its number plus 1; zero is the background.
#version 460
layout(location = 0) flat in uint triangle;
layout(location = 0) out uint identity;

void main() { identity = triangle + gl_PrimitiveID + 1; }
