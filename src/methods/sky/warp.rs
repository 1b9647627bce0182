//! Directions by importance: points that are spread evenly, carried to where the light of a map is.

use crate::math::sampling::Discrete;
use crate::scene::EnvironmentMap;
use glam::Vec3;

/// Texels that light together, row by row, each with what it brings.
pub struct Region {
    /// Row, column and radiance × solid angle, sorted by row and column.
    texels: Vec<(u32, u32, Vec3)>,
    /// The whole.
    pub power: Vec3,
}

/// A direction towards the sky and the irradiance that it brings to a surface which faces it.
pub struct SkySample {
    /// Unit direction.
    pub direction: Vec3,
    /// W·m⁻².
    pub irradiance: Vec3,
}

impl Region {
    /// Of texels and their radiance × solid angle.
    pub fn new(mut texels: Vec<(u32, u32, Vec3)>) -> Self {
        texels.sort_unstable_by_key(|(row, column, _)| (*row, *column));
        let power = texels.iter().map(|(.., power)| power.as_dvec3()).sum::<glam::DVec3>().as_vec3();
        Self { texels, power }
    }

    /// Several as one, if there are any.
    pub fn together(regions: Vec<Self>) -> Option<Self> {
        let texels: Vec<_> = regions.into_iter().flat_map(|region| region.texels).collect();
        (!texels.is_empty()).then(|| Self::new(texels))
    }

    /// `count` samples whose irradiance sums to the region's.
    ///
    /// A row is chosen by the light of all rows, a place in it by that of its texels (Pharr, Jakob and Humphreys 2016,
    /// section 13.6.7), by the points (i + ½)/n, frac(i·φ): any few of them in steps are spread as well.
    pub fn samples(&self, map: &EnvironmentMap, count: u32) -> Vec<SkySample> {
        let rows: Vec<&[(u32, u32, Vec3)]> = self.texels.chunk_by(|a, b| a.0 == b.0).collect();
        let weight = |texel: &(u32, u32, Vec3)| f64::from(texel.2.max_element());
        let Some(by_row) = Discrete::new(rows.iter().map(|row| row.iter().map(weight).sum())) else { return vec![] };
        let mut columns: Vec<Option<Discrete>> = rows.iter().map(|_| None).collect();
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let mut samples = Vec::new();
        for i in 0..count {
            let (row, down) = by_row.sample((f64::from(i) + 0.5) / f64::from(count));
            let by_column = columns[row].get_or_insert_with(|| {
                Discrete::new(rows[row].iter().map(weight)).expect("a row that is chosen has light")
            });
            let (place, across) = by_column.sample((golden * (f64::from(i) + 0.5)).fract());
            let (y, x, power) = rows[row][place];
            let uv = [(f64::from(x) + across) / f64::from(map.width), height(map, y, down)];
            let direction = EnvironmentMap::uv_to_direction(uv.map(|c| c as f32));
            samples.push(SkySample { direction, irradiance: power / power.max_element() });
        }
        let sum: Vec3 = samples.iter().map(|s| s.irradiance).sum();
        let share = self.power / sum.max(Vec3::splat(f32::MIN_POSITIVE));
        for s in &mut samples {
            // A channel that no sample has lights from all of them.
            let even = self.power / count as f32;
            s.irradiance = Vec3::select(sum.cmpgt(Vec3::ZERO), s.irradiance * share, even);
        }
        samples
    }
}

/// v of the place in a row above which `share` of its solid angle lies.
fn height(map: &EnvironmentMap, row: u32, share: f64) -> f64 {
    let cos = |row: u32| (std::f64::consts::PI * f64::from(row) / f64::from(map.height)).cos();
    (cos(row) + (cos(row + 1) - cos(row)) * share).clamp(-1.0, 1.0).acos() / std::f64::consts::PI
}

/// Texels that touch each other, the left and the right end of a row as well, as regions.
pub fn regions(map: &EnvironmentMap, texels: Vec<(u32, u32, Vec3)>) -> Vec<Region> {
    let mut open: std::collections::BTreeMap<(u32, u32), Vec3> =
        texels.into_iter().map(|(row, column, power)| ((row, column), power)).collect();
    let mut found = Vec::new();
    while let Some((at, power)) = open.pop_first() {
        let (mut region, mut next) = (vec![(at.0, at.1, power)], vec![at]);
        while let Some((row, column)) = next.pop() {
            for (dy, dx) in (0..9).map(|i| (i / 3, i % 3)) {
                let Some(y) = (row + dy).checked_sub(1) else { continue };
                let neighbour = (y, (column + dx + map.width - 1) % map.width);
                if let Some(power) = open.remove(&neighbour) {
                    region.push((neighbour.0, neighbour.1, power));
                    next.push(neighbour);
                }
            }
        }
        found.push(Region::new(region));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of a constant map bring a horizontal surface π and weigh all directions alike.
    #[test]
    fn a_constant_map_is_sampled_evenly() {
        let map = EnvironmentMap { width: 128, height: 64, rgb: vec![[1.0; 3]; 128 * 64] };
        let texel = |i: u32| (i / 128, i % 128, Vec3::splat(map.solid_angle(i / 128) as f32));
        let samples = Region::new((0..128 * 64).map(texel).collect()).samples(&map, 128);
        for stride in [1, 4] {
            for start in 0..stride {
                let some = || samples.iter().skip(start).step_by(stride);
                for n in [Vec3::Y, Vec3::X, Vec3::NEG_Z] {
                    let e: f32 = some().map(|s| s.irradiance.x * s.direction.dot(n).max(0.0)).sum();
                    let error = e * stride as f32 / std::f32::consts::PI - 1.0;
                    assert!(error.abs() < 0.03 * stride as f32, "{n}, {start} of {stride}: {error}");
                }
            }
        }
    }

    #[test]
    fn regions_go_round_and_keep_their_light() {
        let map = EnvironmentMap { width: 16, height: 8, rgb: vec![] };
        let texel = |row, column| (row, column, Vec3::new(1.0, 0.0, 2.0));
        let found = regions(&map, vec![texel(2, 0), texel(3, 15), texel(4, 14), texel(6, 7)]);
        assert_eq!(found.iter().map(|r| r.texels.len()).collect::<Vec<_>>(), [3, 1]);
        let sum: Vec3 = found[0].samples(&map, 5).iter().map(|s| s.irradiance).sum();
        assert!((sum - Vec3::new(3.0, 0.0, 6.0)).length() < 1e-5, "{sum}");
    }
}
