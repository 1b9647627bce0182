// Which triangle is seen, and which side of it: triangle + 1, bit 31 set for the front. Zero is the background.
#version 460
layout(location = 0) flat in uint triangle;
layout(location = 0) out uint identity;

void main() { identity = (triangle + gl_PrimitiveID + 1) | (gl_FrontFacing ? 0 : 0x80000000u); }
