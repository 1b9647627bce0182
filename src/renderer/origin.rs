//! What records of a scene follow from, so that a file of them serves no other.

use super::Settings;
use crate::methods::light_set::LightSettings;
use crate::methods::records::file::Origin;
use crate::methods::surface_cache::ALL_BOUNCES;
use crate::scene::Scene;

impl Origin {
    /// Of records of `scene` by `settings`, whatever the view.
    pub fn of(scene: &Scene, settings: &Settings) -> Self {
        let settings = settings_of(settings).into_iter().map(|(name, value)| (name.to_owned(), value));
        Self {
            program: [env!("CARGO_PKG_VERSION"), env!("HEMICUBE_SHADERS")].map(str::to_owned),
            name: scene.name.clone(),
            scene: scene.fingerprints().map(|(name, hash)| (name.to_owned(), format!("{hash:016x}"))).into(),
            settings: settings.collect(),
        }
    }
}

/// By their flags, where they have one. Whether whole workgroups share a view is left out: the device decides, and captures are the same.
fn settings_of(settings: &Settings) -> Vec<(&'static str, String)> {
    let Settings {
        bounces,
        bounce_tolerance,
        bounce_solver,
        places,
        cache,
        lights,
        surface_cells,
        tessellation,
        full_plan,
        ..
    } = settings;
    let LightSettings { area_samples, sky_samples, shadow_size } = lights;
    let or_default = |value: Option<String>| value.unwrap_or_else(|| "by default".into());
    vec![
        ("--bounces", if *bounces == ALL_BOUNCES { "all".into() } else { bounces.to_string() }),
        ("--bounce-tolerance", bounce_tolerance.to_string()),
        ("--bounce-solver", format!("{bounce_solver:?}").to_lowercase()),
        ("--places", or_default(places.map(|count| count.to_string()))),
        ("--light-samples", area_samples.to_string()),
        ("samples of the sky", sky_samples.to_string()),
        ("texels of shadow maps", shadow_size.to_string()),
        ("--surface-cells", or_default(surface_cells.map(|count| count.to_string()))),
        ("--tessellate", or_default(tessellation.map(|share| share.to_string()))),
        ("--full-plan", full_plan.to_string()),
        ("--accuracy", cache.accuracy.to_string()),
        ("--capture", format!("{:?}", cache.capture)),
        ("--capture-size", cache.capture_size.to_string()),
        ("--lod-error", cache.lod_error.to_string()),
        ("--gradients", format!("{:?}", cache.gradients)),
        ("--radius", format!("{:?}", cache.radius)),
        ("--weight", format!("{:?}", cache.weight)),
        ("--min-radius", cache.min_radius.to_string()),
        ("--max-radius", cache.max_radius.to_string()),
        ("--coverage", cache.covered.to_string()),
        ("--contrast", cache.contrast.to_string()),
        ("--batch", or_default(cache.batch.map(|count| count.to_string()))),
        ("--normal-limit", cache.normal_limit.to_string()),
        ("--neighbours", (if cache.clamped { "clamp" } else { "free" }).into()),
        ("--hidden", (if cache.hidden { "reject" } else { "allow" }).into()),
        ("--seed", cache.seed.to_string()),
    ]
}
