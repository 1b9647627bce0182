use super::*;
use crate::scene::{Part, cornell};
use glam::Mat3;

fn checker(wrap: Wrap, nearest: bool) -> Texture {
    let rgba = vec![[0, 0, 0, 255], [255, 255, 255, 255], [255, 0, 0, 0], [0, 255, 0, 51]];
    Texture { name: String::new(), width: 2, height: 2, rgba, wrap: [wrap; 2], nearest }
}

fn red(texture: &Texture, u: f32, v: f32) -> f32 {
    texture.sample(Vec2::new(u, v), Encoding::Linear).x
}

#[test]
fn texel_centres_are_at_half_integers() {
    for nearest in [false, true] {
        let t = checker(Wrap::Repeat, nearest);
        assert_eq!(
            [red(&t, 0.25, 0.25), red(&t, 0.75, 0.25), red(&t, 0.25, 0.75), red(&t, 0.75, 0.75)],
            [0., 1., 1., 0.]
        );
    }
    let t = checker(Wrap::Repeat, false);
    assert_eq!(red(&t, 0.5, 0.25), 0.5);
    assert_eq!(red(&t, 0.375, 0.25), 0.25);
    assert_eq!(red(&checker(Wrap::Repeat, true), 0.4999, 0.25), 0.0);
    assert_eq!(red(&checker(Wrap::Repeat, true), 0.5, 0.25), 1.0);
}

#[test]
fn wrapping_is_as_vulkan_says() {
    assert_eq!(red(&checker(Wrap::Repeat, false), 0.0, 0.25), 0.5, "half of the texel at the other end");
    assert_eq!(red(&checker(Wrap::ClampToEdge, false), 0.0, 0.25), 0.0);
    assert_eq!(red(&checker(Wrap::MirroredRepeat, false), 1.25, 0.25), 1.0, "the second tile is mirrored");
    assert_eq!(red(&checker(Wrap::Repeat, false), -0.75, 0.25), 0.0);
    let order = |wrap: Wrap| (-3..6).map(|i| wrap.apply(i, 3)).collect::<Vec<_>>();
    assert_eq!(order(Wrap::Repeat), [0, 1, 2, 0, 1, 2, 0, 1, 2]);
    assert_eq!(order(Wrap::MirroredRepeat), [2, 1, 0, 0, 1, 2, 2, 1, 0]);
    assert_eq!(order(Wrap::ClampToEdge), [0, 0, 0, 0, 1, 2, 2, 2, 2]);
    for uv in [Vec2::splat(f32::MAX), Vec2::splat(-1e30), Vec2::NAN] {
        assert!(checker(Wrap::MirroredRepeat, false).sample(uv, Encoding::Srgb).is_finite());
    }
}

#[test]
fn srgb_is_decoded_and_alpha_is_not() {
    let t = Texture { rgba: vec![[188; 4]; 4], ..checker(Wrap::Repeat, false) };
    let texel = t.sample(Vec2::splat(0.5), Encoding::Srgb);
    assert!((texel.x - 0.502_886).abs() < 1e-5 && (texel.w - 188.0 / 255.0).abs() < 1e-6, "{texel}");
}

/// One triangle in the xy plane, u along x and v along y.
fn triangle(material: Material) -> Scene {
    Scene {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::Z; 3],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 3],
        uvs: [vec![Vec2::ZERO, Vec2::X, Vec2::Y], vec![]],
        colors: vec![Vec4::new(0.5, 1.0, 1.0, 1.0); 3],
        triangles: vec![[0, 1, 2]],
        parts: vec![Part { material: 0, first_triangle: 0, triangle_count: 1 }],
        materials: vec![material],
        textures: vec![checker(Wrap::Repeat, true)],
        ..Scene::default()
    }
}

fn plain() -> Material {
    cornell().materials[0].clone()
}

const TEXTURE: Option<TextureRef> = Some(TextureRef { texture: 0, set: 0, transform: Mat3::IDENTITY });

#[test]
fn albedo_is_base_times_texture_times_vertex_colour() {
    let base_color = Vec4::new(0.8, 0.5, 0.25, 1.0);
    let mut scene = triangle(Material { base_color, base_texture: TEXTURE, alpha_cutoff: Some(0.5), ..plain() });
    let white = scene.surface(0, Vec2::new(0.75, 0.2));
    assert_eq!((white.albedo, white.alpha), (Vec3::new(0.4, 0.5, 0.25), 1.0));
    assert!((white.position - Vec3::new(0.75, 0.2, 0.0)).length() < 1e-6);
    assert!(scene.is_present(0, Vec2::new(0.75, 0.2)) && !scene.is_present(0, Vec2::new(0.2, 0.75)));
    scene.materials[0].emission = Vec3::ONE;
    scene.materials[0].emission_texture = TEXTURE;
    let (lit, dark) = (scene.surface(0, Vec2::new(0.75, 0.2)), scene.surface(0, Vec2::new(0.2, 0.2)));
    assert_eq!((lit.emission, lit.albedo), (Vec3::ONE, Vec3::new(0.4, 0.5, 0.25)), "a point that emits reflects too");
    assert_eq!((dark.emission, dark.albedo), (Vec3::ZERO, Vec3::ZERO), "black texel of the base colour");
    // One texel of the four is white and not masked: half of it lies in the triangle, a quarter of the triangle's area.
    let emitters = scene.emitters();
    assert_eq!(emitters[0].radiance, Vec3::splat(0.25), "{emitters:?}");
    assert_eq!((emitters[0].triangle, emitters[0].area), (0, 0.5));
}

#[test]
fn a_normal_map_bends_the_normal_towards_the_tangent() {
    let mut scene = triangle(Material { normal_texture: TEXTURE, ..plain() });
    scene.textures[0].rgba = vec![[255, 128, 255, 255]; 4];
    let bent = scene.surface(0, Vec2::new(0.2, 0.2));
    assert!((bent.shading_normal - Vec3::new(1.0, 0.0, 1.0).normalize()).length() < 0.01, "{}", bent.shading_normal);
    assert_eq!(bent.geometric_normal, Vec3::Z);
    scene.textures[0].rgba = vec![[128, 255, 255, 255]; 4];
    scene.materials[0].normal_scale = 0.5;
    let n = scene.surface(0, Vec2::new(0.2, 0.2)).shading_normal;
    assert!((n - Vec3::new(0.0, 0.5, 1.0).normalize()).length() < 0.01, "green is up: {n}");
    scene.tangents.iter_mut().for_each(|t| t.w = -1.0);
    assert!(scene.surface(0, Vec2::new(0.2, 0.2)).shading_normal.y < -0.4);
}

#[test]
fn bounds_and_areas_also_hold_for_tiny_scenes() {
    let mut scene = triangle(plain());
    assert_eq!(scene.bounds(), (Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)));
    scene.positions.iter_mut().for_each(|p| *p *= 1e-18);
    assert!((scene.area(0) - 0.5e-36).abs() < 1e-42);
    assert_eq!(scene.geometric_normal(0), Vec3::Z);
}
