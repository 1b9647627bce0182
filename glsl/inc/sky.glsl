// Radiance from outside the scene: constant (size 1×1) or an equirectangular map, bilinear, row 0 at +Y, the centre
// column along −Z. Wants `sky_size` and `sky`.

vec3 sky_radiance(vec3 direction) {
    uvec2 size = sky_size.xy;
    if (size == uvec2(1)) return sky[0].rgb;
    vec3 d = normalize(direction);
    vec2 uv = vec2(0.5 + atan(d.x, -d.z) / (2.0 * PI), acos(clamp(d.y, -1.0, 1.0)) / PI) * vec2(size) - 0.5;
    ivec2 at = ivec2(floor(uv));
    vec2 f = uv - vec2(at);
    int x0 = (at.x + int(size.x)) % int(size.x), x1 = (x0 + 1) % int(size.x);
    int y0 = clamp(at.y, 0, int(size.y) - 1), y1 = clamp(at.y + 1, 0, int(size.y) - 1);
    int width = int(size.x);
    return mix(mix(sky[y0 * width + x0].rgb, sky[y0 * width + x1].rgb, f.x),
               mix(sky[y1 * width + x0].rgb, sky[y1 * width + x1].rgb, f.x), f.y);
}
