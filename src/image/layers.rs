//! Which layers of a render go into a file (`--layers`).

use std::collections::BTreeSet;
use std::str::FromStr;
use thiserror::Error;

/// The layers a render can write beside the colour itself, with what they hold.
pub const KNOWN: [(&str, &str); 11] = [
    ("direct", "radiance that leaves the surface after direct light, W·sr⁻¹·m⁻²"),
    ("indirect", "radiance that leaves the surface after indirect light, W·sr⁻¹·m⁻²"),
    ("irradiance", "indirect irradiance, W·m⁻²"),
    ("irradiance_direct", "direct irradiance, W·m⁻²"),
    ("albedo", "diffuse reflectance, 0 to 1"),
    ("N", "unit normal in world space"),
    ("P", "position in world space, metres"),
    ("Z", "distance along the view axis, metres"),
    ("records", "cache records that reach the pixel"),
    ("emission", "radiance that the surface emits, W·sr⁻¹·m⁻²"),
    ("mask", "1 where a surface that does not emit is seen"),
];

/// A name that is no layer.
#[derive(Debug, Error, PartialEq)]
#[error("there is no layer {name:?}; layers are: {}, or all", KNOWN.map(|(known, _)| known).join(", "))]
pub struct LayerError {
    /// What was asked for.
    pub name: String,
}

/// A choice of layers. The colour (`R`, `G`, `B`) is always part of it.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerSet {
    /// `None` is every layer.
    names: Option<BTreeSet<String>>,
}

impl LayerSet {
    /// Every layer.
    pub fn all() -> Self {
        Self { names: None }
    }

    /// The colour alone.
    pub fn colour() -> Self {
        Self { names: Some(BTreeSet::new()) }
    }

    /// Whether `layer` is chosen.
    pub fn contains(&self, layer: &str) -> bool {
        layer.is_empty() || self.names.as_ref().is_none_or(|names| names.contains(layer))
    }
}

impl Default for LayerSet {
    /// What most programs ask for: light, albedo and geometry.
    fn default() -> Self {
        let names = ["direct", "indirect", "irradiance", "albedo", "N", "P", "Z"];
        Self { names: Some(names.map(String::from).into()) }
    }
}

impl FromStr for LayerSet {
    type Err = LayerError;

    /// Reads `all` or names with commas between them; spaces and an empty list are allowed.
    fn from_str(text: &str) -> Result<Self, LayerError> {
        let names: Vec<&str> = text.split(',').map(str::trim).filter(|name| !name.is_empty()).collect();
        let colour = |name: &str| matches!(name, "R" | "G" | "B" | "RGB");
        let known = |name: &str| name == "all" || colour(name) || KNOWN.iter().any(|&(known, _)| known == name);
        if let Some(name) = names.iter().find(|name| !known(name)) {
            return Err(LayerError { name: (*name).to_owned() });
        }
        if names.contains(&"all") {
            return Ok(Self::all());
        }
        let chosen = names.into_iter().filter(|name| !colour(name)).map(str::to_owned);
        Ok(Self { names: Some(chosen.collect()) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_read() {
        let set: LayerSet = "direct, Z".parse().unwrap();
        assert!(set.contains("") && set.contains("direct") && set.contains("Z") && !set.contains("N"));
        assert_eq!("".parse(), Ok(LayerSet::colour()));
        assert_eq!("R,G,B".parse(), Ok(LayerSet::colour()));
        assert_eq!("N,all".parse(), Ok(LayerSet::all()));
    }

    #[test]
    fn unknown_names_are_answered_with_the_known_ones() {
        let message = "direct,normals".parse::<LayerSet>().unwrap_err().to_string();
        assert!(
            message.contains("\"normals\"") && message.contains("irradiance") && message.contains("all"),
            "{message}"
        );
        assert!("ALL".parse::<LayerSet>().is_err());
    }
}
