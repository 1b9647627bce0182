//! What records were made of.

use serde::{Deserialize, Serialize};

/// Program, scene and settings that records follow from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// Version of the program, and a number for its shaders.
    pub program: [String; 2],
    /// Name of the scene; it tells nothing apart.
    pub name: String,
    /// Parts of the scene, each with a hash.
    pub scene: Vec<(String, String)>,
    /// Settings as the user knows them, each with its value.
    pub settings: Vec<(String, String)>,
}

impl Origin {
    /// What differs in another origin, that of a file's records, in words; none where they may be used.
    pub fn difference(&self, file: &Self) -> Option<String> {
        let [[ours, our_shaders], [theirs, their_shaders]] = [&self.program, &file.program];
        if ours != theirs {
            return Some(format!("they were made by hemicube {theirs}, and this is {ours}"));
        }
        if our_shaders != their_shaders {
            return Some(format!("they were made by another build of hemicube {ours}, with other shaders"));
        }
        let of_scene = || {
            let (what, _) = self.scene.iter().zip(&file.scene).find(|(ours, theirs)| ours != theirs)?.0;
            let (ours, theirs) = (&self.name, &file.name);
            let whose = if ours == theirs { String::new() } else { format!(", of the scene {theirs:?}") };
            Some(format!("they were made with another {what} than the scene's{whose}"))
        };
        let of_settings = || {
            let different = self.settings.iter().zip(&file.settings).find(|(ours, theirs)| ours != theirs)?;
            let ((what, ours), (_, theirs)) = different;
            Some(format!("they were made with {what} {theirs}, and this run has {what} {ours}"))
        };
        let rest = || (self.scene.len(), self.settings.len()) != (file.scene.len(), file.settings.len());
        of_scene().or_else(of_settings).or_else(|| rest().then(|| "they were made of something else".into()))
    }
}
