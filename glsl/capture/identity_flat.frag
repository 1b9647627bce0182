// The same as identity.frag for devices without gl_PrimitiveID: every triangle has vertices of its own.
#version 460
layout(location = 0) flat in uint triangle;
layout(location = 0) out uint identity;

void main() { identity = (triangle + 1) | (gl_FrontFacing ? 0 : 0x80000000u); }
