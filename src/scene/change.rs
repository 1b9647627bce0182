//! What differs between two moments of a scene, beside its cameras.

use super::{Background, Scene};

impl Scene {
    /// What of `other` differs from this scene so that records of one are wrong for the other, in a word; none where only cameras
    /// moved.
    pub fn change_to(&self, other: &Self) -> Option<&'static str> {
        let same_geometry = self.origin == other.origin
            && self.positions == other.positions
            && self.normals == other.normals
            && self.triangles == other.triangles
            && self.parts == other.parts;
        let same_looks = self.materials == other.materials
            && self.textures == other.textures
            && self.tangents == other.tangents
            && self.uvs == other.uvs
            && self.colors == other.colors;
        let same_lights = self.lights == other.lights;
        if !same_geometry {
            Some("geometry")
        } else if !same_looks {
            Some("materials")
        } else if !same_lights || !same_background(&self.background, &other.background) {
            Some("light")
        } else {
            None
        }
    }
}

fn same_background(a: &Background, b: &Background) -> bool {
    match (a, b) {
        (Background::Black, Background::Black) => true,
        (Background::Constant(a), Background::Constant(b)) => a == b,
        (Background::Map(a), Background::Map(b)) => (a.width, a.height, &a.rgb) == (b.width, b.height, &b.rgb),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::super::cornell;
    use glam::Vec3;

    #[test]
    fn cameras_are_no_change_and_the_rest_is() {
        let scene = cornell();
        let mut other = cornell();
        other.cameras[0].camera_to_world.w_axis.x += 1.0;
        assert_eq!(scene.change_to(&other), None);
        other.positions[0].x += 0.1;
        assert_eq!(scene.change_to(&other), Some("geometry"));
        let mut other = cornell();
        other.materials[0].emission += Vec3::ONE;
        assert_eq!(scene.change_to(&other), Some("materials"));
        let mut other = cornell();
        other.background = super::Background::Constant(Vec3::ONE);
        assert_eq!(scene.change_to(&other), Some("light"));
    }
}
