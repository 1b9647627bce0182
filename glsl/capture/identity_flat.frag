// The same as identity.frag where the vertices carry the triangle.
#version 460
layout(location = 0) flat in uint triangle;
layout(location = 0) out uint identity;

void main() { identity = triangle + 1; }
