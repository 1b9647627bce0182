// Irradiance from a triangle of radiance 1, unoccluded (Lambert 1760): ½ Σ Θᵢ n·Γᵢ over the edges of what is above the
// horizon. Corners relative to the receiver, counter-clockwise seen from where the triangle shines.

float edge_term(vec3 n, vec3 a, vec3 b) {
    vec3 c = cross(a, b);
    float sine = length(c);
    return sine > 0.0 ? atan(sine, dot(a, b)) * dot(n, c) / sine : 0.0;
}

// Point of the edge ab at the height 0; heights of different signs.
vec3 at_horizon(vec3 a, vec3 b, float ha, float hb) { return a + (b - a) * (ha / (ha - hb)); }

float triangle_irradiance(vec3 n, vec3 a, vec3 b, vec3 c) {
    vec3 h = vec3(dot(n, a), dot(n, b), dot(n, c));
    bvec3 above = greaterThan(h, vec3(0.0));
    if (!any(above)) return 0.0;
    float sum;
    if (all(above)) {
        sum = edge_term(n, a, b) + edge_term(n, b, c) + edge_term(n, c, a);
    } else {
        // Turned so that a is the corner on a side of its own.
        bool a_alone = above.y == above.z, b_alone = above.x == above.z;
        vec3 p = a_alone ? a : b_alone ? b : c, q = a_alone ? b : b_alone ? c : a, r = a_alone ? c : b_alone ? a : b;
        vec3 g = a_alone ? h : b_alone ? h.yzx : h.zxy;
        vec3 pq = at_horizon(p, q, g.x, g.y), rp = at_horizon(r, p, g.z, g.x);
        // The edge along the horizon has n·Γ = ±1 and closes the outline.
        sum = g.x > 0.0 ? edge_term(n, p, pq) + edge_term(n, pq, rp) + edge_term(n, rp, p)
                        : edge_term(n, pq, q) + edge_term(n, q, r) + edge_term(n, r, rp) + edge_term(n, rp, pq);
    }
    return max(-0.5 * sum, 0.0);
}
