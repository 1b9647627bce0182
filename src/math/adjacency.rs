//! Which triangles share an edge.

use glam::Vec3;

/// No triangle.
pub const NONE: u32 = u32::MAX;

/// For each triangle, the ones across its edges opposite to its corners 0, 1 and 2, or [`NONE`].
///
/// Corners are the same where their positions are equal. Where more than two triangles share an edge, each continues in
/// the one that bends least. Triangles without area are no one's neighbours.
pub fn neighbours(triangles: &[[u32; 3]], positions: &[Vec3]) -> Vec<[u32; 3]> {
    let place = weld(positions);
    let mut edges: Vec<(u64, u32)> = Vec::with_capacity(triangles.len() * 3);
    for (index, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|v| positions[v as usize]);
        if (b - a).cross(c - a) == Vec3::ZERO {
            continue;
        }
        for edge in 0..3 {
            let [p, q] = [1, 2].map(|i| place[triangle[(edge + i) % 3] as usize]);
            edges.push((u64::from(p.min(q)) << 32 | u64::from(p.max(q)), (3 * index + edge) as u32));
        }
    }
    edges.sort_unstable();
    let mut across = vec![[NONE; 3]; triangles.len()];
    for sharing in edges.chunk_by(|a, b| a.0 == b.0) {
        for (_, one) in sharing {
            let mut others = sharing.iter().map(|(_, other)| *other).filter(|other| other / 3 != one / 3);
            let bend = |other: &u32| bend(triangles, positions, *one, *other);
            let best =
                if sharing.len() == 2 { others.next() } else { others.min_by(|a, b| bend(a).total_cmp(&bend(b))) };
            across[(one / 3) as usize][(one % 3) as usize] = best.map_or(NONE, |other| other / 3);
        }
    }
    across
}

/// Cosine of the angle between two triangles about their common edge: −1 where one continues the other, 1 where they lie
/// on each other.
fn bend(triangles: &[[u32; 3]], positions: &[Vec3], one: u32, other: u32) -> f32 {
    let at = |edge: u32, turn: u32| {
        let triangle = triangles[(edge / 3) as usize];
        positions[triangle[((edge % 3 + turn) % 3) as usize] as usize]
    };
    let (foot, along) = (at(one, 1), (at(one, 2) - at(one, 1)).normalize_or_zero());
    let rise = |edge: u32| (at(edge, 0) - foot).reject_from_normalized(along).normalize_or_zero();
    rise(one).dot(rise(other))
}

/// `triangles` without seams: corners are the same where their positions are equal, by the first vertex there.
pub fn welded(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let first_at = weld(positions);
    triangles.iter().map(|t| t.map(|v| first_at[v as usize])).collect()
}

/// The first vertex at each vertex's position.
fn weld(positions: &[Vec3]) -> Vec<u32> {
    // Adding zero makes −0 and 0 the same.
    let bits = |index: u32| (positions[index as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|index| bits(*index));
    let mut place = vec![0; positions.len()];
    for same in order.chunk_by(|a, b| bits(*a) == bits(*b)) {
        for index in same {
            place[*index as usize] = same[0];
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    #[test]
    fn a_quad_of_two_triangles_with_corners_of_their_own() {
        let (a, b, c, d) = (Vec3::ZERO, Vec3::X, vec3(1.0, 1.0, 0.0), vec3(-0.0, 1.0, 0.0));
        let across = neighbours(&[[0, 1, 2], [3, 4, 5]], &[a, b, c, vec3(-0.0, 0.0, 0.0), c, d]);
        assert_eq!(across, [[NONE, 1, NONE], [NONE, NONE, 0]]);
    }

    /// Two crossing walls: each goes on in itself, and a triangle without area is passed over.
    #[test]
    fn walls_that_cross_in_an_edge_continue_straight() {
        let positions = [Vec3::ZERO, Vec3::Z, Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z * 0.5];
        let across = neighbours(&[[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 1, 5], [0, 1, 6]], &positions);
        let last: Vec<u32> = across.iter().map(|edges| edges[2]).collect();
        assert_eq!(last, [1, 0, 3, 2, NONE]);
    }
}
