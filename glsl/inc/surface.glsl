// Material of a surface point. Wants `material`; with TEXTURED also the three textures; constants HAS_BASE_TEXTURE,
// HAS_NORMAL_TEXTURE, HAS_EMISSION_TEXTURE.

struct Surface { vec4 albedo; vec3 emission; vec3 normal; };

vec2 transformed(vec4 rows[2], vec2 uv0, vec2 uv1) {
    vec3 uv = vec3(rows[0].w == 0.0 ? uv0 : uv1, 1.0);
    return vec2(dot(rows[0].xyz, uv), dot(rows[1].xyz, uv));
}

Surface surface_at(Material material, vec2 uv0, vec2 uv1, vec4 color, vec3 normal, vec4 tangent) {
    Surface s = Surface(material.base_color * color, material.emission.rgb, normal);
#ifdef TEXTURED
    if (HAS_BASE_TEXTURE != 0) s.albedo *= textureLod(base_texture, transformed(material.base_uv, uv0, uv1), 0.0);
    if (HAS_EMISSION_TEXTURE != 0)
        s.emission *= textureLod(emission_texture, transformed(material.emission_uv, uv0, uv1), 0.0).rgb;
    if (HAS_NORMAL_TEXTURE != 0) {
        vec3 m = textureLod(normal_texture, transformed(material.normal_uv, uv0, uv1), 0.0).xyz * 2.0 - 1.0;
        vec3 t = tangent.xyz - normal * dot(normal, tangent.xyz);
        if (dot(t, t) > 1e-12) {
            t = normalize(t);
            vec3 b = cross(normal, t) * tangent.w;
            vec3 n = m.x * material.emission.w * t + m.y * material.emission.w * b + m.z * normal;
            if (dot(n, n) > 1e-12) s.normal = normalize(n);
        }
    }
#endif
    return s;
}
