// The same as identity.frag for devices without gl_PrimitiveID: every triangle has vertices of its own.
#version 460
layout(location = 1) flat in uint own_triangle;
layout(location = 0) out uint identity;

void main() { identity = (own_triangle + 1) | (gl_FrontFacing ? 0x80000000u : 0); }
