//! Interpolation of the light between the samples of a volume.

use super::cell::{Interpolation, trilinear};
use super::jets::Jets;
use super::tree::Tree;
use super::{Volume, visibility};
use glam::{DVec3, Vec3};

/// A point outside of the volume.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("[{}, {}, {}] lies outside of the volume, which reaches from {low} to {high}", point.x, point.y, point.z)]
pub struct NotThere {
    /// The point.
    pub point: DVec3,
    /// The volume's lowest corner.
    pub low: DVec3,
    /// Its highest corner.
    pub high: DVec3,
}

/// Settings of a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadSettings {
    /// Interpolation between samples.
    pub interpolation: Interpolation,
    /// Whether walls hide samples ([`visibility`]).
    pub guard: bool,
}

/// A volume prepared for reading.
pub struct Reader<'a> {
    volume: &'a Volume,
    /// The cells, and the points at their corners.
    pub tree: Tree,
    /// Values and slopes for the cubic interpolation; none without gradients.
    jets: Option<Jets>,
}

/// The cubic interpolation has no weights that a wall could lower. It is replaced by that with gradients where a hidden sample has more
/// than this trilinear weight.
const GIVES_WAY: f64 = 1e-3;

impl<'a> Reader<'a> {
    /// Builds the tree of the cells, and interpolates at corners without samples.
    pub fn new(volume: &'a Volume) -> Self {
        let tree = Tree::new(volume);
        let jets = volume.has_gradients().then(|| Jets::new(volume, &tree));
        Self { volume, tree, jets }
    }

    /// The samples around a point with their trilinear weights, which are above 0 and sum to 1.
    pub fn weights(&self, point: DVec3) -> Vec<(u32, f64)> {
        let (node, t, _) = self.tree.find(&self.volume.lattice, point);
        let node = &self.tree.nodes[node];
        let mut all: Vec<(u32, f64)> = Vec::with_capacity(8);
        for (weight, corner) in trilinear(t).into_iter().zip(node.corners).filter(|(weight, _)| *weight > 0.0) {
            for (sample, share) in &self.tree.points[corner as usize].mix {
                match all.iter_mut().find(|(known, _)| known == sample) {
                    Some((_, sum)) => *sum += weight * share,
                    None => all.push((*sample, weight * share)),
                }
            }
        }
        all
    }

    /// The coefficients at a point of the scene, W·sr⁻¹·m⁻².
    ///
    /// # Errors
    /// [`NotThere`] outside of the volume.
    pub fn read(&self, point: DVec3, settings: ReadSettings) -> Result<Vec<DVec3>, NotThere> {
        if !self.volume.contains(point) {
            let [low, high] = self.volume.bounds;
            return Err(NotThere { point, low, high });
        }
        let interpolation = if self.jets.is_none() && settings.interpolation.wants_gradients() {
            Interpolation::Trilinear
        } else {
            settings.interpolation
        };
        let weights = self.weights(point);
        let seen = |(sample, weight): &(u32, f64)| {
            (*sample, *weight, visibility::weight(&self.volume.samples[*sample as usize], point, settings.guard))
        };
        let weights: Vec<(u32, f64, f64)> = weights.iter().map(seen).collect();
        let Some(jets) = self.jets.as_ref().filter(|_| interpolation == Interpolation::Hermite) else {
            return Ok(self.blend(point, &weights, interpolation));
        };
        // Visibility of the most hidden sample, those of almost no weight left aside.
        let sight = weights.iter().map(|(_, weight, seen)| seen.max(1.0 - weight / GIVES_WAY)).fold(1.0, f64::min);
        let cubic = || jets.read(&self.volume.lattice, &self.tree, point);
        if sight >= 1.0 {
            return Ok(cubic());
        }
        let blended = self.blend(point, &weights, Interpolation::Gradients);
        Ok(blended.iter().zip(cubic()).map(|(blended, cubic)| blended.lerp(cubic, sight)).collect())
    }

    /// Σ w·v(x) / Σ w over the samples, each with its trilinear weight and its visibility.
    fn blend(&self, point: DVec3, weights: &[(u32, f64, f64)], by: Interpolation) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; crate::math::sh::count(self.volume.order)];
        let mut all = 0.0;
        // The least distance, so that 1/distance is finite at a sample.
        let nearest = 1e-6 * (self.volume.lattice.high - self.volume.lattice.low).length();
        for (number, weight, seen) in weights {
            let sample = &self.volume.samples[*number as usize];
            let offset = point - sample.position;
            let mut weight = weight * seen;
            if by == Interpolation::InverseDistance {
                weight /= offset.length().max(nearest);
            }
            all += weight;
            for (c, (sum, value)) in sums.iter_mut().zip(&sample.coefficients).enumerate() {
                let mut value = value.as_dvec3();
                if by == Interpolation::Gradients {
                    value += moved(&sample.gradients[c], offset);
                }
                *sum += weight * value;
            }
        }
        sums.iter_mut().for_each(|sum| *sum /= all);
        sums
    }
}

/// Change of a coefficient over `offset`, by its gradient.
fn moved(gradients: &[Vec3; 3], offset: DVec3) -> DVec3 {
    let [x, y, z] = gradients.map(|slope| slope.as_dvec3());
    offset.x * x + offset.y * y + offset.z * z
}
