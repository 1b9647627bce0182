// Which triangle is seen, and which side of it: triangle + 1, bit 31 set for the front. Zero is the background.
#version 460
layout(location = 0) flat in uint first_triangle;
layout(location = 0) out uint identity;

void main() { identity = (first_triangle + gl_PrimitiveID + 1) | (gl_FrontFacing ? 0x80000000u : 0); }
