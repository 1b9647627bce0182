// Attributes of a vertex; streams that the scene does not have are never read. Constants HAS_UV0, HAS_UV1, HAS_TANGENTS,
// HAS_COLORS.
vec2 uv0_of(uint vertex) { return HAS_UV0 != 0 ? uv0s[vertex] : vec2(0.0); }
vec2 uv1_of(uint vertex) { return HAS_UV1 != 0 ? uv1s[vertex] : vec2(0.0); }
vec4 tangent_of(uint vertex) { return HAS_TANGENTS != 0 ? tangents[vertex] : vec4(0.0); }
vec4 color_of(uint vertex) { return HAS_COLORS != 0 ? colors[vertex] : vec4(1.0); }
