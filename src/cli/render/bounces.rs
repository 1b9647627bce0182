//! What a render says of light beyond the first bounce.

use hemicube::methods::surface_cache::Bounced;
use serde_json::{Value, json};

/// What was done, in a line.
pub fn in_words(bounced: &Bounced) -> String {
    let Bounced { places, steps, lost, seen_bytes, .. } = bounced;
    format!(
        "bounces: {places} places, {} products, residual {:.1e}, {:.2} % of the light by reflection left out, {} kB of what is seen",
        steps.len(),
        steps.last().map_or(0.0, |step| step.residual),
        lost * 100.0,
        seen_bytes / 1000
    )
}

/// The same for `--stats`, and where the sum stood after each product.
pub fn in_numbers(bounced: &Bounced) -> Value {
    let Bounced { places, rounds, seen_bytes, entries, steps, lost, times_ms, .. } = bounced;
    let [capture, build, solve, light] = times_ms;
    let products: Vec<_> =
        steps.iter().map(|s| json!({"residual": s.residual, "missing": s.missing, "ms": s.ms})).collect();
    json!({"places": places, "rounds": rounds, "seen_bytes": seen_bytes, "entries": entries, "products": products,
        "lost": lost, "ms": {"capture": capture, "build": build, "solve": solve, "light": light}})
}
