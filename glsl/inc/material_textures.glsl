// Set 1 of textured variants: a texture that the material does not have is bound to one that it has, and never read.
#ifdef TEXTURED
layout(set = 1, binding = 0) uniform sampler2D base_texture;
layout(set = 1, binding = 1) uniform sampler2D normal_texture;
layout(set = 1, binding = 2) uniform sampler2D emission_texture;
#endif
