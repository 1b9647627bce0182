//! The light of a picture beside that of the path tracer.

use super::picture;
use glam::DVec3;
use hemicube::reference::{Progressive, Settings as PathSettings, Tracer, View, batch_for};
use hemicube::renderer::Settings;
use hemicube::scene::{Camera, Scene};

/// Mean irradiance over a picture's mask, all channels together.
#[derive(Clone, Copy, Debug, Default)]
pub struct Energy {
    /// The renderer's.
    pub is: f64,
    /// The path tracer's.
    pub should: f64,
    /// Standard error of that.
    pub error: f64,
}

impl Energy {
    /// Ratio of the two, less 1.
    pub fn off(&self) -> f64 {
        if self.should > 0.0 { self.is / self.should - 1.0 } else { self.is }
    }

    /// Whether they differ by more than a share of the light and three standard errors.
    pub fn is_off_by(&self, share: f64) -> bool {
        let off = (self.is - self.should).abs();
        off.is_nan() || off > share * self.should + 3.0 * self.error
    }

    /// Whether the path tracer knows the light to a share of it.
    pub fn is_known_to(&self, share: f64) -> bool {
        self.error <= share * self.should
    }
}

/// A layer of irradiance, pixel by pixel, mean of the channels: the renderer's and the path tracer's.
pub struct Light {
    pub energy: Energy,
    pub is: Vec<f32>,
    pub should: Vec<f32>,
}

/// Direct and indirect light of a picture by `settings`, beside that by `spp` paths a pixel.
pub fn energies(scene: &Scene, camera: &Camera, settings: &Settings, spp: u32) -> [Light; 2] {
    let rendered = picture(scene, camera, settings);
    let tracer = Tracer::new(scene);
    let batch = batch_for(spp);
    let paths = PathSettings { bounces: 1, seed: 1, batch };
    let mut truth = Progressive::new(&tracer, View::new(camera, settings.width, settings.height), paths);
    (0..spp.div_ceil(batch)).for_each(|_| truth.advance());
    let mask = rendered.scalar("mask").unwrap();
    let pixels: Vec<_> =
        (0..mask.len()).filter(|i| mask[*i] == 1.0 && truth.pixels[*i].reflector().is_some()).collect();
    let (count, sum) = ((3 * pixels.len()).max(1) as f64, |v: DVec3| v.element_sum());
    let of = |layer: &str, estimate: &dyn Fn(usize) -> (DVec3, DVec3)| {
        let values = rendered.rgb(layer).unwrap();
        let is: f64 = pixels.iter().flat_map(|i| values.map(|plane| f64::from(plane[*i]))).sum();
        let should: f64 = pixels.iter().map(|i| sum(estimate(*i).0)).sum();
        // The channels of a pixel go together.
        let variance: f64 = pixels.iter().map(|i| sum(estimate(*i).1).powi(2)).sum();
        let mean = |i: usize| values.map(|plane| plane[i] / 3.0).iter().sum();
        let all = 0..mask.len();
        Light {
            energy: Energy { is: is / count, should: should / count, error: variance.sqrt() / count },
            is: all.clone().map(mean).collect(),
            should: all.map(|i| (sum(estimate(i).0) / 3.0) as f32).collect(),
        }
    };
    let direct = |i: usize| (truth.estimate(i).mean[0], truth.estimate(i).stderr[0]);
    let indirect = |i: usize| (truth.estimate(i).indirect(), truth.estimate(i).stderr_indirect);
    [of("irradiance_direct", &direct), of("irradiance", &indirect)]
}
