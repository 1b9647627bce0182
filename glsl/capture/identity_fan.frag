// The same as identity.frag for fans, whose vertices tell the side too.
#version 460
layout(location = 0) flat in uint triangle;
layout(location = 0) out uint identity;

void main() { identity = triangle + 1; }
