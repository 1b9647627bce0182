use super::*;
use crate::scene::{Texture, TextureRef, Wrap};
use glam::{Mat3, Vec3, Vec4};

/// One masked triangle, u along its first side and v along its last.
fn triangle(texture: Option<Texture>, repeats: f32, alphas: [f32; 3]) -> Scene {
    let base_texture =
        texture.is_some().then(|| TextureRef { texture: 0, set: 0, transform: Mat3::from_scale(Vec2::splat(repeats)) });
    let material = Material { base_texture, alpha_cutoff: Some(0.3), ..crate::scene::build::diffuse(0.5) };
    Scene {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::Z; 3],
        uvs: [vec![Vec2::ZERO, Vec2::X, Vec2::Y], vec![]],
        colors: alphas.map(|a| Vec4::new(1.0, 1.0, 1.0, a)).to_vec(),
        triangles: vec![[0, 1, 2]],
        parts: vec![Part { material: 0, first_triangle: 0, triangle_count: 1 }],
        materials: vec![material],
        textures: texture.into_iter().collect(),
        ..Scene::default()
    }
}

fn checker(side: u32) -> Texture {
    let texel = |i: u32| [255, 255, 255, if (i % side + i / side).is_multiple_of(2) { 255 } else { 0 }];
    let rgba = (0..side * side).map(texel).collect();
    Texture { name: String::new(), width: side, height: side, rgba, wrap: [Wrap::Repeat; 2], nearest: true }
}

fn baked(scene: &Scene) -> Opacity {
    scene.opacity(&scene.triangles, &scene.parts)
}

/// Twin of `is_present` in `glsl/capture_compute`.
fn is_present(opacity: &Opacity, at: Vec2) -> bool {
    let Mask { n, first } = opacity.masks[0];
    let s = at * n as f32;
    let (i, j) = (s.x as u32, s.y as u32);
    let upper = u32::from(s.x.fract() + s.y.fract() > 1.0);
    let piece = i * (2 * n - i) + 2 * j + upper;
    opacity.words[first as usize * TEXEL_WORDS + piece as usize / 32] >> (piece % 32) & 1 != 0
}

fn share(opacity: &Opacity) -> f64 {
    let present: u32 = opacity.words.iter().map(|w| w.count_ones()).sum();
    f64::from(present) / f64::from(opacity.masks[0].n.pow(2))
}

#[test]
fn bits_follow_texels() {
    let scene = triangle(Some(checker(8)), 1.0, [1.0; 3]);
    let opacity = baked(&scene);
    assert_eq!(opacity.masks, [Mask { n: 32, first: 0 }]);
    for i in 0..2000 {
        let at = scattered(i);
        assert_eq!(is_present(&opacity, at), scene.is_present(0, at), "{at}");
    }
}

/// Alpha 1 at one corner and 0 at the others is above 0.3 in the 0.7² next to it, to a piece's width along the border.
#[test]
fn bits_follow_vertex_alpha() {
    let scene = triangle(None, 1.0, [0.0, 1.0, 0.0]);
    let share = share(&baked(&scene));
    assert!((share - 0.49).abs() < 0.7 / f64::from(BY_VERTICES), "{share}");
}

/// 500 periods of a checker: no grid of pieces can follow it, but half of it is there.
#[test]
fn what_is_finer_than_the_bits_keeps_its_share() {
    let opacity = baked(&triangle(Some(checker(2)), 500.0, [1.0; 3]));
    assert_eq!(opacity.masks[0].n, FINEST);
    let share = share(&opacity);
    // Of that many independent points the deviation would be 0.4 %.
    assert!((share - 0.5).abs() < 0.01, "{share}");
}

#[test]
fn what_is_there_as_a_whole_has_no_bits() {
    let opacity = baked(&triangle(None, 1.0, [0.3; 3]));
    assert_eq!((opacity.masks, opacity.words), (vec![Mask::default()], vec![]));
    let gone = baked(&triangle(None, 1.0, [0.2; 3]));
    assert_eq!((gone.masks[0].n, gone.words), (1, vec![0; TEXEL_WORDS]));
}

/// Masks of many triangles get coarser, so that all of them stay within the budget; a scene that has too many is told.
/// Those that look at the same texels count as one.
#[test]
fn masks_stay_within_their_budget() {
    let many = |count: usize| {
        let mut scene = triangle(Some(checker(8)), 1.0, [1.0; 3]);
        scene.parts[0].triangle_count = count as u32;
        scene.triangles = vec![[0, 1, 2]; count];
        scene
    };
    let shared = many(1000);
    assert_eq!(baked(&shared).words.len() * size_of::<u32>(), bytes(32));
    let distinct = |count: usize| {
        let mut scene = many(count);
        scene.positions = vec![Vec3::ZERO; 3 * count];
        scene.triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        scene.colors = vec![];
        let moved = |i: usize| [Vec2::ZERO, Vec2::X, Vec2::Y][i % 3] + (i / 3) as f32;
        scene.uvs[0] = (0..3 * count).map(moved).collect();
        scene
    };
    let full = distinct(BUDGET / bytes(16));
    assert_eq!(finest(&full.masked(&full.triangles, &full.parts).distinct), 16);
    assert_eq!(full.too_many_masked(), None);
    assert!(distinct(BUDGET / bytes(COARSEST) + 1).too_many_masked().is_some());
}
