//! Bakes irradiance volumes: light at the places that [`crate::volume::place`] asks for, measured by captures.

use super::gather::Gathering;
use super::probes::Result;
use super::sphere_probes::{SphereProbeSettings, SteadyProbes};
use crate::passes::distances::Distances;
use crate::scene::Scene;
use crate::vk::Device;
use crate::vk::pass::Recorder;
use crate::volume::Volume;
use crate::volume::place::{Adaptive, Common, Measured, Placement, Seen, adaptive, uniform};
use glam::DVec3;
use std::sync::Arc;

/// Where samples are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Places {
    /// So many along each axis of the box.
    Uniform(u32),
    /// Where light changes.
    Adaptive(Adaptive),
}

/// How coefficients' gradients are found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gradients {
    /// Not at all.
    None,
    /// By the edges between the texels of the sample's own capture ([`crate::math::capture::Weights`]).
    Edges,
    /// By central differences of six captures around it, so far away (Tatarchuk and Oat 2005).
    Differences(f64),
}

/// How a volume is baked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeSettings {
    /// How samples look at the scene; whether gradients and distances are wanted of captures is decided here.
    pub probes: SphereProbeSettings,
    /// How gradients are found.
    pub gradients: Gradients,
    /// Where they are.
    pub places: Places,
    /// Share of triangles' backs in the sphere from which on a place is inside of geometry.
    pub inside: f32,
    /// Whether moments of distances are kept, for the leak guard.
    pub moments: bool,
}

/// The box that a scene's volume fills, in the scene's own coordinates. A side without length gets a thousandth of the longest.
pub fn bounds(scene: &Scene) -> [DVec3; 2] {
    let (low, high) = scene.bounds();
    let [low, high] = [low, high].map(|corner| corner.as_dvec3() + scene.origin);
    let least = 1e-3 * (high - low).max_element();
    let spare = DVec3::select((high - low).cmplt(DVec3::splat(least)), DVec3::splat(0.5 * least), DVec3::ZERO);
    [low - spare, high + spare]
}

/// Bakes the light of `scene` in the box of its triangles. `on_progress` hears how many places a request has, at its beginning
/// with 0 done, and how many of them were measured since.
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
    let by_edges = settings.gradients == Gradients::Edges;
    let probe = SphereProbeSettings { distances: true, gradients: by_edges, ..settings.probes };
    let mut probes = SteadyProbes::new(device, recorder, scene, &probe)?;
    let common = Common {
        bounds: bounds(scene),
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
        Places::Uniform(per_side) => uniform(&common, *per_side, &mut measure),
        Places::Adaptive(settings) => adaptive(&common, settings, &mut measure),
    }
}

/// Measures at places and at six more around each, which make its gradients.
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

/// What a capture found, as a volume holds it.
pub fn measured(found: Gathering, gradients: bool) -> Measured {
    let seen = |cell: &Distances| Seen { moments: cell.moments, backs: cell.backs, nearness: cell.nearness };
    Measured {
        coefficients: found.projected.coefficients,
        gradients: if gradients { found.projected.gradients } else { Vec::new() },
        inverse_distance: found.projected.inverse_distance,
        seen: found.distances.iter().map(seen).collect(),
    }
}
