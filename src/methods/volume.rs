//! Bakes irradiance volumes: captures measure the light at the places that [`crate::volume::place`] asks for.

use super::gather::Gathering;
use super::probes::Result;
use super::sphere_probes::{SphereProbeSettings, SteadyProbes};
use crate::passes::distances::Distances;
use crate::scene::Scene;
use crate::vk::Device;
use crate::vk::pass::Recorder;
use crate::volume::Volume;
use crate::volume::place::{Adaptive, Common, Measured, Placement, Seen, adaptive, uniform};
use glam::{DVec3, UVec3};
use std::sync::Arc;

/// Where the samples of a volume are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Places {
    /// A uniform grid: the number of samples along each axis of the box, 2 at least.
    Uniform(UVec3),
    /// An octree that is finer where light changes.
    Adaptive(Adaptive),
}

/// How the gradients of the coefficients are computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gradients {
    /// No gradients.
    None,
    /// From the edges between the texels of the sample's own capture ([`crate::math::capture::Weights`]).
    Edges,
    /// By central differences of six captures around the sample, at this distance from it (Tatarchuk and Oat 2005).
    Differences(f64),
}

/// How a volume is baked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeSettings {
    /// The captures of the samples. Their `gradients` and `distances` are set by [`bake`].
    pub probes: SphereProbeSettings,
    /// How the gradients of the coefficients are computed.
    pub gradients: Gradients,
    /// Where the samples are.
    pub places: Places,
    /// The box to fill, by its lowest and highest corner in the scene's own coordinates; [`bounds`] gives the whole scene's.
    pub bounds: [DVec3; 2],
    /// Share of the sphere around a sample from which on backs of triangles mean that it is inside of geometry, 0 to 1.
    pub inside: f32,
    /// Whether samples keep the moments of their distances, for the leak guard.
    pub moments: bool,
}

/// The box around a scene, in the scene's own coordinates. A side without length gets a thousandth of the longest.
pub fn bounds(scene: &Scene) -> [DVec3; 2] {
    let (low, high) = scene.bounds();
    let [low, high] = [low, high].map(|corner| corner.as_dvec3() + scene.origin);
    let least = 1e-3 * (high - low).max_element();
    let spare = DVec3::select((high - low).cmplt(DVec3::splat(least)), DVec3::splat(0.5 * least), DVec3::ZERO);
    [low - spare, high + spare]
}

/// Bakes the light of `scene`. `on_progress(all, done)` is called with `done` 0 before `all` places are captured, and then with the
/// number of places of each batch.
///
/// # Errors
/// The device's, or too many lights.
pub fn bake(
    device: &Arc<Device>,
    recorder: &mut Recorder,
    scene: &Scene,
    settings: &BakeSettings,
    on_progress: &mut dyn FnMut(usize, usize),
) -> Result<(Volume, Placement)> {
    let reach = (settings.bounds[1] - settings.bounds[0]).length();
    let by_edges = settings.gradients == Gradients::Edges;
    let probe = SphereProbeSettings { distances: Some(reach as f32), gradients: by_edges, ..settings.probes };
    let mut probes = SteadyProbes::new(device, recorder, scene, &probe)?;
    let common = Common {
        bounds: settings.bounds,
        order: probe.order,
        bounces: "1".into(),
        inside: settings.inside,
        moments: settings.moments,
    };
    let mut capture = |places: &[DVec3]| {
        let relative: Vec<_> = places.iter().map(|place| (*place - scene.origin).as_vec3()).collect();
        on_progress(places.len(), 0);
        let found = probes.measure(recorder, &relative, &mut |done| on_progress(places.len(), done))?;
        Ok(found.into_iter().map(|found| measured(found, by_edges)).collect::<Vec<_>>())
    };
    let mut measure = |places: &[DVec3]| match settings.gradients {
        Gradients::Differences(step) => with_differences(places, step, &mut capture),
        Gradients::None | Gradients::Edges => capture(places),
    };
    match &settings.places {
        Places::Uniform(counts) => uniform(&common, *counts, &mut measure),
        Places::Adaptive(settings) => adaptive(&common, settings, &mut measure),
    }
}

/// Measures at places, and at six more around each for its gradients.
fn with_differences(
    places: &[DVec3],
    step: f64,
    capture: &mut dyn FnMut(&[DVec3]) -> Result<Vec<Measured>>,
) -> Result<Vec<Measured>> {
    let around = |place: &DVec3| {
        let place = *place;
        let beside = DVec3::AXES.into_iter().flat_map(move |axis| [place - step * axis, place + step * axis]);
        std::iter::once(place).chain(beside)
    };
    let all: Vec<DVec3> = places.iter().flat_map(around).collect();
    let mut found = capture(&all)?;
    let difference =
        |[less, more]: [&Measured; 2], c: usize| (more.coefficients[c] - less.coefficients[c]) / (2.0 * step) as f32;
    for of_place in found.chunks_exact_mut(7) {
        let [centre, x0, x1, y0, y1, z0, z1] = of_place else { unreachable!("chunks have seven") };
        let pairs = [[&*x0, &*x1], [&*y0, &*y1], [&*z0, &*z1]];
        centre.gradients = (0..centre.coefficients.len()).map(|c| pairs.map(|pair| difference(pair, c))).collect();
    }
    Ok(found.into_iter().step_by(7).collect())
}

/// The result of a capture, as [`crate::volume::place`] takes it.
fn measured(found: Gathering, gradients: bool) -> Measured {
    let seen = |cell: &Distances| Seen { moments: cell.moments, backs: cell.backs, nearness: cell.nearness };
    Measured {
        coefficients: found.projected.coefficients,
        gradients: if gradients { found.projected.gradients } else { Vec::new() },
        inverse_distance: found.projected.inverse_distance,
        seen: found.distances.iter().map(seen).collect(),
    }
}
