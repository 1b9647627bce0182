// Set 0: the scene's geometry. A stream that the scene does not have is bound to the positions and never read.
layout(set = 0, binding = 0, std430) readonly buffer Positions { float positions[]; };
layout(set = 0, binding = 1, std430) readonly buffer Indices { uint indices[]; };
layout(set = 0, binding = 2, std430) readonly buffer Normals { uint normals[]; };
layout(set = 0, binding = 3, std430) readonly buffer Uv0 { vec2 uv0s[]; };
layout(set = 0, binding = 4, std430) readonly buffer Uv1 { vec2 uv1s[]; };
layout(set = 0, binding = 5, std430) readonly buffer Tangents { vec4 tangents[]; };
layout(set = 0, binding = 6, std430) readonly buffer Colors { vec4 colors[]; };
layout(set = 0, binding = 7, std430) readonly buffer Materials { Material materials[]; };
