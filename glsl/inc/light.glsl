// Irradiance vector of a light sample: direction to the light (unit) and irradiance of a surface that faces it, before
// visibility. Wants LIGHT_KIND.

struct Arriving { vec3 direction; vec3 irradiance; };

// A small disc instead of a point (Wallace, Elmquist and Haines 1989, eq. 5): bounded next to the emitter, and the same in
// the limit of many samples. `power`: radiance times area.
Arriving light_from_disc(LightSample light, vec3 p, vec3 power) {
    vec3 d = light.position.xyz - p;
    float distance2 = dot(d, d);
    vec3 w = d * inversesqrt(max(distance2, 1e-30));
    return Arriving(w, power * (max(-dot(w, light.direction.xyz), 0.0) / (distance2 + light.position.w)));
}

// 1 − cos of the angle between −d and the axis: sin²/(1 + cos), for small angles are lost in the cosine.
float versine(vec3 d, float distance2, vec3 axis) {
    vec3 across = cross(d, axis);
    float cosine = -dot(d, axis) * inversesqrt(max(distance2, 1e-30));
    return cosine > 0.0 ? dot(across, across) / (max(distance2, 1e-30) * (1.0 + cosine)) : 1.0 - cosine;
}

// Whether a sample's shadow view is for p: in a shell about a centre, or anywhere.
bool is_in_shell(LightSample light, vec3 p, vec3 centre) {
    float away = distance(p, centre);
    return away >= light.shell.x && (light.shell.y == 0.0 || away < light.shell.y);
}

Arriving light_arriving(LightSample light, vec3 p) {
    if (LIGHT_KIND == LIGHT_DIRECTIONAL) return Arriving(-light.direction.xyz, light.power.rgb);
    if (LIGHT_KIND == LIGHT_AREA) return light_from_disc(light, p, light.power.rgb);
    vec3 d = light.position.xyz - p;
    float distance2 = dot(d, d);
    vec3 w = d * inversesqrt(max(distance2, 1e-30));
    if (LIGHT_KIND == LIGHT_POINT) return Arriving(w, light.power.rgb / max(distance2, 1e-30));
    float falloff = clamp((light.direction.w - versine(d, distance2, light.direction.xyz)) * light.power.w, 0.0, 1.0);
    return Arriving(w, light.power.rgb * (falloff * falloff / max(distance2, 1e-30)));
}
